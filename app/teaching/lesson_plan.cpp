#include "app/teaching/lesson_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/commands/kinds.h"
#include "sim/commands/strokes.h"
#include "sim/commands/words.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"

namespace limberg {
namespace {

constexpr double kSharp_deg = 35;  // a corner that turns by less is a point of a curve
constexpr double kSame_mm = 1.5;
constexpr size_t kMostLetters = 26;

double turn_deg(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  const Vec2 u = b - a, v = c - b;
  return std::abs(elementary::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v))) * 180 / std::numbers::pi;
}

void add_letters(std::vector<LetteredPoint>& letters, const std::vector<ChartPoint>& corners, bool closed) {
  const size_t n = corners.size();
  for (size_t i = 0; i < n && letters.size() < kMostLetters; ++i) {
    const bool end = !closed && (i == 0 || i + 1 == n);
    if (!end && turn_deg(corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]) < kSharp_deg) continue;
    if (std::any_of(letters.begin(), letters.end(),
                    [&](const LetteredPoint& l) { return (l.at - corners[i]).norm() < kSame_mm; }))
      continue;
    letters.push_back({char('A' + int(letters.size())), corners[i]});
  }
}

std::string round_of(std::span<const LetteredPoint> letters, const std::vector<ChartPoint>& corners) {
  std::string s;
  for (const ChartPoint& c : corners)
    for (const LetteredPoint& l : letters)
      if ((l.at - c).norm() < kSame_mm) s += (s.empty() ? "" : ", ") + std::string(1, l.letter);
  return s;
}

std::string beside(std::span<const LetteredPoint> letters, const ChartPoint& at, const Words& w) {
  const std::string near = near_letter(letters, at, w);
  return near.empty() ? w("({:.0f}, {:.0f}) mm", at.x(), at.y()) : near;
}

/// What to do, by the letters.
struct ActWords {
  std::span<const LetteredPoint> letters;
  const Words& w;

  std::string operator()(const Excise& e) const {
    const std::string round = round_of(letters, corners_of_outline(e.outline));
    return round.empty() ? w("Excise: along the red line, {:.3g} mm deep", e.depth_mm)
                         : w("Excise: round by {}, {:.3g} mm deep", round, e.depth_mm);
  }
  std::string operator()(const Incise& i) const {
    const std::string by = round_of(letters, corners_of_path(i.path));
    const double mm = path_length(i.path);
    return by.empty() ? w("Cut along the blue line, {:.0f} mm long, {:.3g} mm deep", mm, i.depth_mm)
                      : w("Cut from one to the next: {}, {:.0f} mm long, {:.3g} mm deep", by, mm, i.depth_mm);
  }
  std::string operator()(const Undermine& u) const {
    return w("Undermine all that the green line holds, at {:.3g} mm", u.depth_mm);
  }
  std::string operator()(const SetHook& h) const { return w("Set a hook beside {}", beside(letters, h.at, w)); }
  std::string operator()(const MoveHook& m) const { return w("Carry hook {} to the ring that is drawn", m.id); }
  std::string operator()(const ReleaseHook& r) const { return w("Let hook {} go", r.id); }
  std::string operator()(const Suture& s) const {
    return w("Stitch {} to {}", beside(letters, s.a, w), beside(letters, s.b, w));
  }
  std::string operator()(const SutureRow& r) const {
    const std::string a = beside(letters, r.a.front(), w), b = beside(letters, r.b.front(), w);
    if (a == beside(letters, r.a.back(), w) && b == beside(letters, r.b.back(), w))
      return w("Row of stitches every {:.3g} mm: one edge along {}, the other along {}", r.spacing_mm, a, b);
    return w("Row of stitches every {:.3g} mm: one edge from {} to {}, the other from {} to {}", r.spacing_mm,
             beside(letters, r.a.front(), w), beside(letters, r.a.back(), w), beside(letters, r.b.front(), w),
             beside(letters, r.b.back(), w));
  }
  std::string operator()(const HeadCommand& h) const {
    if (const auto* c = std::get_if<CutBone>(&h))
      return w(c->contour_mm.empty() ? english("Saw along the plane that is drawn")
                                     : english("Saw once round, along the line on the bone"));
    if (std::holds_alternative<CutBoneByBlade>(h)) return w("Saw along the planes that are drawn");
    if (const auto* m = std::get_if<MoveFragment>(&h)) {
      const Vec3 t = m->by.translation_mm;
      std::string ways;
      const auto way = [&](double mm, const char* to, const char* from) {
        if (std::abs(mm) >= 0.5) ways += " " + w("{:.1f} mm {}", std::abs(mm), w(mm > 0 ? to : from));
      };
      way(t.y(), english("forwards"), english("backwards")), way(t.z(), english("up"), english("down")),
          way(t.x(), english("to the right"), english("to the left"));
      const double turned_deg = m->by.rotation_deg.norm();
      return turned_deg > 0.1 ? w("Carry the piece{}, turned by {:.1f}°", ways, turned_deg)
                              : w("Carry the piece{}", ways);
    }
    return w.said(in_words(Command(h)));
  }
  template <class Other>
  std::string operator()(const Other& o) const {
    return w.said(in_words(Command(o)));
  }
};

/// A lesson's step in other words.
LessonStep in_language(LessonStep s, const Words& w) {
  s.say = w(s.say), s.why = w(s.why), s.hint = w(s.hint);
  if (s.question) {
    s.question->ask = w(s.question->ask), s.question->because = w(s.question->because);
    for (std::string& a : s.question->answers) a = w(a);
  }
  return s;
}

}  // namespace

NearLetters near_letters(std::span<const LetteredPoint> letters, const ChartPoint& at) {
  constexpr double kAt_mm = 3.5, kReach_mm = 30;
  const LetteredPoint *first = nullptr, *second = nullptr;
  const auto far = [&](const LetteredPoint* l) { return l ? (l->at - at).norm() : 1e9; };
  for (const LetteredPoint& l : letters)
    if (far(&l) < far(first))
      second = first, first = &l;
    else if (far(&l) < far(second))
      second = &l;
  if (!first || far(first) > kReach_mm) return {};
  if (far(first) <= kAt_mm || !second || far(second) > kReach_mm) return {first->letter, 0};
  return {std::min(first->letter, second->letter), std::max(first->letter, second->letter)};
}

std::string near_letter(std::span<const LetteredPoint> letters, const ChartPoint& at, const Words& w) {
  const NearLetters near = near_letters(letters, at);
  if (near.second != 0) return w("the line {}{}", near.first, near.second);
  return near.first == 0 ? "" : std::string(1, near.first);
}

LessonPlan make_lesson_plan(const Lesson* lesson, std::span<const Command> script, const Words& w) {
  LessonPlan p;
  p.w = w;
  if (lesson) {
    p.title = w(lesson->title), p.goal = w(lesson->goal), p.hints = lesson->hints, p.limits = lesson->words.limits;
    for (std::string& h : p.hints) h = w(h);
    for (SafeLimit& l : p.limits) l.name = w(l.name);
    p.tolerances = lesson->tolerances;
    for (const auto& [name, limit] : lesson->tolerances) {
      if (name == "corner_mm") p.within.corner_mm = limit;
      if (name == "angle_deg") p.within.angle_deg = limit;
      if (name == "limb_percent") p.within.limb_percent = limit;
    }
  }
  const auto end_step = [&](const std::string& stage) {
    TeachingStep s;
    s.words.stage = stage, s.name = w(stage);
    s.first = p.steps.empty() ? 0 : p.steps.back().first + p.steps.back().acts;
    s.acts = p.acts.size() - s.first;
    if (s.acts == 0) return;
    if (lesson)
      for (const LessonStep& of : lesson->words.steps)
        if (of.stage == stage) s.words = in_language(of, w);
    p.steps.push_back(std::move(s));
  };
  for (const Command& c : join_strokes(script)) {
    if (const auto* stage = std::get_if<Stage>(&c)) {
      end_step(stage->name);
    } else if (!leaves_patient(c) && !std::holds_alternative<Undo>(c) && !std::holds_alternative<Redo>(c)) {
      p.acts.push_back({c, p.steps.size(), "", {}});
      p.bone |= std::holds_alternative<HeadCommand>(c);
    }
  }
  end_step("end");
  for (const PlannedAct& a : p.acts) {
    if (const auto* e = std::get_if<Excise>(&a.command)) add_letters(p.letters, corners_of_outline(e->outline), true);
    if (const auto* i = std::get_if<Incise>(&a.command)) add_letters(p.letters, corners_of_path(i->path), false);
  }
  for (PlannedAct& a : p.acts) a.words = std::visit(ActWords{p.letters, w}, a.command);
  for (TeachingStep& s : p.steps)
    if (s.words.say.empty())
      for (size_t i = s.first; i < s.first + s.acts; ++i) s.words.say += (i > s.first ? "; " : "") + p.acts[i].words;
  return p;
}

}  // namespace limberg
