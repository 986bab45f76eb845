// The animated file of an operation: the rules of glTF 2.0 that its validator checks and that can be broken here, and
// that what is in it is the patient. Read back by a reader of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "app/export/glb.h"
#include "app/export/gltf.h"
#include "render/image.h"
#include "sim/base/workers.h"
#include "sim/patient/world.h"
#include "tests/app/export/pictured_block.h"

namespace limberg {
namespace test_gltf {

using nlohmann::json;

struct Glb {
  json j;
  std::string bin;
};

uint32_t word_at(const std::string& s, size_t at) {
  uint32_t v = 0;
  std::memcpy(&v, s.data() + at, 4);
  return v;
}

Glb read(const std::string& bytes) {
  Glb g;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word_at(bytes, 4), 2u);
  EXPECT_EQ(word_at(bytes, 8), bytes.size());
  const uint32_t n = word_at(bytes, 12);
  EXPECT_EQ(n % 4, 0u);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  g.j = json::parse(bytes.substr(20, n));
  const size_t bin = 20 + n;
  EXPECT_EQ(word_at(bytes, bin) % 4, 0u);
  EXPECT_EQ(bytes.substr(bin + 4, 4), std::string("BIN\0", 4));
  g.bin = bytes.substr(bin + 8);
  EXPECT_EQ(g.bin.size(), word_at(bytes, bin));
  return g;
}

int width(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
}

std::vector<float> floats(const Glb& g, size_t accessor) {
  const json& a = g.j["accessors"][accessor];
  EXPECT_EQ(a["componentType"], 5126);
  const json& v = g.j["bufferViews"][a["bufferView"].get<size_t>()];
  std::vector<float> out(a["count"].get<size_t>() * size_t(width(a["type"])));
  std::memcpy(out.data(), g.bin.data() + v["byteOffset"].get<size_t>(), out.size() * 4);
  return out;
}
std::vector<uint32_t> indices(const Glb& g, size_t accessor) {
  const json& a = g.j["accessors"][accessor];
  EXPECT_EQ(a["componentType"], 5125);
  const json& v = g.j["bufferViews"][a["bufferView"].get<size_t>()];
  std::vector<uint32_t> out(a["count"].get<size_t>());
  std::memcpy(out.data(), g.bin.data() + v["byteOffset"].get<size_t>(), out.size() * 4);
  return out;
}

void expect_valid(const Glb& g) {
  const json& j = g.j;
  EXPECT_EQ(j["asset"]["version"], "2.0");
  ASSERT_EQ(j["buffers"].size(), 1u);
  EXPECT_EQ(j["buffers"][0]["byteLength"], g.bin.size());
  size_t end = 0;
  for (const json& v : j["bufferViews"]) {
    EXPECT_EQ(v["byteOffset"].get<size_t>() % 4, 0u);
    EXPECT_GE(v["byteOffset"].get<size_t>(), end);
    end = v["byteOffset"].get<size_t>() + v["byteLength"].get<size_t>();
    EXPECT_LE(end, g.bin.size());
    EXPECT_GT(v["byteLength"].get<size_t>(), 0u);
  }
  std::set<size_t> positions;
  for (size_t i = 0; i < j["accessors"].size(); ++i) {
    const json& a = j["accessors"][i];
    const size_t k = size_t(width(a["type"])), bytes = a["count"].get<size_t>() * k * 4;
    ASSERT_GT(a["count"].get<size_t>(), 0u);
    EXPECT_LE(bytes, j["bufferViews"][a["bufferView"].get<size_t>()]["byteLength"].get<size_t>());
    if (a["componentType"] != 5126) continue;
    const std::vector<float> v = floats(g, i);
    for (const float x : v) ASSERT_TRUE(std::isfinite(x));
    if (!a.contains("min")) continue;
    for (size_t c = 0; c < k; ++c) {
      float low = v[c], high = v[c];
      for (size_t n = c; n < v.size(); n += k) low = std::min(low, v[n]), high = std::max(high, v[n]);
      EXPECT_EQ(a["min"][c].get<float>(), low);
      EXPECT_EQ(a["max"][c].get<float>(), high);
    }
  }
  for (const json& m : j["meshes"]) {
    const size_t targets = m.contains("weights") ? m["weights"].size() : 0;
    for (const json& p : m["primitives"]) {
      const size_t position = p["attributes"]["POSITION"];
      EXPECT_TRUE(j["accessors"][position].contains("min"));
      const size_t n = j["accessors"][position]["count"];
      EXPECT_LT(p["material"].get<size_t>(), j["materials"].size());
      const std::vector<uint32_t> index = indices(g, p["indices"]);
      EXPECT_EQ(index.size() % (p["mode"] == 1 ? 2 : 3), 0u);
      for (const uint32_t v : index) ASSERT_LT(v, n);
      EXPECT_EQ(p.contains("targets") ? p["targets"].size() : 0, targets);
      if (targets)
        for (const json& t : p["targets"]) {
          EXPECT_EQ(j["accessors"][t["POSITION"].get<size_t>()]["count"], n);
          EXPECT_TRUE(j["accessors"][t["POSITION"].get<size_t>()].contains("min"));
        }
    }
  }
  std::vector<int> parents(j["nodes"].size(), 0);
  for (const json& n : j["nodes"])
    for (const json& c : n.value("children", json::array())) ++parents.at(c.get<size_t>());
  for (const json& n : j["scenes"][0]["nodes"]) ++parents.at(n.get<size_t>());
  for (const int p : parents) EXPECT_EQ(p, 1);
  for (const json& a : j.value("animations", json::array())) {
    std::set<std::string> driven;
    for (const json& c : a["channels"]) {
      const size_t node = c["target"]["node"];
      const std::string path = c["target"]["path"];
      EXPECT_TRUE(driven.insert(std::to_string(node) + path).second);
      const json& s = a["samplers"][c["sampler"].get<size_t>()];
      const std::vector<float> t = floats(g, s["input"]), out = floats(g, s["output"]);
      EXPECT_TRUE(j["accessors"][s["input"].get<size_t>()].contains("max"));
      EXPECT_GE(t.front(), 0);
      for (size_t i = 1; i < t.size(); ++i) EXPECT_LT(t[i - 1], t[i]);
      const size_t each = path == "weights" ? j["meshes"][j["nodes"][node]["mesh"].get<size_t>()]["weights"].size() : 3;
      EXPECT_EQ(out.size(), t.size() * each);
    }
  }
}

/// A sampler's output at a time: STEP or LINEAR.
std::vector<float> sampled(const Glb& g, const json& s, float at) {
  const std::vector<float> t = floats(g, s["input"]), v = floats(g, s["output"]);
  const size_t each = v.size() / t.size();
  size_t i = 0;
  while (i + 1 < t.size() && t[i + 1] <= at) ++i;
  std::vector<float> out(v.begin() + ptrdiff_t(i * each), v.begin() + ptrdiff_t((i + 1) * each));
  if (s["interpolation"] == "LINEAR" && i + 1 < t.size() && at > t[i])
    for (size_t k = 0; k < each; ++k) out[k] += (at - t[i]) / (t[i + 1] - t[i]) * (v[(i + 1) * each + k] - out[k]);
  return out;
}

/// The places of the only surface that is shown at a time, as a viewer would have them, in mm.
std::vector<float> shown(const Glb& g, float at, const std::string& kind = "surface") {
  std::vector<float> out;
  for (size_t n = 1; n < g.j["nodes"].size(); ++n) {
    const json& mesh = g.j["meshes"][g.j["nodes"][n]["mesh"].get<size_t>()];
    if (mesh["name"] != kind) continue;
    std::vector<float> scale{1, 1, 1}, weights;
    for (const json& c : g.j["animations"][0]["channels"])
      if (c["target"]["node"] == n)
        (c["target"]["path"] == "scale" ? scale : weights) =
            sampled(g, g.j["animations"][0]["samplers"][c["sampler"].get<size_t>()], at);
    if (scale[0] == 0) continue;
    EXPECT_TRUE(out.empty()) << "two at a time at " << at;
    const json& p = mesh["primitives"][0];
    out = floats(g, p["attributes"]["POSITION"]);
    for (size_t t = 0; t < weights.size(); ++t) {
      const std::vector<float> way = floats(g, p["targets"][t]["POSITION"]);
      for (size_t i = 0; i < out.size(); ++i) out[i] += weights[t] * way[i];
    }
  }
  return out;
}

void expect_places(const std::vector<float>& got, const Snapshot& s) {
  ASSERT_EQ(got.size(), 3 * s.x_mm.size());
  for (size_t v = 0; v < s.x_mm.size(); ++v)
    for (size_t k = 0; k < 3; ++k) ASSERT_NEAR(got[3 * v + k], s.x_mm[v][long(k)], 1e-4);
}

void settle(World& w) {
  StepSettings s;
  for (int i = 0; i < 40; ++i) w.step(s);
}

/// A patient before and after a slit is cut and opens, which is seen last.
Glb slit(World& world, Snapshot& seen) {
  GltfStory story;
  world.fill(seen);
  story.add(0, "before", seen);
  EXPECT_TRUE(world.apply(Incise{{{-15, 0}, {15, 0}}, 4}).done);
  settle(world);
  world.fill(seen);
  story.add(1, "open", seen);
  return read(story.bytes("block"));
}

TEST(Gltf, PlaysTheOperation) {
  InlineWorkers workers;
  World world(test::small_block(), workers);
  GltfStory story;
  std::vector<Snapshot> seen;
  const auto add = [&](double t, const char* name) {
    world.fill(seen.emplace_back());
    story.add(t, name, seen.back());
  };
  add(2, "");
  ASSERT_TRUE(world.apply(Incise{{{-15, 0}, {15, 0}}, 4}).done);
  add(3, "cut");
  settle(world);
  add(4, "open");
  ASSERT_TRUE(world.apply(Suture{{0, 1}, {0, -1}, 0}).done);
  settle(world);
  add(6, "stitched");
  const Glb g = read(story.bytes("block"));
  expect_valid(g);
  // Times begin with the first frame.
  expect_places(shown(g, 0), seen[0]);
  expect_places(shown(g, .9f), seen[0]);
  expect_places(shown(g, 1), seen[1]);
  expect_places(shown(g, 2), seen[2]);
  expect_places(shown(g, 4), seen[3]);
  // Halfway between two frames of one surface everything is halfway.
  const std::vector<float> half = shown(g, 3);
  for (size_t v = 0; v < seen[2].x_mm.size(); ++v)
    ASSERT_NEAR(half[3 * v + 1], (seen[2].x_mm[v].y() + seen[3].x_mm[v].y()) / 2, 1e-4);
  EXPECT_TRUE(shown(g, 3, "stitches").empty());
  const std::vector<float> stitch = shown(g, 4, "stitches");
  ASSERT_EQ(stitch.size(), 6u);
  EXPECT_NEAR(stitch[1], seen[3].sutures[0].a_mm.y(), 1e-4);
  // A viewer finds the moments by name.
  ASSERT_EQ(g.j["asset"]["extras"]["moments"].size(), 3u);
  EXPECT_EQ(g.j["asset"]["extras"]["moments"][0]["name"], "cut");
  EXPECT_EQ(g.j["asset"]["extras"]["moments"][0]["at_s"], 1.0);
  // Wounds have a look of their own after the cut, none before.
  EXPECT_EQ(g.j["meshes"][0]["primitives"].size() + 1, g.j["meshes"][1]["primitives"].size());
}

TEST(Gltf, WhatTheTissueLiesAgainstIsThereAndStill) {
  InlineWorkers workers;
  WorldSpec spec = test::small_block();
  auto body = std::make_shared<Body>(*spec.body);
  body->colliders.push_back(
      parse_collider("v 40 0 0\nv 48 0 0\nv 40 8 0\nv 40 0 8\n"
                     "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
                     {"wedge.obj"}));
  spec.body = body;
  World world(spec, workers);
  Snapshot seen;
  const Glb g = slit(world, seen);
  expect_valid(g);
  int wedges = 0;
  for (const auto& mesh : g.j["meshes"]) {
    if (mesh["name"] != body->colliders[0]->name) continue;
    ++wedges;
    const auto& places = g.j["accessors"][mesh["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
    EXPECT_EQ(places["count"], 4);
    EXPECT_EQ(places["min"], nlohmann::json({40.0, 0.0, 0.0}));
    EXPECT_EQ(places["max"], nlohmann::json({48.0, 8.0, 8.0}));
    EXPECT_FALSE(mesh.contains("weights"));
  }
  EXPECT_EQ(wedges, 1);
}

TEST(Gltf, OneMomentStandsStill) {
  InlineWorkers workers;
  const World world(test::small_block(), workers);
  GltfStory story;
  EXPECT_TRUE(story.empty());
  Snapshot s;
  world.fill(s);
  story.add(0, "end", s);
  const Glb g = read(story.bytes("block"));
  expect_valid(g);
  EXPECT_FALSE(g.j.contains("animations"));
  // mm to m, and z up to y up.
  EXPECT_NEAR(g.j["nodes"][0]["scale"][0].get<double>(), 1e-3, 1e-9);
  const json& q = g.j["nodes"][0]["rotation"];
  const Eigen::Quaterniond turn(q[3].get<double>(), q[0].get<double>(), q[1].get<double>(), q[2].get<double>());
  EXPECT_LT((turn * Vec3::UnitZ() - Vec3::UnitY()).norm(), 1e-6);
}

// A block with a picture, whose faces meet at seams of it: each corner of the skin lies where the picture has it.
TEST(Gltf, ThePictureLiesOnTheSkin) {
  InlineWorkers workers;
  WorldSpec spec = test::pictured_block();
  auto body = std::make_shared<Body>(*spec.body);
  auto& uv = body->surface.uv;
  ASSERT_EQ(uv.size(), body->surface.tri.size());
  for (size_t t = 0; t < uv.size(); t += 2)  // every other triangle elsewhere: a seam round each
    for (Eigen::Vector2f& at : uv[t]) at = Eigen::Vector2f(0.5f, 0.25f) + 0.1f * at;
  spec.body = body;
  World world(spec, workers);
  Snapshot seen;
  const Glb g = slit(world, seen);
  expect_valid(g);
  const json& view = g.j["bufferViews"][g.j["images"][0]["bufferView"].get<size_t>()];
  const Image read_back =
      decode_png(std::string_view(g.bin).substr(view["byteOffset"], view["byteLength"]), "the file's picture");
  EXPECT_EQ(read_back.width, 2);
  EXPECT_EQ(read_back.rgb, spec.image->rgb);
  const json& skin = g.j["materials"][kSkinLook]["pbrMetallicRoughness"];
  EXPECT_EQ(skin["baseColorTexture"], (json{{"index", 0}, {"texCoord", 0}}));
  EXPECT_EQ(skin["baseColorFactor"], (json{1, 1, 1, 1}));

  const SurfaceView& v = seen.topology->view;
  const json& mesh = g.j["meshes"][1];  // the second surface, of one frame
  const auto p = std::find_if(mesh["primitives"].begin(), mesh["primitives"].end(),
                              [](const json& q) { return q["material"] == kSkinLook; });
  ASSERT_NE(p, mesh["primitives"].end());
  const std::vector<float> x = floats(g, (*p)["attributes"]["POSITION"]),
                           at = floats(g, (*p)["attributes"]["TEXCOORD_0"]);
  ASSERT_EQ(at.size() / 2, x.size() / 3);
  EXPECT_GT(x.size() / 3, seen.x_mm.size()) << "no vertex is parted at a seam";
  const std::vector<uint32_t> corner = indices(g, (*p)["indices"]);
  size_t c = 0;
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::skin) continue;
    for (size_t k = 0; k < 3; ++k, ++c) {
      ASSERT_LT(c, corner.size());
      for (size_t i = 0; i < 3; ++i) ASSERT_EQ(x[3 * corner[c] + i], seen.x_mm[size_t(v.tri[t][int(k)])][long(i)]);
      ASSERT_EQ(at[2 * corner[c]], v.uv[t][k].x());
      ASSERT_EQ(at[2 * corner[c] + 1], 1 - v.uv[t][k].y());
    }
  }
  EXPECT_EQ(c, corner.size());
}

}  // namespace test_gltf
}  // namespace limberg
