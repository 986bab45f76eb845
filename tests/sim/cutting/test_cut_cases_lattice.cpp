// The named cases 23 to 28, 35 and 39: what cells make of cuts, beside closed forms and the voxel oracle.
#include "sim/lattice/embedding.h"
#include "tests/sim/cutting/case_scene.h"
#include "tests/sim/lattice/voxel_oracle.h"

namespace limberg::test {
namespace test_cut_cases_lattice {

int32_t cell_at(const CaseScene& s, const Vec3& x) { return cell_of(*s.t, x); }

/// Components of a cell against the oracle, finer and finer where they differ.
void like_voxels(const CaseScene& s, int32_t cell) {
  const VoxelOracle oracle(s.a);
  std::vector<double> exact;
  for (const CellClass& c : s.t->components[size_t(cell)]->classes) exact.push_back(c.fraction);
  std::sort(exact.rbegin(), exact.rend());
  bool same = false;
  for (int n : {20, 40, 80, 160}) {
    const std::vector<double> seen = oracle.pieces(s.g, cell, n);
    same = seen.size() == exact.size();
    for (size_t i = 0; same && i < seen.size(); ++i) same = std::abs(seen[i] - exact[i]) < 3.0 / n;
    if (same) break;
  }
  EXPECT_TRUE(same) << "cell " << cell << " exact " << exact.size();
}

CUT_CASE(C23_ends_inside_a_cell, case_slab()) {
  // Level with the lattice's rows the wall ends in the middle of a cell.
  const Vec3 middle = s.g.node_mm({6, 6, 2}) + 0.5 * s.g.cell_mm();
  s.cut(strip({{-20, middle.y()}, {middle.x(), middle.y()}}, 3, -20));
  const int32_t tip = cell_at(s, middle), before = cell_at(s, middle - Vec3(s.g.cell_mm().x(), 0, 0));
  EXPECT_EQ(s.t->copies_of(tip), 1);
  EXPECT_EQ(s.t->copies_of(before), 2);
  // Both copies behind share the tip's nodes on the common square: the tip does not open.
  const CellCopy& one = s.t->cells[size_t(s.t->copy(tip, 0))];
  for (int k = 0; k < 2; ++k) {
    const CellCopy& c = s.t->cells[size_t(s.t->copy(before, k))];
    for (size_t corner = 0; corner < 8; corner += 2) EXPECT_EQ(c.node[corner + 1], one.node[corner]);
  }
}

CUT_CASE(C24_ends_exactly_on_a_lattice_plane, case_slab()) {
  // The end edge leans by one unit across the plane: it meets it in a rational point, exactly.
  const int32_t plane = s.g.origin.x + 6 * s.g.pitch.x;
  Blade b = strip({{-20, 0.3}, {1, 0.3}}, 3, -6, false, 100);
  b.vertex[2].x = plane - 1;
  b.vertex[3].x = plane + 1;
  s.cut(b);
  EXPECT_EQ(s.last.tries, 1);
  s.expect(1, {2});
  for (const CellCopy& c : s.t->cells) EXPECT_GT(c.fraction, 0);
}

CUT_CASE(C25_front_clips_a_cell_face, case_slab()) {
  // A level sheet from a slit, with a pointed end that pokes 0.4 mm through one square of a cell.
  const double h = s.g.cell_mm().x();
  const Vec3 low = s.g.node_mm({6, 6, 1});
  const double y = low.y() + 0.5 * h, z = low.z() + 0.45 * h;
  s.cut(strip({{low.x() - 1.4 * h, y - 6}, {low.x() - 1.4 * h, y + 6}}, 2, z - 1));
  Blade b;
  b.vertex = {at(low.x() - 1.5 * h, y - 2, z), at(low.x() - 1.5 * h, y + 2, z + 0.1), at(low.x() + 0.4, y, z)};
  b.tri = {{0, 2, 1}};
  b.seed = {2};
  s.cut(b);
  s.expect(1, {2});
  const int32_t cell = cell_at(s, low + Vec3(0.3, 0.5 * h, 0.45 * h));
  ASSERT_TRUE(s.t->components[size_t(cell)]);
  EXPECT_EQ(s.t->copies_of(cell), 1);
  EXPECT_GT(s.t->components[size_t(cell)]->walks, 0);
  like_voxels(s, cell);
}

/// A closed surface of eight triangles about a point, inward or outward.
void add_octahedron(TriMesh& m, const Vec3& c, const Vec3& r, bool inward) {
  const int32_t first = int32_t(m.X_mm.size());
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0})
      m.X_mm.push_back(grid().to_mm(grid().to_grid(c + sign * r[axis] * Vec3::Unit(axis))));
  for (int k = 0; k < 8; ++k) {
    Tri t{first + (k & 1), first + 2 + (k >> 1 & 1), first + 4 + (k >> 2 & 1)};
    if ((__builtin_popcount(unsigned(k)) % 2 == 1) != inward) std::swap(t[1], t[2]);
    m.tri.push_back(t), m.tag.push_back(SurfaceTag::skin), m.uv.push_back({});
  }
}

TriMesh with_flat_crack() {
  TriMesh m = case_slab();
  add_octahedron(m, {-1.5, -2, -2.9}, {1.2, 1.1, 0.0002}, true);
  return m;
}
CUT_CASE(C26_open_crack_inside_a_cell, with_flat_crack(), 9) {
  // No stroke can make it: a cavity as flat as the grid allows.
  const int32_t cell = cell_at(s, {-1.5, -2, -2.9});
  EXPECT_EQ(s.t->copies_of(cell), 1);
  s.expect(1, {2, 2});  // one piece; its skin and one more shell
  EXPECT_EQ(s.a.components().size(), 2u);
  EXPECT_NEAR(s.a.components()[1].volume_mm3, 0, 1e-2);
  s.cut(strip({{-20, 2.3}, {20, 2.1}}, 3, -4));
  s.expect(1, {2, 2});
}

TriMesh with_bubble() {
  TriMesh m = case_slab();
  add_octahedron(m, {-1.5, -2, -2.9}, {1.2, 1.1, 1.0}, true);
  add_octahedron(m, {-1.5, -2, -2.9}, {1.19, 1.09, 0.99}, false);
  return m;
}
CUT_CASE(C27_closed_bubble_inside_a_cell, with_bubble(), 9) {
  const int32_t cell = cell_at(s, {-1.5, -2, -2.9});
  EXPECT_EQ(s.t->copies_of(cell), 2);
  EXPECT_EQ(s.a.pieces(), 2);
  EXPECT_EQ(s.a.components().size(), 3u);
  EXPECT_EQ(euler(s.a), (Chi{2, 2, 2}));
  const double inside = 8.0 / 6 * 1.19 * 1.09 * 0.99;
  EXPECT_NEAR(*std::min_element(s.t->piece_volume_mm3.begin(), s.t->piece_volume_mm3.end()), inside, 1e-3);
  EXPECT_GT(s.t->walks, 0);  // the void's shell was attached to what surrounds it
  s.cut(strip({{-20, 2.3}, {20, 2.1}}, 3, -4));
  EXPECT_EQ(s.a.pieces(), 2);
}

// 18 planes in general position: 1 + 18 + 153 + 816 pieces when all triple points lie inside.
TEST(CutCases, C28_a_thousand_pieces_in_one_cell) {
  const TriMesh cube = flat_slab(40, 40, 40, 2, 2);
  CaseScene s(cube, lattice_over(cube, 44, 0.05));
  ASSERT_EQ(s.g.count.x, 1);
  const double pi = std::acos(-1.0);
  std::vector<Vec3> normal;
  std::vector<double> offset;
  for (int i = 0; i < 18; ++i) {
    const double t = 0.07 + 2 * pi * i / 18, tilt = 0.5;
    normal.push_back(Vec3(std::cos(t) * std::sin(tilt), std::sin(t) * std::sin(tilt), std::cos(tilt)));
    offset.push_back(0.15 * std::sin(37.0 * i + 1));
  }
  int inside = 0;
  for (size_t i = 0; i < 18; ++i)
    for (size_t j = i + 1; j < 18; ++j)
      for (size_t k = j + 1; k < 18; ++k) {
        Mat3 m;
        m << normal[i].transpose(), normal[j].transpose(), normal[k].transpose();
        const Vec3 x = m.inverse() * Vec3(offset[i], offset[j], offset[k]);
        inside += x.cwiseAbs().maxCoeff() < 19.5;
      }
  ASSERT_EQ(inside, 816);
  const Vec3 centre(0, 0, -20);
  for (size_t i = 0; i < 18; ++i) {
    const Vec3 u = normal[i].unitOrthogonal(), v = normal[i].cross(u), c = centre + offset[i] * normal[i];
    Blade b;
    for (int k = 0; k < 4; ++k) {
      const Vec3 p = c + 60 * ((k & 1 ? 1 : -1) * u + (k & 2 ? 1 : -1) * v);
      b.vertex.push_back(at(p.x(), p.y(), p.z()));
    }
    b.tri = {{0, 1, 3}, {0, 3, 2}};
    b.seed = {2, 2};
    const uint64_t volume = s.a.store().volume_residue;
    ASSERT_TRUE(s.a.cut(b, i + 1).ok());
    ASSERT_EQ(s.a.store().volume_residue, volume);
  }
  EXPECT_EQ(s.a.check_all(), "");
  EXPECT_EQ(s.a.pieces(), 988);
  EXPECT_EQ(euler(s.a), Chi(988, 2));
  const auto t = update_topology(*s.t, material_surface(s.a));
  EXPECT_EQ(t->cells.size(), 988u);
  EXPECT_EQ(t->pieces, 988);
  double sum = 0;
  for (double v : t->piece_volume_mm3) sum += v;
  EXPECT_NEAR(sum, 64000, 1e-6);
}

CUT_CASE(C35_thinner_than_a_cell, case_slab()) {
  // A slot of 1 mm right through, narrower than a cell: its two lips are the two skins of an eyelid.
  const Vec3 middle = s.g.node_mm({6, 6, 2}) + 0.5 * s.g.cell_mm();
  const double y = middle.y();
  s.cut(strip({{-18, y - 0.5}, {18, y - 0.5}, {18, y + 0.5}, {-18, y + 0.5}}, 3, -20, true));
  const auto& all = s.a.components();
  s.excise(all[0].volume_mm3 < all[1].volume_mm3 ? 0 : 1);
  s.expect(1, {0});
  for (int dx = -2; dx <= 2; ++dx)
    for (int dz = -1; dz <= 0; ++dz) {
      const int32_t cell = cell_at(s, middle + Vec3(dx * 5.0, 0, dz * 5.0));
      EXPECT_EQ(s.t->copies_of(cell), 2);
      like_voxels(s, cell);
    }
}

CUT_CASE(C39_replay_at_another_lattice, wavy_case_slab()) {
  LatticeGrid half = s.g;
  for (Int3* v : {&half.pitch}) *v = {v->x / 2, v->y / 2, v->z / 2};
  half.count = {2 * s.g.count.x, 2 * s.g.count.y, 2 * s.g.count.z};
  CaseScene fine(wavy_case_slab(), half);
  for (CaseScene* x : {&s, &fine}) {
    x->cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
    x->cut(strip({{1, -20}, {2, 20}}, 3, -8));
    x->cut(sheet({-9, -0.1, -4}, {18, 0, 0}, {0, 12, 0}, 9, 6));
    x->cut(open_box({{16, 12}, {12, 16}, {8, 12}, {12, 8}}, 3, -5));
    x->excise_at({12, 12, 0});
    x->cut(strip({{-40, -13}, {40, -13.3}}, 3, -20));
  }
  EXPECT_EQ(s.a.full_hash(), fine.a.full_hash());
  EXPECT_EQ(fuzz::check_refines(*s.t, *fine.t), "");
}

}  // namespace test_cut_cases_lattice
}  // namespace limberg::test
