// The model of a page: what lies in it is the patient, within half a step; every stage is there; it is small; and its
// coarser surface is a surface still.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/export/page_mesh.h"
#include "app/export/page_model.h"
#include "app/pictures/skin_fields.h"
#include "render/image.h"
#include "sim/base/workers.h"
#include "sim/commands/words.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/app/export/pictured_block.h"

namespace limberg {
namespace test_page_model {

using nlohmann::json;

struct Model {
  json j, told;  // told: asset.extras
  std::string bin;

  explicit Model(const std::string& bytes) {
    uint32_t n = 0;
    std::memcpy(&n, bytes.data() + 12, 4);
    j = json::parse(bytes.substr(20, n)), bin = bytes.substr(28 + n), told = j["asset"]["extras"];
  }
  template <class T>
  std::vector<T> numbers(size_t accessor) const {
    const json& v = j["bufferViews"][j["accessors"][accessor]["bufferView"].get<size_t>()];
    std::vector<T> out(v["byteLength"].get<size_t>() / sizeof(T));
    std::memcpy(out.data(), bin.data() + v["byteOffset"].get<size_t>(), out.size() * sizeof(T));
    return out;
  }
  const json& first(size_t mesh) const { return j["meshes"][mesh]["primitives"][0]; }
  /// Of a mesh, at its frame f, mm.
  std::vector<Vec3> places(size_t mesh, size_t f) const {
    const auto base = numbers<uint16_t>(first(mesh)["attributes"]["POSITION"]);
    std::vector<int16_t> way(base.size(), 0);
    if (f > 0) way = numbers<int16_t>(first(mesh)["targets"][f - 1]["POSITION"]);
    const json &node = j["nodes"][1], &low = node["translation"];
    const double step = node["scale"][0];
    std::vector<Vec3> out;
    for (size_t i = 0; i < base.size(); i += 4)
      out.push_back({low[0].get<double>() + step * (base[i] + way[i]),
                     low[1].get<double>() + step * (base[i + 1] + way[i + 1]),
                     low[2].get<double>() + step * (base[i + 2] + way[i + 2])});
    return out;
  }
};

/// A slit that is cut, opens, and is sewn: four frames, two surfaces.
struct Slit {
  InlineWorkers workers;
  World world{test::small_block(), workers};
  PageModel model{"act"};
  std::vector<Snapshot> seen;

  const Snapshot& now() {
    world.fill(seen.emplace_back());
    return seen.back();
  }
  void act(const Command& c) {
    const Outcome o = std::visit(
        [&](const auto& a) -> Outcome {
          if constexpr (requires { world.apply(a); })
            return world.apply(a);
          else
            return {true, {}};
        },
        c);
    ASSERT_TRUE(o.done) << o.reason;
    for (int i = 0; i < 40; ++i) world.step({});
    model.acted(c, now());
  }
  Slit() {
    model.frame(0, now());
    act(Incise{{{-10, 0}, {10, 0}}, 4});
    model.acted(Stage{"open"}, now());
    act(Suture{{0, 1}, {0, -1}, 0});
    model.acted(Stage{"sewn"}, now());
  }
  TissueMesh mesh_of(const Snapshot& s) const {
    Vec3f low, high;
    EXPECT_TRUE(operated_box(seen.back(), low, high));
    return coarser_away(make_tissue_mesh(*s.topology), low, high);
  }
};

Camera somewhere() { return look_at_ball(Vec3f::Zero(), 30, Vec3f(0, -1, 1), Vec3f::UnitZ(), 24, 16. / 9); }

TEST(PageModel, PlacesAreThePatientsWithinHalfAStep) {
  Slit slit;
  const Model m(slit.model.bytes("block", somewhere(), 16. / 9));
  EXPECT_EQ(m.j["extensionsRequired"], json({"KHR_mesh_quantization"}));
  ASSERT_EQ(m.j["meshes"].size(), 2u);
  EXPECT_EQ(m.j["meshes"][0]["extras"]["at"], json({0.0}));
  EXPECT_EQ(m.j["meshes"][1]["extras"]["at"], json({1.0, 2.0}));
  // Times without a gap.
  EXPECT_EQ(m.j["meshes"][0]["extras"]["until"], m.j["meshes"][1]["extras"]["from"]);
  const double step = m.told["step_mm"];
  EXPECT_EQ(step, kPageStep_mm);
  const std::pair<size_t, size_t> where[] = {{0, 0}, {1, 0}, {1, 1}};
  const Snapshot* const is[] = {&slit.seen[0], &slit.seen[2], &slit.seen[4]};
  double most = 0;
  for (size_t k = 0; k < 3; ++k) {
    const TissueMesh mesh = slit.mesh_of(*is[k]);
    const std::vector<Vec3> x = m.places(where[k].first, where[k].second);
    ASSERT_EQ(x.size(), mesh.source.size());
    for (size_t v = 0; v < x.size(); ++v)
      most = std::max(most, (x[v] - is[k]->x_mm[size_t(mesh.source[v])].cast<double>()).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(most, 0.5 * step + 1e-5);
  EXPECT_GT(most, 0.4 * step);  // whole steps, as it says
}

TEST(PageModel, AStrokeInPiecesIsOneAct) {
  Slit slit;
  PageModel model("s");
  const Snapshot& first = slit.seen.front();
  model.frame(0, first);
  model.done(1, InciseMore{1, {{0, 0}, {5, 0}}, 4, 90, false});
  model.done(2, InciseMore{1, {{12, 0}}, 4, 90, false});
  model.done(3, InciseMore{1, {{20, 0}}, 4, 90, true});
  model.done(4, InciseMore{2, {{0, 3}, {6, 3}}, 4, 90, false});  // stopped: no last piece comes
  model.done(5, Suture{{0, 1}, {0, -1}, 0});
  model.frame(6, slit.seen.back());
  const Model m(model.bytes("block", somewhere(), 16. / 9));
  std::vector<std::string> acts;
  for (const json& a : m.told["acts"]) acts.push_back(a["words"]);
  EXPECT_EQ(acts,
            (std::vector<std::string>{in_words(Incise{{{0, 0}, {20, 0}}, 4}), in_words(Incise{{{0, 3}, {6, 3}}, 4}),
                                      in_words(Suture{{0, 1}, {0, -1}, 0})}));
}

TEST(PageModel, EveryStageActStitchAndFieldIsThere) {
  Slit slit;
  const Model m(slit.model.bytes("block", somewhere(), 16. / 9));
  std::vector<std::string> stages, acts;
  for (const json& a : m.told["acts"]) (a["stage"] ? stages : acts).push_back(a["words"]);
  EXPECT_EQ(stages, (std::vector<std::string>{"open", "sewn"}));
  EXPECT_EQ(acts,
            (std::vector<std::string>{in_words(Incise{{{-10, 0}, {10, 0}}, 4}), in_words(Suture{{0, 1}, {0, -1}, 0})}));
  ASSERT_EQ(m.told["frames"].size(), 3u);
  EXPECT_FALSE(m.told["frames"][1].contains("stitches"));
  ASSERT_EQ(m.told["frames"][2]["stitches"].size(), 1u);
  const json& stitch = m.told["frames"][2]["stitches"][0];
  EXPECT_NEAR(stitch["force_N"].get<double>(), double(slit.seen.back().sutures[0].force_N), 6e-4);
  EXPECT_GE(stitch["path"].size(), 2u);
  // Each field, by the figures of the pictures: half a 255th of the scale, and its ends.
  SkinFields maker;
  const TissueMesh mesh = slit.mesh_of(slit.seen.back());
  size_t i = 0;
  for (int k = 1; k < kSkinFields; ++k, ++i) {
    const FieldShown shown = maker.show(SkinField(k), slit.seen.back());
    ASSERT_LT(i, m.told["fields"].size());
    const json& f = m.told["fields"][i];
    EXPECT_EQ(f["name"], look_of(SkinField(k)).name);
    EXPECT_EQ(f["lo"].get<double>(), shown.lo);
    EXPECT_EQ(f["hi"].get<double>(), shown.hi);
    const auto byte = m.numbers<uint8_t>(m.j["meshes"][1]["extras"]["fields"][1][i]);
    ASSERT_EQ(byte.size(), mesh.source.size());
    for (size_t v = 0; v < byte.size(); ++v) {
      if (mesh.part[v] == Part::skin)
        ASSERT_NEAR(shown.lo + (shown.hi - shown.lo) * byte[v] / 255,
                    std::clamp(double(shown.value[size_t(mesh.source[v])]), shown.lo, shown.hi),
                    (shown.hi - shown.lo) * .502 / 255)
            << f["name"] << " " << v;
    }
  }
}

/// A small block before a wedge of four corners, white and half as bright.
WorldSpec block_before_a_wedge() {
  WorldSpec spec = test::small_block();
  auto body = std::make_shared<Body>(*spec.body);
  body->colliders.push_back(
      parse_collider("v 40 0 0\nv 48 0 0\nv 40 8 0\nv 40 0 8\n"
                     "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
                     {"wedge.obj", 1, Vec3f(1, 0.5f, 0)}));
  spec.body = body;
  return spec;
}

TEST(PageModel, WhatTheTissueLiesAgainstIsThereOnce) {
  InlineWorkers workers;
  World world(block_before_a_wedge(), workers);
  PageModel model("act");
  Snapshot seen;
  world.fill(seen);
  model.frame(0, seen);
  const Model m(model.bytes("block", somewhere(), 16. / 9));
  ASSERT_EQ(m.j["meshes"].size(), 2u);  // the skin of one frame, the wedge
  EXPECT_EQ(m.j["meshes"][1]["extras"], json({{"still", true}}));
  const std::vector<Vec3> at = m.places(1, 0);
  ASSERT_EQ(at.size(), 4u);
  const double half = m.j["nodes"][1]["scale"][0].get<double>() * .5000001;
  for (size_t v = 0; v < 4; ++v)
    EXPECT_LE((at[v] - world.skin()->spec().body->colliders[0]->mesh.X_mm[v]).cwiseAbs().maxCoeff(), half);
  EXPECT_EQ(m.numbers<uint16_t>(m.first(1)["indices"]).size(), 12u);
  // sRGB .5 is .2140 in linear light (IEC 61966-2-1).
  const json rgb = m.j["materials"][m.first(1)["material"].get<size_t>()]["pbrMetallicRoughness"]["baseColorFactor"];
  EXPECT_NEAR(rgb[0].get<double>(), 1, 1e-6);
  EXPECT_NEAR(rgb[1].get<double>(), .2140, 5e-5);
  EXPECT_EQ(rgb[2].get<double>(), 0);
  EXPECT_FALSE(m.first(1)["attributes"].contains("COLOR_0"));
  for (const json& child : m.j["nodes"][1]["children"]) EXPECT_LT(child.get<size_t>(), m.j["nodes"].size());
}

TEST(PageModel, WhatHasColoursOfItsOwnHasThemInThePage) {
  InlineWorkers workers;
  WorldSpec spec = block_before_a_wedge();
  auto body = std::make_shared<Body>(*spec.body);
  body->colliders = {
      parse_collider("v 40 0 0 1 0 0\nv 48 0 0 0 .5 0\nv 40 8 0 0 0 1\nv 40 0 8 1 1 1\n"
                     "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
                     {"wedge.obj"})};
  spec.body = body;
  World world(spec, workers);
  PageModel model("act");
  Snapshot seen;
  world.fill(seen);
  model.frame(0, seen);
  const Model m(model.bytes("block", somewhere(), 16. / 9));
  const auto rgba = m.numbers<std::array<uint8_t, 4>>(m.first(1)["attributes"]["COLOR_0"]);
  ASSERT_EQ(rgba.size(), 4u);
  EXPECT_EQ(rgba[0], (std::array<uint8_t, 4>{255, 0, 0, 255}));
  EXPECT_EQ(rgba[1], (std::array<uint8_t, 4>{0, 55, 0, 255})) << "255 x .2140";
  EXPECT_EQ(rgba[3], (std::array<uint8_t, 4>{255, 255, 255, 255}));
}

// The picture goes along as it is, each vertex of the skin knows its place in it, and colours that other programs would
// multiply by are not there.
TEST(PageModel, ThePictureOnTheSkinIsInThePage) {
  InlineWorkers workers;
  World world(test::pictured_block(), workers);
  PageModel model("act");
  Snapshot seen;
  world.fill(seen);
  model.frame(0, seen);
  const Model m(model.bytes("block", somewhere(), 16. / 9));
  const json& view = m.j["bufferViews"][m.j["images"][0]["bufferView"].get<size_t>()];
  EXPECT_EQ(decode_png(std::string_view(m.bin).substr(view["byteOffset"], view["byteLength"]), "picture").rgb,
            seen.topology->image->rgb);
  const json& skin = m.j["materials"][m.first(0)["material"].get<size_t>()]["pbrMetallicRoughness"];
  EXPECT_EQ(skin["baseColorTexture"], (json{{"index", 0}, {"texCoord", 1}}));
  EXPECT_FALSE(m.first(0)["attributes"].contains("COLOR_0"));
  const auto at = m.numbers<std::array<uint16_t, 2>>(m.first(0)["attributes"]["TEXCOORD_1"]);
  const TissueMesh mesh = coarser_away(make_tissue_mesh(*seen.topology), Vec3f(-99, -99, -99), Vec3f(99, 99, 99));
  ASSERT_EQ(at.size(), mesh.uv.size());
  float most = 0;
  for (size_t v = 0; v < at.size(); ++v) {
    if (mesh.part[v] != Part::skin) continue;
    EXPECT_NEAR(at[v][0] / 65535.f, mesh.uv[v].x(), 1e-5);
    EXPECT_NEAR(at[v][1] / 65535.f, 1 - mesh.uv[v].y(), 1e-5);
    most = std::max(most, mesh.uv[v].x());
  }
  EXPECT_GT(most, 0.5f) << "no places at all";
}

TEST(PageModel, FramesBetweenStagesGiveWayToSize) {
  InlineWorkers workers;
  World world(test::small_block(), workers);
  PageModel model("s");
  Snapshot s;
  world.fill(s);
  for (int i = 0; i <= 16; ++i) {
    for (Vec3f& x : s.x_mm) x.z() += 0.1f;
    if (i == 8)
      model.stage(i, "half way", s);
    else
      model.frame(i, s);
  }
  const std::string whole = model.bytes("block", somewhere(), 1),
                    small = model.bytes("block", somewhere(), 1, whole.size() / 2);
  EXPECT_LT(small.size(), whole.size() / 2);
  const json at = Model(small).j["meshes"][0]["extras"]["at"];
  const std::vector<double> kept = at;
  EXPECT_EQ(kept.front(), 0);
  EXPECT_EQ(kept.back(), 16);
  EXPECT_NE(std::find(kept.begin(), kept.end(), 8), kept.end());
  EXPECT_EQ(Model(model.bytes("block", somewhere(), 1, 1)).j["meshes"][0]["extras"]["at"], json({0.0, 8.0, 16.0}));
}

TEST(PageModel, ACoarserSurfaceIsClosedAndFlatWhereItWas) {
  Slit slit;
  const Snapshot& s = slit.seen.back();
  const TissueMesh fine = make_tissue_mesh(*s.topology), mesh = slit.mesh_of(s);
  EXPECT_LT(mesh.tri.size(), 0.75 * double(fine.tri.size()));
  EXPECT_EQ(mesh.wall_triangles, fine.wall_triangles);
  size_t sum = 0;
  for (const size_t n : mesh.triangles_of) sum += n;
  EXPECT_EQ(sum, mesh.tri.size());
  // Each edge is passed as often one way as the other, by the vertices of the patient: no crack.
  std::map<std::pair<int, int>, int> passed;
  for (const auto& t : mesh.tri)
    for (size_t k = 0; k < 3; ++k) {
      const int a = mesh.source[t[k]], b = mesh.source[t[(k + 1) % 3]];
      passed[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, n] : passed) ASSERT_EQ(n, 0) << edge.first << " " << edge.second;
  // The skin of a block is flat: its area stays, and no triangle of it is turned over.
  const auto area = [](const TissueMesh& m, bool& turned) {
    double a = 0;
    for (size_t t = 0; t < m.skin_triangles; ++t) {
      const auto& [i, j, k] = m.tri[t];
      const double z = 0.5 * double((m.X_mm[j] - m.X_mm[i]).cross(m.X_mm[k] - m.X_mm[i]).z());
      a += z, turned |= z < -1e-6;
    }
    return a;
  };
  bool fine_turned = false, turned = false;
  EXPECT_NEAR(area(mesh, turned), area(fine, fine_turned), 1e-3 * 3600);
  EXPECT_FALSE(turned);
}

}  // namespace test_page_model
}  // namespace limberg
