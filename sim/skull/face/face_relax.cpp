// How the face comes to rest: the finite elements, then tissue and face by the law of motion.
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/skull/face/face_parts.h"

namespace limberg::simplex {

namespace {
constexpr int kStillFor = 5;
constexpr int kTurnEvery = 8;  // iterations between two turns of the rest shape
}  // namespace

void FaceModel::place_elastic() {
  size_t body = 0;
  for (Region& r : region_) {
    if (r.plan.mode != TissueKind::finite_elements) continue;
    Tissue& t = r.tissue;
    const auto u = [&](int32_t i) -> const Vec3& { return u_mm_[size_t(elastic_->node(body, size_t(i)))]; };
    for (size_t c = 0; c < r.top.size(); ++c) {
      Vec3& x = face_.x_mm[size_t(r.face_vertex[c])];
      const auto at = [&](size_t k) { return Vec3(t.node_mm[size_t(r.top[c][k])] + u(r.top[c][k])); };
      const Vec3 A = at(0), B = at(1), C = at(2), n = (B - A).cross(C - A);
      const LocalFrame& over = r.over[c];
      x = over.e[0] * A + over.e[1] * B + over.e[2] * C;
      if (const double l = n.norm(); l > 0) x += over.L_mm / l * n;
      x = frame_ * x;
      face_.before_mm[size_t(r.face_vertex[c])] = x;
    }
    for (size_t k = 0; k < t.tet.size(); ++k) {
      Vec3 x = Vec3::Zero();
      for (int32_t i : t.tet[k]) x += 0.25 * (t.node_mm[size_t(i)] + u(i));
      t.x_mm[k] = frame_ * x;
    }
    for (size_t v = t.tet.size(); v < t.nbr.size(); ++v)
      if (t.role[v] == TissueRole::side) t.x_mm[v] = t.x_mm[size_t(t.nbr[v][0])];
    for (const Foot& f : r.anchor) t.x_mm[size_t(f.at.vertex)] = f.now_mm;
    for (const auto& [v, f] : t.link) t.x_mm[size_t(v)] = face_.x_mm[size_t(f)];
    t.before_mm = t.x_mm;
    ++body;
  }
}

FaceModel::Report FaceModel::step_elastic(int iterations) {
  Report out;
  const std::vector<Vec3> before = u_mm_;
  const FaceElasticity::Report r = elastic_->step(u_mm_, (iterations + 3) / 4, settings_.tolerance);
  for (size_t i = 0; i < before.size(); ++i) out.max_move_mm = std::max(out.max_move_mm, (u_mm_[i] - before[i]).norm());
  if (r.iterations > 0) out.max_move_mm /= r.iterations;
  out.iterations = r.iterations, out.residual = r.residual, out.distance_mm = r.distance_mm, out.inverted = r.inverted;
  elastic_rest_ = r.converged;
  place_elastic();
  return out;
}

FaceModel::Report FaceModel::step_simplex(int iterations) {
  Report out;
  if (!scratch_) scratch_ = std::make_unique<Scratch>(*workers_);
  Law law;
  law.gamma = settings_.gamma, law.external_stiffness = 2;
  law.zone.resize(4);
  law.zone[kFree] = {Constraint::shape, settings_.alpha, settings_.beta, 1, false};
  law.zone[kCarried].fixed = law.zone[kFar].fixed = law.zone[kEvened].fixed = true;
  if (const Admission a = scratch_->motion.set_law(law); !a) throw InputError("", 0, a.refused);
  std::vector<Vec3>& force = scratch_->force;
  // Rest is the face's: springs leave motions inside the tissue that nothing brings to an end.
  const bool influence =
      std::any_of(region_.begin(), region_.end(), [](const Region& r) { return r.plan.mode != TissueKind::smoothing; });
  for (; out.iterations < iterations; ++out.iterations) {
    force.assign(face_.nbr.size(), Vec3::Zero());
    out.max_move_mm = 0;
    for (Region& r : region_) {
      if (r.plan.mode == TissueKind::finite_elements) continue;
      for (const Foot& f : r.anchor) r.tissue.x_mm[size_t(f.at.vertex)] = f.now_mm;
      for (const auto& [v, f] : r.tissue.link) r.tissue.x_mm[size_t(v)] = face_.x_mm[size_t(f)];
      TissueLaw l;
      l.mode = r.plan.mode;
      if (l.mode == TissueKind::springs) l.shape = settings_.hold;
      if (l.mode != TissueKind::smoothing && out.iterations % kTurnEvery == 0) turn_shape(r.tissue, *workers_);
      l.spring = settings_.spring, l.gamma = settings_.gamma;
      out.max_move_mm = std::max(out.max_move_mm, simplex::step(r.tissue, l, *workers_).max_move_mm);
      pull_face(r.tissue, l, force);
    }
    const double stepped_mm = scratch_->motion.step(face_, {force, {}}).max_move_mm;  // before it is evened out
    const double face_move = std::max(stepped_mm, even_out());
    out.max_move_mm = std::max(out.max_move_mm, face_move);
    still_ = (influence ? face_move : out.max_move_mm) < settings_.still_mm ? still_ + 1 : 0;
    if (still_ >= kStillFor) {
      simplex_rest_ = elastic_rest_;
      ++out.iterations;
      break;
    }
  }
  return out;
}

/// One sweep (Gauss and Seidel); the longest way that a vertex went.
double FaceModel::even_out() {
  double most2 = 0;
  const auto moved = [&](int32_t v) { return Vec3(face_.x_mm[size_t(v)] - frame_ * rest_mm_[size_t(v)]); };
  for (int32_t v = 0; v < face_.slots(); ++v) {
    if (!face_.alive(v) || face_.zone[size_t(v)] != kEvened) continue;
    Vec3 mean = Vec3::Zero();
    for (const int32_t u : face_.nbr[size_t(v)]) mean += moved(u) / 3;
    const Vec3 by = mean - moved(v);
    face_.x_mm[size_t(v)] += by, face_.before_mm[size_t(v)] = face_.x_mm[size_t(v)];
    most2 = std::max(most2, by.squaredNorm());
  }
  return std::sqrt(most2);
}

FaceModel::Report FaceModel::step(int iterations) {
  Report out;
  if (at_rest_ || iterations <= 0) {
    out.at_rest = at_rest_;
    return out;
  }
  if (any(true) && !elastic_rest_) out = step_elastic(iterations);
  if (!simplex_rest_) {
    const Report s = step_simplex(iterations);
    out.max_move_mm = std::max(out.max_move_mm, s.max_move_mm), out.iterations = std::max(out.iterations, s.iterations);
  }
  out.at_rest = at_rest_ = elastic_rest_ && simplex_rest_;
  return out;
}

}  // namespace limberg::simplex
