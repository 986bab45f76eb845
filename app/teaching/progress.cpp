#include "app/teaching/progress.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/commands/kinds.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"

namespace limberg {
namespace {

constexpr double kMuchTooFar = 2;  // of a limit: what is shown does not go on from there

int hook_of(const Command& c) {
  if (const auto* h = std::get_if<SetHook>(&c)) return h->id;
  if (const auto* h = std::get_if<MoveHook>(&c)) return h->id;
  if (const auto* h = std::get_if<ReleaseHook>(&c)) return h->id;
  return 0;
}

double worst(const Offs& offs) { return offs.empty() ? 0 : offs.front().share(); }

/// A single stitch, or a bite of a thread that is sewn bite after bite.
std::optional<Suture> stitch_of(const Command& c) {
  if (const auto* one = std::get_if<Suture>(&c)) return *one;
  if (const auto* bite = std::get_if<SutureBite>(&c)) return Suture{bite->a, bite->b};
  return std::nullopt;
}

/// Whether much of a stroke runs along another one: it was cut again there, not gone on with.
bool runs_along(const std::vector<ChartPoint>& stroke, const std::vector<ChartPoint>& other) {
  constexpr double kBeside_mm = 2, kMuch = 0.5;
  double along_mm = 0;
  for (size_t k = 1; k < stroke.size(); ++k)
    if (distance_to_line(other, false, 0.5 * (stroke[k - 1] + stroke[k])) < kBeside_mm)
      along_mm += (stroke[k] - stroke[k - 1]).norm();
  return along_mm > kMuch * std::min(path_length(stroke), path_length(other));
}

/// Two strokes that meet at their ends, as one; nothing: they do not.
std::optional<Incise> gone_on(const Incise& first, const Incise& then) {
  constexpr double kMeet_mm = 4;
  if (first.path.empty() || then.path.empty() || runs_along(then.path, first.path)) return std::nullopt;
  std::optional<Incise> whole;
  double nearest_mm = kMeet_mm;
  for (const bool from_front : {false, true})
    for (const bool to_back : {false, true}) {
      const ChartPoint &end = from_front ? first.path.front() : first.path.back(),
                       &begin = to_back ? then.path.back() : then.path.front();
      if ((begin - end).norm() > nearest_mm) continue;
      nearest_mm = (begin - end).norm(), whole = first;
      if (from_front) std::reverse(whole->path.begin(), whole->path.end());
      std::vector<ChartPoint> more = then.path;
      if (to_back) std::reverse(more.begin(), more.end());
      whole->path.insert(whole->path.end(), more.begin(), more.end());
      whole->depth_mm = std::max(first.depth_mm, then.depth_mm), whole->angle_deg = then.angle_deg;
    }
  return whole;
}

/// A stroke that goes on where one ended that was too short. True: it is better with it.
bool goes_on(const LessonPlan& plan, const std::vector<StandingAct>& standing, size_t s, double than, PlanProgress& p) {
  const auto* then = std::get_if<Incise>(&standing[s].command);
  for (size_t i = 0; then && i < plan.acts.size(); ++i) {
    ActProgress& a = p.act[i];
    if (a.state != ActProgress::done || a.shown || within(a.offs)) continue;
    const auto* first = a.joined ? &*a.joined : std::get_if<Incise>(&standing[a.by].command);
    const std::optional<Incise> whole = first ? gone_on(*first, *then) : std::nullopt;
    auto offs = whole ? against(plan, plan.acts[i], *whole) : std::nullopt;
    if (!offs || worst(*offs) >= std::min(than, worst(a.offs))) continue;
    a.before.push_back(a.by);
    a.by = s, a.shown = standing[s].shown, a.offs = std::move(*offs), a.joined = *whole;
    return true;
  }
  return false;
}

/// Whether single stitches do what a planned row does; those that do are marked as used.
bool sewn_singly(const SutureRow& row, const std::vector<StandingAct>& standing, std::vector<char>& used,
                 ActProgress& p) {
  constexpr double kBeside_mm = 5, kEnough = 0.6;
  std::vector<size_t> found;
  for (size_t s = 0; s < standing.size(); ++s) {
    const auto one = stitch_of(standing[s].command);
    if (!one || used[s]) continue;
    const auto far = [&](const ChartPoint& a, const ChartPoint& b) {
      return std::max(distance_to_line(row.a, false, a), distance_to_line(row.b, false, b));
    };
    if (std::min(far(one->a, one->b), far(one->b, one->a)) < kBeside_mm) found.push_back(s);
  }
  const double planned = path_length(row.a) / std::max(row.spacing_mm, 0.5) + 1;
  if (double(found.size()) < std::max(2.0, kEnough * planned)) return false;
  p.state = ActProgress::done, p.by = found.back();
  for (const size_t s : found) used[s] = 1, p.shown |= standing[s].shown;
  return true;
}

/// A stitch on the way along a planned row that is not done yet: it is no stray.
bool on_the_way(const LessonPlan& plan, const PlanProgress& p, const Command& c) {
  constexpr double kBeside_mm = 5;
  const auto one = stitch_of(c);
  for (size_t i = 0; one && i < plan.acts.size(); ++i)
    if (const auto* row = std::get_if<SutureRow>(&plan.acts[i].command); row && p.act[i].state == ActProgress::open) {
      const auto far = [&](const ChartPoint& a, const ChartPoint& b) {
        return std::max(distance_to_line(row->a, false, a), distance_to_line(row->b, false, b));
      };
      if (std::min(far(one->a, one->b), far(one->b, one->a)) < kBeside_mm) return true;
    }
  return false;
}

/// A closed line that a hand sawed.
const CutBone* sawn_by_hand(const Command& c) {
  const auto* bone = std::get_if<HeadCommand>(&c);
  const auto* cut = bone ? std::get_if<CutBone>(bone) : nullptr;
  return cut && !cut->contour_mm.empty() ? cut : nullptr;
}

/// Lines by hand against a planned cut whose place on the bone is known: done once nearly all of it is sawn.
void saw_along(const LessonPlan& plan, const std::vector<StandingAct>& standing, std::vector<char>& used,
               PlanProgress& progress) {
  constexpr double kEnough = 0.95, kBeside_mm = 4, kBesideAtMost_mm = 12;
  for (size_t s = 0; s < standing.size(); ++s) {
    if (used[s] || !sawn_by_hand(standing[s].command)) continue;
    std::optional<SawnPart> best;
    for (size_t i = 0; i < plan.acts.size(); ++i) {
      if (progress.act[i].state != ActProgress::open || plan.acts[i].on_bone_mm.empty()) continue;
      const auto offs = against(plan, plan.acts[i], standing[s].command);
      if (offs && (!best || worst(*offs) < worst(best->offs))) best = SawnPart{s, i, *offs};
    }
    if (best) used[s] = 1, progress.part.push_back(std::move(*best));
  }
  for (size_t i = 0; i < plan.acts.size(); ++i) {
    const std::vector<Vec3>& line = plan.acts[i].on_bone_mm;
    std::vector<char> sawn(line.size(), 0);
    ActProgress a;
    for (SawnPart& part : progress.part) {
      if (part.act != i) continue;
      const double near_mm = std::min(kBesideAtMost_mm, kBeside_mm + (part.offs.empty() ? 0 : part.offs.front().value));
      for (size_t k = 0; k < line.size(); ++k)
        for (const Vec3& p : sawn_by_hand(standing[part.standing].command)->contour_mm)
          if ((p - line[k]).norm() < near_mm) sawn[k] = 1;
      part.share = double(std::count(sawn.begin(), sawn.end(), 1)) / double(line.size());
      if (a.offs.empty() || worst(part.offs) > worst(a.offs)) a.offs = part.offs;
      a.by = part.standing, a.shown |= standing[part.standing].shown;
      if (part.share >= kEnough) a.state = ActProgress::done;
    }
    if (a.state != ActProgress::done) continue;
    progress.act[i] = std::move(a);
    std::erase_if(progress.part, [&](const SawnPart& part) { return part.act == i; });
  }
}

/// A turn and a shift of the chart.
struct Laid {
  double cos = 1, sin = 0;
  Vec2 from{0, 0}, to{0, 0};
  ChartPoint operator()(const ChartPoint& p) const {
    const Vec2 d = p - from;
    return to + Vec2(cos * d.x() - sin * d.y(), sin * d.x() + cos * d.y());
  }
};

std::vector<ChartPoint> corners_of(const DrawnLine& l) {
  return l.closed ? corners_of_outline(l.path) : corners_of_path(l.path);
}

/// How the learner's cuts lie against the plan's, by least squares of their corners; as planned where they lie within
/// what may be off, or say too little.
Laid laid(const LessonPlan& plan, const PlanProgress& progress, const std::vector<StandingAct>& standing) {
  constexpr double kSameCorner_mm = 12;
  std::vector<std::pair<ChartPoint, ChartPoint>> pairs;
  double most = 0;
  for (size_t i = 0; i < plan.acts.size(); ++i) {
    const ActProgress& p = progress.act[i];
    if (p.state != ActProgress::done || std::holds_alternative<Undermine>(plan.acts[i].command)) continue;
    const auto want = drawn_line(plan.acts[i].command), got = drawn_for(p, standing);
    if (!want || !got) continue;
    const std::vector<ChartPoint> drawn = corners_of(*got);
    for (const ChartPoint& c : corners_of(*want)) {
      const auto near = std::min_element(drawn.begin(), drawn.end(),
                                         [&](const auto& a, const auto& b) { return (a - c).norm() < (b - c).norm(); });
      if (near == drawn.end() || (*near - c).norm() > kSameCorner_mm) continue;
      pairs.emplace_back(c, *near), most = std::max(most, (*near - c).norm());
    }
  }
  Laid l;
  if (pairs.size() < 3 || most <= plan.within.corner_mm) return l;
  for (const auto& [a, b] : pairs) l.from += a / double(pairs.size()), l.to += b / double(pairs.size());
  double along = 0, across = 0;
  for (const auto& [a, b] : pairs) {
    const Vec2 u = a - l.from, v = b - l.to;
    along += u.dot(v), across += u.x() * v.y() - u.y() * v.x();
  }
  if (const double n = std::hypot(along, across); n > 1e-9) l.cos = along / n, l.sin = across / n;
  return l;
}

}  // namespace

std::vector<size_t> PlanProgress::open() const {
  std::vector<size_t> all;
  for (size_t i = 0; i < act.size(); ++i)
    if (act[i].state == ActProgress::open) all.push_back(i);
  return all;
}

PlanProgress progress_of(const LessonPlan& plan, const std::vector<StandingAct>& standing) {
  PlanProgress p;
  p.act.resize(plan.acts.size());
  std::vector<char> used(standing.size(), 0);
  for (size_t s = 0; s < standing.size(); ++s) {
    int best = -1;
    Offs best_offs;
    for (size_t i = 0; i < plan.acts.size(); ++i) {
      // Who cuts again, and well, without taking back what was off has done it now; the first cut is of no plan.
      const ActProgress& before = p.act[i];
      const bool mends = before.state == ActProgress::done && !before.shown && !within(before.offs);
      if (before.state != ActProgress::open && !mends) continue;
      if (sawn_by_hand(standing[s].command) && !plan.acts[i].on_bone_mm.empty()) continue;
      auto offs = against(plan, plan.acts[i], standing[s].command);
      // Fragments are grabbed, carried, let go: the way counts.
      if (!offs || (mends && !within(*offs)) || (best >= 0 && worst(*offs) >= worst(best_offs))) continue;
      best = int(i), best_offs = std::move(*offs);
    }
    if (goes_on(plan, standing, s, best < 0 ? 1e9 : worst(best_offs), p)) {
      used[s] = 1;
      continue;
    }
    if (best < 0) continue;
    ActProgress& a = p.act[size_t(best)];
    if (a.state == ActProgress::done) used[a.by] = 0;
    for (const size_t k : a.before) used[k] = 0;
    a = {ActProgress::done, standing[s].shown, s, std::move(best_offs), {}, {}};
    used[s] = 1;
  }
  for (size_t i = 0; i < plan.acts.size(); ++i)
    if (const auto* row = std::get_if<SutureRow>(&plan.acts[i].command); row && p.act[i].state == ActProgress::open)
      sewn_singly(*row, standing, used, p.act[i]);
  saw_along(plan, standing, used, p);
  bool later = false;             // a cut or a stitch of the plan
  std::map<int, bool> later_way;  // of a hook, by its number in the plan
  for (size_t i = plan.acts.size(); i-- > 0;) {
    const Command& c = plan.acts[i].command;
    ActProgress& a = p.act[i];
    if (!is_of_hooks(c)) {
      later |= a.state == ActProgress::done;
      continue;
    }
    if (a.state == ActProgress::open && (later || later_way[hook_of(c)])) a.state = ActProgress::passed;
    later_way[hook_of(c)] |= a.state == ActProgress::done;
  }
  p.next = size_t(std::find_if(p.act.begin(), p.act.end(), [](const auto& a) { return a.state == ActProgress::open; }) -
                  p.act.begin());
  for (size_t s = 0; s < standing.size(); ++s) {
    const auto* h = std::get_if<HeadCommand>(&standing[s].command);
    const bool of_bone = h && (std::holds_alternative<CutBone>(*h) || std::holds_alternative<CutBoneByBlade>(*h) ||
                               std::holds_alternative<MoveFragment>(*h));
    const bool of_skin = cuts_skin(standing[s].command) || sews(standing[s].command);
    if (!used[s] && (of_bone || of_skin) && !on_the_way(plan, p, standing[s].command)) p.stray.push_back(s);
  }
  return p;
}

std::optional<DrawnLine> drawn_for(const ActProgress& act, const std::vector<StandingAct>& standing) {
  return drawn_line(act.joined ? Command(*act.joined) : standing[act.by].command);
}

int attempt_at(const PlanProgress& p, size_t standing) {
  for (size_t i = 0; i < p.act.size(); ++i)
    if (p.act[i].state == ActProgress::done && p.act[i].by == standing) return int(i);
  return -1;
}

int undos_to_plan(const LessonPlan& plan, const std::vector<StandingAct>& standing) {
  const PlanProgress p = progress_of(plan, standing);
  size_t first = standing.size();
  for (const size_t s : p.stray) first = std::min(first, s);
  for (const SawnPart& part : p.part) first = std::min(first, part.standing);  // what is shown cuts it anew
  for (const ActProgress& a : p.act)
    if (a.state == ActProgress::done && !a.shown && worst(a.offs) > kMuchTooFar && is_undoable(standing[a.by].command))
      first = std::min(first, a.before.empty() ? a.by : a.before.front());
  int undos = 0;
  for (size_t s = first; s < standing.size(); ++s) undos += is_undoable(standing[s].command);
  return undos;
}

std::vector<StandingAct> after_undos(std::vector<StandingAct> standing, int undos) {
  while (undos > 0 && !standing.empty()) {
    undos -= is_undoable(standing.back().command);
    standing.pop_back();
  }
  return standing;
}

Command adapted(const LessonPlan& plan, size_t act, const PlanProgress& progress,
                const std::vector<StandingAct>& standing) {
  Command c = plan.acts[act].command;
  const Laid lay = laid(plan, progress, standing);
  const auto place = [&](std::vector<ChartPoint>& path) {
    for (ChartPoint& p : path) p = lay(p);
  };
  if (auto* i = std::get_if<Incise>(&c)) place(i->path);
  if (auto* e = std::get_if<Excise>(&c)) place(e->outline);
  if (auto* u = std::get_if<Undermine>(&c)) place(u->outline);
  if (auto* s = std::get_if<Suture>(&c)) s->a = lay(s->a), s->b = lay(s->b);
  if (auto* r = std::get_if<SutureRow>(&c)) place(r->a), place(r->b);
  if (!is_of_hooks(c)) return c;
  // The number that the plan's hook has on this patient.
  std::map<int, bool> stands;
  for (const StandingAct& s : standing) {
    if (const auto* h = std::get_if<SetHook>(&s.command)) stands[h->id] = true;
    if (const auto* h = std::get_if<ReleaseHook>(&s.command)) stands[h->id] = false;
  }
  int number = hook_of(c);
  for (size_t i = 0; i < act; ++i)
    if (std::holds_alternative<SetHook>(plan.acts[i].command) && hook_of(plan.acts[i].command) == hook_of(c) &&
        progress.act[i].state == ActProgress::done)
      number = hook_of(standing[progress.act[i].by].command);
  if (auto* h = std::get_if<SetHook>(&c)) {
    while (stands[number]) ++number;
    h->id = number, h->at = lay(h->at);
  }
  if (auto* m = std::get_if<MoveHook>(&c)) m->id = number;
  if (auto* r = std::get_if<ReleaseHook>(&c)) r->id = number;
  return c;
}

}  // namespace limberg
