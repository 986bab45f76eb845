#include "sim/contact/contact_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "sim/base/elementary.h"
#include "sim/contact/contact_stiffness.h"
#include "sim/geometry/triangle.h"
#include "sim/lattice/embedding.h"

namespace limberg {
namespace {

constexpr double kSkinReach_mm = 8;  // skin so near to a rim can be touched
// In usual shares of a place: a piece of wall that holds nothing
// apart, and a bin that leaves its share to its neighbours.
constexpr double kSliver = 0.02, kSmall = 0.35;
constexpr double kSpacing_mm = 1.75;  // places are never farther apart than about this
constexpr double kTurned = 0.34;      // sine of the least turn of a sharp edge, 20 degrees

/// Marks of a coarse grid: is a point within reach of any of the points marked before (to a grid cell)?
class NearMarks {
 public:
  NearMarks(const Vec3& lo, const Vec3& hi, double reach) : lo_(lo - Vec3::Constant(2 * reach)), step_(reach / 2) {
    const Vec3 size = hi - lo + Vec3::Constant(4 * reach);
    for (int a = 0; a < 3; ++a) count_[size_t(a)] = int64_t(size[a] / step_) + 1;
    mark_.assign(size_t(count_[0] * count_[1] * count_[2]), 0);
  }
  void mark(const Vec3& p) {
    const std::array<int64_t, 3> c = cell(p);
    for (int64_t z = c[2] - 2; z <= c[2] + 2; ++z)
      for (int64_t y = c[1] - 2; y <= c[1] + 2; ++y)
        for (int64_t x = c[0] - 2; x <= c[0] + 2; ++x)
          if (inside({x, y, z})) mark_[index({x, y, z})] = 1;
  }
  bool near(const Vec3& p) const {
    const std::array<int64_t, 3> c = cell(p);
    return inside(c) && mark_[index(c)] != 0;
  }

 private:
  std::array<int64_t, 3> cell(const Vec3& p) const {
    const Vec3 c = (p - lo_) / step_;
    return {int64_t(std::floor(c[0])), int64_t(std::floor(c[1])), int64_t(std::floor(c[2]))};
  }
  bool inside(const std::array<int64_t, 3>& c) const {
    for (size_t a = 0; a < 3; ++a)
      if (c[a] < 0 || c[a] >= count_[a]) return false;
    return true;
  }
  size_t index(const std::array<int64_t, 3>& c) const { return size_t((c[2] * count_[1] + c[1]) * count_[0] + c[0]); }
  Vec3 lo_;
  double step_;
  std::array<int64_t, 3> count_{};
  std::vector<uint8_t> mark_;
};

/// 1 per triangle of the view that can be touched.
std::vector<uint8_t> touchable(const SurfaceView& view) {
  std::vector<uint8_t> out(view.tri.size(), 0), on_wall(view.X_mm.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::wall) {
      out[t] = 1;
      for (int32_t v : view.tri[t]) on_wall[size_t(v)] = 1;
    }
  std::vector<int32_t> rim;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin)
      for (int32_t v : view.tri[t])
        if (on_wall[size_t(v)] == 1) on_wall[size_t(v)] = 2, rim.push_back(v);
  if (rim.empty()) return out;
  Vec3 lo = view.X_mm[size_t(rim[0])], hi = lo;
  for (int32_t v : rim) lo = lo.cwiseMin(view.X_mm[size_t(v)]), hi = hi.cwiseMax(view.X_mm[size_t(v)]);
  NearMarks marks(lo, hi, kSkinReach_mm);
  for (int32_t v : rim) marks.mark(view.X_mm[size_t(v)]);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin) {
      const Tri& c = view.tri[t];
      out[t] = marks.near((view.X_mm[size_t(c[0])] + view.X_mm[size_t(c[1])] + view.X_mm[size_t(c[2])]) / 3);
    }
  return out;
}

/// A triangle of a wall, and the bin of the wall that it falls into.
struct Binned {
  int32_t copy = 0, bin = 0, facing = 0;  // cell copy, place in the cell, main direction of the normal
  int32_t triangle = 0;                   // of the contact surface
  Vec3 middle = Vec3::Zero();
  double area = 0;
  auto key() const { return std::tuple(copy, facing, bin); }
};

/// `except`: an axis along which all is one bin, or -1.
int32_t bin_in_cell(const Vec3& at, int parts, int except) {
  int32_t bin = 0;
  for (int a = 2; a >= 0; --a) bin = bin * 64 + (a == except ? 0 : std::clamp(int(std::floor(at[a] * parts)), 0, 63));
  return bin;
}

/// Where a wall runs on evenly, a cell's piece of it is one bin;
/// within a cell of its borders, `parts` in each direction.
void put_into_bins(std::vector<Binned>& wall, const ContactSurface& s, const FemModel& model, const Vec3& cell,
                   int parts) {
  if (wall.empty()) return;
  Vec3 lo = s.X_mm[0], hi = lo;
  for (const Vec3& x : s.X_mm) lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
  NearMarks borders(lo, hi, cell.maxCoeff());
  for (size_t v = 0; v < s.X_mm.size(); ++v) {
    const std::span<const int32_t> around = s.triangles_around(int32_t(v));
    if (std::any_of(around.begin(), around.end(),
                    [&](int32_t t) { return s.sheets.of[size_t(t)] != s.sheets.of[size_t(around[0])]; }))
      borders.mark(s.X_mm[v]);
  }
  for (Binned& b : wall) {
    const Vec3& low = model.X_mm[size_t(s.lattice->cells[size_t(b.copy)].node[0])];
    b.bin = borders.near(low + 0.5 * cell) ? bin_in_cell((b.middle - low).cwiseQuotient(cell), parts, b.facing / 2) : 0;
  }
}

/// A corner of a wall's triangle on a sharp edge, in the bin of its cell copy.
struct EdgePoint {
  int32_t copy = 0, bin = 0, sheet = 0, vertex = 0;
  int32_t triangle = 0, corner = 0;
  double length = 0;  // half of the sharp edges of that triangle that end here
  auto key() const { return std::tuple(copy, bin, sheet, vertex); }
};

/// Walls end in edges that can go into other tissue: where the sheet beside turns away, backwards.
std::vector<EdgePoint> edge_points(const ContactSurface& s, const FemModel& model, std::span<const uint8_t> kind,
                                   const Vec3& cell, int parts) {
  std::vector<EdgePoint> out;
  for (size_t t = 0; t < s.tri.size(); ++t) {
    if (FaceKind(kind[t]) != FaceKind::wall) continue;
    const Tri& c = s.tri[t];
    const Vec3 n2 = area_vector2(s.X_mm[size_t(c[0])], s.X_mm[size_t(c[1])], s.X_mm[size_t(c[2])]);
    if (!(n2.norm() > 0)) continue;
    const Vec3 n = n2.normalized();
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = c[k], b = c[(k + 1) % 3];
      const Vec3 along = s.X_mm[size_t(b)] - s.X_mm[size_t(a)];
      for (int32_t u : s.triangles_around(a)) {
        const Tri& d = s.tri[size_t(u)];
        if (s.sheets.of[size_t(u)] == s.sheets.of[t] || (d[0] != b && d[1] != b && d[2] != b)) continue;
        const int32_t third = d[0] != a && d[0] != b ? d[0] : d[1] != a && d[1] != b ? d[1] : d[2];
        const Vec3 beyond = s.X_mm[size_t(third)] - s.X_mm[size_t(a)];
        const double height = area_vector2(s.X_mm[size_t(d[0])], s.X_mm[size_t(d[1])], s.X_mm[size_t(d[2])]).norm();
        if (n.dot(beyond) * along.norm() > -kTurned * height) continue;  // it turns forwards, or hardly
        for (const size_t end : {k, (k + 1) % 3}) {
          EdgePoint p;
          p.vertex = c[end], p.triangle = int32_t(t), p.corner = int32_t(end), p.sheet = s.sheets.of[t];
          p.copy = s.view->cell_copy[size_t(s.vertex[size_t(p.vertex)])];
          p.length = 0.5 * along.norm();
          const Vec3 low = model.X_mm[size_t(s.lattice->cells[size_t(p.copy)].node[0])];
          p.bin = bin_in_cell((s.X_mm[size_t(p.vertex)] - low).cwiseQuotient(cell), parts, -1);
          out.push_back(p);
        }
      }
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const EdgePoint& a, const EdgePoint& b) { return a.key() < b.key(); });
  return out;
}

/// One place for each bin of edge: the corner of most sheets,
/// or else the point that is nearest to the bin's own middle.
void add_edge_places(ContactSurface& s, const FemModel& model, std::span<const EdgePoint> points, double spacing) {
  std::vector<int32_t> sheets;
  const auto sheets_at = [&](int32_t v) {
    sheets.clear();
    for (int32_t t : s.triangles_around(v))
      if (std::find(sheets.begin(), sheets.end(), s.sheets.of[size_t(t)]) == sheets.end())
        sheets.push_back(s.sheets.of[size_t(t)]);
    return int(sheets.size());
  };
  const auto same = [](const EdgePoint& a, const EdgePoint& b) {
    return a.copy == b.copy && a.bin == b.bin && a.sheet == b.sheet;
  };
  for (size_t from = 0, to; from < points.size(); from = to) {
    Vec3 middle = Vec3::Zero();
    double length = 0;
    for (to = from; to < points.size() && same(points[to], points[from]); ++to)
      middle += points[to].length * s.X_mm[size_t(points[to].vertex)], length += points[to].length;
    if (length < kSmall * spacing) continue;
    middle /= length;
    size_t best = from;
    auto rank = [&](size_t i) {
      return std::pair(-sheets_at(points[i].vertex), (s.X_mm[size_t(points[i].vertex)] - middle).squaredNorm());
    };
    for (size_t i = from + 1; i < to; ++i)
      if (rank(i) < rank(best)) best = i;
    ContactPlace p;
    p.triangle = points[best].triangle;
    p.bary = {0, 0, 0};
    p.bary[size_t(points[best].corner)] = 1;
    p.copy = points[best].copy;
    p.X_mm = s.X_mm[size_t(points[best].vertex)];
    p.embedded = s.embedding[size_t(points[best].vertex)];
    p.area_mm2 = 0.5 * spacing * length;
    p.stiffness_kPa = young_kPa(model, p.copy);
    s.place.push_back(p);
  }
}

}  // namespace

EmbeddedPoint ContactSurface::embedded(int32_t t, const std::array<double, 3>& bary) const {
  const Vec3 X = rest_mm(t, bary);
  int32_t copy = carrier[size_t(t)];
  if (cell_of(*lattice, X) != lattice->cells[size_t(copy)].cell)
    copy = copy_of_point(*lattice, *view, in_view[size_t(t)], bary);
  return embed_in_copy(*lattice, copy, X);
}

std::shared_ptr<const ContactSurface> contact_surface(std::shared_ptr<const SurfaceView> view_ptr,
                                                      const SharedArray<EmbeddedPoint>& embedding,
                                                      std::shared_ptr<const LatticeTopology> lattice_ptr,
                                                      const FemModel& model) {
  const SurfaceView& view = *view_ptr;
  const LatticeTopology& lattice = *lattice_ptr;
  if (std::none_of(view.kind.begin(), view.kind.end(), [](FaceKind k) { return k == FaceKind::wall; })) return nullptr;
  auto s = std::make_shared<ContactSurface>();
  const std::vector<uint8_t> wanted = touchable(view);
  std::vector<int32_t> here(view.X_mm.size(), -1);
  std::vector<Binned> wall;
  std::vector<uint8_t> kind;
  const Vec3 cell = lattice.grid.cell_mm();
  const int parts = std::max(2, int(std::ceil(cell.maxCoeff() / kSpacing_mm - 1e-6)));
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (!wanted[t]) continue;
    Tri tri{};
    for (size_t k = 0; k < 3; ++k) {
      const int32_t v = view.tri[t][k];
      if (here[size_t(v)] < 0) {
        here[size_t(v)] = int32_t(s->vertex.size());
        s->vertex.push_back(v);
        s->X_mm.push_back(view.X_mm[size_t(v)]);
        s->embedding.push_back(embedding[size_t(v)]);
      }
      tri[k] = here[size_t(v)];
    }
    Vec3 middle = Vec3::Zero();
    const int32_t copy = copy_of_point(lattice, view, int32_t(t), {1.0 / 3, 1.0 / 3, 1.0 / 3}, &middle);
    const Vec3 area2 = area_vector2(s->X_mm[size_t(tri[0])], s->X_mm[size_t(tri[1])], s->X_mm[size_t(tri[2])]);
    if (view.kind[t] == FaceKind::wall && area2.norm() > 0) {
      Binned b;
      int axis = 0;
      area2.cwiseAbs().maxCoeff(&axis);
      b.facing = 2 * axis + (area2[axis] > 0);
      b.copy = copy, b.triangle = int32_t(s->tri.size()), b.middle = middle, b.area = 0.5 * area2.norm();
      wall.push_back(b);
    }
    s->tri.push_back(tri);
    s->in_view.push_back(int32_t(t));
    s->carrier.push_back(copy);
    kind.push_back(uint8_t(view.kind[t]));
  }
  s->around_begin.assign(s->vertex.size() + 1, 0);
  for (const Tri& t : s->tri)
    for (int32_t v : t) ++s->around_begin[size_t(v) + 1];
  std::partial_sum(s->around_begin.begin(), s->around_begin.end(), s->around_begin.begin());
  s->around.resize(3 * s->tri.size());
  std::vector<int32_t> fill(s->around_begin.begin(), s->around_begin.end() - 1);
  for (size_t t = 0; t < s->tri.size(); ++t)
    for (int32_t v : s->tri[t]) s->around[size_t(fill[size_t(v)]++)] = int32_t(t);

  s->sheets = find_sheets(s->X_mm, s->tri, kind, s->around_begin, s->around);
  s->view = std::move(view_ptr), s->lattice = std::move(lattice_ptr);

  put_into_bins(wall, *s, model, cell, parts);
  // One place for each bin: the middle of the triangle that is nearest to the bin's own.
  std::stable_sort(wall.begin(), wall.end(), [](const Binned& a, const Binned& b) { return a.key() < b.key(); });
  const double whole = elementary::pow(cell.mean() / parts, 2);
  for (size_t first = 0, last; first < wall.size(); first = last) {  // a wall's piece in one cell copy
    double total = 0, kept = 0;
    for (last = first;
         last < wall.size() && wall[last].copy == wall[first].copy && wall[last].facing == wall[first].facing; ++last)
      total += wall[last].area;
    if (total < kSliver * whole) continue;
    const size_t before = s->place.size();
    double largest = 0;
    for (int pass = 0; pass < 2 && s->place.size() == before; ++pass)  // small bins only where there is no other
      for (size_t from = first, to; from < last; from = to) {
        Vec3 middle = Vec3::Zero();
        double area = 0;
        for (to = from; to < last && wall[to].bin == wall[from].bin; ++to)
          middle += wall[to].area * wall[to].middle, area += wall[to].area;
        if (pass == 0) largest = std::max(largest, area);
        if (area < (pass == 0 ? kSmall * whole : largest)) continue;
        middle /= area;
        size_t best = from;
        for (size_t i = from + 1; i < to; ++i)
          if ((wall[i].middle - middle).squaredNorm() < (wall[best].middle - middle).squaredNorm()) best = i;
        ContactPlace p;
        p.triangle = wall[best].triangle;
        p.copy = wall[best].copy;
        p.X_mm = wall[best].middle;
        p.embedded = embed_in_copy(lattice, wall[best].copy, p.X_mm);
        p.area_mm2 = area, kept += area;
        p.stiffness_kPa = young_kPa(model, p.copy);
        s->place.push_back(p);
      }
    for (size_t i = before; i < s->place.size(); ++i) s->place[i].area_mm2 *= total / kept;
  }
  add_edge_places(*s, model, edge_points(*s, model, kind, cell, parts), cell.mean() / parts);
  std::stable_sort(s->place.begin(), s->place.end(),
                   [](const ContactPlace& a, const ContactPlace& b) { return a.copy < b.copy; });
  return s;
}

}  // namespace limberg
