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

std::string beside(std::span<const LetteredPoint> letters, const ChartPoint& at) {
  const std::string near = near_letter(letters, at);
  return near.empty() ? fmt::format("({:.0f}, {:.0f}) mm", at.x(), at.y()) : near;
}

/// What to do, by the letters.
struct Words {
  std::span<const LetteredPoint> letters;

  std::string operator()(const Excise& e) const {
    const std::string round = round_of(letters, corners_of_outline(e.outline));
    return fmt::format("Excise{}{}, {:.3g} mm deep", round.empty() ? ": along the red line" : ": round by ", round,
                       e.depth_mm);
  }
  std::string operator()(const Incise& i) const {
    const std::string by = round_of(letters, corners_of_path(i.path));
    return fmt::format("Cut{}{}, {:.0f} mm long, {:.3g} mm deep",
                       by.empty() ? " along the blue line" : " from one to the next: ", by, path_length(i.path),
                       i.depth_mm);
  }
  std::string operator()(const Undermine& u) const {
    return fmt::format("Undermine all that the green line holds, at {:.3g} mm", u.depth_mm);
  }
  std::string operator()(const SetHook& h) const { return "Set a hook beside " + beside(letters, h.at); }
  std::string operator()(const MoveHook& m) const {
    return fmt::format("Carry hook {} to the ring that is drawn", m.id);
  }
  std::string operator()(const ReleaseHook& r) const { return fmt::format("Let hook {} go", r.id); }
  std::string operator()(const Suture& s) const {
    return "Stitch " + beside(letters, s.a) + " to " + beside(letters, s.b);
  }
  std::string operator()(const SutureRow& r) const {
    return fmt::format("Row of stitches every {:.3g} mm: one edge from {} to {}, the other from {} to {}", r.spacing_mm,
                       beside(letters, r.a.front()), beside(letters, r.a.back()), beside(letters, r.b.front()),
                       beside(letters, r.b.back()));
  }
  std::string operator()(const HeadCommand& h) const {
    if (const auto* c = std::get_if<CutBone>(&h))
      return c->contour_mm.empty() ? "Saw along the plane that is drawn" : "Saw once round, along the line on the bone";
    if (std::holds_alternative<CutBoneByBlade>(h)) return "Saw along the planes that are drawn";
    if (const auto* m = std::get_if<MoveFragment>(&h)) {
      const Vec3 t = m->by.translation_mm;
      std::string s = "Carry the piece";
      const auto way = [&](double mm, const char* to, const char* from) {
        if (std::abs(mm) >= 0.5) s += fmt::format(" {:.1f} mm {}", std::abs(mm), mm > 0 ? to : from);
      };
      way(t.y(), "forwards", "backwards"), way(t.z(), "up", "down"), way(t.x(), "to the right", "to the left");
      if (m->by.rotation_deg.norm() > 0.1) s += fmt::format(", turned by {:.1f}°", m->by.rotation_deg.norm());
      return s;
    }
    return in_words(Command(h));
  }
  template <class Other>
  std::string operator()(const Other& o) const {
    return in_words(Command(o));
  }
};

}  // namespace

std::string near_letter(std::span<const LetteredPoint> letters, const ChartPoint& at) {
  constexpr double kAt_mm = 3.5, kReach_mm = 30;
  const LetteredPoint *first = nullptr, *second = nullptr;
  const auto far = [&](const LetteredPoint* l) { return l ? (l->at - at).norm() : 1e9; };
  for (const LetteredPoint& l : letters)
    if (far(&l) < far(first))
      second = first, first = &l;
    else if (far(&l) < far(second))
      second = &l;
  if (!first || far(first) > kReach_mm) return "";
  if (far(first) <= kAt_mm || !second || far(second) > kReach_mm) return std::string(1, first->letter);
  char a = first->letter, b = second->letter;
  if (a > b) std::swap(a, b);
  return fmt::format("the line {}{}", a, b);
}

LessonPlan make_lesson_plan(const Lesson* lesson, std::span<const Command> script) {
  LessonPlan p;
  if (lesson) {
    p.title = lesson->title, p.goal = lesson->goal, p.hints = lesson->hints, p.limits = lesson->words.limits;
    p.tolerances = lesson->tolerances;
    for (const auto& [name, limit] : lesson->tolerances) {
      if (name == "corner_mm") p.within.corner_mm = limit;
      if (name == "angle_deg") p.within.angle_deg = limit;
      if (name == "limb_percent") p.within.limb_percent = limit;
    }
  }
  const auto end_step = [&](const std::string& stage) {
    TeachingStep s;
    s.words.stage = stage;
    s.first = p.steps.empty() ? 0 : p.steps.back().first + p.steps.back().acts;
    s.acts = p.acts.size() - s.first;
    if (s.acts == 0) return;
    if (lesson)
      for (const LessonStep& w : lesson->words.steps)
        if (w.stage == stage) s.words = w;
    p.steps.push_back(std::move(s));
  };
  for (const Command& c : join_strokes(script)) {
    if (const auto* stage = std::get_if<Stage>(&c)) {
      end_step(stage->name);
    } else if (!leaves_patient(c) && !std::holds_alternative<Undo>(c) && !std::holds_alternative<Redo>(c)) {
      p.acts.push_back({c, p.steps.size(), ""});
      p.bone |= std::holds_alternative<HeadCommand>(c);
    }
  }
  end_step("end");
  for (const PlannedAct& a : p.acts) {
    if (const auto* e = std::get_if<Excise>(&a.command)) add_letters(p.letters, corners_of_outline(e->outline), true);
    if (const auto* i = std::get_if<Incise>(&a.command)) add_letters(p.letters, corners_of_path(i->path), false);
  }
  for (PlannedAct& a : p.acts) a.words = std::visit(Words{p.letters}, a.command);
  for (TeachingStep& s : p.steps)
    if (s.words.say.empty())
      for (size_t i = s.first; i < s.first + s.acts; ++i) s.words.say += (i > s.first ? "; " : "") + p.acts[i].words;
  return p;
}

}  // namespace limberg
