#include "sim/cutting/arrangement/arrangement.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/cutting/arrangement/cut_builder.h"
#include "sim/cutting/arrangement/radix_sort.h"

namespace limberg {

namespace {

constexpr int kTries = 8;
constexpr int kJitterUnits = 64;  // of the even grid: 8 micrometres

uint64_t scramble(uint64_t x) {  // SplitMix64's finalizer
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

std::string check_blade(const Blade& blade, const ArrangementStore& store) {
  if (blade.tri.empty()) return "the blade is empty";
  if (!blade.seed.empty() && blade.seed.size() != blade.tri.size())
    return "the blade's seeds do not match its triangles";
  if (!blade.uv_mm.empty() && blade.uv_mm.size() != blade.tri.size())
    return "the blade's uv do not match its triangles";
  if (!blade.shared_point.empty() && blade.shared_point.size() != blade.vertex.size())
    return "the blade's shared points do not match its vertices";
  constexpr int32_t limit = RestGrid::kMaxCoordinate - 2 * kJitterUnits;
  for (size_t i = 0; i < blade.vertex.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int32_t c = blade.vertex[i][k];
      if (c % 2 != 0) return "a blade vertex is not on the even grid";
      if (c > limit || c < -limit) return "the blade leaves the domain of the rest grid";
    }
    const int32_t shared = blade.shared_point.empty() ? -1 : blade.shared_point[i];
    if (shared < -1 || shared >= store.points.size()) return "the blade shares a point that does not exist";
    if (shared >= 0 && (!store.points.is_explicit(shared) || store.points.integer(shared) != blade.vertex[i]))
      return "the blade shares a point that is not an explicit point at the same place";
  }
  std::vector<uint64_t> edges, room;
  edges.reserve(blade.tri.size() * 3);
  const int bits = bits_of(blade.vertex.size());
  for (const Tri& t : blade.tri)
    for (size_t k = 0; k < 3; ++k) {
      if (t[k] < 0 || size_t(t[k]) >= blade.vertex.size()) return "a blade triangle names a vertex that does not exist";
      const int32_t next = t[k == 2 ? 0 : k + 1];
      edges.push_back(uint64_t(uint32_t(std::min(t[k], next))) << bits | uint32_t(std::max(t[k], next)));
    }
  radix_sort(edges, room, 2 * bits, [](uint64_t e) { return e; });
  for (size_t i = 0; i + 2 < edges.size(); ++i)
    if (edges[i] == edges[i + 2]) return "more than two triangles of the blade share an edge";
  return {};
}

}  // namespace

Arrangement::Arrangement(const TriMesh& surface, const RestGrid& grid) : store_(std::make_unique<ArrangementStore>()) {
  ArrangementStore& s = *store_;
  s.grid = grid;
  const size_t n = surface.tri.size();
  if (n == 0) throw InputError("", 0, "the body's surface has no triangles; expected a closed surface");
  s.points.reserve(surface.X_mm.size() * 2);
  s.face.reserve(n * 2);
  s.mate.reserve(n * 2);
  s.orig.reserve(n * 2);
  s.edges.reserve(n * 2);  // 1.5 n now
  s.edges.reserve_faces(n * 2);
  for (const Vec3& x : surface.X_mm) {
    if (!grid.fits(x)) throw InputError("", 0, "a surface vertex lies outside the rest grid's domain");
    s.points.add_explicit(grid.to_grid(x));
  }
  s.op.push_back({0, surface.uv, false, {}});
  for (size_t i = 0; i < n; ++i) {
    OrigTri o;
    for (size_t k = 0; k < 3; ++k) {
      if (surface.tri[i][k] < 0 || size_t(surface.tri[i][k]) >= surface.X_mm.size())
        throw InputError("", 0, "triangle " + std::to_string(i) + " of the surface names a vertex that does not exist");
      o.v[k] = surface.tri[i][k];
    }
    o.plane = plane_through(s.points.integer(o.v[0]), s.points.integer(o.v[1]), s.points.integer(o.v[2]));
    if (o.plane.n == std::array<int64_t, 3>{})
      throw InputError("", 0, "triangle " + std::to_string(i) + " of the surface has no area on the rest grid");
    o.live = 1;
    o.whole = int32_t(i);
    s.orig.push_back(o);
    s.face.push_back({o.v, int32_t(i), kMaterialMinus, false, 0});
    s.mate.push_back({-1, -1, -1, -1, -1, -1});
    s.edges.add(int32_t(i), o.v, s.face.back().outer());
    s.tag.push_back(i < surface.tag.size() ? surface.tag[i] : SurfaceTag::skin);
    s.hash_sum += s.face_hash(s.face.back());
    s.volume_residue = mod_add(s.volume_residue, s.face_volume_residue(s.face.back()));
  }
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = s.face[i].v[k], b = s.face[i].v[(k + 1) % 3];
      int count = 0, forward = 0;
      for (int32_t h = s.edges.first(a, b); h >= 0; h = s.edges.next(h))
        ++count, forward += s.face[h / 3].v[size_t(h % 3)] == a;
      if (count != 2 || forward != 1)
        throw InputError("", 0,
                         "the body's surface is not closed and oriented at triangle " + std::to_string(i) +
                             "; expected two triangles in opposite sense at every edge");
      if (a < b)
        if (const char* why = s.glue_edge(a, b, nullptr))
          throw InputError("", 0, std::string("the body's surface: ") + why + " at triangle " + std::to_string(i));
    }
  s.plant();
}

Arrangement::~Arrangement() = default;
Arrangement::Arrangement(Arrangement&&) noexcept = default;
Arrangement& Arrangement::operator=(Arrangement&&) noexcept = default;

void Arrangement::set_fault(FaultPlan* plan) { store_->points.fault = plan; }

CutResult Arrangement::cut(const Blade& blade, uint64_t seed, int first_try) {
  CutResult result;
  result.reason = check_blade(blade, *store_);
  if (!result.reason.empty()) return result;
  if (store_->is_cut_already(blade)) {
    result.status = CutResult::nothing_to_cut;
    result.reason = "this is cut already";
    return result;
  }
  std::optional<Blade> redrawn;
  for (int k = first_try; k < kTries; ++k) {
    result.tries = k + 1;
    // The first try takes the blade as it is; each further one
    // redraws every vertex that is not shared, or shared in vain.
    if (k > 0 && !redrawn && !blade.shared_point.empty()) {
      redrawn = blade;
      redrawn->shared_point = live_shared_points(*store_, blade);
    }
    const Blade& asked = redrawn ? *redrawn : blade;
    std::vector<Int3> vertex = blade.vertex;
    for (size_t i = 0; i < vertex.size() && k > 0; ++i) {
      if (!asked.shared_point.empty() && asked.shared_point[i] >= 0) continue;
      const uint64_t r = scramble(scramble(seed + uint64_t(k) * 0x632be59bd9b4e019ull) ^ i);
      const auto jitter = [&](int shift) {
        return 2 * (int32_t((r >> shift & 0xfffff) % (2 * kJitterUnits + 1)) - kJitterUnits);
      };
      vertex[i].x += jitter(0);
      vertex[i].y += jitter(21);
      vertex[i].z += jitter(42);
    }
    CutBuilder builder(*store_, asked, std::move(vertex));
    const CutBuilder::Outcome outcome = builder.run(result);
    result.reason = builder.reason();
    if (outcome == CutBuilder::coincidence) continue;
    result.status = outcome == CutBuilder::ok        ? CutResult::done
                    : outcome == CutBuilder::nothing ? CutResult::nothing_to_cut
                                                     : CutResult::refused;
    if (result.ok()) result.reason.clear();
    return result;
  }
  return result;
}

void Arrangement::make_room_to_undo(int32_t operations) {
  ArrangementStore& s = *store_;
  size_t faces = 0;
  for (size_t i = 0; i < size_t(operations) && i < s.history.size(); ++i) {
    const OperationDelta& d = s.history[s.history.size() - 1 - i];
    faces += d.mat.size() + d.retired.size();
  }
  s.edges.make_room(faces, int32_t(s.face.size()) - 1);
}

bool Arrangement::undo() {
  ArrangementStore& s = *store_;
  if (s.history.empty()) return false;
  make_room_to_undo(1);
  OperationDelta d = std::move(s.history.back());
  s.history.pop_back();
  s.take_back(d);
  s.last = LastOperation{};
  s.last.kind = LastOperation::undone;
  return true;
}

int32_t Arrangement::operations() const { return int32_t(store_->history.size()); }

uint64_t Arrangement::hash() const { return scramble(store_->hash_sum); }

uint64_t Arrangement::full_hash() const {
  const ArrangementStore& s = *store_;
  Hash64 h;
  h.add(s.hash_sum);
  h.add(s.volume_residue);
  for (int32_t i = 0; i < s.points.size(); ++i) {
    const Residues r = s.points.residues(i);
    for (uint64_t x : r) h.add(x);
    for (int k = 0; k < 3; ++k) h.add(s.points.approx(i)[k]);
  }
  for (size_t f = 0; f < s.face.size(); ++f) {
    const Face& face = s.face[f];
    for (int32_t v : face.v) h.add(v);
    h.add(face.orig);
    h.add(face.mat);
    h.add(uint8_t(face.retired));
    for (int32_t m : s.mate[f]) h.add(m);
  }
  for (size_t o = 0; o < s.orig.size(); ++o) {
    h.add(s.orig[o].live);
    for (int32_t f : s.faces_of(int32_t(o))) h.add(f);
    for (const Constraint& c : constraints_of(int32_t(o))) h.add(c.a), h.add(c.b), h.add(c.partner);
  }
  return h.value();
}

int32_t Arrangement::point_count() const { return store_->points.size(); }
Vec3 Arrangement::point_mm(int32_t i) const {
  return store_->grid.origin_mm + store_->grid.half_unit_mm() * store_->points.approx(i);
}
PointRef Arrangement::point(int32_t i) const { return store_->points.ref(i); }
bool Arrangement::is_explicit(int32_t i) const { return store_->points.is_explicit(i); }
Int3 Arrangement::explicit_point(int32_t i) const { return store_->points.integer(i); }
const RestGrid& Arrangement::grid() const { return store_->grid; }
std::span<const Face> Arrangement::faces() const { return store_->face; }
std::span<const OrigTri> Arrangement::orig_tris() const { return store_->orig; }
int32_t Arrangement::mate(int32_t h) const { return store_->mate[h / 6][size_t(h % 6)]; }
FaceKind Arrangement::kind_of_orig(int32_t o) const {
  if (store_->orig[o].op > 0) return FaceKind::wall;
  switch (store_->tag[o]) {
    case SurfaceTag::fixed:
      return FaceKind::fixed;
    case SurfaceTag::free:
      return FaceKind::free;
    default:
      return FaceKind::skin;
  }
}
std::span<const Constraint> Arrangement::constraints_of(int32_t o) const { return store_->constraints_of(o); }
std::span<const int32_t> Arrangement::faces_of_orig(int32_t o) const { return store_->faces_of(o); }
const LastOperation& Arrangement::last_operation() const { return store_->last; }

}  // namespace limberg
