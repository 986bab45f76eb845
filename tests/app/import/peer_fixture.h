#pragma once
// A peer's files, made by us: a slab of 60 x 40 x 12 mm whose left half lies on bone and whose right half is a lip,
// free on both sides, with a free margin at its right end.
//
//   z ^   skin (2), texture u .05 .. .45                       margin, skin (2), u .5 .. .52
//     |   +-----------------------------------------+
//     |   |                                         |
//     |   +--------------------+--------------------+
//         periosteum (7)        mucosa (2), u .55 .. .95
//
// The other sides are periphery (1). Units are 10 mm. Where x and y are of a texture place: u = .05 + .4 x/60 on the
// skin and u = .55 + .4 x/60 on the mucosa, v = .05 + .9 y/40.
#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "app/import/peer_model.h"

namespace limberg::test {

struct PeerFixture {
  static constexpr int nx = 24, ny = 16;
  static constexpr double length = 6, width = 4, height = 1.2, skin = 0.2;  // in units of 10 mm
  std::string obj, bed;

  PeerFixture() {
    std::vector<std::string> face[8];
    const auto vertex = [&](double x, double y, double z) { obj += fmt::format("v {} {} {}\n", x, y, z); };
    for (const double z : {height, 0.0})
      for (int i = 0; i <= nx; ++i)
        for (int k = 0; k <= ny; ++k) vertex(length * i / nx, width * k / ny, z);
    const auto id = [&](bool low, int i, int k) { return 1 + (low ? (nx + 1) * (ny + 1) : 0) + i * (ny + 1) + k; };
    int texture = 0;
    const auto corner = [&](int v, double u, double w) {
      obj += fmt::format("vt {} {}\n", u, w);
      return fmt::format("{}/{}", v, ++texture);
    };
    const auto quad = [&](int material, std::array<std::string, 4> c) {
      face[material].push_back("f " + c[0] + " " + c[1] + " " + c[2]);
      face[material].push_back("f " + c[0] + " " + c[2] + " " + c[3]);
    };
    const auto u = [](double base, int i) { return base + 0.4 * i / nx; };
    const auto v = [](int k) { return 0.05 + 0.9 * k / ny; };
    for (int i = 0; i < nx; ++i)
      for (int k = 0; k < ny; ++k) {
        quad(2, {corner(id(false, i, k), u(0.05, i), v(k)), corner(id(false, i + 1, k), u(0.05, i + 1), v(k)),
                 corner(id(false, i + 1, k + 1), u(0.05, i + 1), v(k + 1)),
                 corner(id(false, i, k + 1), u(0.05, i), v(k + 1))});
        const bool bone = i < nx / 2;
        quad(bone ? 7 : 2, {corner(id(true, i, k), u(0.55, i), v(k)), corner(id(true, i, k + 1), u(0.55, i), v(k + 1)),
                            corner(id(true, i + 1, k + 1), u(0.55, i + 1), v(k + 1)),
                            corner(id(true, i + 1, k), u(0.55, i + 1), v(k))});
      }
    const auto side = [&](int material, int i0, int k0, int i1, int k1, double u0, double u1, double v0, double v1) {
      quad(material, {corner(id(true, i0, k0), u0, v0), corner(id(true, i1, k1), u0, v1),
                      corner(id(false, i1, k1), u1, v1), corner(id(false, i0, k0), u1, v0)});
    };
    for (int k = 0; k < ny; ++k) {
      side(2, nx, k, nx, k + 1, 0.5, 0.52, v(k), v(k + 1));
      side(1, 0, k + 1, 0, k, 0, 0, 0, 0);  // without area on the texture
    }
    for (int i = 0; i < nx; ++i) side(1, i, 0, i + 1, 0, 0, 0, 0, 0), side(1, i + 1, ny, i, ny, 0, 0, 0, 0);
    for (int m = 0; m < 8; ++m) {
      if (face[m].empty()) continue;
      obj += fmt::format("usemtl {}\n", m);
      for (const std::string& f : face[m]) obj += f + "\n";
    }
    for (int i = 0; i <= nx; ++i)
      for (int k = 0; k <= ny; ++k)
        bed += fmt::format("{} {} {} {}\n", id(false, i, k) - 1, length * i / nx, width * k / ny, height - skin);
  }

  static std::string scene(const std::string& object = "slab.obj") {
    return R"({"dynamicObjects":{")" + object +
           R"(":{"textureMaps":[1]}},"staticObjects":{"teeth.obj":{"textureMap":2}},
"tetrahedralProperties":{"minStrain":0.8,"maxStrain":1.26,"autoSutureSpacing":0.14,"nTetSizeLevels":4,
"maxDimMegatetSubdivs":34},"fixedCollisionSets":{"teeth.obj":[1,2]}})";
  }

  // Places, mm of the slab, and displacements in mm.
  static std::string place(double x, double y, const Vec3& moved_mm = Vec3::Zero(), int material = 2,
                           const std::string& end = "", bool below = false) {
    const double unit = history_mm();
    return fmt::format(R"("material{}":{},"historyTexture{}":[{:.9f},{:.9f}],"displacement{}":[{:.9f},{:.9f},{:.9f}])",
                       end, material, end, (below ? 0.55 : 0.05) + 0.4 * x / 60, 0.05 + 0.9 * y / 40, end,
                       moved_mm.x() / unit, moved_mm.y() / unit, moved_mm.z() / unit);
  }
  static double history_mm() {
    const Vec3 size(60, 40, 12);
    return (size.maxCoeff() + 2e-4 * size.norm()) / 34 / 8;
  }
  static std::string incision(const std::vector<Vec2>& path, bool in = false, bool out = false) {
    std::string s = fmt::format(R"({{"makeIncision":[{{"Tin":{},"Tout":{},"incisedObject":0,"pointNumber":{}}})", in,
                                out, path.size());
    for (const Vec2& p : path) s += R"(,{"incisionPoint":{)" + place(p.x(), p.y()) + "}}";
    return s + "]}";
  }
  static std::string deep_cut(const std::vector<Vec2>& path, bool in, bool out) {
    std::string s = fmt::format(R"({{"makeDeepCut":[{{"deepCutObject":0,"openIn":{},"openOut":{},"pointNumber":{}}})",
                                in, out, path.size());
    for (const Vec2& p : path) s += R"(,{"deepCutPoint":{)" + place(p.x(), p.y()) + R"(,"postNormal":[0,0,1]}})";
    return s + "]}";
  }
  static std::string undermine(const std::vector<Vec2>& points, bool connect_first, bool connect_last) {
    std::string s = R"({"undermine":[)";
    for (size_t i = 0; i < points.size(); ++i)
      s += (i ? "," : "") + std::string(R"({"underminePoint":{)") + place(points[i].x(), points[i].y()) +
           fmt::format(R"(,"incisionConnect":{}}}}})",
                       (i == 0 && connect_first) || (i + 1 == points.size() && connect_last));
    return s + "]}";
  }
  static std::string excise(double x, double y) { return R"({"excise":{)" + place(x, y) + "}}"; }
  static std::string hook(int number, const std::string& where) {
    return fmt::format(R"({{"addHook":{{{},"hookNum":{}}}}})", where, number);
  }
  static std::string suture(int number, const std::string& a, const std::string& b, bool linked) {
    return fmt::format(R"({{"addSuture":{{{},{},"linked":{},"sutureNum":{}}}}})", a, b, linked, number);
  }
  static std::string history(const std::vector<std::string>& acts, const std::string& between = ",\n") {
    std::string s = "[\n{\"loadSceneFile\":\"slab.smd\"}";
    for (const std::string& a : acts) s += between + a;
    return s + "\n]\n";
  }

  PeerModel model() const {
    const PeerBed deep = parse_peer_bed(bed, "slab.bed");
    return parse_peer_model(obj, "slab.obj", parse_peer_scene(scene(), "slab.smd"), &deep, "slab.bed", 10);
  }
};

}  // namespace limberg::test
