#pragma once
// Acts on a skull and the face over it, as a script line or a gesture states them. Places are in mm in the frame of the
// head (x right, y forward, z up, origin between the ears), on the bones where they were at first; nothing of any mesh.
// How each is written in a script stands in table_head.h.
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// A fragment by its number, or (id -1) the one that a place belongs to.
struct FragmentPick {
  int32_t id = -1;
  Vec3 at_mm{0, 0, 0};
};
/// A turn about a place (its centre where there is none), then a shift.
struct RigidMove {
  Vec3 translation_mm{0, 0, 0}, rotation_deg{0, 0, 0};
  std::optional<Vec3> about_mm;
};
/// The map of places that a move means; `centre_mm`: what it turns about when it does not say.
Eigen::Isometry3d isometry(const RigidMove& move, const Vec3& centre_mm);
/// ... and back, about the origin.
RigidMove as_move(const Eigen::Isometry3d& map);

struct CutBone {
  std::vector<Vec3> contour_mm;  // empty: the plane
  Vec3 point_mm{0, 0, 0}, normal{0, 0, 1};
  double radius_mm = 0;  // 0: all that the plane cuts
  std::optional<FragmentPick> of;
  bool must_divide = true;
};
/// By planes that meet in a corner, one after the other: a step of a Le Fort I, a sagittal split
/// (sim/skull/bone/corner_blade.h).
struct CutBoneByBlade {
  Vec3 corner_mm{0, 0, 0};
  std::vector<Vec3> rays;  // directions; each plane lies between one and the next
  double reach_mm = 150;
  std::optional<FragmentPick> of;
  bool must_divide = true;
};
inline constexpr size_t kMostBladeRays = 8;
struct MoveFragment {
  FragmentPick fragment;
  RigidMove by;
  double seconds = 2;
};
/// Hands that may hold a fragment each: that of the stylus, and two gloves.
inline constexpr int kHands = 3;
struct GrabFragment {
  FragmentPick fragment;
  int hand = 0;
};
struct DragFragment {
  RigidMove to;
  double seconds = 2;
  int hand = 0;
};
struct LetGo {
  bool snap = false;
  int hand = 0;
};
struct PlateFragments {
  Vec3 a_mm{0, 0, 0}, b_mm{0, 0, 0};
};
struct JoinFragments {
  FragmentPick a, b;
  double smooth_mm = 0;  // of the seam, to both sides
};
/// Work on the surface of a bone (sim/skull/bone/surface_work.h).
struct SplitFace {
  Vec3 at_mm{0, 0, 0};
};
struct MergeFaces {
  Vec3 at_mm{0, 0, 0};
};
struct SmoothSurface {
  Vec3 at_mm{0, 0, 0};
  double radius_mm = 10;
};
struct PushSurface {
  Vec3 from_mm{0, 0, 0}, to_mm{0, 0, 0};
  double radius_mm = 8;
  std::optional<FragmentPick> of;
};
struct Unplate {
  FragmentPick fragment;
};
struct SortFragments {};
enum class TissueKind : uint8_t { smoothing, springs, shape, finite_elements };
struct ConnectTissue {
  std::string name;
  Vec3 face_mm{0, 0, 0}, bone_mm{0, 0, 0};
  double face_radius_mm = 25, bone_radius_mm = 0;
  std::vector<Vec3> face_outline_mm;  // a closed line round the region of the face; none: all within face_radius_mm
  int layers = 2;
  double young_kPa = 10;
  TissueKind mode = TissueKind::finite_elements;
};
inline Vec3 middle_of(const std::vector<Vec3>& places) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : places) sum += x;
  return places.empty() ? sum : Vec3(sum / double(places.size()));
}
struct PlaceLandmark {
  std::string name;
  Vec3 at_mm{0, 0, 0};
  bool on_face = false;
};

/// What the skull is laid upon.
enum class SkullBeside : uint8_t { off, normal, mirror };
struct Superpose {
  SkullBeside on = SkullBeside::normal;
  std::string name;
};

using HeadCommand = std::variant<CutBone, MoveFragment, GrabFragment, DragFragment, LetGo, PlateFragments,
                                 JoinFragments, ConnectTissue, PlaceLandmark, Superpose, Unplate, SortFragments,
                                 CutBoneByBlade, SplitFace, MergeFaces, SmoothSurface, PushSurface>;

/// The names of TissueKind in scripts and scenes, in its order.
inline constexpr const char* kTissueKinds[] = {"smoothing", "springs", "shape", "finite_elements"};
inline constexpr const char* kTissueKindList = "smoothing, springs, shape or finite_elements";
/// The same in words, for people.
inline constexpr const char* kTissueKindWords[] = {"smoothing: the face does not feel it", "springs", "shape",
                                                   "finite elements"};

inline constexpr const char* kSkullBeside[] = {"off", "normal", "mirror"};
/// The same in words, for people.
inline constexpr const char* kSkullBesideWords[] = {"the skull alone", "the skull beside a normal one",
                                                    "the skull beside its mirror image"};

}  // namespace limberg
