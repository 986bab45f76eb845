#pragma once
// What the soft tissue of a patient is built from; made by app/ from a scene file, or by a researcher's own code.
#include <cstdint>
#include <memory>

#include "sim/body/body.h"

namespace limberg {

struct FaultPlan;

/// automatic: on where something has been cut that can touch.
enum class ContactChoice : uint8_t { automatic, on, off };

struct WorldSpec {
  std::shared_ptr<const Body> body;
  double cell_mm = 3.5;
  double suture_k_N_per_mm = 20;
  // a stitch holds the mean of its wound's edge over so much to either side; 0: one point of it
  double suture_bite_mm = 1;
  double hook_k_N_per_mm = 0.5;
  double suture_pull_mm_per_step = 0.5;  // how fast a stitch is drawn tight
  double region_mm = 0;  // > 0: tissue farther than this from the chart's origin holds still (lattice/region.h)
  bool can_cut = true;   // false: no cutter is built
  // cells in which a cut ends are divided twice, three times where it runs askew, so that it opens to within a quarter
  // cell of its end
  bool refine_fronts = false;
  bool refine_pockets = true;                  // with refine_fronts: at the rim of what is undermined too
  bool dynamic = false;                        // false: quasi-static
  ContactChoice contact = ContactChoice::off;  // do wound surfaces keep each other out? (contact/contact_finder.h)
  uint64_t seed = 1;
  FaultPlan* fault = nullptr;  // tests only: lets steps of a cut fail (cutting/arrangement/fault.h)
};

}  // namespace limberg
