// Layers that are not as thick everywhere: the places of a file, what is between them, and what cells have of them,
// against volumes and moments that are known without a lattice.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "sim/body/thickness.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::test {
namespace test_thickness_by_place {

constexpr double kSizes_mm[] = {5, 3.5, 2};
constexpr double kMean_mm = 2, kSlope = 0.03;  // of the skin, along x

double wedge(const Vec3& X) { return kMean_mm + kSlope * X.x(); }

/// A slab of 60 x 60 x 11.5 mm whose layer `of` is as thick as `thick` says.
template <class Thick>
Body uneven(Body b, size_t of, Thick&& thick) {
  b.thickness_mm.resize(of + 1);
  for (const Vec3& X : b.surface.X_mm) b.thickness_mm[of].push_back(float(thick(X)));
  return b;
}

void only_weighs(Body& b, size_t layer) {
  for (size_t l = 0; l < b.layers.size(); ++l) b.layers[l].material.density_kg_mm3 = l == layer ? 1e-6 : 1e-16;
}

double moment_x(const SheetLattice& l) {
  double sum = 0;
  for (size_t n = 0; n < l.m->X_mm.size(); ++n) sum += l.m->mass_kg[n] / 1e-6 * l.m->X_mm[n].x();
  return sum;
}

// Its nominal thickness of 1.5 mm is nowhere but on one line.
TEST(ThicknessByPlace, AWedgeOfSkinHasItsVolumeAndItsMoment) {
  const double volume = 3600 * kMean_mm, moment = kSlope * 60 * 60. * 60 * 60 / 12;
  for (const bool block : {true, false})
    for (const double h : kSizes_mm)
      for (const double off : {0.0, 0.3, 0.7}) {
        SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << h << " mm, " << off);
        Body b = uneven(slab(0), 0, wedge);
        b.is_box = block;
        only_weighs(b, 0);
        const SheetLattice l(std::move(b), h, block ? Vec3::Zero() : Vec3(0.3, 0.6, off));
        EXPECT_NEAR(skin_mass(l), volume, 0.01 * volume);
        // Masses lie at the nodes: what is between two of them is known to a part of a cell.
        EXPECT_NEAR(moment_x(l), moment, 0.03 * moment);
      }
}

TEST(ThicknessByPlace, SoHasALayerBetweenTwoOthers) {
  for (const bool block : {true, false})
    for (const double h : kSizes_mm) {
      SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << h);
      Body b = slab(0);
      b.layers = {b.layers[0], {"fat", 4, b.layers[1].material}, {"muscle", 100, b.layers[1].material}};
      b = uneven(std::move(b), 1, [](const Vec3& X) { return 5 + 0.05 * X.y(); });
      b.is_box = block;
      only_weighs(b, 1);
      const SheetLattice l(std::move(b), h, block ? Vec3::Zero() : Vec3(0.3, 0.6, 0.45));
      EXPECT_NEAR(skin_mass(l), 3600 * 5, 0.01 * 3600 * 5);
    }
}

// Skin that is everywhere thicker than its layer says is skin of that thickness.
TEST(ThicknessByPlace, TheSameEverywhereIsAnEvenLayer) {
  for (const bool block : {true, false})
    for (const double h : kSizes_mm) {
      SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << h);
      Body even = slab(0), told = uneven(slab(0), 0, [](const Vec3&) { return 3.2; });
      even.layers[0].thickness_mm = 3.2;
      even.is_box = told.is_box = block;
      const Vec3 shift = block ? Vec3::Zero() : Vec3(0.3, 0.6, 0.45);
      const double want = shear_energy(SheetLattice(std::move(even), h, shift));
      // (The same pieces but in a block, whose rows know moments of every degree and pieces those of two.)
      EXPECT_NEAR(shear_energy(SheetLattice(std::move(told), h, shift)), want, (block ? 2e-4 : 1e-6) * want);
    }
}

TEST(ThicknessByPlace, LayersAreCountedFromTheirOwnBorders) {
  Body b = slab(0);
  b.layers = {
      {"skin", 2, b.layers[0].material}, {"fat", 3, b.layers[1].material}, {"muscle", 50, b.layers[1].material}};
  b = uneven(std::move(b), 0, [](const Vec3& X) { return X.x() < 0 ? 1.0 : 3.0; });
  const Skin skin(std::make_shared<Body>(std::move(b)));
  const auto layer = [&](double x, double depth) {
    Bvh::Closest near;
    const double d = skin.depth_mm({x, 1, -depth}, near);
    return skin.layer_at(skin.in_layers_mm(d, near));
  };
  EXPECT_EQ(layer(-20, 0.9), 0);
  EXPECT_EQ(layer(-20, 1.1), 1);
  EXPECT_EQ(layer(-20, 3.9), 1);
  EXPECT_EQ(layer(-20, 4.1), 2);
  EXPECT_EQ(layer(20, 2.9), 0);
  EXPECT_EQ(layer(20, 3.1), 1);
  EXPECT_EQ(layer(20, 5.9), 1);
  EXPECT_EQ(layer(20, 6.1), 2);
  EXPECT_EQ(skin.layers_within(3.5, 0.1), std::pair(1, 1));
  EXPECT_EQ(skin.layers_within(2, 0.1), std::pair(0, 1));
  EXPECT_EQ(skin.layers_within(5, 0.1), std::pair(1, 2));
}

// A body under no load rests as it lies: as test_layer_thickness.cpp has it, with skin of 1 to 4 mm.
TEST(ThicknessByPlace, BodyUnderNoLoadRests) {
  Sheet s;
  s.top = [](double x, double y) { return 6 * std::cos(0.08 * x) * std::cos(0.06 * y + 0.3); };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 9; };
  for (const double h : {5.0, 3.5}) {
    const SheetLattice l(uneven(layered(sheet_mesh(s), kSkin_mm), 0, [](const Vec3& X) { return 2.5 + 0.05 * X.x(); }),
                         h, {0.5, 0.3, 0.7});
    EXPECT_LT(force_at_rest(l, h), 1e-9) << h;
  }
}

std::vector<PlaceThickness> read(const std::string& text) { return parse_thickness(text, "skin.txt"); }
std::string why(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing";
}

TEST(ThicknessByPlace, AFileHasAPlaceInEveryLine) {
  const auto got = read("# of a face\n1 2 3 1.5\n\n-1e1, 2, 3,\t2 # chin\r\n4 5 6 0.5");
  ASSERT_EQ(got.size(), 3u);
  EXPECT_EQ(got[1].at_mm, Vec3(-10, 2, 3));
  EXPECT_EQ(got[1].thickness_mm, 2);
  EXPECT_EQ(got[2].thickness_mm, 0.5);
  EXPECT_NE(why("").find("skin.txt: holds no place"), std::string::npos);
  EXPECT_NE(why("# nothing\n").find("holds no place"), std::string::npos);
  EXPECT_NE(why("1 2 3 1\n1 2 3\n").find("skin.txt:2: holds 3 numbers; expected four"), std::string::npos);
  EXPECT_NE(why("1 2 3 4 5\n").find("more than four"), std::string::npos);
  EXPECT_NE(why("1 2 x 1\n").find("no number"), std::string::npos);
  EXPECT_NE(why("1 2 3x 1\n").find("no number"), std::string::npos);
  EXPECT_NE(why("nan 2 3 1\n").find("no number"), std::string::npos);
  EXPECT_NE(why("1 2 3 0\n").find("from 0.1 to 100"), std::string::npos);
  EXPECT_NE(why("1 2 3 inf\n").find("no number"), std::string::npos);
  EXPECT_NE(why("1 2 1e5 1\n").find("10 m"), std::string::npos);
}

// At a place it is what is said of it, elsewhere between what its neighbours have, and it changes evenly.
TEST(ThicknessByPlace, BetweenPlacesItIsBetweenTheirs) {
  for (const int n : {1, 3, 40}) {
    ThicknessSpec spec;
    for (int i = 0; i < n; ++i)
      spec.points.push_back(
          {{60 * std::fmod(0.618 * i, 1.0) - 30, 60 * std::fmod(0.754 * i, 1.0) - 30, 0}, 1 + 0.05 * i});
    Body b = slab(0);
    const Vec3 on = b.surface.X_mm[17];
    spec.points[0].at_mm = on;
    const std::vector<float> got = thickness_of(spec, b, 0);
    ASSERT_EQ(got.size(), b.surface.X_mm.size());
    EXPECT_EQ(got[17], 1.0f);
    for (const float t : got) {
      EXPECT_GE(t, 1.0f - 1e-6f);
      EXPECT_LE(t, float(1 + 0.05 * (n - 1)) + 1e-6f);
    }
  }
  // Along a line: no step larger than a smooth field of this size would have.
  ThicknessSpec spec;
  for (int i = 0; i < 40; ++i)
    spec.points.push_back(
        {{60 * std::fmod(0.618 * i, 1.0) - 30, 60 * std::fmod(0.754 * i, 1.0) - 30, 0}, 2 + std::sin(0.9 * i)});
  Body line = slab(0);
  line.surface.X_mm.clear();
  for (int i = 0; i <= 6000; ++i) line.surface.X_mm.push_back({0.01 * i - 30, 1.3, 0});
  const std::vector<float> along = thickness_of(spec, line, 0);
  for (size_t i = 1; i < along.size(); ++i) EXPECT_LT(std::abs(along[i] - along[i - 1]), 0.02f) << i;
}

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "limberg_thickness_by_place";
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const char* name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return (path / name).string();
  }
};

// An open sheet that lies askew below the slab, 2 to 8 mm deep.
TEST(ThicknessByPlace, DownToASurface) {
  const Folder folder;
  ThicknessSpec spec;
  spec.down_to = folder.write("bed.obj", "v -40 -40 -1\nv 40 -40 -9\nv 40 40 -9\nv -40 40 -1\nf 1 2 3 4\n");
  const Body b = slab(0);
  const std::vector<float> got = thickness_of(spec, b, 0);
  for (size_t v = 0; v < got.size(); ++v) {
    const Vec3& X = b.surface.X_mm[v];
    const bool rim = std::max(std::abs(X.x()), std::abs(X.y())) > 29;  // where the skin's normal is that of a corner
    if (X.z() == 0 && !rim) {
      EXPECT_NEAR(got[v], 5 + 0.1 * X.x(), 1e-5) << X.transpose();
    }
  }
  // The second layer ends there: what is left below the first.
  const std::vector<float> second = thickness_of(spec, b, 1);
  for (size_t v = 0; v < got.size(); ++v)
    if (b.surface.X_mm[v].z() == 0) {
      EXPECT_NEAR(second[v], std::max(0.1, double(got[v]) - 1.5), 1e-5);
    }
  const auto refused = [&](const std::string& text) -> std::string {
    spec.down_to = folder.write("bed.obj", text);
    try {
      thickness_of(spec, b, 0);
    } catch (const InputError& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_NE(refused("v -40 -40 5\nv 40 -40 5\nv 40 40 5\nf 1 2 3\n").find("beneath 0 of"), std::string::npos);
  EXPECT_NE(refused("v -40 -40 -500\nv 40 -40 -500\nv 40 40 -500\nf 1 2 3\n").find("from a place of the skin"),
            std::string::npos);
  EXPECT_NE(refused("no surface").find("bed.obj"), std::string::npos);
}

}  // namespace test_thickness_by_place
}  // namespace limberg::test
