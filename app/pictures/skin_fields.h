#pragma once
// What can be shown in colours on the skin, beside its own: each
// a figure per vertex of the view, in the unit of its legend.
//
//   stretch    largest principal stretch less 1, prestretch included: how hard it is pulled            %
//   least      least principal stretch less 1, prestretch included: below 0 it is pressed and folds    %, signed
//   area       present area over the area before the operation, less 1                                 %, signed
//   stress     largest principal Cauchy stress in the skin's plane (skin_strain.h)                     kPa
//   height     above where the skin's surface was before the operation: dog-ears, dents                mm, signed
//   moved      distance from where the same skin was before the operation; of a head, of its face      mm
//   perfusion  index of undermined skin (perfusion.h); 1 where it is not undermined
//
// Nothing is worked out but what is asked for, and what hangs on the topology alone once a topology.
// Figures of triangles come to the vertices as means weighted by area at rest. Walls and sides have none.
//
// CPU time of one call on the closed rhomboid, 69,000 triangles (2026-11-21): 10 ms for stretch, least and stress,
// 1 for area, .5 for the others; the first after a cut 68 for perfusion, the first of a scene 40 for height.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/colour_map.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class Skin;
struct MembraneState;

enum class SkinField : uint8_t { none = 0, stretch, least, area, stress, height, moved, perfusion };
inline constexpr int kSkinFields = 8;

struct SkinFieldLook {
  const char* name;   // in a list
  const char* title;  // over a legend
  const char* unit;
  ColourScale scale = ColourScale::magnitude;
  double least_end = 1;  // of the scale: smaller differences are not blown up
};
const SkinFieldLook& look_of(SkinField field);

struct FieldShown {
  std::vector<float> value;           // per vertex of the view; empty: the scene has no such field
  double lo = 0, hi = 1;              // of the scale: round numbers that hold 99 % of the skin's vertices
  bool above = false, below = false;  // values lie beyond
  int intervals = 5;                  // between the scale's round numbers: where iso-lines run
};

class SkinFields {
 public:
  SkinFields();
  ~SkinFields();
  /// Valid until the next call. A head without skin has `moved` only.
  const FieldShown& show(SkinField field, const Snapshot& snapshot);

 private:
  FieldShown shown_;
  std::shared_ptr<const Body> body_;
  std::unique_ptr<Skin> skin_;
  std::vector<float> perfusion_;
  std::shared_ptr<const SurfaceTopology> perfused_;
  // Three fields are of one state: of the places that were shown last.
  const std::vector<MembraneState>& states(const Snapshot& snapshot);
  std::vector<MembraneState> states_;
  std::vector<Vec3f> states_at_mm_;
  std::shared_ptr<const SurfaceTopology> states_of_;
};

}  // namespace limberg
