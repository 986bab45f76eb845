#include "app/window/plan_sheet.h"

#include <algorithm>
#include <cmath>

#include "app/teaching/saw_watch.h"

namespace limberg {
namespace {

// Linear RGB.
const Vec3f kCut{0.10f, 0.02f, 0.30f}, kPocket{0.02f, 0.26f, 0.07f}, kSew{0.80f, 0.55f, 0.02f},
    kLimit{0.72f, 0.02f, 0.02f}, kEarlier{0.35f, 0.36f, 0.38f}, kBone{0.10f, 0.02f, 0.30f};
constexpr float kThin_mm = 0.28f, kThick_mm = 0.5f, kAbove_mm = 0.12f;
constexpr double kSample_mm = 1.2, kRim_mm = 0.8, kDash_mm = 3, kFarBetween_mm = 6;

}  // namespace

void PlanSheet::pen(const Snapshot& s, const std::vector<ChartPoint>& path, bool closed, const Vec3f& colour,
                    float radius_mm, bool dashed) {
  std::vector<Vec3f> piece;
  double drawn_mm = 0;
  const auto end = [&] {
    if (piece.size() > 1) {
      const std::vector<float> radius(piece.size(), std::max(radius_mm, least_mm_));
      add_tube(props_, piece, radius, {colour, 0, 0}, 5);
    }
    piece.clear();
  };
  const size_t n = path.size();
  for (size_t i = 0; n > 1 && i + 1 < n + (closed ? 1 : 0); ++i) {
    const ChartPoint &a = path[i], &b = path[(i + 1) % n];
    const int steps = std::max(1, int(std::ceil((b - a).norm() / kSample_mm)));
    for (int k = 0; k <= steps; ++k) {
      if (k > 0) drawn_mm += (b - a).norm() / steps;
      const SkinTouch at = chart_.at(s, a + (b - a) * (double(k) / steps), kRim_mm);
      const bool gap = dashed && std::fmod(drawn_mm, 2 * kDash_mm) >= kDash_mm;
      if (at.triangle < 0 || gap) {
        end();
        continue;
      }
      const Vec3f x = (at.x_mm + double(kAbove_mm) * at.normal).cast<float>();
      // Where a cut lies between two places they may be far apart now.
      if (!piece.empty() && double((x - piece.back()).norm()) > kFarBetween_mm) end();
      piece.push_back(x);
    }
  }
  end();
}

void PlanSheet::ring(const Vec3f& at, float radius_mm, const Vec3f& colour) {
  constexpr int kPieces = 20;
  std::vector<Vec3f> path;
  for (int i = 0; i <= kPieces; ++i) {
    const float t = 2 * float(M_PI) * float(i) / kPieces;
    path.push_back(at + radius_mm * Vec3f(std::cos(t), std::sin(t), 0));
  }
  add_tube(props_, path, std::vector<float>(path.size(), std::max(kThin_mm, least_mm_)), {colour, 0, 0}, 5);
}

void PlanSheet::planes_on_bone(const Snapshot& s, const HeadCommand& cut) {
  const SurfaceView& view = s.topology->view;
  const std::vector<SawPlane> planes = planes_of(cut);
  const int32_t bone = bone_meant(*s.topology, cut);  // what else the planes meet is not to be sawn
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (!s.topology->is_ground(t, Ground::bone) || t >= s.topology->object.size() || s.topology->object[t] != bone)
      continue;
    std::array<Vec3, 3> x;
    for (size_t k = 0; k < 3; ++k) x[k] = s.x_mm[size_t(view.tri[t][k])].cast<double>();
    for (const SawPlane& plane : planes)
      if (const auto on = plane.through(x); on && plane.reaches(on->first) && plane.reaches(on->second))
        lines_.add(on->first.cast<float>(), on->second.cast<float>(), Vec3f(0.45f, 0.05f, 0.85f));
  }
}

void PlanSheet::on_bone(const HeadCommand& act, const Snapshot& s, bool next) {
  const float radius = next ? 0.7f : 0.45f;
  const auto tube = [&](const std::vector<Vec3f>& path, const Vec3f& colour) {
    if (path.size() > 1) add_tube(props_, path, std::vector<float>(path.size(), radius), {colour, 0, 0}, 6);
  };
  if (const auto* c = std::get_if<CutBone>(&act)) {
    if (c->contour_mm.empty()) return planes_on_bone(s, act);
    std::vector<Vec3f> path;
    for (const Vec3& p : c->contour_mm) path.push_back(p.cast<float>());
    path.push_back(path.front());
    tube(path, kBone);
  } else if (std::holds_alternative<CutBoneByBlade>(act)) {
    planes_on_bone(s, act);
  } else if (const auto* m = std::get_if<MoveFragment>(&act)) {
    const Vec3f from = m->fragment.at_mm.cast<float>(),
                to = (isometry(m->by, m->fragment.at_mm) * m->fragment.at_mm).cast<float>();
    const float long_mm = (to - from).norm();
    if (long_mm < 0.5f) return;
    const Vec3f along = (to - from) / long_mm;
    tube({from, from + std::max(long_mm, 14.0f) * along}, kSew);
    const Vec3f side = along.unitOrthogonal();
    const Vec3f tip = from + std::max(long_mm, 14.0f) * along;
    tube({tip - 4 * along + 2.5f * side, tip, tip - 4 * along - 2.5f * side}, kSew);
  }
}

void PlanSheet::act(const Coach& coach, size_t i, const Snapshot& s) {
  const Command& c = coach.plan().acts[i].command;
  const bool next = i == coach.progress().next, of_step = coach.plan().acts[i].step == coach.says().step;
  const float radius = next ? kThick_mm : kThin_mm;
  if (const auto line = drawn_line(c)) {
    const bool pocket = std::holds_alternative<Undermine>(c);
    if (!pocket || of_step) pen(s, line->path, line->closed, pocket ? kPocket : kCut, radius, pocket);
    return;
  }
  if (const auto* h = std::get_if<HeadCommand>(&c)) {
    if (of_step) on_bone(*h, s, next);
    return;
  }
  if (!next) return;  // of sewing and hooks one at a time
  const auto dot = [&](const ChartPoint& p) {
    if (const SkinTouch at = chart_.at(s, p, 2.5); at.triangle >= 0)
      ring((at.x_mm + 0.3 * at.normal).cast<float>(), 1.1f, kSew);
  };
  if (const auto* k = std::get_if<Suture>(&c)) dot(k->a), dot(k->b);
  if (const auto* k = std::get_if<SutureBite>(&c)) dot(k->a), dot(k->b);
  if (const auto* k = std::get_if<SutureRow>(&c)) {
    pen(s, k->a, false, kSew, kThick_mm, false), pen(s, k->b, false, kSew, kThick_mm, false);
    dot(k->a.front()), dot(k->b.front());
  }
  if (const auto* k = std::get_if<SetHook>(&c)) dot(k->at);
  if (const auto* k = std::get_if<MoveHook>(&c)) ring(k->to_mm.cast<float>(), 2, kSew);
}

void PlanSheet::draw(const Coach& coach, const Snapshot& s, float pixel_mm) {
  constexpr float kMost_mm = 0.8f;                  // from afar lines are thin all the same
  least_mm_ = std::min(1.2f * pixel_mm, kMost_mm);  // a pixel wide where the patient is drawn half as large
  props_.clear(), lines_.clear(), letters_.clear();
  if (coach.mode() != LessonMode::guided || !has_surface(s)) return;
  const LessonPlan& plan = coach.plan();
  const bool skin = s.topology->body != nullptr;
  if (skin && !chart_.built_for(s)) chart_.build(*s.topology);
  // What was cut last and lies off is seen beside its plan, until it is taken back or one goes on.
  const auto off = [&](size_t i) {
    const ActProgress& a = coach.progress().act[i];
    return a.state == ActProgress::done && !a.shown && !within(a.offs) && a.by + 1 == coach.standing().size() &&
           !std::holds_alternative<Undermine>(plan.acts[i].command) && drawn_line(plan.acts[i].command);
  };
  for (size_t i = 0; i < plan.acts.size(); ++i)
    if ((coach.progress().act[i].state == ActProgress::open || off(i)) &&
        (skin || std::holds_alternative<HeadCommand>(plan.acts[i].command)))
      act(coach, i, s);
  for (const SafeLimit& l : plan.limits) {
    if (l.bone_line.empty()) continue;
    std::vector<Vec3f> path;
    for (const Vec3& p : l.bone_line) path.push_back(p.cast<float>());
    add_tube(props_, path, std::vector<float>(path.size(), 0.7f), {kLimit, 0, 0}, 6);
    letters_.push_back({path[path.size() / 2], l.name, true});
  }
  if (!skin) return;
  if (const auto& at = coach.says().answer_place)
    if (const SkinTouch t = chart_.at(s, *at, 2.5); t.triangle >= 0)
      ring((t.x_mm + 0.3 * t.normal).cast<float>(), 2.5f, kSew);
  if (!coach.earlier().empty())
    for (const DrawnLine& l : coach.earlier().back().cuts) pen(s, l.path, l.closed, kEarlier, kThin_mm, false);
  for (const SafeLimit& l : plan.limits) {
    if (l.line.empty()) continue;
    pen(s, l.line, false, kLimit, kThick_mm, true);
    if (const SkinTouch at = chart_.at(s, l.line[l.line.size() / 2], 2.5); at.triangle >= 0)
      letters_.push_back({at.x_mm.cast<float>(), l.name, true});
  }
  for (const LetteredPoint& l : plan.letters)
    if (const SkinTouch at = chart_.at(s, l.at, 2.5); at.triangle >= 0)
      letters_.push_back({at.x_mm.cast<float>(), std::string(1, l.letter)});
}

}  // namespace limberg
