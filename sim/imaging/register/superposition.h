#pragma once
// Superposition: one surface laid upon another (an abnormal skull on a normal one), and what then differs.
//
//   landmarks    pairs of places: the rotation, shift and, if wanted,
//                scale with the least sum of squares (Umeyama 1991, by
//                singular values; for unit scale the same as Horn 1987)
//   ICP          the nearest places on the other surface, the `keep` share of the
//                pairs with the smallest distances, the small motion with the
//                least squares of distances along the other's normals; again
//                until it stands still (Chen and Medioni 1992; trimmed:
//                Chetverikov and others 2002). Once it moves little, pairs within
//                three robust standard deviations count too: with noise, the
//                smallest distances are those that agree with the present guess
//   mirror plane the surface reflected in a first guess, laid upon itself by ICP; the plane that bisects the result
//   distance map signed distance of every vertex to the other surface, > 0 outside (weighted normals, Baerentzen and
//                Aanaes 2005, blended at edges), mean, rms, 95th percentile
//
// A surface without triangles is a cloud: normals are those of the best plane
// through the nearest 12 points, without a side; distances to it are without sign.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/point_tree.h"
#include "sim/imaging/io/surface_file.h"

namespace limberg {

/// x -> scale R x + t.
struct Similarity {
  double scale = 1;
  Mat3 R = Mat3::Identity();  // a rotation; det -1 where a reflection is meant
  Vec3 t_mm = Vec3::Zero();
  Vec3 operator()(const Vec3& x) const { return scale * (R * x) + t_mm; }
  Similarity operator*(const Similarity& b) const { return {scale * b.scale, R * b.R, scale * (R * b.t_mm) + t_mm}; }
  Similarity inverse() const { return {1 / scale, R.transpose(), -(R.transpose() * t_mm) / scale}; }
  double angle_deg() const;
};

struct LandmarkFit {
  Similarity map;                 // of `from` onto `to`
  double rms_mm = 0, max_mm = 0;  // residuals
  std::string reason;             // why there is none; empty: good
  explicit operator bool() const { return reason.empty(); }
};
/// Refused with the reason: fewer than three pairs, places (nearly)
/// on a line or at one point, numbers that are not finite.
LandmarkFit fit_landmarks(const std::vector<Vec3>& from_mm, const std::vector<Vec3>& to_mm, bool with_scale);

/// Mean of places; zero where there are none.
Vec3 middle_of(const std::vector<Vec3>& x_mm);

/// What a surface lacks to be laid upon another by its shape, or another upon it; empty: nothing. At least 10 points,
/// not all (nearly) on a line, and where there are triangles one with an area.
std::string lacks_shape(const Surface& surface);

/// What is laid upon: searchable.
class SurfaceTarget {
 public:
  /// Throws InputError: no points. `by_side`: closest_facing will be asked for.
  explicit SurfaceTarget(const Surface& surface, bool by_side = false);
  struct Place {
    Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitZ();
    double distance_mm = 0;  // > 0
    bool border = false;     // on the rim of an open surface
  };
  Place closest(const Vec3& x_mm) const;
  /// The nearest place of a face that looks the way of `normal` (a unit vector; all within 54 degrees of it, none past
  /// 95): of a thin wall its own side. None within `far_mm`, or a cloud: false.
  bool closest_facing(const Vec3& x_mm, const Vec3& normal, double far_mm, Place& place) const;
  bool cloud() const { return tri_.empty(); }

 private:
  Place place_of(const Bvh::Closest& c) const;

  std::vector<Tri> tri_;
  std::vector<Vec3> normal_;  // of vertices, or of points
  std::vector<uint8_t> rim_;  // vertex on a border
  Bvh bvh_;
  std::array<Bvh, 6> side_;  // faces that look along +x, -x, +y, ...
  PointTree tree_;
  std::vector<Vec3> face_normal_;
};

struct IcpSettings {
  double keep = 0.7;  // share of the pairs
  int iterations = 200;
  double still_mm = 1e-3;  // ends when no sample moves farther,
  int patience = 0;        // or when so many iterations have brought the rms down by less than 1e-4 of it; 0: never so
  bool with_scale = false;
  int samples = 8000;  // at most, of the vertices of the surface that is moved (evenly by number)
};
struct IcpResult {
  Similarity map;
  double rms_mm = 0;  // of the pairs that were kept, along the normals
  int iterations = 0;
  bool still = false;  // ended by itself
  std::string reason;  // why there is none (too few samples, a surface that lets the motion slip); empty: good
  explicit operator bool() const { return reason.empty(); }
};
IcpResult icp(const Surface& moved, const SurfaceTarget& target, const Similarity& start, const IcpSettings& settings,
              Workers& workers);
/// From where they lie, from equal middles and from equal principal axes (four ways): the best of them.
IcpResult icp_from_anywhere(const Surface& moved, const SurfaceTarget& target, const Surface& target_surface,
                            const IcpSettings& settings, Workers& workers);

struct MirrorPlane {
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitX();
  Similarity map;     // the reflection that ICP arrived at (nearly one in the plane)
  double rms_mm = 0;  // of the kept pairs
  std::string reason;
  explicit operator bool() const { return reason.empty(); }
  Vec3 reflect(const Vec3& x) const { return x - 2 * normal.dot(x - point_mm) * normal; }
};
/// `normal`: of the first guess, through the middle of the surface.
MirrorPlane mirror_plane(const Surface& surface, const Vec3& normal, const IcpSettings& settings, Workers& workers);

struct DistanceMap {
  std::vector<double> signed_mm;  // per vertex of the surface that was laid upon
  double mean_mm = 0, mean_abs_mm = 0, rms_mm = 0, p95_mm = 0, max_mm = 0;  // mean with sign, the others of sizes
};
DistanceMap distance_map(const Surface& surface, const Similarity& map, const SurfaceTarget& target, Workers& workers);

}  // namespace limberg
