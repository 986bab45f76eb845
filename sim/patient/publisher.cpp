#include "sim/patient/publisher.h"

namespace limberg {

void Publisher::fill(const Tissue& tissue, const Holding& holding, const LastStep& last, Snapshot& snapshot,
                     bool with_field) {
  const std::shared_ptr<const SurfaceTopology>& topology = tissue.version().surface;
  const SurfaceTopology& surface = *topology;
  const ElasticSolver& solver = tissue.solver();
  snapshot.topology_version = surface.version;
  if (snapshot.topology != topology) snapshot.topology = topology;
  const std::span<const Vec3f> u = solver.displacement_mm();
  const size_t n = surface.view.X_mm.size();
  snapshot.x_mm.resize(n);
  for (size_t v = 0; v < n; ++v) {
    const EmbeddedPoint& e = surface.embedding[v];
    Vec3f d = Vec3f::Zero();
    for (size_t i = 0; i < 8; ++i) d += e.w[i] * u[size_t(e.node[i])];
    snapshot.x_mm[v] = surface.view.X_mm[v].cast<float>() + d;
  }
  snapshot.hooks.clear();
  for (const Hook& h : holding.hooks) {
    const Vec3 at = tissue.position_mm(h.anchor.embedded);
    snapshot.hooks.push_back(
        {h.id, at.cast<float>(), h.handle_mm.cast<float>(), (solver.spring_force_mN(h.spring) * 1e-3).cast<float>()});
  }
  snapshot.sutures.clear();
  for (const Stitch& s : holding.stitches) {
    if (!s.across()) continue;
    const Vec3 a = tissue.position_mm(s.a.embedded), b = tissue.position_mm(s.b.embedded);
    snapshot.sutures.push_back(
        {s.id, a.cast<float>(), b.cast<float>(), float(solver.spring_force_mN(s.spring).norm() * 1e-3),
         float((tissue.held_mm(s.a) - tissue.held_mm(s.b)).norm()), s.thread, float(s.tied_N), float(s.peak_N)});
  }
  snapshot.residual = last.residual;
  snapshot.distance_mm = last.distance_mm;
  if (!with_field) {
    snapshot.field.clear();
    return;
  }
  if (!tension_ || tension_version_ != surface.version) {
    tension_ = std::make_unique<TensionField>(surface, tissue.skin());
    tension_version_ = surface.version;
  }
  tension_->compute(surface, solver, snapshot.field);
}

}  // namespace limberg
