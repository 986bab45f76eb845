#pragma once
// Acts on a skull and the face over it, as a script line or a gesture states them. Places are in mm in the frame of the
// head (x left, y forward, z up, origin between the ears), on the bones where they were at first; nothing of any mesh.
//
//   {"action":"osteotomy","contour":[[x,y,z],...]}                        a closed cut through all of the bone, through
//   places on its
//                                                                          surface: dense as a cursor draws them, or
//                                                                          picked ones
//   {"action":"osteotomy","point":[x,y,z],"normal":[x,y,z],               a plane; "radius_mm": only what it cuts
//   within that distance
//    "radius_mm":30,"of":P}                                               of the point; "of": only this fragment.
//                                                                          Both: "must_divide":false allows a cut that
//                                                                          frees nothing
//   {"action":"move_fragment","fragment":P,"translation_mm":[x,y,z],      by so much from where it is: turned about
//   "about" (a place
//    "rotation_deg":[x,y,z],"about":[x,y,z],"seconds":2}                  as things lie now; its centre when left out)
//    by the angle
//                                                                          |rotation_deg| about its direction, then
//                                                                          shifted
//   {"action":"grab","fragment":P}                                        held by the hand from now on; what is in its
//   way stops it
//   {"action":"drag","translation_mm":[x,y,z],"rotation_deg":[x,y,z],     where the hand takes it: as in move_fragment,
//   from where it was
//    "about":[x,y,z],"seconds":2}                                         grabbed
//   {"action":"let_go","snap":true}                                       with "snap": into the nearest of its cuts.
//   The three also with
//                                                                          "hand":1, for two hands that hold one each
//   {"action":"plate","a":[x,y,z],"b":[x,y,z]}                            a plate from bone to bone: its two fragments
//   move together
//   {"action":"unplate","fragment":P}                                     the plates on it are taken off
//   {"action":"join","a":P,"b":P}                                         two fragments become one
//   {"action":"sort"}                                                     fragments are put together by their cut
//   rings, wherever they lie:
//                                                                          what fits and is verified goes to a bone
//                                                                          that does not move, or to
//                                                                          the one with the smallest number
//                                                                          (sim/skull/bone/sorting.h)
//   {"action":"connect_tissue","name":"chin","face":[x,y,z],"face_radius_mm":25,"bone":[x,y,z],"bone_radius_mm":40,
//    "layers":3,"young_kPa":10,"mode":"finite_elements"}                  tissue between a region of the face and one
//    of the bone, within
//                                                                          so far of these places; "bone_radius_mm" 0:
//                                                                          all bone. Modes:
//                                                                          smoothing, springs, shape, finite_elements
//   {"action":"landmark","name":"Pog","at":[x,y,z],"on":"bone"}           a named place, set on the nearest bone (or
//   "face"); a name
//                                                                          that is there already is moved
//   {"action":"superpose","on":"normal","name":"advanced"}               the skull is laid upon a normal one ("normal")
//   or upon its own mirror
//                                                                          image ("mirror"): from now on it is shown
//                                                                          so, and how far from it
//                                                                          it is at this moment stands in the report
//                                                                          under that name.
//                                                                          "off": it is shown alone again. No part of
//                                                                          undo
//
// P is a fragment's number, or a place [x,y,z] on it.
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
struct MoveFragment {
  FragmentPick fragment;
  RigidMove by;
  double seconds = 2;
};
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
  int layers = 2;
  double young_kPa = 10;
  TissueKind mode = TissueKind::finite_elements;
};
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
                                 JoinFragments, ConnectTissue, PlaceLandmark, Superpose, Unplate, SortFragments>;

/// The names of TissueKind in scripts and scenes, in its order.
inline constexpr const char* kTissueKinds[] = {"smoothing", "springs", "shape", "finite_elements"};
inline constexpr const char* kTissueKindList = "smoothing, springs, shape or finite_elements";

inline constexpr const char* kSkullBeside[] = {"off", "normal", "mirror"};
/// The same in words, for people.
inline constexpr const char* kSkullBesideWords[] = {"the skull alone", "the skull beside a normal one",
                                                    "the skull beside its mirror image"};

}  // namespace limberg
