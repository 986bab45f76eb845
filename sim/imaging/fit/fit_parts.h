#pragma once
// The parts of a fit (fit.h): what vertices are drawn to, and what is done to the mesh's topology.
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/base/workers.h"
#include "sim/geometry/point_tree.h"
#include "sim/imaging/fit/fit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::imaging {

/// Where the vertices are drawn to.
class Sight {
 public:
  virtual ~Sight() = default;
  /// Pull of a vertex at x with outward normal N, when the fit is at `t` (0..1 of its way) and no pull is longer than
  /// `range`; `seen`: it has found the surface itself, not only the way to it.
  virtual Vec3 pull(const Vec3& x, const Vec3& N, double t, double range, bool& seen) const = 0;
  /// Distance of a seen vertex to the surface; `way`: its last pull.
  virtual double distance(const Vec3& x, const Vec3& way) const = 0;
  /// Distance to the nearest place of the surface, whatever the normal; infinite beyond `within`.
  virtual double nearest(const Vec3& x, double within) const = 0;
  /// A thin wall lies nearer than any place of the surface.
  virtual bool on_wall(const Vec3&) const { return false; }
  virtual double voxel() const = 0;
  /// mm outside the object as far as that is known; for points: 0.
  virtual double air(const Vec3& x) const = 0;
  virtual bool knows_air() const = 0;
  /// The way back to the object from a place in air, sideways too; no longer than `most`.
  virtual Vec3 home(const Vec3& x, double most) const = 0;
  /// Border of the data that a place lies at: 2 axis + (0 low, 1
  /// high), with the outward normal there and the way to it; -1: none.
  virtual int border(const Vec3& x, double within, Vec3& outward, double& way) const = 0;
  virtual const std::vector<Vec3>& surface() const = 0;
  /// A vertex that has left the surface and is to be cut off: where the data end, at the mouths of cavities.
  virtual bool lost(const Vec3&, bool seen) const { return !seen; }
  /// Where a rim's vertex belongs: at the border of the data in direction `outward` or, when that is zero, on the crest
  /// between the surface and the wall of the opening. `along`: the rim's direction; N: the surface's outward normal;
  /// false: nothing is known there.
  virtual bool rim(const Vec3&, const Vec3& /*along*/, const Vec3& /*N*/, const Vec3& /*outward*/, Vec3& /*to*/) const {
    return false;
  }
  /// What a plane comes down upon; null: it started otherwise, or the target is no scan.
  virtual const ScanHeights* heights() const { return nullptr; }
  /// The way of a rim's vertex to the nearest edge of a scan; none: zero.
  virtual Vec3 to_edge(const Vec3&) const { return Vec3::Zero(); }
  /// The way to where a scan goes on beyond a rim's vertex, in direction
  /// `out`, by those of its points that are `left`; it does not: zero.
  virtual Vec3 onwards(const Vec3&, const Vec3& /*N*/, const Vec3& /*out*/,
                       const std::vector<int32_t>& /*left*/) const {
    return Vec3::Zero();
  }
};

class VolumeSight final : public Sight {
 public:
  explicit VolumeSight(const Prepared& p)
      : p_(p),
        volume_(p.volume),
        guide_(p.guide),
        tree_(p.surface_mm),
        walls_(p.wall_mm),
        to_voxel_(p.volume.step_mm.inverse()),
        mean_voxel_(elementary::cbrt(std::abs(p.volume.step_mm.determinant()))) {}
  Vec3 pull(const Vec3& x, const Vec3& N, double t, double range, bool& seen) const override;
  double distance(const Vec3& x, const Vec3& way) const override;
  double nearest(const Vec3& x, double within) const override { return tree_.nearest(x, within).distance; }
  bool on_wall(const Vec3& x) const override;
  double voxel() const override { return p_.voxel_mm; }
  double air(const Vec3& x) const override { return guide_.value(x); }
  bool knows_air() const override { return true; }
  Vec3 home(const Vec3& x, double most) const override;
  int border(const Vec3& x, double within, Vec3& outward, double& way) const override;
  const std::vector<Vec3>& surface() const override { return p_.surface_mm; }
  bool lost(const Vec3& x, bool seen) const override;
  bool rim(const Vec3& x, const Vec3& along, const Vec3& N, const Vec3& outward, Vec3& to) const override;

 private:
  bool at_gate(const Vec3& x) const;
  bool onto(Vec3& x, const Vec3& e1, const Vec3& e2, double within) const;
  bool edge(const Vec3& x, const Vec3& N, double range, double& at) const;
  const Prepared& p_;
  VolumeSampler volume_, guide_;
  PointTree tree_, walls_;
  Mat3 to_voxel_;
  double mean_voxel_;
};

class PointSight final : public Sight {
 public:
  PointSight(const std::vector<Vec3>& points, const ScanView* plane, const std::vector<Vec3>& looks);
  Vec3 pull(const Vec3& x, const Vec3& N, double t, double range, bool& seen) const override;
  double distance(const Vec3& x, const Vec3& way) const override;
  double nearest(const Vec3& x, double within) const override { return tree_.nearest(x, within).distance; }
  double voxel() const override { return spacing_; }
  double air(const Vec3&) const override { return 0; }
  bool knows_air() const override { return false; }
  Vec3 home(const Vec3&, double) const override { return Vec3::Zero(); }
  int border(const Vec3&, double, Vec3&, double&) const override { return -1; }
  const std::vector<Vec3>& surface() const override { return points_; }
  const ScanHeights* heights() const override { return heights_ ? &*heights_ : nullptr; }
  bool lost(const Vec3& x, bool seen) const override;
  Vec3 to_edge(const Vec3& x) const override;
  Vec3 onwards(const Vec3& x, const Vec3& N, const Vec3& out, const std::vector<int32_t>& left) const override;

 private:
  const std::vector<Vec3>&points_, &looks_;
  std::optional<ScanHeights> heights_;
  PointTree tree_, edge_;
  double size_ = 0, spacing_ = 0;
  std::vector<double> around_;  // spacing around each point
};

/// Joins sheets that have met in air (t3) and cuts thin tubes through air (t4). `still` marks vertices that face
/// another sheet closely and are not to be pulled on (1), and those of tips and tubes in air, which are to go home (2).
/// Places of joins are remembered: a tunnel is opened once.
class Topology {
 public:
  Topology(simplex::Mesh& m, const Sight& s) : m_(m), sight_(s) {}
  /// `edge_mm`: mean edge of the mesh now.
  void check(double edge_mm, std::vector<uint8_t>& still);
  int joined = 0, cut = 0;
  std::vector<std::string> notes;

 private:
  struct Join {
    Vec3 at_mm;
    double radius_mm;
  };
  bool near(int32_t v, int32_t face, int depth) const;
  struct Neck {
    int32_t v;
    Vec3 middle_mm;
    double air;
  };
  void cut_necks(const std::vector<Neck>& neck, double edge_mm);
  simplex::Mesh& m_;
  const Sight& sight_;
  std::vector<Join> done_;
};

/// Borders of a region of faces, each with the region on its left; contours of from-vertices.
std::vector<std::vector<int32_t>> borders_of(const simplex::Mesh& m, const std::vector<uint8_t>& in);

/// Opens the regions of blind faces (end faces count as such).
/// Returns how many; what could not be opened goes to `notes`.
int open_blind(simplex::Mesh& m, std::vector<uint8_t> blind, std::vector<std::string>& notes);

/// Faces beside rims are split until no edge of a rim is longer than `edge_mm`, where that can be done.
void split_rims(simplex::Mesh& m, double edge_mm);

/// The end contours with their places. LPS (x left, y posterior, z superior) is taken for granted; `low`, `high`: box
/// of the object; `skull`: openings are named after those of a skull where they lie so.
std::vector<FitHole> places(const simplex::Mesh& m, const Sight& s, const Vec3& low, const Vec3& high, bool skull);

}  // namespace limberg::imaging
