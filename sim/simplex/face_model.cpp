#include "sim/simplex/face_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <queue>
#include <set>

#include "sim/error.h"
#include "sim/geometry/bvh.h"
#include "sim/hash.h"
#include "sim/simplex/dual.h"
#include "sim/simplex/motion.h"

namespace limberg::simplex {
namespace {

enum Zone : uint16_t { kFree = 0, kCarried = 1, kFar = 2 };
constexpr int kStillFor = 5;

Vec3 place_of(const Anchor& a, const Mesh& m) {
  const Vec3 &A = m.x_mm[size_t(a.skull[0])], &B = m.x_mm[size_t(a.skull[1])], &C = m.x_mm[size_t(a.skull[2])];
  Vec3 x = a.weight[0] * A + a.weight[1] * B + a.weight[2] * C;
  const Vec3 N = (B - A).cross(C - A);
  if (const double l = N.norm(); l > 0) x += a.height_mm / l * N;
  return x;
}

/// The surface of bones as triangles to stand on: cut faces and holes are none.
struct Ground {
  FanTriangles fan;
  Bvh bvh;
  explicit Ground(const Mesh& m, std::span<const int32_t> region = {}) : fan(fan_triangles(m)) {
    std::vector<uint8_t> in(m.face_edge.size(), region.empty());
    for (int32_t v : region)
      if (m.alive(v))
        for (int32_t f : m.left[size_t(v)]) in[size_t(f)] = 1;
    std::vector<int32_t> subset;
    for (size_t t = 0; t < fan.face.size(); ++t)
      if (in[size_t(fan.face[t])] && m.kind(fan.face[t]) == FaceKind::surface) subset.push_back(int32_t(t));
    if (!subset.empty()) bvh = Bvh(fan.X_mm, fan.tri, subset);
  }
};

/// The place of the ground nearest to p, by three vertices of the face it lies in.
bool stand(const Ground& g, const Mesh& m, const Vec3& p, Anchor& a) {
  if (g.bvh.empty()) return false;
  const Bvh::Closest c = g.bvh.closest(p);
  const Tri& t = g.fan.tri[size_t(c.triangle)];
  const std::vector<int32_t> ring = m.ring(g.fan.face[size_t(c.triangle)]);
  const size_t at = size_t(std::find(ring.begin(), ring.end(), t[1]) - ring.begin());
  a.skull[0] = t[1], a.skull[1] = t[2], a.skull[2] = ring[(at + 1 + ring.size() / 2) % ring.size()];
  const LocalFrame f = local_frame(p, m.x_mm[size_t(a.skull[0])], m.x_mm[size_t(a.skull[1])], m.x_mm[size_t(a.skull[2])]);
  for (size_t k = 0; k < 3; ++k) a.weight[k] = f.e[k];
  a.height_mm = f.L_mm;
  a.axes = axes_of(a, m);
  return true;
}

limberg::Outcome refuse(std::string why) { return {false, std::move(why)}; }

int fragments_under(const std::vector<int32_t>& component, const auto& feet) {
  std::set<int32_t> seen;
  for (const auto& f : feet)
    if (f.at.skull[0] >= 0) seen.insert(component[size_t(f.at.skull[0])]);
  return int(seen.size());
}

}  // namespace

const char* name_of(FaceMode m) {
  switch (m) {
    case FaceMode::smoothing: return "smoothing";
    case FaceMode::springs: return "springs";
    case FaceMode::shape: return "shape";
    case FaceMode::finite_elements: return "finite elements";
  }
  return "";
}

struct FaceModel::Scratch {
  explicit Scratch(Workers& w) : motion(w) {}
  Motion motion;
  std::vector<Vec3> force;
};

FaceModel::FaceModel(Mesh face, Workers& workers, const FaceModelSettings& settings) : workers_(&workers), settings_(settings), face_(std::move(face)), rest_mm_(face_.x_mm) {
  face_.before_mm = face_.x_mm;
  record_shape(face_);
}
FaceModel::FaceModel(const FaceModel& o)
    : workers_(o.workers_), settings_(o.settings_), face_(o.face_), rest_mm_(o.rest_mm_), region_(o.region_), warnings_(o.warnings_), u_mm_(o.u_mm_), elastic_(o.elastic_),
      at_rest_(o.at_rest_), elastic_rest_(o.elastic_rest_), simplex_rest_(o.simplex_rest_), still_(o.still_) {}
FaceModel& FaceModel::operator=(const FaceModel& o) {
  if (this != &o) *this = FaceModel(o);
  return *this;
}
FaceModel::FaceModel(FaceModel&&) noexcept = default;
FaceModel& FaceModel::operator=(FaceModel&&) noexcept = default;
FaceModel::~FaceModel() = default;

bool FaceModel::any(bool elastic) const {
  return std::any_of(region_.begin(), region_.end(), [&](const Region& r) { return (r.plan.mode == FaceMode::finite_elements) == elastic; });
}

limberg::Outcome FaceModel::connect(const Mesh& bones, FaceTissuePlan plan, const Mesh* at_rest) {
  for (const Region& r : region_) {
    if (r.plan.name == plan.name) return refuse("there is a tissue " + plan.name + " already; another name was expected");
    std::vector<uint8_t> has(face_.nbr.size(), 0);
    for (int32_t v : r.face_vertex) has[size_t(v)] = 1;
    for (int32_t v : plan.face_region)
      if (face_.alive(v) && has[size_t(v)]) return refuse("vertex " + std::to_string(v) + " of the face belongs to tissue " + r.plan.name + " already");
  }
  if (plan.mode == FaceMode::finite_elements && !(plan.young_kPa > 0)) return refuse("finite elements need a stiffness above 0 kPa");
  TissueSettings s;
  s.layers = plan.layers, s.young_kPa = plan.young_kPa, s.max_thickness_mm = settings_.max_thickness_mm;
  TissueResult built = build_tissue(face_, plan.face_region, bones, plan.skull_region, s, *workers_);
  if (!built) return refuse(built.reason);
  Region r;
  r.tissue = std::move(built.tissue);
  Tissue& t = r.tissue;
  const Mesh& rest = at_rest ? *at_rest : bones;
  const size_t columns = t.link.size(), tets = t.tet.size(), n = t.node_mm.size() / size_t(t.layers + 1);
  r.column.resize(t.nbr.size());
  // Tetrahedra come layer by layer, three per triangle of the region; a boundary vertex hangs on one of them.
  for (size_t v = 0; v < t.nbr.size(); ++v) r.column[v] = int32_t((v < tets ? v : size_t(t.nbr[v][0])) / 3 % columns);
  r.face_vertex.resize(columns), r.start_mm.resize(columns), r.foot.resize(columns), r.top.resize(columns);
  for (const auto& [v, f] : t.link) {
    const size_t c = size_t(r.column[size_t(v)]);
    r.face_vertex[c] = f, r.start_mm[c] = face_.x_mm[size_t(f)];
  }
  for (size_t c = 0; c < columns; ++c) {
    size_t k = 0;
    for (int32_t i : t.tet[tets - 3 * columns + 3 * c + 2])
      if (size_t(i) >= n * size_t(t.layers)) r.top[c][k++] = i;
  }
  const auto foot = [&](const Anchor& a) {
    Foot f;
    f.at = a, f.rest_mm = place_of(a, rest), f.now_mm = place_of(a, bones);
    f.turn = axes_of(a, bones) * axes_of(a, rest).transpose();
    return f;
  };
  for (const Anchor& a : t.anchor) {
    r.foot[size_t(r.column[size_t(a.vertex)])] = int32_t(r.anchor.size());
    r.anchor.push_back(foot(a));
  }
  if (plan.mode == FaceMode::finite_elements) {
    const Ground ground(bones, plan.skull_region);
    for (size_t i = 0; i < n; ++i) {
      Anchor a;
      a.vertex = int32_t(i);
      if (!stand(ground, bones, t.node_mm[i], a)) return refuse("the region of the skull has no surface");
      r.under.push_back(foot(a));
    }
  }
  std::vector<int32_t> component;
  components(bones, component);
  r.fragments = fragments_under(component, r.anchor);
  r.plan = std::move(plan);
  region_.push_back(std::move(r));
  if (region_.back().plan.mode == FaceMode::finite_elements) make_elasticity();
  zones();
  return {true, ""};
}

void FaceModel::make_elasticity() {
  std::vector<FaceElasticity::Body> bodies;
  std::vector<std::pair<size_t, size_t>> old;  // region, its place among the bodies before
  for (const Region& r : region_)
    if (r.plan.mode == FaceMode::finite_elements) bodies.push_back({&r.tissue, r.plan.young_kPa});
  auto next = std::make_shared<FaceElasticity>(bodies, settings_.elasticity, *workers_);
  std::vector<Vec3> u(next->nodes(), Vec3::Zero());
  if (elastic_) {
    size_t body = 0;
    for (const Region& r : region_) {
      if (r.plan.mode != FaceMode::finite_elements) continue;
      if (body + 1 < bodies.size())  // the last one is new
        for (size_t i = 0; i < r.tissue.node_mm.size(); ++i) u[size_t(next->node(body, i))] = u_mm_[size_t(elastic_->node(body, i))];
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
    if (r.plan.mode != FaceMode::smoothing)
      for (int32_t v : r.face_vertex) far[size_t(v)] = 0, open.push({0, v});
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > far[size_t(v)]) continue;
    for (int32_t w : face_.nbr[size_t(v)])
      if (const double e = d + (rest_mm_[size_t(w)] - rest_mm_[size_t(v)]).norm(); e <= settings_.transition_mm && e < far[size_t(w)]) far[size_t(w)] = e, open.push({e, w});
  }
  for (size_t v = 0; v < far.size(); ++v) face_.zone[v] = std::isfinite(far[v]) ? kFree : kFar;
  for (const Region& r : region_)
    if (r.plan.mode == FaceMode::finite_elements)
      for (int32_t v : r.face_vertex) face_.zone[size_t(v)] = kCarried;
  ++face_.version;
}

void FaceModel::follow(const Mesh& bones) {
  bool moved = false;
  // Where a foot carries what stands over it: x -> Q x + c. Returns how far the foot itself goes.
  const auto carry = [&](const Region& r, Foot& f, Mat3& Q, Vec3& c) {
    for (int32_t v : f.at.skull)
      if (!bones.alive(v)) throw InputError("", 0, "tissue " + r.plan.name + " stands on vertex " + std::to_string(v) + " of the bones, which has gone; rebind was expected");
    const Vec3 x = place_of(f.at, bones);
    const double far = (x - f.now_mm).norm();
    if (!(far > 0)) {
      Q = Mat3::Identity(), c = Vec3::Zero();
      return far;
    }
    const Mat3 turn = axes_of(f.at, bones) * f.at.axes.transpose();
    Q = turn * f.now_turn.transpose(), c = x - Q * f.now_mm;
    f.now_mm = x, f.now_turn = turn;
    return far;
  };
  size_t body = 0;
  for (Region& r : region_) {
    Tissue& t = r.tissue;
    const bool elastic = r.plan.mode == FaceMode::finite_elements;
    bool here = false;
    std::vector<Mat3> Q(r.foot.size());
    std::vector<Vec3> c(r.foot.size());
    for (size_t k = 0; k < r.foot.size(); ++k) here |= carry(r, r.anchor[size_t(r.foot[k])], Q[k], c[k]) > 1e-9;
    if (elastic) {
      const size_t n = r.under.size();
      for (Foot& f : r.under) {
        const size_t i = size_t(f.at.vertex);
        Mat3 R;
        Vec3 shift;
        if (!(carry(r, f, R, shift) > 1e-9)) continue;
        here = true;
        for (size_t l = 0; l <= size_t(t.layers); ++l) {
          Vec3& u = u_mm_[size_t(elastic_->node(body, l * n + i))];
          const Vec3& X = t.node_mm[l * n + i];
          u = l == 0 ? Vec3(f.now_mm - X) : Vec3(R * (X + u) + shift - X);
        }
      }
      ++body;
    }
    if (!here) continue;
    moved = true, simplex_rest_ = false;
    if (elastic) {
      elastic_rest_ = false;
      continue;
    }
    for (size_t v = 0; v < t.nbr.size(); ++v) {
      if (t.role[v] == TissueRole::face) continue;
      const size_t k = size_t(r.column[v]);
      t.x_mm[v] = Q[k] * t.x_mm[v] + c[k], t.before_mm[v] = t.x_mm[v];
    }
    if (r.plan.mode != FaceMode::smoothing)
      for (size_t k = 0; k < r.foot.size(); ++k) {
        Vec3& x = face_.x_mm[size_t(r.face_vertex[k])];
        x = Q[k] * x + c[k], face_.before_mm[size_t(r.face_vertex[k])] = x;
      }
    for (size_t i = 0; i < t.link.size(); ++i) t.lift_mm[i] = r.anchor[size_t(t.under[i])].now_turn * t.lift0_mm[i];
  }
  if (moved) at_rest_ = false, still_ = 0;
}

void FaceModel::place_elastic() {
  size_t body = 0;
  for (Region& r : region_) {
    if (r.plan.mode != FaceMode::finite_elements) continue;
    Tissue& t = r.tissue;
    const auto u = [&](int32_t i) -> const Vec3& { return u_mm_[size_t(elastic_->node(body, size_t(i)))]; };
    for (size_t c = 0; c < r.top.size(); ++c) {
      Vec3& x = face_.x_mm[size_t(r.face_vertex[c])];
      x = r.start_mm[c] + (u(r.top[c][0]) + u(r.top[c][1]) + u(r.top[c][2])) / 3;
      face_.before_mm[size_t(r.face_vertex[c])] = x;
    }
    for (size_t k = 0; k < t.tet.size(); ++k) {
      Vec3 x = Vec3::Zero();
      for (int32_t i : t.tet[k]) x += 0.25 * (t.node_mm[size_t(i)] + u(i));
      t.x_mm[k] = x;
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
  law.zone.resize(3);
  law.zone[kFree] = {Constraint::shape, settings_.alpha, settings_.beta, 1, false};
  law.zone[kCarried].fixed = law.zone[kFar].fixed = true;
  if (const Admission a = scratch_->motion.set_law(law); !a) throw InputError("", 0, a.refused);
  std::vector<Vec3>& force = scratch_->force;
  // Rest is the face's: springs leave motions inside the tissue that nothing brings to an end.
  const bool influence = std::any_of(region_.begin(), region_.end(), [](const Region& r) { return r.plan.mode != FaceMode::smoothing; });
  for (; out.iterations < iterations; ++out.iterations) {
    force.assign(face_.nbr.size(), Vec3::Zero());
    out.max_move_mm = 0;
    for (Region& r : region_) {
      if (r.plan.mode == FaceMode::finite_elements) continue;
      for (const Foot& f : r.anchor) r.tissue.x_mm[size_t(f.at.vertex)] = f.now_mm;
      for (const auto& [v, f] : r.tissue.link) r.tissue.x_mm[size_t(v)] = face_.x_mm[size_t(f)];
      TissueLaw l;
      l.mode = r.plan.mode == FaceMode::smoothing ? TissueMode::smoothing : TissueMode::springs;
      l.shape = r.plan.mode == FaceMode::shape ? settings_.mix : 0;
      l.spring = settings_.spring, l.gamma = settings_.gamma;
      out.max_move_mm = std::max(out.max_move_mm, simplex::step(r.tissue, l, *workers_).max_move_mm);
      pull_face(r.tissue, l, force);
    }
    const double face_move = scratch_->motion.step(face_, {force, {}}).max_move_mm;
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

void FaceModel::rebind(const Mesh& rest) {
  warnings_.clear();
  if (region_.empty()) return;
  std::vector<int32_t> component;
  components(rest, component);
  std::unique_ptr<Ground> ground;  // made when the first one has lost its footing
  const auto bind = [&](Foot& f) {
    const Anchor& a = f.at;
    const bool alive = rest.alive(a.skull[0]) && rest.alive(a.skull[1]) && rest.alive(a.skull[2]);
    if (alive && component[size_t(a.skull[0])] == component[size_t(a.skull[1])] && component[size_t(a.skull[1])] == component[size_t(a.skull[2])] &&
        (place_of(a, rest) - f.rest_mm).norm() < 1e-9)
      return;
    if (!ground) ground = std::make_unique<Ground>(rest);
    if (!stand(*ground, rest, f.rest_mm, f.at)) throw InputError("", 0, "there is no bone for the tissue to stand on");
    f.at.axes = f.turn * f.at.axes;
  };
  for (Region& r : region_) {
    for (Foot& f : r.anchor) bind(f);
    for (Foot& f : r.under) bind(f);
    for (size_t i = 0; i < r.anchor.size(); ++i) r.tissue.anchor[i] = r.anchor[i].at;
    const int now = fragments_under(component, r.anchor);
    if (now > r.fragments)
      warnings_.push_back("tissue " + r.plan.name + " hangs on " + std::to_string(now) + " fragments now (" + std::to_string(r.fragments) + " when it was made): a cut goes through its region");
  }
}

std::vector<const Tissue*> FaceModel::tissues() const {
  std::vector<const Tissue*> out;
  for (const Region& r : region_) out.push_back(&r.tissue);
  return out;
}

std::vector<std::string> FaceModel::describe() const {
  std::vector<std::string> out;
  for (const Region& r : region_) {
    char line[300];
    std::snprintf(line, sizeof line, "%s: %s, %d layers, %zu vertices of the face over %d of tissue (%zu tetrahedra), %.1f kPa", r.plan.name.c_str(), name_of(r.plan.mode), r.tissue.layers,
                  r.face_vertex.size(), r.tissue.vertices(), r.tissue.tet.size(), r.plan.young_kPa);
    out.push_back(line);
    if (r.plan.mode == FaceMode::springs || r.plan.mode == FaceMode::shape) {
      const ZeroModes z = zero_energy_modes(r.tissue);
      std::snprintf(line, sizeof line, "; its springs leave %lld of %lld motions free (%.2f per free vertex)%s", static_cast<long long>(z.modes), static_cast<long long>(z.dofs),
                    z.dofs > 0 ? 3 * double(z.modes) / double(z.dofs) : 0., r.plan.mode == FaceMode::shape ? ", held by the shape force" : "");
      out.back() += line;
    }
  }
  return out;
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
  return h.value();
}

}  // namespace limberg::simplex
