// The named cases 1 to 16: single walls, loops, coincidences with skin and lattice, crossings.
#include "tests/sim/cutting/case_scene.h"

namespace limberg::test {
namespace test_cut_cases_walls {

CUT_CASE(C01_straight_partial, wavy_case_slab()) {
  s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  s.expect(1, {2});
  int sides = 0;
  for (FaceKind k : s.a.surface_view().kind) sides += k == FaceKind::wall;
  EXPECT_EQ(sides, 2 * s.last.wall_faces);
}

CUT_CASE(C02_through_cut, case_slab()) {
  const double x = grid().to_mm(at(3.217, 0, 0)).x();
  s.cut(strip({{x, -40.31}, {x, 41.17}}, 3, -20, false, 200));
  ASSERT_EQ(s.last.tries, 1);  // as drawn: then the volumes are known
  s.expect(2, {2, 2});
  std::vector<double> v{s.a.components()[0].volume_mm3, s.a.components()[1].volume_mm3};
  std::sort(v.begin(), v.end());
  EXPECT_NEAR(v[0], 60 * 12 * (30 - x), 1e-12 * 43200);
  EXPECT_NEAR(v[1], 60 * 12 * (30 + x), 1e-12 * 43200);
}

CUT_CASE(C03_closed_loop_no_floor, wavy_case_slab()) {
  s.cut(strip(kRhombus, 3, -6, true));
  s.expect(1, {2});
  EXPECT_EQ(s.fronts(), 1);
  EXPECT_EQ(s.a.loose_component_near({0, 0, 0}, 5), -1);  // the post is attached
}

CUT_CASE(C04_plug_excision, case_slab()) {
  s.cut(open_box(kRhombus, 3, -6));
  s.expect(2, {2, 2});
  const uint64_t before = s.a.store().volume_residue;
  const ExciseResult e = s.excise_at({0, 0, 0});
  s.expect(1, {2});
  EXPECT_NE(s.a.store().volume_residue, before);
  EXPECT_NEAR(e.volume_mm3, 120 * 6, 2e-3 * 720);  // the outline on the grid, redrawn within 8 um
  EXPECT_NEAR(s.a.volume_mm3() + e.volume_mm3, 43200, 1e-12 * 43200);
}

CUT_CASE(C05_through_drill, wavy_case_slab()) {
  s.cut(strip({{8, 0.1}, {0.2, 5}, {-8, 0}, {0, -5}}, 3, -20, true));
  EXPECT_EQ(s.a.pieces(), 2);
  const auto& all = s.a.components();
  s.excise(all[0].volume_mm3 < all[1].volume_mm3 ? 0 : 1);
  s.expect(1, {0});
}

CUT_CASE(C06_through_a_skin_vertex, case_slab()) {
  CaseScene beside(case_slab());
  beside.cut(strip({{-10, -7.01}, {8, 11.013}}, 2, -5));
  s.cut(strip({{-9, -9}, {9, 9}}, 2, -5));  // through vertices at multiples of 3 mm
  EXPECT_GT(s.last.tries, 1);
  EXPECT_EQ(s.a.pieces(), beside.a.pieces());
  EXPECT_EQ(euler(s.a), euler(beside.a));
}

CUT_CASE(C07_along_a_skin_edge, case_slab()) {
  s.cut(strip({{-8, 3}, {8, 3}}, 2, -5));
  EXPECT_GT(s.last.tries, 1);
  EXPECT_LE(s.last.tries, 8);
  s.expect(1, {2});
}

CUT_CASE(C08_coplanar_with_the_skin, case_slab()) {
  if (s.attempt(sheet({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}, 8, 8))) {
    EXPECT_LE(s.last.tries, 8);
  }
  const uint64_t hash = s.a.full_hash();
  Blade in_skin;  // a whole triangle of the skin as the blade
  in_skin.vertex = {at(0, 0, 0), at(3, 0, 0), at(3, 3, 0)};
  in_skin.tri = {{0, 1, 2}};
  in_skin.seed = {2};
  if (!s.attempt(in_skin)) {
    EXPECT_EQ(s.a.full_hash(), hash);
  }
}

CUT_CASE(C09_through_a_row_of_240_vertices, flat_slab(60, 4, 6, 240, 4), 5) {
  s.cut(strip({{-40, 0}, {40, 0}}, 2, -4, false, 4));
  EXPECT_GT(s.last.tries, 1);  // the first try meets zeros
  s.expect(1, {2});
}

// Planes of the lattice are odd, blades even: a wall can lie one half-unit on either side.
CUT_CASE(C10_on_a_lattice_plane, case_slab()) {
  const auto on = [&](CaseScene& x, int32_t side) {
    const int32_t plane = x.g.origin.x + 6 * x.g.pitch.x;
    Blade b = strip({{0, -40}, {0, 40}}, 3, -20, false, 100);
    for (Int3& v : b.vertex) v.x = plane + side;
    x.cut(b);
    EXPECT_EQ(x.last.tries, 1);
    for (const CellCopy& c : x.t->cells) EXPECT_GT(c.fraction, 0);
    x.expect(2, {2, 2});
    return x.t->cells.size();
  };
  CaseScene other(case_slab());
  const size_t low = on(s, -1), high = on(other, 1);
  EXPECT_EQ(low, high);  // the slab's lattice is the same from left and right of a plane
}

// A wall that holds a vertical line of the lattice exactly: x + y is the same for it and for the line's nodes.
CUT_CASE(C11_through_a_lattice_node, case_slab()) {
  std::vector<size_t> copies, nodes;
  for (int32_t shift : {-2, 2, 0}) {
    CaseScene other(case_slab());
    CaseScene& x = shift ? other : s;
    const int32_t X = x.g.origin.x + 6 * x.g.pitch.x, Y = x.g.origin.y + 6 * x.g.pitch.y,
                  Z = x.g.origin.z + 2 * x.g.pitch.z;
    // Three corners in a plane through the node: the node is the middle of two of them.
    Blade b;
    const int32_t far = 40 * 16384 + 1;
    b.vertex = {{X - far + shift, Y + far, Z - far},
                {X + far + shift, Y - far, Z + far},
                {X + far + shift, Y - far, Z - far},
                {X - far + shift, Y + far, Z + far}};
    b.tri = {{0, 2, 1}, {0, 1, 3}};
    b.seed = {1, 1};
    x.cut(b);
    EXPECT_EQ(x.last.tries, 1);
    EXPECT_EQ(x.a.pieces(), 2);
    copies.push_back(x.t->cells.size());
    nodes.push_back(x.t->nodes.size());
  }
  // A tie is broken as if the lattice lay a little lower: as with one of the two walls beside.
  EXPECT_TRUE(copies[2] == copies[0] || copies[2] == copies[1]) << copies[0] << " " << copies[1] << " " << copies[2];
  EXPECT_TRUE(nodes[2] == nodes[0] || nodes[2] == nodes[1]) << nodes[0] << " " << nodes[1] << " " << nodes[2];
}

CUT_CASE(C12_along_a_lattice_edge, case_slab()) {
  std::vector<size_t> copies, nodes;
  for (int32_t shift : {-2, 2, 0}) {
    CaseScene other(case_slab());
    CaseScene& x = shift ? other : s;
    const int32_t X = x.g.origin.x + 6 * x.g.pitch.x, Y = x.g.origin.y + 6 * x.g.pitch.y, far = 40 * 16384 + 1;
    Blade b = strip({{0, -40}, {0, 40}}, 3, -20, false, 100);
    for (Int3& v : b.vertex) v.x = v.y < 0 ? X - far + shift : X + far + shift, v.y = v.y < 0 ? Y + far : Y - far;
    x.cut(b);
    EXPECT_EQ(x.last.tries, 1);
    EXPECT_EQ(x.a.pieces(), 2);
    copies.push_back(x.t->cells.size());
    nodes.push_back(x.t->nodes.size());
  }
  EXPECT_TRUE(copies[2] == copies[0] || copies[2] == copies[1]);
  EXPECT_TRUE(nodes[2] == nodes[0] || nodes[2] == nodes[1]);  // no orphan
}

CUT_CASE(C13_x_crossing, wavy_case_slab()) {
  s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  s.cut(strip({{1, -20}, {2, 20}}, 3, -4));
  s.expect(1, {2});
  EXPECT_GT(s.wall_edges_with(4), 0);  // four quadrants
  CaseScene through(wavy_case_slab());
  through.cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20));
  through.cut(strip({{1, -40}, {2, 40}}, 3, -20));
  through.expect(4, {2, 2, 2, 2});
}

CUT_CASE(C14_t_in_and_t_out, wavy_case_slab()) {
  s.cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20));
  Blade in = strip({{1, -40}, {2, 0.9}}, 3, -20);  // ends past the wall
  in.seed[in.seed.size() - 1] = in.seed[in.seed.size() - 2] = 0;
  s.cut(in);
  s.expect(3, {2, 2, 2});
  EXPECT_GT(s.wall_edges_with(3), 0);           // three sectors
  s.cut(strip({{-8, 0.5}, {-9, 40}}, 3, -20));  // begins before it
  s.expect(4, {2, 2, 2, 2});
  CaseScene partial(wavy_case_slab());
  partial.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  partial.cut(strip({{1, -15}, {2, 0.9}}, 3, -4));
  partial.cut(strip({{-8, 15}, {-7, 0.4}}, 3, -8));
  partial.expect(1, {2});
}

TriMesh loose_slab() {  // nothing is held: slivers at the line are debris like any other
  TriMesh m = wavy_case_slab();
  for (SurfaceTag& t : m.tag)
    if (t == SurfaceTag::fixed) t = SurfaceTag::free;
  return m;
}
CUT_CASE(C15_star_of_six_through_one_line, loose_slab()) {
  for (int i = 0; i < 6; ++i) {
    const double t = 0.1 + i * std::acos(-1.0) / 6, off = 0.0008 * ((i * 7) % 13 - 6);  // within 10 um of the axis
    const Vec2 d(60 * std::cos(t), 60 * std::sin(t)), n(-std::sin(t) * off, std::cos(t) * off);
    s.cut(strip({n - d, n + d}, 3, -20, false, 200));
    s.sweep(0.5);
  }
  int large = 0;
  for (const auto& c : s.a.components()) large += c.volume_mm3 > 1;
  EXPECT_EQ(large, 12);
  EXPECT_EQ(s.a.pieces(), 12);
}

CUT_CASE(C16_sharp_bend_of_5_degrees, wavy_case_slab()) {
  const double t = 5 * std::acos(-1.0) / 180;
  s.cut(strip({{-18, 0.4}, {0, 0.4}, Vec2(0, 0.4) - 18 * Vec2(std::cos(t), std::sin(t))}, 3, -6));
  s.expect(1, {2});
  EXPECT_EQ(s.fronts(), 1);
}

}  // namespace test_cut_cases_walls
}  // namespace limberg::test
