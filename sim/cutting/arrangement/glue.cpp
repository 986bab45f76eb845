// The gluing rule: live faces around an edge, sorted; consecutive ones bound a sector of material or of nothing.
#include <algorithm>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

namespace {

// Where h lies as seen from g, turning counter-clockwise around a
// -> b: 0 in (0, 180), 1 at 180, 2 in (180, 360), -1 coinciding.
int sector(const PointStore& points, int32_t a, int32_t b, const RadialFace& g, const RadialFace& h) {
  if (g.orig == h.orig) return g.sense == h.sense ? -1 : 1;
  const int side = g.sense * points.side(*g.plane, h.third);
  if (side > 0) return 0;
  if (side < 0) return 2;
  const int sg = points.turn(*g.plane, a, b, g.third);
  const int sh = points.turn(*g.plane, a, b, h.third);
  return sg * sh < 0 ? 1 : -1;
}

}  // namespace

bool sort_radially(const PointStore& points, int32_t a, int32_t b, std::vector<RadialFace>& faces) {
  if (faces.size() < 3) return faces.size() < 2 || faces[0].orig != faces[1].orig || faces[0].sense != faces[1].sense;
  bool ok = true;
  faces[0].sector = -2;
  for (size_t i = 1; i < faces.size(); ++i) {
    faces[i].sector = sector(points, a, b, faces[0], faces[i]);
    if (faces[i].sector == -1) ok = false;
  }
  // Within an open half turn "h is counter-clockwise of g" is an order. Few faces meet here: insertion sort.
  for (size_t i = 2; i < faces.size(); ++i)
    for (size_t j = i; j > 1; --j) {
      bool before = faces[j].sector < faces[j - 1].sector;
      if (faces[j].sector == faces[j - 1].sector) {
        const int s = sector(points, a, b, faces[j], faces[j - 1]);
        if (s == -1 || s == 1) ok = false;
        before = s == 0;
      }
      if (!before) break;
      std::swap(faces[j], faces[j - 1]);
    }
  return ok;
}

const char* ArrangementStore::glue_edge(int32_t a, int32_t b, int32_t h0, OperationDelta* delta) {
  const auto set = [&](int32_t f, int side, int k, int32_t value) {
    int32_t& m = mate[size_t(f)][size_t(3 * side + k)];
    if (m == value) return;
    if (delta && f < delta->faces) delta->mate.push_back({sided_half_edge(sided_face(f, side), k), m});
    m = value;
  };
  // Faces i and i + 1 bound a sector. As data: the half-edge's face
  // and place in it, its counter-clockwise side, material bits.
  struct Around {
    int32_t face;
    int k, ccw_side;
    uint8_t mat;
  };
  const auto join = [&](const Around& g, const Around& h) {
    const int gs = g.ccw_side, hs = 1 - h.ccw_side;
    const bool glued = g.mat >> gs & 1;
    if (glued != bool(h.mat >> hs & 1)) return false;
    set(g.face, gs, g.k, glued ? sided_half_edge(sided_face(h.face, hs), h.k) : -1);
    set(h.face, hs, h.k, glued ? sided_half_edge(sided_face(g.face, gs), g.k) : -1);
    return true;
  };
  const auto here = [&](int32_t h) {
    const int32_t f = h / 3;
    const int k = h % 3;
    return Around{f, k, face[size_t(f)].v[size_t(k)] == a ? 0 : 1, face[size_t(f)].mat};
  };
  constexpr const char* kDisagree = "the two faces of a sector disagree about material";
  constexpr const char* kCoincide = "two faces coincide at an edge";
  if (h0 < 0) return nullptr;
  const int32_t h1 = edges.next(h0);
  if (h1 < 0) {  // a crack front
    const Around g = here(h0);
    return join(g, g) ? nullptr : kDisagree;
  }
  const int32_t h2 = edges.next(h1);
  if (h2 < 0) {  // nearly always
    const Around g = here(std::min(h0, h1)), h = here(std::max(h0, h1));
    if (g.ccw_side == h.ccw_side && face[size_t(g.face)].orig == face[size_t(h.face)].orig) return kCoincide;
    return join(g, h) && join(h, g) ? nullptr : kDisagree;
  }
  thread_local std::vector<RadialFace> around;
  around.clear();
  for (int32_t h = h0; h >= 0; h = edges.next(h)) {
    const Face& f = face[h / 3];
    const size_t k = size_t(h % 3);
    RadialFace r;
    r.orig = f.orig;
    r.plane = &orig[f.orig].plane;
    r.sense = f.v[k] == a ? 1 : -1;
    r.third = f.v[(k + 2) % 3];
    r.mat = f.mat;
    r.half_edge = h;
    size_t at = around.size();  // by half-edge
    around.push_back(r);
    for (; at > 0 && around[at - 1].half_edge > h; --at) std::swap(around[at], around[at - 1]);
  }
  if (!sort_radially(points, a, b, around)) return kCoincide;
  for (size_t i = 0; i < around.size(); ++i) {
    const int32_t g = around[i].half_edge, h = around[i + 1 < around.size() ? i + 1 : 0].half_edge;
    if (!join(here(g), here(h))) return kDisagree;
  }
  return nullptr;
}

namespace {

using Corners = std::array<Residues, 3>;

uint64_t hash_of(const Face& f, const Corners& corner) {
  uint64_t h = uint64_t(f.orig) * 4 + f.mat;
  for (const Residues& c : corner)
    for (uint64_t r : c) {
      h = (h ^ r) * 0x9e3779b97f4a7c15ull;
      h ^= h >> 31;
    }
  return h * 0xff51afd7ed558ccdull;
}

uint64_t volume_of(const Face& f, const Corners& corner) {
  if (f.mat == 0 || f.mat == (kMaterialPlus | kMaterialMinus)) return 0;  // two banks cancel
  const auto& [a, b, c] = corner;
  uint64_t det = 0;
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det = mod_add(det, mod_mul(a[i], mod_sub(mod_mul(b[j], c[k]), mod_mul(b[k], c[j]))));
  }
  // Material on the negative side: the stored orientation faces outward.
  return f.mat == kMaterialMinus ? det : mod_sub(0, det);
}

Corners corners_of(const PointStore& points, const Face& f) {
  return {points.residues(f.v[0]), points.residues(f.v[1]), points.residues(f.v[2])};
}

}  // namespace

uint64_t ArrangementStore::face_hash(const Face& f) const { return hash_of(f, corners_of(points, f)); }

uint64_t ArrangementStore::face_volume_residue(const Face& f) const { return volume_of(f, corners_of(points, f)); }

void ArrangementStore::account_sums(int32_t id, bool in) {
  const Face& f = face[id];
  const Corners corner = corners_of(points, f);
  if (in) {
    hash_sum += hash_of(f, corner);
    volume_residue = mod_add(volume_residue, volume_of(f, corner));
  } else {
    hash_sum -= hash_of(f, corner);
    volume_residue = mod_sub(volume_residue, volume_of(f, corner));
  }
}

}  // namespace limberg
