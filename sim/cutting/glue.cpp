// The gluing rule: live faces around an edge, sorted; consecutive ones bound a sector of material or of nothing.
#include <algorithm>

#include "sim/cutting/store.h"

namespace limberg {

namespace {

// Where h lies as seen from g, turning counter-clockwise around a -> b: 0 in (0, 180), 1 at 180, 2 in (180, 360), -1
// coinciding.
int sector(const PointStore& points, int32_t a, int32_t b, const RadialFace& g, const RadialFace& h) {
  if (g.orig == h.orig) return g.sense == h.sense ? -1 : 1;
  const int side = g.sense * side_of_plane(g.plane, points.ref(h.third));
  if (side > 0) return 0;
  if (side < 0) return 2;
  const int sg = orient2d(g.plane, points.ref(a), points.ref(b), points.ref(g.third));
  const int sh = orient2d(g.plane, points.ref(a), points.ref(b), points.ref(h.third));
  return sg * sh < 0 ? 1 : -1;
}

}  // namespace

bool sort_radially(const PointStore& points, int32_t a, int32_t b, std::vector<RadialFace>& faces) {
  if (faces.size() < 3) return faces.size() < 2 || faces[0].orig != faces[1].orig || faces[0].sense != faces[1].sense;
  struct Item {
    RadialFace face;
    int sector;
  };
  std::vector<Item> items;
  bool ok = true;
  for (size_t i = 0; i < faces.size(); ++i) {
    const int s = i == 0 ? -2 : sector(points, a, b, faces[0], faces[i]);
    if (s == -1) ok = false;
    items.push_back({faces[i], s});
  }
  // Within an open half turn "h is counter-clockwise of g" is an order. Few faces meet here: insertion sort.
  for (size_t i = 2; i < items.size(); ++i)
    for (size_t j = i; j > 1; --j) {
      bool before = items[j].sector < items[j - 1].sector;
      if (items[j].sector == items[j - 1].sector) {
        const int s = sector(points, a, b, items[j].face, items[j - 1].face);
        if (s == -1 || s == 1) ok = false;
        before = s == 0;
      }
      if (!before) break;
      std::swap(items[j], items[j - 1]);
    }
  for (size_t i = 0; i < faces.size(); ++i) faces[i] = items[i].face;
  return ok;
}

std::string ArrangementStore::glue_edge(int32_t a, int32_t b, Delta* delta) {
  thread_local std::vector<RadialFace> around;
  around.clear();
  for (int32_t h = edges.first(a, b); h >= 0; h = edges.next(h)) {
    const Face& f = face[h / 3];
    const size_t k = size_t(h % 3);
    RadialFace r;
    r.orig = f.orig;
    r.plane = orig[f.orig].plane;
    r.sense = f.v[k] == a ? 1 : -1;
    r.third = f.v[(k + 2) % 3];
    r.mat = f.mat;
    r.half_edge = h;
    around.push_back(r);
  }
  if (around.empty()) return {};
  std::sort(around.begin(), around.end(),
            [](const RadialFace& x, const RadialFace& y) { return x.half_edge < y.half_edge; });
  if (!sort_radially(points, a, b, around)) return "two faces coincide at an edge";
  const auto set = [&](int32_t half_edge, int side, int32_t value) {
    int32_t& m = mate[half_edge / 3][size_t(3 * side + half_edge % 3)];
    if (m == value) return;
    if (delta) delta->mate.push_back({(half_edge / 3) * 6 + 3 * side + half_edge % 3, m});
    m = value;
  };
  for (size_t i = 0; i < around.size(); ++i) {
    const RadialFace &g = around[i], &h = around[(i + 1) % around.size()];
    if (g.ccw_material() != h.cw_material()) return "the two faces of a sector disagree about material";
    const int gs = g.ccw_side(), hs = 1 - h.ccw_side();
    const bool glued = g.ccw_material();
    set(g.half_edge, gs, glued ? (h.half_edge / 3) * 6 + 3 * hs + h.half_edge % 3 : -1);
    set(h.half_edge, hs, glued ? (g.half_edge / 3) * 6 + 3 * gs + g.half_edge % 3 : -1);
  }
  return {};
}

uint64_t ArrangementStore::face_hash(const Face& f) const {
  uint64_t h = uint64_t(f.orig) * 4 + f.mat;
  const auto mix = [&h](uint64_t v) {
    h = (h ^ v) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 31;
  };
  for (int32_t v : f.v)
    for (uint64_t r : points.residues(v)) mix(r);
  return h * 0xff51afd7ed558ccdull;
}

uint64_t ArrangementStore::face_volume_residue(const Face& f) const {
  if (f.mat == 0 || f.mat == (kMaterialPlus | kMaterialMinus)) return 0;  // two banks cancel
  const Residues a = points.residues(f.v[0]), b = points.residues(f.v[1]), c = points.residues(f.v[2]);
  uint64_t det = 0;
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det = mod_add(det, mod_mul(a[i], mod_sub(mod_mul(b[j], c[k]), mod_mul(b[k], c[j]))));
  }
  // Material on the negative side: the stored orientation faces outward.
  return f.mat == kMaterialMinus ? det : mod_sub(0, det);
}

}  // namespace limberg
