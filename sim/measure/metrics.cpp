#include "sim/measure/metrics.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/polyline.h"
#include "sim/geometry/triangle.h"
#include "sim/measure/table.h"

namespace limberg {
namespace {

double skin_at_rest_mm2(const SurfaceView& view) {
  double sum = 0;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin)
      sum += 0.5 * area_vector2(view.X_mm[size_t(view.tri[t][0])], view.X_mm[size_t(view.tri[t][1])],
                                view.X_mm[size_t(view.tri[t][2])])
                       .norm();
  return sum;
}

// Of the skin at rest inside a chart polygon: the polygon, weighted with how far the skin leans from the chart, at
// points half a mm apart.
double rest_area_mm2(const Skin& skin, std::span<const ChartPoint> polygon) {
  constexpr double kStep_mm = 0.5;
  double plain = 0, leaning = 0;
  int n = 0;
  Vec2 lo = polygon[0], hi = polygon[0];
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    plain += 0.5 * (a.x() * b.y() - a.y() * b.x());
    lo = lo.cwiseMin(a), hi = hi.cwiseMax(a);
  }
  const double step = std::max(kStep_mm, (hi - lo).maxCoeff() / 100);
  for (double x = lo.x() + step / 2; x < hi.x(); x += step)
    for (double y = lo.y() + step / 2; y < hi.y(); y += step) {
      const Vec2 p(x, y);
      if (!inside_polygon(polygon, p)) continue;
      const auto hit = skin.at(p);
      if (!hit) continue;
      leaning += 1 / std::max(0.05, std::abs(hit->normal.dot(skin.body().chart_normal())));
      ++n;
    }
  return std::abs(plain) * (n > 0 ? leaning / n : 1);
}

constexpr double kField_mm = 20;  // the operated skin reaches so far from the cuts: about one side of a flap

}  // namespace

ForceBalance force_balance(std::span<const HookState> hooks, std::span<const SutureState> sutures,
                           const Vec3& support_force_mN, const Vec3& load_force_mN) {
  ForceBalance b;
  constexpr double kLeast_N = 0.01;
  double all = 0;
  for (const HookState& h : hooks) {
    b.hooks_N += h.force_N.cast<double>();
    all += double(h.force_N.norm());
  }
  b.supports_N = -1e-3 * support_force_mN;  // on the tissue
  b.loads_N = 1e-3 * load_force_mN;
  b.sum_N = b.hooks_N + b.supports_N + b.loads_N;
  all += b.supports_N.norm() + b.loads_N.norm();
  for (const SutureState& s : sutures) all += 2 * std::abs(double(s.force_N));
  b.relative = b.sum_N.norm() / std::max(all, kLeast_N);
  return b;
}

// Cells with J <= 0: how many, how much tissue is in them, and where in the body the largest part of it is.
static void look_at_inverted(std::span<const float> J, const FemModel& model, Metrics& m) {
  double largest_mm3 = 0;
  for (size_t c = 0; c < J.size(); ++c) {
    if (J[c] > 0) continue;
    ++m.inverted_cells;
    const HexCell& cell = model.cells[c];
    const double volume_mm3 = double(cell.scale) * model.stencils[size_t(cell.stencil)].volume_mm3;
    m.inverted_mm3 += volume_mm3;
    if (volume_mm3 <= largest_mm3) continue;
    largest_mm3 = volume_mm3;
    m.inverted_at_mm.setZero();
    for (const int32_t n : cell.node) m.inverted_at_mm += model.X_mm[size_t(n)] / 8;
  }
}

Metrics measure(const Snapshot& snapshot, const Skin& skin, const ElasticSolver& solver, const RestVolumes& volumes,
                std::span<const Command> script, const MeasureAlso& also) {
  Metrics m;
  m.pieces = volumes.pieces;
  m.volume_mm3 = volumes.volume_mm3;
  m.removed_volume_mm3 = volumes.removed_mm3;
  m.initial_volume_mm3 = volumes.initial_mm3;
  if (volumes.initial_mm3 > 0)
    m.volume_change = (volumes.volume_mm3 + volumes.removed_mm3 - volumes.initial_mm3) / volumes.initial_mm3;

  for (const SutureState& s : snapshot.sutures) {
    const Vec3f at = 0.5f * (s.a_mm + s.b_mm);
    SutureFigure f{s.id,
                   double(s.force_N),
                   double(s.gap_mm),
                   {at.x(), at.y(), at.z()},
                   s.thread,
                   std::nullopt,
                   std::max(double(s.peak_N), double(s.force_N))};
    if (s.tied_N >= 0) f.tied_N = double(s.tied_N);
    m.sutures.push_back(f);
    m.suture_force_peak_N = std::max(m.suture_force_peak_N, f.peak_N);
    m.sutures_over_2_5_N += f.force_N > kSutureForce_N.warn, m.sutures_over_5_N += f.force_N > kSutureForce_N.bad;
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
  look_at_inverted(J, solver.model(), m);
  m.balance = force_balance(snapshot.hooks, snapshot.sutures, solver.support_force_mN(),
                            solver.load_force_mN() + also.collider_force_mN + also.soft_hold_force_mN);

  const SurfaceView& view = snapshot.topology->view;
  const std::span<const Vec3f> x = snapshot.x_mm;
  const SkinStrain strain = skin_strain(view, x, skin.body());
  m.stretch_max = strain.stretch_max;
  m.stretch_p99 = strain.stretch_p99;
  m.stress_max_kPa = strain.stress_max_kPa;
  m.stress_p95_kPa = strain.stress_p95_kPa;
  m.beyond_law_mm2 = strain.beyond_law_mm2;
  if (strain.angle_deg >= 0) m.stress_fibre_angle_deg = strain.angle_deg;
  m.compressed_mm2 = strain.compressed_mm2;
  if (const std::vector<Vec3> rim = rim_mm(view); !rim.empty()) {
    const DogEar ear = dog_ear(view, x, skin, rim, kField_mm);
    m.dog_ear_mm = ear.height_mm;
    m.dog_ear_volume_mm3 = ear.volume_mm3;
    m.dog_ear_at_mm = ear.at_mm;
  }
  const WoundGape gape = wound_gape(view, x);
  m.wound_gape_mm = gape.gape_mm;
  m.wound_gape_mean_mm = gape.mean_mm;
  m.gape = gape;
  m.turned = turned_skin(view, x, skin);
  m.raw = raw_tissue(view, x, skin);
  m.one_bank = also.one_bank;
  for (const SutureFigure& s : m.sutures)
    if (s.force_N < kHolds_N) m.slack.push_back(s.id);
  m.scar_length_mm = 0.5 * gape.rim_now_mm;
  if (m.scar_length_mm > 0) m.closure_line_N_per_m = 1000 * m.closure_force_N / m.scar_length_mm;
  m.step_off_mm = gape.step_mm, m.step_off_mean_mm = gape.step_mean_mm;
  if (also.closure_energy_uJ) m.closure_energy_mJ = 1e-3 * *also.closure_energy_uJ;
  m.compression = compression(view, x);
  m.penetration = penetration(view, x);
  for (size_t i = 0; i < solver.contacts(); ++i) m.contact_force_N += 1e-3 * solver.contact_force_mN(i);

  if (const auto z = find_central_limb(script)) {
    m.elongations = elongations(view, x, skin, *z);
    if (m.elongations) m.elongation = m.elongations->direct;
  }
  const double gone_mm2 = skin.area_mm2() - skin_at_rest_mm2(view);
  m.excised_mm2 = gone_mm2 > 1e-9 * skin.area_mm2() ? gone_mm2 : 0;  // two long sums: what rounding leaves is nothing
  for (const Command& c : script)
    if (const auto* e = std::get_if<Excise>(&c)) {
      m.waste_mm2 = std::max(0.0, m.excised_mm2 - rest_area_mm2(skin, e->outline));
      break;
    }
  const SkinPoints points(view, skin);
  if (const auto plan = plan_of(skin, also.plan, script)) m.predicted = predicted_points(view, x, skin, points, *plan);
  for (const Landmark& l : also.landmarks) {
    m.landmarks.push_back({l.name, l.at, landmark(points, x, skin, l.at)});
    if (m.landmarks.back().figure)
      m.landmark_max_mm = std::max(m.landmark_max_mm, m.landmarks.back().figure->displacement_mm);
  }
  m.perfused = perfusion(view, skin);
  if (const auto f = find_transposition_flap(script))
    m.flap_area_mm2 = skin_area_mm2(view, x, skin.body(), std::array{f->C, f->D, f->E, f->F});
  return m;
}

}  // namespace limberg
