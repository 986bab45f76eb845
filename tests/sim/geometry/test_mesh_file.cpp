// Bodies from PLY and STL files are those of the same OBJ; colours come along.
#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/body/collider.h"
#include "sim/body/obj.h"
#include "sim/geometry/io/mesh_file.h"

namespace limberg {
namespace test_mesh_file {

constexpr ObjTextLimits kLimits{1000, 1000};

/// A block, whose corners are colourful.
TriMesh block() {
  BlockSpec s;
  s.size_mm = {12, 8, 4};
  s.skin_cell_mm = 2;
  return make_block(s).surface;
}
int colour_of(const Vec3& X, int channel) { return int(std::abs(X.sum() * 7 + 40 * channel)) % 256; }

std::string obj(const TriMesh& m) {
  std::ostringstream s;
  for (const Vec3& X : m.X_mm) s << "v " << X.x() << ' ' << X.y() << ' ' << X.z() << '\n';
  for (const Tri& t : m.tri) s << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return s.str();
}
std::string ply(const TriMesh& m, bool colours = true, bool faces_first = false) {
  std::ostringstream vertices, faces, head;
  for (const Vec3& X : m.X_mm) {
    vertices << X.x() << ' ' << X.y() << ' ' << X.z();
    for (int c = 0; colours && c < 3; ++c) vertices << ' ' << colour_of(X, c);
    vertices << '\n';
  }
  for (const Tri& t : m.tri) faces << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  head << "element vertex " << m.X_mm.size() << "\nproperty float x\nproperty float y\nproperty float z\n";
  if (colours) head << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string of_faces =
      "element face " + std::to_string(m.tri.size()) + "\nproperty list uchar int vertex_indices\n";
  return "ply\nformat ascii 1.0\n" + (faces_first ? of_faces + head.str() : head.str() + of_faces) + "end_header\n" +
         (faces_first ? faces.str() + vertices.str() : vertices.str() + faces.str());
}
std::string stl(const TriMesh& m) {
  std::string s(80, ' ');
  const auto add = [&](const auto& v) { s.append(reinterpret_cast<const char*>(&v), sizeof(v)); };
  add(uint32_t(m.tri.size()));
  for (const Tri& t : m.tri) {
    for (int k = 0; k < 3; ++k) add(0.0f);
    for (const int32_t v : t)
      for (int k = 0; k < 3; ++k) add(float(m.X_mm[size_t(v)][k]));
    add(uint16_t(0));
  }
  return s;
}

Body body(const std::string& text, const char* name) {
  ObjSpec spec;
  spec.path = name;
  spec.layers = {{"skin", 1, {}}};
  return parse_obj(text, spec);
}

TEST(MeshFile, EveryKindGivesTheSameBody) {
  const TriMesh m = block();
  const Body of_obj = body(obj(m), "a.obj"), of_ply = body(ply(m), "a.ply"), of_stl = body(stl(m), "a.stl");
  EXPECT_EQ(of_ply.surface.X_mm, of_obj.surface.X_mm);
  EXPECT_EQ(of_ply.surface.tri, of_obj.surface.tri);
  EXPECT_EQ(of_ply.surface.tag, of_obj.surface.tag);
  // Corners of an STL have no numbers: they come in the order of the triangles.
  ASSERT_EQ(of_stl.surface.tri.size(), of_obj.surface.tri.size());
  EXPECT_EQ(of_stl.surface.X_mm.size(), of_obj.surface.X_mm.size());
  for (size_t t = 0; t < of_obj.surface.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_EQ(of_stl.surface.X_mm[size_t(of_stl.surface.tri[t][k])],
                of_obj.surface.X_mm[size_t(of_obj.surface.tri[t][k])]);
  EXPECT_EQ(of_stl.surface.tag, of_obj.surface.tag);
}

TEST(MeshFile, ColoursOfAPlyAreThoseOfItsVertices) {
  const TriMesh m = block();
  const Body b = body(ply(m), "a.ply");
  ASSERT_EQ(b.rgb.size(), b.surface.X_mm.size());
  for (size_t v = 0; v < b.rgb.size(); ++v)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(b.rgb[v][c], colour_of(b.surface.X_mm[v], c) / 255.0, 1e-6);
  EXPECT_TRUE(body(ply(m, false), "a.ply").rgb.empty());
  EXPECT_TRUE(body(stl(m), "a.stl").rgb.empty());
}

TEST(MeshFile, CollidersMayBeOfEveryKind) {
  const TriMesh m = block();
  ColliderSpec spec;
  spec.path = "a.obj";
  const size_t triangles = parse_collider(obj(m), spec)->mesh.tri.size();
  spec.path = "a.ply";
  EXPECT_EQ(parse_collider(ply(m), spec)->mesh.tri.size(), triangles);
  EXPECT_EQ(parse_collider(ply(m), spec)->rgb.size(), m.X_mm.size());
  spec.path = "a.stl";
  EXPECT_EQ(parse_collider(stl(m), spec)->mesh.tri.size(), triangles);
}

std::string why(const std::string& bytes, const char* name, const ObjTextLimits& limits = kLimits) {
  try {
    parse_mesh_file(bytes, name, limits);
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing";
}

TEST(MeshFile, WhatIsWrongIsNamed) {
  const TriMesh m = block();
  EXPECT_EQ(why(ply(m), "a.ply"), "nothing");
  EXPECT_EQ(why(ply(m, true, true), "a.ply"), "nothing");  // faces may come first
  EXPECT_EQ(why(stl(m), "a.stl"), "nothing");
  EXPECT_NE(why(ply(m).substr(0, ply(m).size() - 3), "a.ply").find("a.ply"), std::string::npos);
  EXPECT_NE(why(stl(m).substr(0, 300), "a.stl").find("is cut short"), std::string::npos);
  EXPECT_NE(why(ply(m), "a.ply", {10, 1000}).find("more than 10 vertices"), std::string::npos);
  EXPECT_NE(why(ply(m), "a.ply", {1000, 10}).find("more than 10 triangles"), std::string::npos);
  EXPECT_NE(why(stl(m), "a.stl", {1000, 10}).find("more than 10 triangles"), std::string::npos);
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NE(why(head + "3 0 1 3\n", "a.ply").find("a.ply:13: a face names point 3; there are 3"), std::string::npos);
  EXPECT_NE(why(head + "3 0 1 -1\n", "a.ply").find("names point -1"), std::string::npos);
  EXPECT_NE(why(head + "2 0 1\n", "a.ply").find("fewer than three corners"), std::string::npos);
  EXPECT_NE(why(head + "4 0 1 2 0\n", "a.ply", {10, 10, 3}).find("4 corners; expected at most 3"), std::string::npos);
  EXPECT_NE(why("ply\nformat ascii 1.0\n", "a.ply").find("header does not end"), std::string::npos);
}

}  // namespace test_mesh_file
}  // namespace limberg
