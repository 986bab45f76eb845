#include "app/teaching/coach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/head/measures.h"
#include "app/teaching/bite_words.h"
#include "app/teaching/plan_ground.h"
#include "app/teaching/why_missed.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/table.h"

namespace limberg {
namespace {

constexpr double kHint_s = 15, kMoreHint_s = 30, kShowHint_s = 45;  // of hesitation
constexpr double kWord_s = 20, kPraise_s = 6;                       // a word stays so long
constexpr double kReach_mm = 8, kStep_mm = 0.5;
constexpr size_t kMostSaid = 1000, kMostPoints = 4000;

/// An act of the kind that a tool draws, to be compared by its kind alone.
std::optional<Command> like(Tool tool) {
  if (tool == Tool::scalpel) return Incise{};
  if (tool == Tool::excise) return Excise{};
  if (tool == Tool::undermine) return Undermine{};
  return std::nullopt;
}

bool is_whole(const Command& c) {
  const auto* piece = std::get_if<InciseMore>(&c);
  return !piece || piece->last;
}

bool crosses(const std::vector<ChartPoint>& path, bool closed, const std::vector<ChartPoint>& line) {
  const auto side = [](const Vec2& a, const Vec2& b, const Vec2& p) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  };
  const size_t n = path.size();
  for (size_t i = 0; i + 1 < n + (closed ? 1 : 0); ++i)
    for (size_t k = 0; k + 1 < line.size(); ++k) {
      const Vec2 &a = path[i], &b = path[(i + 1) % n], &c = line[k], &d = line[k + 1];
      if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) return true;
    }
  return false;
}

/// The tool in the hand that does it; nothing: none does.
struct ToolFor {
  using May = std::optional<Tool>;
  May operator()(const Incise&) const { return Tool::scalpel; }
  May operator()(const Excise&) const { return Tool::excise; }
  May operator()(const ExcisePiece&) const { return Tool::excise; }
  May operator()(const CutThrough& c) const { return c.from_bed ? std::nullopt : May(Tool::scalpel_through); }
  May operator()(const InSpace& c) const {
    const auto* s = std::get_if<Suture>(&c.act);
    if (s && (s->side_a != HeldSide::skin || s->side_b != HeldSide::skin)) return Tool::suture_deep;
    return std::visit(*this, c.act);
  }
  May operator()(const Undermine&) const { return Tool::undermine; }
  May operator()(const SetHook&) const { return Tool::hook; }
  May operator()(const MoveHook&) const { return Tool::hook; }
  May operator()(const ReleaseHook&) const { return Tool::hook_out; }
  May operator()(const Suture& s) const { return s.depth_mm > 0 ? Tool::suture_buried : Tool::suture; }
  May operator()(const SutureRow& r) const {
    return r.running ? Tool::suture_running : r.depth_mm > 0 ? Tool::suture_row_buried : Tool::suture_row;
  }
  May operator()(const SutureCorner&) const { return Tool::suture_corner; }
  May operator()(const SutureBite&) const { return Tool::suture_bites; }
  May operator()(const TieSuture&) const { return Tool::suture_knot; }
  May operator()(const CutSuture&) const { return Tool::scissors; }
  May operator()(const Mark& m) const { return m.wipes ? Tool::swab : Tool::marker; }
  May operator()(const HeadCommand& h) const {
    if (const auto* c = std::get_if<CutBone>(&h))
      return c->contour_mm.empty() ? std::nullopt : May(Tool::saw);  // planes are the panel's
    return std::holds_alternative<MoveFragment>(h) ? May(Tool::grab) : std::nullopt;
  }
  template <class Other>
  May operator()(const Other&) const {
    return std::nullopt;
  }
};

/// For the middle of a sentence; only English writes its first letter small there.
std::string lower(std::string s, const Words& w) {
  if (w.language() == "en" && s.size() > 1 && s[0] >= 'A' && s[0] <= 'Z' && !(s[1] >= 'A' && s[1] <= 'Z'))
    s[0] = char(s[0] - 'A' + 'a');
  if (!s.empty() && s.back() == '.') s.pop_back();
  return s;
}

}  // namespace

Coach::Coach(LessonPlan plan, LessonMode mode) : plan_(std::move(plan)), mode_(mode), answers_(plan_.steps.size(), 0) {
  progress_ = progress_of(plan_, standing_);
  says_.goal = plan_.goal;
  tell_state();
}

void Coach::say(const std::string& word, bool praise) {
  if (word.empty()) return;
  says_.word = word, says_.word_is_praise = praise, word_s_ = t_s_;
  if (said_.size() < kMostSaid) said_.push_back({t_s_, word});
}

void Coach::set_mode(LessonMode mode) {
  if (mode_ == LessonMode::examination) return;
  mode_ = mode;
  says_.word.clear();
  tell_state();
}

void Coach::answer(int number) {
  if (!says_.question || number < 1 || number > int(says_.question->answers.size())) return;
  answered(judge_choice(*says_.question, number, plan_.w));
  answers_[says_.step] = number;
}

void Coach::answer_place(const ChartPoint& at) {
  if (!says_.question || !says_.question->place) return;
  const std::optional<ChartPoint> place = says_.question->place;
  answered(judge_place(*says_.question, at, plan_.w));
  says_.answer_place = place;
}

void Coach::answer_number(double value) {
  if (says_.question && says_.question->number) answered(judge_number(*says_.question, value, plan_.w));
}

void Coach::ask_again() { say(plan_.w("A question is open: click on the place that it asks for, and then go on.")); }

/// Of a question without a list of answers 1 counts as the right one.
void Coach::answered(const Answered& a) {
  answers_[says_.step] = a.right ? says_.question->right : says_.question->right + 1;
  says_.answer = a.words, says_.answer_right = a.right, says_.answer_place.reset();
  active_s_ = t_s_;
  says_.word.clear();
  tell_state();
}

void Coach::hear(const Notice& n) {
  t_s_ = std::max(t_s_, n.t_s), active_s_ = t_s_;
  if (n.kind == Notice::dropped) {
    ++missed_;
    std::string word = plan_.w.said(n.text.data());
    if (!word.empty()) word[0] = char(std::toupper(word[0])), word += '.';
    return say(word);
  }
  if (!n.command) return;
  if (n.kind == Notice::refused) {
    if (shown_) return say(plan_.w("What was to be shown cannot be done here: {}.", plan_.w.said(n.text.data())));
    ++refused_;
    std::string word = plan_.w("Not done: {}.", plan_.w.said(n.text.data()));
    const auto* bone = std::get_if<HeadCommand>(n.command.get());
    const auto* sawn = bone ? std::get_if<CutBone>(bone) : nullptr;
    if (sawn && !sawn->contour_mm.empty())  // by hand: what the mesh says of it is of little help
      word += std::string(" ") +
              plan_.w("Lead the saw once all round the bone, behind as well, and back to where the line began.");
    return say(word);
  }
  if (const auto* s = std::get_if<Shown>(n.command.get())) {
    shown_ = s->begins;
    if (shown_) says_.word.clear();  // what it spoke of is not what is seen now
  }
  script_.push_back(*n.command);
  if (!is_whole(*n.command)) return;
  if (n.kind == Notice::done && n.freed >= 0) freed_[to_json_line(*n.command)] = n.freed;
  standing_ = standing_acts(script_);
  follow_plan();
  if (n.kind == Notice::undone && !shown_) ++undone_, says_.word.clear();
  if (n.kind == Notice::redone && !shown_)
    undone_ = std::max(0, undone_ - 1);  // one who looks back and comes forth again
  if (n.kind == Notice::done && !leaves_patient(*n.command) && !standing_.empty()) {
    shown_acts_ += shown_;
    if (!shown_) judge_newest(n.freed == 0);
  }
  tell_state();
}

/// What stands against the plan, and what only the patient knows of it: what came free by a cut of bone.
void Coach::follow_plan() {
  constexpr int kPlanned = 1;  // each planned cut of bone frees one piece
  progress_ = progress_of(plan_, standing_);
  for (ActProgress& a : progress_.act) {
    if (a.state != ActProgress::done || a.shown || freed_.empty()) continue;
    const Command& c = standing_[a.by].command;
    if (!std::holds_alternative<HeadCommand>(c)) continue;
    const auto freed = freed_.find(to_json_line(c));
    if (freed == freed_.end() || freed->second <= kPlanned) continue;
    a.offs.push_back({Off::pieces, double(freed->second), kPlanned,
                      plan_.w("{} pieces came free, and one is planned: the saw met more bone than is meant. Give it "
                              "less reach",
                              freed->second)});
    std::stable_sort(a.offs.begin(), a.offs.end(), [](const Off& x, const Off& y) { return x.share() > y.share(); });
  }
}

std::string Coach::out_of_order(size_t act) const {
  if (progress_.next >= plan_.acts.size()) return "";
  const size_t step = plan_.acts[progress_.next].step;
  if (step >= plan_.acts[act].step) return "";
  const auto of_hook = [&](size_t i) { return is_of_hooks(plan_.acts[i].command); };
  const std::vector<size_t> open = progress_.open();  // which hook goes first is of no weight
  if (of_hook(act) && std::all_of(open.begin(), open.end(), [&](size_t i) { return i > act || of_hook(i); })) return "";
  const TeachingStep &first = plan_.steps[step], &then = plan_.steps[plan_.acts[act].step];
  return first.words.why.empty() ? plan_.w("Out of order: \"{}\" comes before \"{}\".", first.name, then.name)
                                 : plan_.w("Out of order: \"{}\" comes before \"{}\", for this reason: {}.", first.name,
                                           then.name, lower(first.words.why, plan_.w));
}

std::string Coach::over_limit(const Command& c) const {
  if (const auto* bone = std::get_if<HeadCommand>(&c))
    for (const SafeLimit& l : plan_.limits)
      if (const auto near = nearest_to_limit_mm(l, *bone); near && *near < l.nearest_mm)
        return plan_.w("Too near: the cut comes within {:.1f} mm of a safe limit ({}); {:g} mm are kept.", *near,
                       lower(l.name, plan_.w), l.nearest_mm);
  const auto line = drawn_line(c);
  if (!line) return "";
  for (const SafeLimit& l : plan_.limits) {
    if (l.deepest_mm && line->depth_mm > *l.deepest_mm)
      return plan_.w("Too deep: {:.1f} mm. {} begins at {:.1f} mm.", line->depth_mm, l.name, *l.deepest_mm);
    if (!l.line.empty() && crosses(line->path, line->closed, l.line))
      return plan_.w("The cut crosses a safe limit: {}.", l.name);
  }
  return "";
}

void Coach::judge_newest(bool hangs_together) {
  if (mode_ != LessonMode::guided) return;
  const Words& w = plan_.w;
  const std::string take_back = w("Ctrl+Z takes it back.");
  const size_t newest = standing_.size() - 1;
  const Command& c = standing_[newest].command;
  if (const auto* bite = std::get_if<SutureBite>(&c)) return new_bites_.push_back(*bite);
  if (std::holds_alternative<LetThreadGo>(c))
    return say(w("The thread is not tied: the edges part again. The next bite draws it tight; Shift+0 ties it."));
  if (const std::string limit = over_limit(c); !limit.empty()) return say(limit + " " + take_back);
  for (const SawnPart& part : progress_.part)
    if (part.standing == newest) {
      if (const std::string off = gentle_word(part.offs); !off.empty()) return say(off + " " + take_back);
      if (hangs_together)
        return say(w("So far as planned: {:.0f} % of the line is sawn. Saw the rest of it too, in lines that close; or "
                     "take this back (Ctrl+Z) and lead the saw all round at once.",
                     100 * part.share),
                   true);
      return say(w("A piece has come free, but {:.0f} % of the line is not sawn.", 100 * (1 - part.share)) + " " +
                 take_back);
    }
  if (const int act = attempt_at(progress_, newest); act >= 0) {
    const ActProgress& done = progress_.act[size_t(act)];
    const std::string order = out_of_order(size_t(act)), off = gentle_word(done.offs);
    const auto* line = std::get_if<Incise>(&plan_.acts[size_t(act)].command);
    const bool stops_short = line && !within(done.offs) && done.offs.front().kind == Off::length &&
                             path_length(drawn_for(done, standing_)->path) < path_length(line->path);
    const std::string back = stops_short      ? w("Go on from where it ends; or Ctrl+Z takes it back.")
                             : is_undoable(c) ? take_back
                                              : w("Take its handle and carry it on.");
    if (!off.empty()) return say(off + (order.empty() ? "" : " " + order) + " " + back);
    if (!order.empty())
      return say(order + " " + (is_undoable(c) ? take_back : w("Take its handle and carry it back.")));
    if (hangs_together)
      return say(w("All along the line, but the bone still hangs together: look behind, and inside. ") + take_back);
    return say(is_undoable(c) ? w("As planned.") : "", true);
  }
  if (std::find(progress_.stray.begin(), progress_.stray.end(), newest) == progress_.stray.end()) return;
  // Of another kind than anything that is open, or far from it.
  const std::vector<size_t> open = progress_.open();
  const bool wanted =
      std::any_of(open.begin(), open.end(), [&](size_t i) { return plan_.acts[i].command.index() == c.index(); });
  const std::string next =
      progress_.all_done() ? "" : " " + w("Next in the plan: {}.", lower(plan_.acts[progress_.next].words, w));
  if (!wanted) return say(w("This is not in the plan.") + next + " " + take_back);
  double far = 0;
  if (const auto line = drawn_line(c)) {
    far = 1e9;
    for (const size_t i : open)
      if (const auto want = drawn_line(plan_.acts[i].command); want && plan_.acts[i].command.index() == c.index())
        for (const ChartPoint& p : line->path) far = std::min(far, distance_to_line(want->path, want->closed, p));
  }
  say((far > 1 && far < 1e8 ? w("This lies elsewhere than planned, {:.0f} mm away at its nearest.", far)
                            : w("This lies elsewhere than planned.")) +
      next + " " + take_back);
}

void Coach::missed(const MissedPress& press, const Snapshot& patient) {
  if (shown_) return;
  ++missed_, active_s_ = t_s_;
  say(why_missed(press, patient, plan_.w));
}

void Coach::tell_state() {
  says_.steps.clear();
  says_.undos_to_plan = mode_ == LessonMode::examination ? 0 : undos_to_plan(plan_, standing_);
  says_.finished = progress_.all_done() && !plan_.acts.empty();
  says_.step = says_.finished || plan_.acts.empty() ? plan_.steps.size() : plan_.acts[progress_.next].step;
  for (size_t i = 0; i < plan_.steps.size(); ++i) {
    const TeachingStep& t = plan_.steps[i];
    StepSeen s{t.name};
    bool all = true, off = false, shown = false;
    for (size_t k = t.first; k < t.first + t.acts; ++k) {
      const ActProgress& a = progress_.act[k];
      all &= a.state != ActProgress::open, off |= a.state == ActProgress::done && !a.shown && !within(a.offs),
          shown |= a.shown;
    }
    s.state = i == says_.step ? StepSeen::now
              : !all          ? StepSeen::ahead
              : shown         ? StepSeen::shown
              : off           ? StepSeen::off
                              : StepSeen::done;
    says_.steps.push_back(std::move(s));
  }
  says_.limit.clear(), says_.say.clear(), says_.why.clear(), says_.act.clear(), says_.tool.reset(),
      says_.question = nullptr;
  if (mode_ != LessonMode::guided) says_.hint.clear(), says_.answer.clear();
  if (mode_ != LessonMode::guided || says_.step >= plan_.steps.size()) return;
  const LessonStep& w = plan_.steps[says_.step].words;
  says_.say = w.say, says_.why = w.why, says_.act = plan_.acts[progress_.next].words;
  says_.tool = std::visit(ToolFor{}, plan_.acts[progress_.next].command);
  if (drawn_line(plan_.acts[progress_.next].command))
    for (const SafeLimit& l : plan_.limits)
      if (l.deepest_mm) says_.limit = plan_.w("Never deeper than {:g} mm: {}.", *l.deepest_mm, lower(l.name, plan_.w));
  if (w.question && answers_[says_.step] == 0) says_.question = &*w.question;
  if (!w.question || answers_[says_.step] == 0) says_.answer.clear(), says_.answer_place.reset();
}

void Coach::follow_stroke(const Snapshot& s, const HandSeen& hand) {
  const ToolState& t = hand.tool;
  const std::optional<Command> kind = like(Tool(t.tool));
  const bool draws = t.valid && t.pressed && kind && !hand.showing && has_surface(s);
  if (!draws || !pressed_) stroke_.path.clear();
  if (draws) {
    const Vec3 tip(t.tip_mm[0], t.tip_mm[1], t.tip_mm[2]);
    if (skin_.another(s) || !pressed_) touched_ = -1;
    const SkinTouch at = skin_.closest(s, tip, touched_);
    touched_ = at.triangle;
    if (at.triangle >= 0 && at.distance_mm < kReach_mm && stroke_.path.size() < kMostPoints &&
        (stroke_.path.empty() || (stroke_.path.back() - at.chart).norm() > kStep_mm))
      stroke_.path.push_back(at.chart);
    stroke_.depth_mm = hand.depth_mm, stroke_.angle_deg = hand.angle_deg;
  }
  pressed_ = draws;
  says_.stroke.clear(), says_.stroke_of.clear();
  if (mode_ != LessonMode::guided || stroke_.path.size() < 2) return;
  const std::vector<size_t> open = progress_.open();
  if (const PlannedAct* a = meant(plan_, open, *kind, stroke_))
    says_.stroke = live_rows(plan_, *a, stroke_), says_.stroke_of = a->words;
}

/// The saw, held near a planned cut of bone or led along it; or a plane through the three places that were picked last.
void Coach::follow_saw(const Snapshot& s, const HandSeen& hand) {
  if (mode_ != LessonMode::guided || !plan_.bone || !has_surface(s)) return;
  constexpr double kPatience_s = 0.3, kOff_mm = 25;
  const std::vector<size_t> open = progress_.open();
  const ToolState& t = hand.tool;
  const bool holds = t.valid && Tool(t.tool) == Tool::saw && !hand.showing;
  saw_.tip_mm = Vec3(t.tip_mm[0], t.tip_mm[1], t.tip_mm[2]), saw_.shaft = Vec3(t.shaft[0], t.shaft[1], t.shaft[2]);
  if (!holds || !t.pressed) saw_.sawn_mm.clear(), saw_told_ = false, saw_off_s_ = -1;
  if (holds) {
    bone_.another(s);
    const SkinTouch at = bone_.closest(s, saw_.tip_mm, -1);
    if (at.triangle < 0 || at.distance_mm > kOff_mm) return;
    if (t.pressed && at.distance_mm < kReach_mm && saw_.sawn_mm.size() < kMostPoints &&
        (saw_.sawn_mm.empty() || (saw_.sawn_mm.back() - at.X_mm).norm() > kStep_mm))
      saw_.sawn_mm.push_back(at.X_mm);
    const PlannedAct* a = sawn_for(plan_, open, saw_.tip_mm);
    if (!a) return;
    says_.stroke = saw_rows(plan_, *a, saw_), says_.stroke_of = a->words;
    const std::string word = t.pressed ? saw_word(*a, saw_.tip_mm, plan_.w) : "";
    if (word.empty()) saw_off_s_ = -1;
    if (!word.empty() && saw_off_s_ < 0) saw_off_s_ = t_s_;
    if (!word.empty() && !saw_told_ && t_s_ - saw_off_s_ >= kPatience_s) saw_told_ = true, say(word);
    return;
  }
  std::vector<std::pair<int, Vec3>> picked;
  for (size_t i = 0; i < std::min(s.topology->landmark.size(), s.landmark_mm.size()); ++i)
    if (const int n = picked_number(s.topology->landmark[i])) picked.emplace_back(n, s.landmark_mm[i].cast<double>());
  if (picked.size() < 3) return;
  std::sort(picked.begin(), picked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  const std::array<Vec3, 3> three{picked[0].second, picked[1].second, picked[2].second};
  if (const PlannedAct* a = sawn_for(plan_, open, (three[0] + three[1] + three[2]) / 3))
    says_.stroke = plane_rows(std::get<HeadCommand>(a->command), three, plan_.w), says_.stroke_of = a->words;
}

void Coach::tell_bites(const Snapshot& s) {
  for (const SutureBite& b : new_bites_) {
    // Of the thread that it goes on with: what stands since the last knot.
    std::vector<SutureBite> thread;
    for (const StandingAct& a : standing_) {
      if (std::holds_alternative<TieSuture>(a.command)) thread.clear();
      if (const auto* bite = std::get_if<SutureBite>(&a.command)) thread.push_back(*bite);
    }
    const size_t n = thread.size();
    const BiteWord w = bite_word(s, std::max(1, int(n)), b, n > 1 ? &thread[n - 2] : nullptr,
                                 n > 2 ? bites_apart_mm(thread[n - 3], thread[n - 2]) : 0, plan_.w);
    say(w.words, w.praise);
  }
  new_bites_.clear();
}

void Coach::look(const Snapshot& s, const HandSeen& hand) {
  t_s_ = std::max(t_s_, double(s.device_tick) * 1e-3);
  if (!lines_known_ && has_surface(s)) {
    lines_known_ = true;
    if (plan_.bone) find_lines_on_bone(plan_, *s.topology);
    say_on_chart(plan_, s);
  }
  sutures_ = s.sutures, sewing_ = s.sewn.thread != 0;
  if (hand.tool.pressed || hand.showing || hand.tool.tool != tool_) active_s_ = t_s_;
  tool_ = hand.tool.tool;
  follow_stroke(s, hand);
  follow_saw(s, hand);
  tell_bites(s);
  if (t_s_ - word_s_ > (says_.word_is_praise ? kPraise_s : kWord_s)) says_.word.clear();
  says_.hint.clear();
  if (mode_ != LessonMode::guided || says_.step >= plan_.steps.size() || says_.question) return;
  const double still_s = t_s_ - active_s_;
  const std::string& hint = plan_.steps[says_.step].words.hint;
  const std::string general = plan_.hints.empty() ? "" : plan_.hints[std::min(says_.step, plan_.hints.size() - 1)];
  if (still_s > kHint_s) says_.hint = hint.empty() ? general : hint;
  if (still_s > kMoreHint_s)
    says_.hint += (says_.hint.empty() ? "" : " ") + plan_.w("Now: {}.", lower(says_.act, plan_.w));
  if (still_s > kShowHint_s) says_.hint += std::string(" ") + plan_.w("N shows it.");
}

Attempt Coach::present() const {
  Attempt a;
  const Words& w = plan_.w;
  std::vector<std::pair<double, std::string>> better;
  for (size_t i = 0; i < plan_.steps.size(); ++i) {
    const TeachingStep& t = plan_.steps[i];
    Attempt::Row row{t.name, w("not done")};
    for (size_t k = t.first; k < t.first + t.acts; ++k) {
      const ActProgress& p = progress_.act[k];
      if (p.state != ActProgress::done) continue;
      if (p.shown) {
        row.shown = true;
        continue;
      }
      row.judged = true;
      if (!p.offs.empty() && p.offs.front().share() > row.share)
        row.share = p.offs.front().share(), row.value = lower(gentle_word(p.offs), w);
      if (const std::string off = gentle_word(p.offs); !off.empty())
        better.emplace_back(p.offs.front().share(), w("\"{}\": {}.", t.name, lower(off, w)));
      if (const auto line = drawn_for(p, standing_);
          line && !std::holds_alternative<Undermine>(standing_[p.by].command))
        a.cuts.push_back(*line);
    }
    if (row.judged && row.share <= 1) row.value = w("as planned");
    if (row.shown) row.value = row.judged ? w("{}, a part was shown", row.value) : w("was shown");
    a.rows.push_back(std::move(row));
  }
  const auto figure = [&](const char* tolerance, const std::string& unit, double value, bool judged) {
    for (const auto& [name, limit] : plan_.tolerances)
      if (name == tolerance) {
        a.rows.push_back(
            {w(words_of_tolerance(name)),
             unit.empty() ? w("{:.3g}, at most {:g}", value, limit) : w("{:.3g} {}, at most {:g}", value, unit, limit),
             value / std::max(limit, 1e-6), !judged, judged});
        const Judgement j{name, unit, limit, value, "", value <= limit};
        for (const std::string& s : to_do_better(std::span(&j, 1)))
          if (judged) better.emplace_back(value / std::max(limit, 1e-6), w.said(s));
      }
  };
  if (!sutures_.empty()) {
    double gap = 0, most = 0, sum = 0;
    for (const SutureState& x : sutures_)
      gap = std::max(gap, double(x.gap_mm)), most = std::max(most, double(x.force_N)), sum += double(x.force_N);
    figure("gap_mm", "mm", gap, shown_acts_ == 0), figure("suture_peak_N", "N", most, shown_acts_ == 0);
    figure("suture_N", "N", most, shown_acts_ == 0), figure("closure_N", "N", sum, shown_acts_ == 0);
  }
  figure("undos", "", undone_, true);
  figure("time_s", "s", t_s_ - began_s_, shown_acts_ == 0);
  const auto count = [&](const char* what, int n, const char* advice) {
    if (n == 0) return;
    a.rows.push_back({w(what), std::to_string(n), double(n) / 2, false, true});
    if (n > 2) better.emplace_back(double(n) / 2, fmt::format("{}: {}. {}", w(what), n, w(advice)));
  };
  count(english("Presses that came to nothing"), missed_, english("Look where the tip is before you press."));
  count(english("Acts that were refused"), refused_, english("Read the reason: it says what is missing."));
  if (shown_acts_ > 0) a.rows.push_back({w("Acts that were shown"), std::to_string(shown_acts_), 0, true, false});
  if (sewing_)
    better.emplace_back(2, w("The running stitch is not tied: its knot is made at its last bite (Shift+0)."));
  if (!progress_.stray.empty())
    better.emplace_back(
        3, w.counted(int64_t(progress_.stray.size()), "{} act stands on the patient that the plan does not have.",
                     "{} acts stand on the patient that the plan does not have.", progress_.stray.size()));
  int asked = 0, right = 0;
  for (size_t i = 0; i < answers_.size(); ++i)
    if (answers_[i] > 0) ++asked, right += answers_[i] == plan_.steps[i].words.question->right;
  if (asked > 0) a.rows.push_back({w("Questions"), w("{} of {} right", right, asked), 0, false, true});
  std::stable_sort(better.begin(), better.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  for (size_t i = 0; i < better.size() && a.better.size() < 3; ++i)
    if (std::find(a.better.begin(), a.better.end(), better[i].second) == a.better.end())
      a.better.push_back(better[i].second);
  return a;
}

int Coach::try_again() {
  if (standing_.empty()) return 0;
  earlier_.push_back(present());
  undone_ = missed_ = refused_ = shown_acts_ = 0;
  began_s_ = active_s_ = t_s_;
  says_.word.clear();
  return int(
      std::count_if(standing_.begin(), standing_.end(), [](const StandingAct& a) { return is_undoable(a.command); }));
}

Showing Coach::showing(bool clean) const {
  Showing s;
  if (mode_ == LessonMode::examination) return s;
  s.undos = clean ? says_.undos_to_plan : 0;
  const std::vector<StandingAct> from = after_undos(standing_, s.undos);
  const PlanProgress p = s.undos > 0 ? progress_of(plan_, from) : progress_;
  if (p.all_done()) return s;
  s.acts = {adapted(plan_, p.next, p, from)}, s.words = plan_.acts[p.next].words;
  return s;
}

}  // namespace limberg
