#pragma once
// Cephalometry: lengths, angles, lines of the soft tissue and asymmetry from named landmarks.
//
//   const auto rows = cephalometry(landmarks);          // every row of cephalometric_measures(), missing ones named
//   std::cout << to_csv(rows);
//
// Places in mm in the head's frame (imaging/head_shape.h): x right, y forwards, z up. All in three dimensions: so ANB
// is an angle of its own and not SNA - SNB when points leave the sagittal plane (its sign is that of SNA - SNB).
// Angles between planes and lines are taken in projection on the sagittal plane x = 0, as on a film; the rows say so.
//
// Uncertainty: each coordinate of a landmark is off by its own standard deviation, independently; the figure's
// is the root of the sum of the squared changes that one standard deviation in each coordinate makes.
//
// Landmarks on bone: S sella, N nasion, Ba basion, A, B subspinale and supramentale, ANS, PNS nasal spines, Pog, Gn, Me
// chin, Is, Ii edges of the incisors (of the alveolar arches where there are no teeth), Or, Po, Go, Co, Zy with _L, _R;
// on the skin a prime or small letters: g' n' prn sn ls sto li sl pog' gn' me', and en ex al ch zy' go' t with _L, _R.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/geometry/bvh.h"
#include "sim/geometry/vec.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct NamedPoint {
  std::string name;
  Vec3 at_mm = Vec3::Zero();
  double sd_mm = 1;  // standard deviation of each coordinate: about 1 mm for landmarks picked in a CT
};

struct CephalometricMeasure {
  std::string name, unit;  // unit: mm, deg
  std::string definition;
  std::optional<double> norm, norm_sd;
  std::string source;  // of the norm; empty: there is none
  std::vector<std::string> landmarks;
};
/// What is measured, in the order of the rows.
const std::vector<CephalometricMeasure>& cephalometric_measures();

struct CephalometricRow {
  const CephalometricMeasure* measure = nullptr;
  std::optional<double> value;  // nothing: landmarks are missing, or the figure is not defined for their places
  double sd = 0;                // of the value, from the landmarks' uncertainty
  std::vector<std::string> missing;
};
/// Later points of the same name replace earlier ones.
std::vector<CephalometricRow> cephalometry(std::span<const NamedPoint> points);

/// Left against right, for every pair _L, _R: how far the mirror image of the left one lies from the right one.
struct AsymmetryRow {
  std::string name;
  Vec3 difference_mm = Vec3::Zero();  // right less mirrored left: outwards, forwards, upwards
  double distance_mm = 0;
};
/// The mirror plane: through the midline landmarks that are there (S,
/// N, Ba, ANS, PNS), by least squares; with fewer than three, x = 0.
struct Asymmetry {
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitX();
  bool fitted = false;
  std::vector<AsymmetryRow> rows;
  double rms_mm = 0;
};
Asymmetry asymmetry(std::span<const NamedPoint> points);

/// How a fragment has moved: translation of its centre, and the rotation as yaw
/// about z (its front to the left is positive), then pitch about x (its front up
/// is positive), then roll about y (its right side down is positive); Rz Rx Ry.
struct FragmentMotion {
  Vec3 translation_mm = Vec3::Zero();
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0, angle_deg = 0;  // angle: of the whole rotation
};
FragmentMotion fragment_motion(const Eigen::Isometry3d& pose, const Vec3& centre_mm);

/// A picked place, brought to the mesh: the nearest vertex when it
/// is within `vertex_mm`, else the nearest place of the surface.
struct Snapped {
  Vec3 at_mm = Vec3::Zero();
  int32_t vertex = -1;  // -1: within a face
  int32_t face = -1;
  double moved_mm = 0;
};
std::optional<Snapped> snap(const simplex::Mesh& mesh, const Vec3& picked_mm, double vertex_mm = 1,
                            double most_mm = 20);

/// name,value,unit,sd,norm,norm_sd,source,definition,missing; numbers with four digits after the point, text in quotes.
std::string to_csv(std::span<const CephalometricRow> rows);

}  // namespace limberg
