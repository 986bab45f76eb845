#include "sim/skull/bone/surface_work.h"

#include <algorithm>
#include <cmath>

#include "sim/base/text.h"
#include "sim/geometry/triangle.h"
#include "sim/skull/bone/seam.h"
#include "sim/skull/bone/surface.h"
#include "sim/skull/simplex/motion.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::bone {
namespace {

using simplex::FaceKind;
using simplex::Mesh;

// A ball goes in steps of a fifth of its radius at most; at each the law of motion pushes so often that 2 % of what lay
// within is left within (1 - 0.5)^6.
constexpr double kPushStep = 0.2;
constexpr int kPushIterations = 6, kMostPushSteps = 2000;
constexpr double kPushBeta = 0.5, kSpreadAlpha = 0.2, kDamping = 1;
constexpr double kUnmoved_mm = 1e-9;

WorkedSurface cannot(std::string why) { return {std::move(why), {}}; }

/// The face at a place, and the place on it.
struct Found {
  int32_t face = -1;
  Vec3 at_mm = Vec3::Zero();
};
Found face_at(const Mesh& m, int32_t inside, const Vec3& x) {
  const BoneSurface s = bone_surface(m, component_of(m, inside));
  const Bvh::Closest c = s.bvh.closest(x, kWorkFarthest_mm);
  if (c.triangle < 0) return {};
  return {s.face[size_t(c.triangle)], c.point_mm};
}

std::string far_off() {
  return text("there is no bone within %.0f mm of that place; expected a place on it", kWorkFarthest_mm);
}
constexpr const char* kNoSurface = "the place lies on the wall of a cut or on a rim; expected the bone's own surface";

bool still(const Mesh& m, int32_t v) {
  bool s = m.flags[size_t(v)] & simplex::kLocked;
  for (const int32_t f : m.left[size_t(v)]) s |= m.kind(f) != FaceKind::surface;
  return s;
}

double volume_mm3(const Mesh& m, int32_t inside) {
  std::vector<int32_t> part_of;
  const int32_t parts = simplex::components(m, part_of);
  return bulks(m, part_of, parts)[size_t(part_of[size_t(inside)])].volume_mm3;
}

WorkedSurface split(Mesh& m, int32_t face, simplex::Delta& delta) {
  const auto done = simplex::t2_across(m, face, delta);
  if (!done) return cannot(std::string("the face cannot be split: ") + simplex::sentence(done.answer));
  return {{},
          text("a face of %d corners is split into two",
               int(m.face_size[size_t(done.face[0])] + m.face_size[size_t(done.face[1])] - 4))};
}

WorkedSurface merge(Mesh& m, const Found& at, simplex::Delta& delta) {
  int32_t from = -1, to = -1;
  double near = 1e300;
  m.around(at.face, [&](int32_t h) {
    const Vec3 &a = m.x_mm[size_t(m.from(h))], &b = m.x_mm[size_t(m.to(h))];
    const double t = std::clamp((at.at_mm - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-30), 0., 1.);
    const double d = (a + t * (b - a) - at.at_mm).norm();
    if (d < near) near = d, from = m.from(h), to = m.to(h);
  });
  if (still(m, from) || still(m, to)) return cannot(kNoSurface);
  const auto done = simplex::t1(m, from, to, delta);
  if (!done) return cannot(std::string("the faces cannot be merged: ") + simplex::sentence(done.answer));
  return {{}, text("two faces are merged into one of %d corners", int(m.face_size[size_t(done.face[0])]))};
}

WorkedSurface smooth(Mesh& m, const Found& at, const SurfaceWork& w, Workers& workers, simplex::Delta& delta) {
  int32_t seed = -1;
  for (const int32_t v : m.ring(at.face))
    if (seed < 0 || (m.x_mm[size_t(v)] - at.at_mm).norm() < (m.x_mm[size_t(seed)] - at.at_mm).norm()) seed = v;
  const SeamReport r = smooth_seam(m, std::vector<int32_t>{seed}, w.radius_mm, workers, delta);
  if (r.vertices == 0) return cannot("nothing that may move lies within that radius; expected surface away from cuts");
  return {{},
          text("%d places are smoothed, moved by %.2f mm at most; the bone's volume kept to %.1g of it",
               int(r.vertices), r.farthest_mm, std::abs(r.volume_change))};
}

double from_way(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((x - a).dot(d) / d.squaredNorm(), 0., 1.) : 0;
  return (a + t * d - x).norm();
}

WorkedSurface push(Mesh& m, int32_t inside, const SurfaceWork& w, Workers& workers, simplex::Delta& delta) {
  const double way = (w.to_mm - w.at_mm).norm(), R = w.radius_mm;
  const double steps = std::ceil(way / (kPushStep * R));
  if (steps > kMostPushSteps)
    return cannot(
        text("the ball's way is %.0f mm long; expected at most %.0f of its radii", way, kMostPushSteps * kPushStep));
  const std::vector<uint8_t> mine = component_of(m, inside);
  std::vector<int32_t> free;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (mine[size_t(v)] && !still(m, v) && from_way(m.x_mm[size_t(v)], w.at_mm, w.to_mm) < 2 * R) free.push_back(v);
  if (std::none_of(free.begin(), free.end(),
                   [&](int32_t v) { return from_way(m.x_mm[size_t(v)], w.at_mm, w.to_mm) < R; }))
    return cannot("the ball meets no surface that may move on its way; expected bone nearer to it than its radius");

  const double before = volume_mm3(m, inside);
  simplex::Edit e(m, delta);
  for (const int32_t v : free) e.save_vertex(v);
  std::vector<Vec3> was;
  for (const int32_t v : free) was.push_back(m.x_mm[size_t(v)]), m.before_mm[size_t(v)] = m.x_mm[size_t(v)];
  simplex::Law law;
  law.gamma = kDamping;
  law.zone.resize(2);
  law.zone[0].fixed = true;
  law.zone[1].constraint = simplex::Constraint::position;
  law.zone[1].alpha = kSpreadAlpha, law.zone[1].beta = kPushBeta;
  const std::vector<uint16_t> zones = m.zone;
  std::fill(m.zone.begin(), m.zone.end(), uint16_t(0));
  for (const int32_t v : free) m.zone[size_t(v)] = 1;
  ++m.version;
  simplex::Motion motion(workers);
  motion.set_law(law);
  simplex::Repulsor ball;
  ball.radius_mm = R, ball.beta = kPushBeta;
  Vec3 last = w.at_mm;
  for (int k = 0; k <= int(steps); ++k) {
    const Vec3 now = steps > 0 ? Vec3(w.at_mm + (k / steps) * (w.to_mm - w.at_mm)) : w.at_mm;
    for (int i = 0; i < kPushIterations; ++i) {
      ball.from_mm = i == 0 ? last : now, ball.to_mm = now;
      motion.step(m, {.force_mm = {}, .repulsor = std::span(&ball, 1)});
    }
    last = now;
  }
  m.zone = zones;
  ++m.version;
  double farthest = 0;
  int moved = 0;
  for (size_t i = 0; i < free.size(); ++i) {
    m.before_mm[size_t(free[i])] = m.x_mm[size_t(free[i])];
    const double d = (m.x_mm[size_t(free[i])] - was[i]).norm();
    farthest = std::max(farthest, d), moved += d > kUnmoved_mm;
  }
  for (const int32_t v : free) {
    e.reshape(v);
    for (const int32_t n : m.nbr[size_t(v)]) e.reshape(n);
  }
  return {{},
          text("%d places are pushed, by %.2f mm at most; the bone's volume goes by %+.0f mm^3", moved, farthest,
               volume_mm3(m, inside) - before)};
}

}  // namespace

WorkedSurface work_surface(Mesh& m, int32_t inside, const SurfaceWork& w, Workers& workers, simplex::Delta& delta) {
  using Kind = SurfaceWork::Kind;
  if (!w.at_mm.allFinite() || !w.to_mm.allFinite()) return cannot("a place is not finite");
  if ((w.kind == Kind::smooth || w.kind == Kind::push) && !(w.radius_mm > 0 && std::isfinite(w.radius_mm)))
    return cannot("the radius is not above 0");
  if (w.kind == Kind::push) return push(m, inside, w, workers, delta);
  const Found at = face_at(m, inside, w.at_mm);
  if (at.face < 0) return cannot(far_off());
  if (m.kind(at.face) != FaceKind::surface) return cannot(kNoSurface);
  switch (w.kind) {
    case Kind::split_face:
      return split(m, at.face, delta);
    case Kind::merge_faces:
      return merge(m, at, delta);
    default:
      return smooth(m, at, w, workers, delta);
  }
}

}  // namespace limberg::bone
