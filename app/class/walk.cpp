#include "app/class/walk.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/base/error.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"

namespace limberg {
namespace {

bool ends_act(const Command& c) {
  const auto* piece = std::get_if<InciseMore>(&c);
  return !piece || piece->last;
}

bool takes_back(const Command& c) { return std::holds_alternative<Undo>(c) || std::holds_alternative<Redo>(c); }

/// Hooks are means: where they go and when is the surgeon's own affair, and shows in what they help to do.
bool is_means(const Command& c) {
  return std::holds_alternative<SetHook>(c) || std::holds_alternative<MoveHook>(c) ||
         std::holds_alternative<ReleaseHook>(c);
}

/// The first step of which an act is open that is an end in itself; their number: none.
size_t first_open_step(const LessonPlan& plan, const PlanProgress& p) {
  for (size_t i = 0; i < plan.acts.size(); ++i)
    if (p.act[i].state == ActProgress::open && !is_means(plan.acts[i].command)) return plan.acts[i].step;
  return plan.steps.size();
}

/// Times of acts, and their order, as they came.
void follow(const LessonPlan& plan, const TimedActs& acts, Maybe total_s, ClassWalk& w) {
  const bool timed = !acts.at_s.empty();
  double from_s = 0, elsewhere = 0, back = 0;
  std::vector<double> step_s(plan.steps.size(), 0);
  std::vector<Command> so_far;
  PlanProgress before = progress_of(plan, {});
  bool shown = false;
  for (size_t i = 0; i < acts.command.size(); ++i) {
    const Command& c = acts.command[i];
    so_far.push_back(c);
    if (const auto* s = std::get_if<Shown>(&c)) shown = s->begins;
    if (!ends_act(c) || leaves_patient(c) || std::holds_alternative<Shown>(c)) continue;
    const double took = timed ? std::max(0.0, acts.at_s[i] - from_s) : 0;
    const std::vector<StandingAct> standing = standing_acts(so_far);
    const PlanProgress now = progress_of(plan, standing);
    // One of several lines along a planned cut of bone that are not all of it yet.
    const auto part = std::find_if(now.part.begin(), now.part.end(),
                                   [&](const SawnPart& p) { return p.standing + 1 == standing.size(); });
    const int attempt = standing.empty() || takes_back(c) ? -1 : attempt_at(now, standing.size() - 1);
    if (is_means(c) && attempt < 0) continue;  // what it takes counts for what it helps to do
    if (timed) from_s = std::max(from_s, acts.at_s[i]);
    if (takes_back(c)) {
      back += took;
    } else if (attempt >= 0) {
      const size_t step = plan.acts[size_t(attempt)].step;
      if (step < step_s.size()) step_s[step] += took;
      w.out_of_order += !shown && !is_means(c) && first_open_step(plan, now) < step &&
                        before.act[size_t(attempt)].state != ActProgress::done;
    } else if (part != now.part.end()) {
      const size_t step = plan.acts[part->act].step;
      if (step < step_s.size()) step_s[step] += took;
    } else {
      elsewhere += took;
    }
    before = now;
  }
  if (!timed) return;
  for (size_t i = 0; i < w.steps.size(); ++i)
    if (w.steps[i].done > 0) w.steps[i].time_s = step_s[i];
  w.elsewhere_s = elsewhere, w.taken_back_s = back;
  if (total_s) w.afterwards_s = std::max(0.0, *total_s - from_s);
}

/// Of a result that knows its stages alone.
void times_of_stages(const ClassMember& m, ClassWalk& w) {
  if (m.result.mode.value_or("").empty()) return;  // of a script: they are numbers of lines
  double from_s = 0;
  for (const ResultStage& s : m.result.stages) {
    if (!s.t_s) return;
    const auto step = std::find_if(w.steps.begin(), w.steps.end(), [&](const auto& x) { return x.name == s.name; });
    if (step != w.steps.end() && !step->time_s && step->done > 0) step->time_s = std::max(0.0, *s.t_s - from_s);
    from_s = *s.t_s;
  }
}

}  // namespace

TimedActs acts_of(const ClassMember& m) {
  TimedActs a;
  const bool timed = m.also.act_s.size() == m.result.script.size() && !m.also.act_s.empty();
  for (size_t i = 0; i < m.result.script.size(); ++i) {
    try {
      a.command.push_back(parse_command(m.result.script[i], "script", int(i + 1)));
    } catch (const InputError&) {
      continue;  // of another version
    }
    if (timed) a.at_s.push_back(m.also.act_s[i]);
  }
  return a;
}

ClassWalk walk_of(const LessonPlan& plan, const ClassMember& m) {
  ClassWalk w;
  const TimedActs acts = acts_of(m);
  const std::vector<StandingAct> standing = standing_acts(acts.command);
  const PlanProgress p = progress_of(plan, standing);
  for (const TeachingStep& t : plan.steps) {
    StepWalk s;
    s.name = t.words.stage, s.planned = int(t.acts);
    for (size_t k = t.first; k < t.first + t.acts; ++k) {
      const ActProgress& a = p.act[k];
      s.done += a.state != ActProgress::open;
      s.shown += a.state == ActProgress::done && a.shown;
      if (is_means(plan.acts[k].command)) continue;
      if (a.state != ActProgress::done || a.shown || a.offs.empty() || a.offs.front().share() <= s.share) continue;
      s.share = a.offs.front().share(), s.off = gentle_word(a.offs);
    }
    for (const SawnPart& part : p.part) {  // the last of a cut's lines says how much of it they are together
      if (part.act < t.first || part.act >= t.first + t.acts) continue;
      const double left = 1 - part.share;
      s.sawn = part.share, s.share = std::max(1 + left, part.offs.empty() ? 0 : part.offs.front().share());
      s.off = fmt::format(english("only {:.0f} % of the line is sawn"), 100 * part.share);
    }
    w.steps.push_back(std::move(s));
  }
  w.elsewhere = int(p.stray.size());
  for (const StandingAct& a : standing) w.shown += a.shown;
  follow(plan, acts, m.result.duration_s, w);
  if (acts.at_s.empty()) times_of_stages(m, w);
  return w;
}

}  // namespace limberg
