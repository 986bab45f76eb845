// Metamorphic tests: what is moved, turned, mirrored, divided or done in another order comes to the same.
#include <map>

#include "tests/sim/cutting/case_scene.h"

namespace limberg::test {
namespace test_cut_symmetry {

// What does not depend on where a scene lies: pieces with their Euler characteristics and sizes, how cells are filled.
struct Signature {
  std::vector<std::tuple<int64_t, int, bool>> pieces;  // 1e-6 mm^3, V - E + F, held
  size_t cells = 0, nodes = 0;
  int lattice_pieces = 0;
  bool operator==(const Signature&) const = default;
};

struct Scene {
  TriMesh body;
  LatticeGrid lattice;
  std::vector<Blade> blade;
};

Signature run(const Scene& s, bool with_lattice = true, int64_t grain = 1000000) {
  Arrangement a(s.body, grid());
  Signature out;
  uint64_t seed = 1;
  for (const Blade& b : s.blade) {
    const CutResult r = a.cut(b, seed++);
    EXPECT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(r.tries, 1);  // another try would be drawn otherwise
    EXPECT_EQ(a.check_all(), "");
  }
  const std::vector<int> chi = euler(a);
  for (size_t i = 0; i < chi.size(); ++i)
    out.pieces.push_back(
        {std::llround(a.components()[i].volume_mm3 * double(grain)), chi[i], a.components()[i].touches_fixed});
  std::sort(out.pieces.begin(), out.pieces.end());
  if (!with_lattice) return out;
  const auto t = build_topology(s.lattice, material_surface(a));
  EXPECT_EQ(check_topology(*t), "");
  out.cells = t->cells.size();
  out.nodes = t->nodes.size();
  out.lattice_pieces = t->pieces;
  EXPECT_EQ(t->pieces, a.pieces());
  return out;
}

// Incision, T, undermining, a plug, a cut right through; in general position, so that every first try goes right.
Scene scene() {
  Scene s;
  s.body = wavy_slab(40, 10, 12, 0.7);
  s.lattice = lattice_over(s.body, 5.13);
  s.blade.push_back(strip({{-12.117, 0.331}, {11.243, 1.171}}, 3.01, -6.037, false, 4));
  s.blade.push_back(strip({{1.031, -11.13}, {2.071, 12.37}}, 3.03, -4.091, false, 4));
  s.blade.push_back(sheet({-9.03, 0.113, -3.071}, {18.01, 0.1, 0.05}, {0.07, 9.13, 0.11}, 5, 3));
  s.blade.push_back(open_box({{9.03, -9.1}, {5.07, -5.013}, {1.11, -9.17}, {5.013, -13.07}}, 3.07, -5.03));
  s.blade.push_back(strip({{-30.07, -14.13}, {31.11, -15.07}}, 4.03, -14.01, false, 200));
  return s;
}

struct Symmetry {
  std::array<int, 3> axis;
  std::array<int, 3> sign;
  Int3 of(const Int3& p) const {
    const int32_t c[3] = {p.x, p.y, p.z};
    return {sign[0] * c[axis[0]], sign[1] * c[axis[1]], sign[2] * c[axis[2]]};
  }
  bool mirrors() const {
    const int even = (axis[0] == 0 && axis[1] == 1) || (axis[0] == 1 && axis[1] == 2) || (axis[0] == 2 && axis[1] == 0);
    return (even ? 1 : -1) * sign[0] * sign[1] * sign[2] < 0;
  }
};

Scene moved(const Scene& s, const Symmetry& g, const Int3& shift, bool lattice_too) {
  Scene out = s;
  const auto place = [&](const Int3& p) {
    const Int3 q = g.of(p);
    return Int3{q.x + shift.x, q.y + shift.y, q.z + shift.z};
  };
  for (Vec3& x : out.body.X_mm) x = grid().to_mm(place(grid().to_grid(x)));
  if (g.mirrors())
    for (Tri& t : out.body.tri) std::swap(t[1], t[2]);
  for (Blade& b : out.blade)
    for (Int3& v : b.vertex) v = place(v);
  if (lattice_too) {
    const LatticeGrid& l = s.lattice;
    const Int3 a = place(l.origin), b = place({l.origin.x + l.count.x * l.pitch.x, l.origin.y + l.count.y * l.pitch.y,
                                               l.origin.z + l.count.z * l.pitch.z});
    out.lattice.origin = {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
    const int32_t n[3] = {l.count.x, l.count.y, l.count.z};
    out.lattice.count = {n[g.axis[0]], n[g.axis[1]], n[g.axis[2]]};
  }
  return out;
}

TEST(CutSymmetry, The48OfTheCube) {
  const Scene s = scene();
  const Signature expected = run(s);
  ASSERT_EQ(expected.pieces.size(), 3u);
  std::array<int, 3> axis{0, 1, 2};
  do
    for (int k = 0; k < 8; ++k) {
      const Symmetry g{axis, {k & 1 ? -1 : 1, k & 2 ? -1 : 1, k & 4 ? -1 : 1}};
      SCOPED_TRACE(::testing::Message() << axis[0] << axis[1] << axis[2] << " " << k);
      EXPECT_EQ(run(moved(s, g, {0, 0, 0}, true)), expected);
    }
  while (std::next_permutation(axis.begin(), axis.end()));
}

TEST(CutSymmetry, Translations) {
  const Scene s = scene();
  const Signature expected = run(s);
  const Symmetry same{{0, 1, 2}, {1, 1, 1}};
  for (const Int3& by : {Int3{2, 0, 0}, Int3{-12346, 7770, 54322}, Int3{500000, -400000, 300002}})
    EXPECT_EQ(run(moved(s, same, by, true)), expected);
  // Over a lattice that stays where it is: the surface is the same, cells are others.
  Signature surface = run(s, false);
  for (const Int3& by : {Int3{2, 4, -6}, Int3{3000, -5002, 1234}}) {
    Scene other = moved(s, same, by, false);
    other.lattice.count = {s.lattice.count.x + 1, s.lattice.count.y + 1, s.lattice.count.z + 1};
    EXPECT_EQ(run(other, false), surface);
    EXPECT_EQ(run(other).lattice_pieces, expected.lattice_pieces);
  }
}

TEST(CutSymmetry, BladesTurnedOver) {
  const Scene s = scene();
  const Signature expected = run(s);
  for (unsigned which = 1; which < 32; which += 3) {
    Scene other = s;
    for (size_t i = 0; i < other.blade.size(); ++i)
      if (which >> i & 1)
        for (Tri& t : other.blade[i].tri) std::swap(t[1], t[2]);
    EXPECT_EQ(run(other), expected);
  }
}

// Every triangle in four: midpoints rounded to the grid move the blade by a ten-thousandth of a millimetre.
TEST(CutSymmetry, BladesDividedFiner) {
  const Scene s = scene();
  Scene fine = s;
  for (Blade& b : fine.blade) {
    Blade out;
    out.vertex = b.vertex;
    std::map<std::pair<int32_t, int32_t>, int32_t> middle;
    const auto mid = [&](int32_t p, int32_t q) {
      const auto [it, made] = middle.try_emplace({std::min(p, q), std::max(p, q)}, int32_t(out.vertex.size()));
      if (made) {
        const Int3 &x = b.vertex[size_t(p)], &y = b.vertex[size_t(q)];
        out.vertex.push_back({(x.x + y.x) / 4 * 2, (x.y + y.y) / 4 * 2, (x.z + y.z) / 4 * 2});
      }
      return it->second;
    };
    for (size_t i = 0; i < b.tri.size(); ++i) {
      const Tri t = b.tri[i];
      const int32_t p = mid(t[0], t[1]), q = mid(t[1], t[2]), r = mid(t[2], t[0]);
      for (const Tri& x : {Tri{t[0], p, r}, Tri{p, t[1], q}, Tri{r, q, t[2]}, Tri{p, q, r}}) {
        out.tri.push_back(x);
        out.seed.push_back(b.seed[i]);
      }
    }
    b = out;
  }
  const Signature a = run(s), b = run(fine);
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.lattice_pieces, b.lattice_pieces);
  for (size_t i = 0; i < a.pieces.size(); ++i) {
    EXPECT_EQ(std::get<1>(a.pieces[i]), std::get<1>(b.pieces[i]));
    EXPECT_NEAR(double(std::get<0>(a.pieces[i])), double(std::get<0>(b.pieces[i])), 0.5e6);  // 0.5 mm^3
  }
}

TEST(CutSymmetry, DisjointCutsInAnyOrder) {
  Scene s;
  s.body = wavy_slab(40, 10, 12, 0.7);
  s.lattice = lattice_over(s.body, 5.13);
  s.blade.push_back(strip({{-15.1, -14.3}, {-4.07, -13.1}}, 3.01, -6.03, false, 4));
  s.blade.push_back(open_box({{12.03, 8.1}, {9.07, 12.013}, {5.11, 8.17}, {9.013, 4.07}}, 3.07, -5.03));
  s.blade.push_back(strip({{-14.1, 5.3}, {-9.07, 14.1}, {-3.2, 6.1}}, 3.01, -4.03, false, 4));
  s.blade.push_back(strip({{15.1, -13.3}, {3.3, -6.1}}, 3.01, -14.03, false, 20));
  const Signature expected = run(s);
  std::vector<size_t> order{0, 1, 2, 3};
  do {
    Scene other = s;
    for (size_t i = 0; i < 4; ++i) other.blade[i] = s.blade[order[i]];
    EXPECT_EQ(run(other), expected);
  } while (std::next_permutation(order.begin(), order.end()));
}

}  // namespace test_cut_symmetry
}  // namespace limberg::test
