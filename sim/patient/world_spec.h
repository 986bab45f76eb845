#pragma once
// What the soft tissue of a patient is built from; made by app/ from a scene file, or by a researcher's own code.
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "sim/body/body.h"
#include "sim/body/skin_image.h"
#include "sim/fem/solver/focus_settings.h"

namespace limberg {

struct FaultPlan;

/// automatic: on where something has been cut that can touch.
enum class ContactChoice : uint8_t { automatic, on, off };

/// Cells within the radius of a place on the skin, or of a stretch from place to place, are divided so often. A part of
/// the scene: with other cells (--cells) they are 1 / 2^level of those.
struct FineZone {
  ChartPoint at{0, 0}, to{0, 0};  // equal: a place
  double radius_mm = 0;
  double depth_mm = std::numeric_limits<double>::infinity();  // what lies deeper is left as it is
  int level = 0;
  bool operator==(const FineZone&) const = default;
};

/// A force on a patch of skin, that keeps size and direction: a weight that lies there, a strap that pulls.
struct SkinLoad {
  ChartPoint at{0, 0};
  Vec3 force_N = Vec3::Zero();
  double radius_mm = 2;  // of the patch, 43 places of which share the force (skin_patch.h); 0: a point
  bool operator==(const SkinLoad&) const = default;
};

struct WorldSpec {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const SkinImage> image;  // on its skin, by its texture coordinates; null: there is none
  double cell_mm = 3.5;
  double suture_k_N_per_mm = 20;
  // A stitch holds the skin so far from it, along its wound's edge and behind it (skin_patch.h); 0: one point of the
  // edge. A needle goes in and out about 2 mm behind the edge, and presses on about as much along it.
  double suture_bite_mm = 2;
  double hook_k_N_per_mm = 0.5;
  double hook_tip_mm = 2;  // radius of the piece of skin that a hook holds, as one with two teeth does; 0: a point
  double suture_pull_mm_per_step = 0.5;  // how fast a stitch is drawn tight
  fem::FocusSettings focus;              // of steps that ask for it
  double region_mm = 0;  // > 0: tissue farther than this from the chart's origin holds still (lattice/region.h)
  bool can_cut = true;   // false: no cutter is built
  // cells in which a cut ends are divided twice, three times where it runs askew, so that it opens to within a quarter
  // cell of its end
  bool refine_fronts = false;
  bool refine_pockets = true;  // with refine_fronts: at the rim of what is undermined too
  std::vector<FineZone> fine;  // the lattice's grading (lattice/grading.h)
  int wound_level = 0;         // so often cells are divided that a blade goes through, and their neighbours
  bool dynamic = false;        // false: quasi-static
  ContactChoice contact = ContactChoice::off;  // do wound surfaces keep each other out? (contact/contact_finder.h)
  double contact_friction = 0;                 // coefficient of Coulomb's law, of wounds and colliders
  // Zero: the tissue has no weight. The body as given is its shape without weight and loads, which sags from there.
  Vec3 gravity_m_s2 = Vec3::Zero();
  std::vector<SkinLoad> loads;
  uint64_t seed = 1;
  FaultPlan* fault = nullptr;  // tests only: lets steps of a cut fail (cutting/arrangement/fault.h)
};

}  // namespace limberg
