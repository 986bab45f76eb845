#include "sim/measure/metrics.h"

#include <algorithm>

namespace limberg {
namespace {

constexpr double kField_mm = 20;  // the operated skin reaches so far from the cuts: about one side of a flap

}  // namespace

ForceBalance force_balance(std::span<const HookState> hooks, std::span<const SutureState> sutures, const Vec3& support_force_mN) {
  ForceBalance b;
  constexpr double kLeast_N = 0.01;
  double all = 0;
  for (const HookState& h : hooks) {
    b.hooks_N += h.force_N.cast<double>();
    all += double(h.force_N.norm());
  }
  b.supports_N = -1e-3 * support_force_mN;  // on the tissue
  b.sum_N = b.hooks_N + b.supports_N;
  all += b.supports_N.norm();
  for (const SutureState& s : sutures) all += 2 * std::abs(double(s.force_N));
  b.relative = b.sum_N.norm() / std::max(all, kLeast_N);
  return b;
}

Metrics measure(const Snapshot& snapshot, const Skin& skin, const ElasticSolver& solver, const RestVolumes& volumes,
                std::span<const Command> script) {
  Metrics m;
  m.pieces = volumes.pieces;
  m.volume_mm3 = volumes.volume_mm3;
  m.removed_volume_mm3 = volumes.removed_mm3;
  m.initial_volume_mm3 = volumes.initial_mm3;
  if (volumes.initial_mm3 > 0) m.volume_change = (volumes.volume_mm3 + volumes.removed_mm3 - volumes.initial_mm3) / volumes.initial_mm3;

  for (const SutureState& s : snapshot.sutures) {
    const Vec3f at = 0.5f * (s.a_mm + s.b_mm);
    const SutureFigure f{s.id, double(s.force_N), double(s.gap_mm), {at.x(), at.y(), at.z()}};
    m.sutures.push_back(f);
    m.closure_force_N += f.force_N;
    m.suture_gap_max_mm = std::max(m.suture_gap_max_mm, f.gap_mm);
    if (m.suture_force_max_id == 0 || f.force_N > m.suture_force_max_N) {
      m.suture_force_max_N = f.force_N;
      m.suture_force_max_id = f.id;
    }
  }

  std::vector<float> J;
  solver.cell_J(J);
  if (!J.empty()) m.min_J = double(*std::min_element(J.begin(), J.end()));
  m.inverted_cells = int(std::count_if(J.begin(), J.end(), [](float j) { return !(j > 0); }));
  m.balance = force_balance(snapshot.hooks, snapshot.sutures, solver.support_force_mN());

  const SurfaceView& view = snapshot.topology->view;
  const std::span<const Vec3f> x = snapshot.x_mm;
  const SkinStrain strain = skin_strain(view, x, skin.body());
  m.stretch_max = strain.stretch_max;
  m.stretch_p99 = strain.stretch_p99;
  m.stress_max_kPa = strain.stress_max_kPa;
  m.stress_p95_kPa = strain.stress_p95_kPa;
  if (const std::vector<Vec3> rim = rim_mm(view); !rim.empty()) {
    const DogEar ear = dog_ear(view, x, skin, rim, kField_mm);
    m.dog_ear_mm = ear.height_mm;
    m.dog_ear_volume_mm3 = ear.volume_mm3;
    m.dog_ear_at_mm = ear.at_mm;
  }
  const WoundGape gape = wound_gape(view, x);
  m.wound_gape_mm = gape.gape_mm;
  m.wound_gape_mean_mm = gape.mean_mm;
  m.compression = compression(view, x);
  m.penetration = penetration(view, x);
  for (size_t i = 0; i < solver.contacts(); ++i) m.contact_force_N += 1e-3 * solver.contact_force_mN(i);

  if (const auto z = find_central_limb(script)) m.elongation = elongation(view, x, skin, *z);
  if (const auto f = find_transposition_flap(script)) m.flap_area_mm2 = skin_area_mm2(view, x, skin.body(), std::array{f->C, f->D, f->E, f->F});
  return m;
}

}  // namespace limberg
