#pragma once
// Measuring on the patient: two points give a length, three an angle at the second. The points are of the tissue: they
// move with it, and a cut does not lose them.
#include <vector>

#include "app/window/ray_cast.h"

namespace limberg {

class Ruler {
 public:
  /// Takes the point; a fourth begins anew.
  void add(const Snapshot& snapshot, const RayHit& hit);
  void clear() { points_.clear(); }

  struct Reading {
    std::vector<Vec3f> at_mm;           // of each point, now
    double length_mm = 0, rest_mm = 0;  // straight, between the last two points; at rest
    double angle_deg = 0;               // at the second of three points
  };
  Reading read(const Snapshot& snapshot);

 private:
  struct Point {
    uint64_t version = 0;
    int32_t triangle = -1;
    Vec3f bary = Vec3f::Zero();
    Vec3 X_mm = Vec3::Zero();  // at rest
    Vec3f x_mm = Vec3f::Zero();
    FaceKind kind = FaceKind::skin;
  };
  static void find_again(Point& p, const Snapshot& snapshot);
  std::vector<Point> points_;
};

}  // namespace limberg
