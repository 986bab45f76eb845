#pragma once
// The operation as one glTF 2.0 file (.glb), which any viewer opens, turns and plays.
//
//   Surface   for each version of the surface between two cuts a mesh with a primitive for each thing (skin, wound,
//             side, face, bone); how it moves is morph targets, one for each further frame, run through by an
//             animation. Nodes are shown in their time: their scale steps from 0 to 1 and back.
//   Picture   that on the skin, where it has one: vertices at its seams are there once for each side.
//   Stitches and hooks are lines, in the same way. Colliders are there once and do not move.
//
// Metres and y up, as glTF wants it: the root node scales mm and turns z up into y up. No normals: where none are given
// a viewer shades each triangle flat, which stays right however a flap is turned. asset.extras lists the moments and
// times.
//
// Written here, without tinygltf: nlohmann/json, which is there, writes the JSON, and a package more for everybody who
// builds would save a hundred lines. Specification: Khronos, glTF 2.0, 2021; tests/app/export/test_gltf.cpp checks the
// rules of its validator that can be broken here.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/body/collider.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class GltfStory {
 public:
  /// Times ascend. `name`: of a moment; empty: a frame between. Frames without a surface are left out.
  void add(double t_s, const std::string& name, const Snapshot& snapshot);
  bool empty() const { return frames_ == 0; }
  int frames() const { return frames_; }
  /// Of one frame: no animation.
  std::string bytes(const std::string& title) const;

 private:
  /// What is drawn with one list of indices while it lasts.
  struct Part {
    std::string name;
    int material = 0;
    std::vector<uint32_t> index;
  };
  struct Shape {
    std::string key, name;
    bool lines = false;
    std::vector<Part> parts;
    std::vector<Eigen::Vector2f> uv;  // of each vertex, from above; empty: no picture
    std::vector<double> t_s;
    std::vector<std::vector<Vec3f>> x_mm;  // per frame
    double until_s = -1;                   // when it goes; < 0: it stays
  };
  void frame(int series, double t_s, const std::string& key, std::vector<Vec3f> x_mm,
             const std::function<std::vector<Part>()>& parts, const char* name, bool lines);

  /// The skin's vertices parted along the seams of its picture.
  struct Pictured {
    std::string key;                           // the surface's
    std::vector<uint32_t> more;                // vertices of the view that come again, after all of it
    std::vector<std::array<uint32_t, 3>> tri;  // in all of these
    std::vector<Eigen::Vector2f> uv;           // from above
  };
  static Pictured pictured(const SurfaceTopology& topology, const std::string& key);

  std::vector<Shape> shapes_;
  Pictured pictured_;
  std::shared_ptr<const SkinImage> image_;
  bool on_face_ = false;  // it is a face's
  std::vector<std::shared_ptr<const Collider>> colliders_;
  int last_[3] = {-1, -1, -1};  // of each series: the shape that is there now
  std::vector<std::pair<double, std::string>> moments_;
  int frames_ = 0;
  double first_s_ = 0, last_s_ = 0;
};

}  // namespace limberg
