#include "sim/patient/press_probe.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

// The lattice under the patch against a half space, 2026-11-21:
// radii of .95 to 1.5 h, by where the place lies in its cell.
constexpr double kPatch = 0.75, kFelt = 1.2;
// A layer between depths a and b has the share exp(-k a / r) - exp(-k b / r) in what a flat end of radius r meets: the
// form is King's, k of his curves for layers near as thick as the end is wide; three layered blocks came within 16 % of
// a lattice that resolves the end, 2026-11-21.
constexpr double kReach = 1.2;
constexpr double kStiffest_N_mm = 20;    // of the springs: what lies between a tip and skin is not harder
constexpr double kShallowest_mm = 0.25;  // a smaller depth would be lost in what the patient itself still moves
constexpr int32_t kFirstSpring = 1 << 30;

}  // namespace

double compliance_mm_N(std::span<const Layer> layers, double radius_mm) {
  double sum = 0, top = 0;
  for (size_t l = 0; l < layers.size(); ++l) {
    const double bottom = top + layers[l].thickness_mm;
    const double share = elementary::exp(-kReach * top / radius_mm) -
                         (l + 1 < layers.size() ? elementary::exp(-kReach * bottom / radius_mm) : 0);
    const Material& m = layers[l].material;
    sum += share * 1e3 * (1 - m.poisson * m.poisson) / (2 * radius_mm * m.young_kPa);  // kPa = mN / mm^2; 1e3 mN = 1 N
    top = bottom;
  }
  return sum;
}

namespace {

/// As thick as they are at a place of the skin.
std::vector<Layer> layers_at(const Body& body, const Vec3& X_mm) {
  std::vector<Layer> out = body.layers;
  size_t nearest = 0;
  for (size_t v = 1; v < body.surface.X_mm.size(); ++v)
    if ((body.surface.X_mm[v] - X_mm).squaredNorm() < (body.surface.X_mm[nearest] - X_mm).squaredNorm()) nearest = v;
  for (size_t l = 0; l < out.size(); ++l) out[l].thickness_mm = body.layer_thickness_mm(l, int32_t(nearest));
  return out;
}

}  // namespace

PressProbe::~PressProbe() = default;

void PressProbe::meet(const Pressed& p) {
  if (!solver_) solver_ = make_solver(workers_);
  if (model_ != p.model) {
    model_ = p.model;
    solver_->set_model(model_, {});
    solver_->restore(p.solver.save());
    pressed_by_.assign(model_->X_mm.size(), Vec3f::Zero());
  }
  if (version_ == p.surface.version && !around_.empty()) return;
  version_ = p.surface.version;
  const SurfaceView& view = p.surface.view;
  around_.assign(view.X_mm.size(), {});
  for (size_t t = 0; t < view.tri.size(); ++t)
    for (int k = 0; k < 3; ++k) around_[size_t(view.tri[t][size_t(k)])].push_back(int32_t(t));
  seen_.assign(view.tri.size(), 0);
}

// Vertices of the same kind of surface within the radius at rest
// that hang together with the place, by the area they stand for.
void PressProbe::find_patch(const Pressed& p, const PressQuestion& q, double radius_mm) {
  const SurfaceView& view = p.surface.view;
  const auto corner = [&](int32_t t, int k) -> const Vec3& {
    return view.X_mm[size_t(view.tri[size_t(t)][size_t(k)])];
  };
  Vec3 middle = Vec3::Zero();
  for (int k = 0; k < 3; ++k) middle += q.bary[size_t(k)] * corner(q.triangle, k);
  patch_.clear();
  queue_.assign(1, q.triangle);
  seen_[size_t(q.triangle)] = 1;
  const auto add = [&](int32_t v, double weight) {
    for (Touched& known : patch_)
      if (known.vertex == v) return void(known.weight += weight);
    patch_.push_back({v, weight});
  };
  for (size_t at = 0; at < queue_.size(); ++at) {
    const int32_t t = queue_[at];
    const double share = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm() / 6;
    for (int k = 0; k < 3; ++k) {
      if ((corner(t, k) - middle).norm() > radius_mm) continue;
      const int32_t v = view.tri[size_t(t)][size_t(k)];
      add(v, share);
      for (int32_t other : around_[size_t(v)])
        if (!seen_[size_t(other)] && view.kind[size_t(other)] == view.kind[size_t(q.triangle)])
          seen_[size_t(other)] = 1, queue_.push_back(other);
    }
  }
  for (int32_t t : queue_) seen_[size_t(t)] = 0;
  if (patch_.size() >= 3) return;
  patch_.clear();  // triangles wider than the patch: its corners, as the place lies between them
  for (int k = 0; k < 3; ++k)
    if (q.bary[size_t(k)] > 0) patch_.push_back({view.tri[size_t(q.triangle)][size_t(k)], q.bary[size_t(k)]});
}

PressAnswer PressProbe::ask(const Pressed& p, const PressQuestion& q, int iterations) {
  PressAnswer answer;
  answer.topology_version = q.topology_version, answer.triangle = q.triangle;
  if (q.topology_version != p.surface.version) return answer;
  if (q.triangle < 0 || size_t(q.triangle) >= p.surface.view.tri.size())
    throw InputError("", 0,
                     "triangle " + std::to_string(q.triangle) + " is pressed on; the surface has " +
                         std::to_string(p.surface.view.tri.size()));
  if (!q.normal.allFinite() || !std::isfinite(q.depth_mm) || !(q.radius_mm > 0))
    throw InputError("", 0, "a tool presses with a finite direction and depth and a radius above 0");
  meet(p);
  const double h = p.model->cell_mm.maxCoeff(), felt = std::max(kFelt * h, q.radius_mm);
  find_patch(p, q, std::max(kPatch * h, q.radius_mm));
  const double depth = std::max(q.depth_mm, kShallowest_mm);
  const SurfaceView& view = p.surface.view;
  std::vector<Layer> here;  // where they are not as thick everywhere
  if (!p.body.thickness_mm.empty()) here = layers_at(p.body, view.X_mm[size_t(view.tri[size_t(q.triangle)][0])]);
  const std::span<const Layer> layers = here.empty() ? p.body.layers : here;
  const double stiffness =
      1 / std::max(1 / kStiffest_N_mm, compliance_mm_N(layers, q.radius_mm) - compliance_mm_N(layers, felt));

  double weights = 0;
  for (const Touched& t : patch_) weights += t.weight;
  std::vector<Spring> springs(p.springs.begin(), p.springs.end());
  const size_t own = springs.size();
  for (size_t i = 0; i < patch_.size(); ++i) {
    Spring s;
    s.id = kFirstSpring + int32_t(i);
    s.a = p.surface.embedding[size_t(patch_[i].vertex)];
    s.to_world = true;
    s.target_mm = p.solver.position_mm(s.a) - depth * q.normal;
    s.k_N_per_mm = stiffness * patch_[i].weight / weights;
    springs.push_back(s);
  }
  const std::span<const Vec3f> now = p.solver.displacement_mm();
  std::vector<Vec3f> start(now.begin(), now.end());
  for (size_t i = 0; i < start.size(); ++i) start[i] += pressed_by_[i];
  solver_->set_displacement_mm(start);
  solver_->set_springs(springs);
  solver_->set_contacts(p.contacts);
  solver_->set_gravity(p.solver.gravity_m_s2());
  solver_->set_loads(p.solver.loads());
  StepSettings settings;
  settings.max_iterations = iterations;
  settings.tolerance = 1e-4;  // a stiffness to a few per cent; a hand tells 7 to 10
  const StepReport report = solver_->step(settings);

  double force_mN = 0;
  for (size_t i = own; i < springs.size(); ++i) force_mN -= solver_->spring_force_mN(springs[i].id).dot(q.normal);
  const std::span<const Vec3f> then = solver_->displacement_mm();
  for (size_t i = 0; i < then.size(); ++i) pressed_by_[i] = then[i] - now[i];
  answer.depth_mm = q.depth_mm;
  answer.stiffness_N_mm = std::max(0.0, 1e-3 * force_mN / depth);
  answer.residual = float(report.residual), answer.iterations = report.iterations;
  return answer;
}

}  // namespace limberg
