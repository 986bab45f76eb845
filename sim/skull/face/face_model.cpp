#include "sim/skull/face/face_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/skull/face/face_parts.h"

namespace limberg::simplex {
namespace {

Outcome refuse(std::string why) { return {false, std::move(why)}; }

}  // namespace

FaceModel::FaceModel(Mesh face, Workers& workers, const FaceModelSettings& settings)
    : workers_(&workers), settings_(settings), face_(std::move(face)), rest_mm_(face_.x_mm) {
  face_.before_mm = face_.x_mm;
  record_shape(face_);
}
FaceModel::FaceModel(const FaceModel& o)
    : workers_(o.workers_),
      settings_(o.settings_),
      face_(o.face_),
      rest_mm_(o.rest_mm_),
      region_(o.region_),
      warnings_(o.warnings_),
      u_mm_(o.u_mm_),
      frame_(o.frame_),
      bones_mm_(o.bones_mm_),
      elastic_(o.elastic_),
      at_rest_(o.at_rest_),
      elastic_rest_(o.elastic_rest_),
      simplex_rest_(o.simplex_rest_),
      still_(o.still_) {}
FaceModel& FaceModel::operator=(const FaceModel& o) {
  if (this != &o) *this = FaceModel(o);
  return *this;
}
FaceModel::FaceModel(FaceModel&&) noexcept = default;
FaceModel& FaceModel::operator=(FaceModel&&) noexcept = default;
FaceModel::~FaceModel() = default;

bool FaceModel::any(bool elastic) const {
  return std::any_of(region_.begin(), region_.end(),
                     [&](const Region& r) { return (r.plan.mode == TissueKind::finite_elements) == elastic; });
}

Outcome FaceModel::connect(const Mesh& bones, FaceTissuePlan plan, const Mesh* at_rest) {
  for (const Region& r : region_) {
    if (r.plan.name == plan.name)
      return refuse("there is a tissue " + plan.name + " already; another name was expected");
    std::vector<uint8_t> has(face_.nbr.size(), 0);
    for (int32_t v : r.face_vertex) has[size_t(v)] = 1;
    const auto both = std::count_if(plan.face_region.begin(), plan.face_region.end(),
                                    [&](int32_t v) { return face_.alive(v) && has[size_t(v)]; });
    if (both > 0)
      return refuse("its region of the face overlaps that of tissue " + r.plan.name + " (" + std::to_string(both) +
                    " of " + std::to_string(plan.face_region.size()) +
                    " vertices); expected a place farther from it or a smaller radius");
  }
  if (plan.mode == TissueKind::finite_elements && !(plan.young_kPa > 0))
    return refuse("finite elements need a stiffness above 0 kPa");
  TissueSettings s;
  s.layers = plan.layers, s.young_kPa = plan.young_kPa, s.max_thickness_mm = settings_.max_thickness_mm;
  if (plan.mode == TissueKind::finite_elements) s.floor = plan.floor, s.mend = plan.mend;
  TissueResult built = build_tissue(face_, plan.face_region, bones, plan.skull_region, s, *workers_);
  // Vertices over columns that cannot be mended are left out, until the rest stands.
  const size_t asked = plan.face_region.size();
  while (!built && !built.unsound.empty()) {
    std::vector<int32_t> bad = std::move(built.unsound), rest = plan.face_region;
    std::sort(bad.begin(), bad.end());
    std::erase_if(rest, [&](int32_t v) { return std::binary_search(bad.begin(), bad.end(), v); });
    rest = patch_of(face_, std::move(rest));
    if (double(rest.size()) < (1 - plan.leave_out) * double(asked)) break;
    plan.face_region = std::move(rest);
    built = build_tissue(face_, plan.face_region, bones, plan.skull_region, s, *workers_);
  }
  if (built && settings_.elasticity.skin_kPa > 0 && plan.young_kPa > 0 && plan.mode != TissueKind::finite_elements) {
    // The skin's share of the top layer is known once there is one.
    s.skin_kPa = top_layer_kPa(built.tissue, plan.young_kPa, settings_.elasticity);
    built = build_tissue(face_, plan.face_region, bones, plan.skull_region, s, *workers_);
  }
  if (!built) return refuse(built.reason);
  Region r;
  r.tissue = std::move(built.tissue);
  Tissue& t = r.tissue;
  const Mesh& rest = at_rest ? *at_rest : bones;
  const size_t columns = t.link.size(), tets = t.tet.size(), n = t.node_mm.size() / size_t(t.layers + 1);
  r.column.resize(t.nbr.size());
  // Tetrahedra come layer by layer, three per triangle of the region; a boundary vertex hangs on one of them.
  for (size_t v = 0; v < t.nbr.size(); ++v) r.column[v] = int32_t((v < tets ? v : size_t(t.nbr[v][0])) / 3 % columns);
  r.face_vertex.resize(columns), r.foot.resize(columns), r.top.resize(columns);
  for (const auto& [v, f] : t.link) {
    const size_t c = size_t(r.column[size_t(v)]);
    r.face_vertex[c] = f;
  }
  for (size_t c = 0; c < columns; ++c) {
    size_t k = 0;
    for (int32_t i : t.tet[tets - 3 * columns + 3 * c + 2])
      if (size_t(i) >= n * size_t(t.layers)) r.top[c][k++] = i;
  }
  for (const BoneAnchor& a : t.anchor) {
    r.foot[size_t(r.column[size_t(a.vertex)])] = int32_t(r.anchor.size());
    r.anchor.push_back(make_foot(a, bones, rest));
  }
  if (plan.mode == TissueKind::finite_elements) {
    const Standing ground(bones, plan.skull_region);
    for (size_t i = 0; i < n; ++i) {
      BoneAnchor a;
      a.vertex = int32_t(i);
      if (ground.stand(t.node_mm[i], a) < 0) return refuse("the region of the skull has no surface");
      r.under.push_back(make_foot(a, bones, rest));
    }
    for (size_t c = 0; c < columns; ++c)
      r.over.push_back(local_frame(face_.x_mm[size_t(r.face_vertex[c])], t.node_mm[size_t(r.top[c][0])],
                                   t.node_mm[size_t(r.top[c][1])], t.node_mm[size_t(r.top[c][2])]));
    const Eigen::Isometry3d back = frame_.inverse();
    for (Vec3& X : t.node_mm) X = back * X;
  }
  std::vector<int32_t> component;
  components(bones, component);
  r.fragments = fragments_under(component, r.anchor);
  r.plan = std::move(plan);
  region_.push_back(std::move(r));
  bones_mm_ = bones.x_mm;
  if (region_.back().plan.mode == TissueKind::finite_elements) make_elasticity();
  zones();
  return {true, ""};
}

void FaceModel::make_elasticity() {
  std::vector<FaceElasticity::Body> bodies;
  std::vector<std::pair<size_t, size_t>> old;  // region, its place among the bodies before
  for (const Region& r : region_)
    if (r.plan.mode == TissueKind::finite_elements) bodies.push_back({&r.tissue, r.plan.young_kPa});
  auto next = std::make_shared<FaceElasticity>(bodies, settings_.elasticity, *workers_);
  std::vector<Vec3> u(next->nodes(), Vec3::Zero());
  if (elastic_) {
    size_t body = 0;
    for (const Region& r : region_) {
      if (r.plan.mode != TissueKind::finite_elements) continue;
      if (body + 1 < bodies.size())  // the last one is new
        for (size_t i = 0; i < r.tissue.node_mm.size(); ++i)
          u[size_t(next->node(body, i))] = u_mm_[size_t(elastic_->node(body, i))];
      ++body;
    }
  }
  elastic_ = std::move(next);
  u_mm_ = std::move(u);
}

void FaceModel::zones() {
  std::vector<double> far(face_.nbr.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, int32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  for (const Region& r : region_)
    if (r.plan.mode != TissueKind::smoothing)
      for (int32_t v : r.face_vertex) far[size_t(v)] = 0, open.push({0, v});
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > far[size_t(v)]) continue;
    for (int32_t w : face_.nbr[size_t(v)])
      if (const double e = d + (rest_mm_[size_t(w)] - rest_mm_[size_t(v)]).norm();
          e <= settings_.transition_mm && e < far[size_t(w)])
        far[size_t(w)] = e, open.push({e, w});
  }
  for (size_t v = 0; v < far.size(); ++v) face_.zone[v] = std::isfinite(far[v]) ? kFree : kFar;
  for (const Region& r : region_)
    if (r.plan.mode == TissueKind::finite_elements)
      for (int32_t v : r.face_vertex) face_.zone[size_t(v)] = kCarried;
  // Tissue that is not elastic pulls at the free vertices; that holds them.
  if (any(true) && !any(false) && !shape_rests())
    for (uint16_t& z : face_.zone)
      if (z == kFree) z = kEvened;
  ++face_.version;
}

bool FaceModel::shape_rests() const {
  constexpr double kPush_mm = 1e-3;  // small beside edges of a few mm: the constraint is as good as linear
  constexpr int kWarm = 100, kMore = 100;
  Mesh m = face_;
  m.x_mm = rest_mm_;
  uint64_t state = 1;  // of Knuth's generator (MMIX): any start that has a share of every motion will do
  const auto push = [&] {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return kPush_mm * (double(state >> 11) / 9007199254740992. - 0.5);
  };
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v) && m.zone[size_t(v)] == kFree) m.x_mm[size_t(v)] += Vec3(push(), push(), push());
  m.before_mm = m.x_mm;
  ++m.version;
  // Without inertia and half of the way at a time: what the constraint shrinks shrinks, what it stretches grows.
  Law law;
  law.gamma = 1, law.zone.resize(3), law.zone[kFree] = {Constraint::shape, 0.5, 0, 1, false};
  law.zone[kCarried].fixed = law.zone[kFar].fixed = true;
  Motion motion(*workers_);
  if (!motion.set_law(law)) return false;
  const auto off = [&] {
    double sum = 0;
    for (int32_t v = 0; v < m.slots(); ++v)
      if (m.alive(v) && m.zone[size_t(v)] == kFree) sum += (m.x_mm[size_t(v)] - rest_mm_[size_t(v)]).squaredNorm();
    return sum;
  };
  for (int i = 0; i < kWarm; ++i) motion.step(m);
  const double before = off();
  for (int i = 0; i < kMore; ++i) motion.step(m);
  return off() <= before;
}

std::vector<const Tissue*> FaceModel::tissues() const {
  std::vector<const Tissue*> out;
  for (const Region& r : region_) out.push_back(&r.tissue);
  return out;
}

std::vector<std::string> FaceModel::describe() const {
  std::vector<std::string> out;
  for (const Region& r : region_) {
    const std::string line =
        fmt::format("{}: {}, {} layers, {} vertices of the face over {} of tissue ({} tetrahedra), {:.1f} kPa",
                    r.plan.name, kTissueKinds[size_t(r.plan.mode)], r.tissue.layers, r.face_vertex.size(),
                    r.tissue.vertices(), r.tissue.tet.size(), r.plan.young_kPa);
    out.push_back(line);
    if (r.plan.mode == TissueKind::springs || r.plan.mode == TissueKind::shape)
      out.back() += "; " + free_motions(size_t(&r - region_.data()));
  }
  const std::vector<FaceBundle>& bundles = settings_.elasticity.bundles;
  for (size_t b = 0; b < bundles.size(); ++b) {
    const FaceElasticity::Bundled in = elastic_ ? elastic_->bundled()[b] : FaceElasticity::Bundled{};
    out.push_back(
        in.tetrahedra > 0
            ? fmt::format("muscle {}: {} tetrahedra, {:.0f} mm³", bundles[b].name, in.tetrahedra, in.volume_mm3)
            : fmt::format("muscle {} lies in no finite elements beneath the skin", bundles[b].name));
  }
  const std::vector<FaceSlide>& slides = settings_.elasticity.slides;
  for (size_t k = 0; k < slides.size(); ++k) {
    const FaceElasticity::Bundled in = elastic_ ? elastic_->sliding()[k] : FaceElasticity::Bundled{};
    out.push_back(in.tetrahedra > 0 ? fmt::format("skin slides on bone, {}: {} tetrahedra, {:.0f} mm³, {:.3g} kPa a mm",
                                                  slides[k].name, in.tetrahedra, in.volume_mm3, slides[k].kPa_per_mm)
                                    : fmt::format("slide {} lies in no finite elements of two layers or more on bone",
                                                  slides[k].name));
  }
  return out;
}

std::string FaceModel::free_motions(size_t region, int64_t dense_up_to) const {
  const Region& r = region_[region];
  const ZeroModes z = zero_energy_modes(r.tissue, dense_up_to);
  return fmt::format("its springs leave {}{} of {} motions free ({:.2f} per free vertex){}", z.estimate ? "about " : "",
                     z.modes, z.dofs, z.dofs > 0 ? 3 * double(z.modes) / double(z.dofs) : 0.,
                     r.plan.mode == TissueKind::shape || settings_.hold > 0 ? ", held by the shape force" : "");
}

FaceModel::Moved FaceModel::moved() const {
  Moved m;
  int64_t n = 0;
  for (int32_t v = 0; v < face_.slots(); ++v) {
    if (!face_.alive(v) || face_.zone[size_t(v)] == kFar) continue;
    const double d = (face_.x_mm[size_t(v)] - rest_mm_[size_t(v)]).norm();
    m.rms_mm += d * d, m.max_mm = std::max(m.max_mm, d), ++n;
  }
  if (n > 0) m.rms_mm = std::sqrt(m.rms_mm / double(n));
  return m;
}

uint64_t FaceModel::hash() const {
  Hash64 h;
  h.add(simplex::hash(face_));
  for (const Region& r : region_) h.add(r.plan.name), h.add(r.plan.mode), h.add(simplex::hash(r.tissue));
  for (const Vec3& u : u_mm_)
    for (int k = 0; k < 3; ++k) h.add(u[k]);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) h.add(frame_.matrix()(i, k));
  return h.value();
}

}  // namespace limberg::simplex
