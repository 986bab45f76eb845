#pragma once
// How stiff is the patient here, against a tool that presses? Asked of the finite
// elements themselves, of this very patient: layers, prestretch, an undermined
// pocket below, a wound's edge beside, hooks, stitches and contacts all count.
//
// A second solver over the same model takes the patient's positions, presses a patch of the
// surface in by the depth asked for, and tells force over depth. The patient knows nothing
// of it: no bit of its state changes, so recordings and replays do not depend on it. It
// goes on from its last answer, so a few iterations per question follow a tool that moves.
//
// A lattice of cells h cannot see a tip much smaller than h. So the patch is a disc of .75 h, which
// the lattice feels as a flat end of 1.2 h, and the closer neighbourhood of the tip is added as
// springs in series: what a half space of the same layers yields more under the tip than under an end
// of 1.2 h (Boussinesq 1885; layers as in King 1987). Tips that the lattice can see get no springs.
#include <memory>
#include <span>
#include <vector>

#include "sim/body/body.h"
#include "sim/contact/contact_finder.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/press.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// What is pressed on, as it is now.
struct Pressed {
  const SurfaceTopology& surface;
  std::shared_ptr<const FemModel> model;
  const ElasticSolver& solver;
  std::span<const Spring> springs;
  std::span<const Contact> contacts;
  const Body& body;
};

class PressProbe {
 public:
  explicit PressProbe(Workers& workers) : workers_(workers) {}
  ~PressProbe();
  /// InputError: a triangle that is not there. A question about
  /// another version of the surface is not answered: stiffness 0.
  PressAnswer ask(const Pressed& patient, const PressQuestion& question, int iterations = 8);

 private:
  struct Touched {
    int32_t vertex;
    double weight;
  };
  void meet(const Pressed& patient);
  void find_patch(const Pressed& patient, const PressQuestion& question, double radius_mm);

  Workers& workers_;
  std::unique_ptr<ElasticSolver> solver_;
  std::shared_ptr<const FemModel> model_;
  uint64_t version_ = 0;
  std::vector<std::vector<int32_t>> around_;  // per vertex of the view: its triangles
  std::vector<Touched> patch_;
  std::vector<uint8_t> seen_;
  std::vector<int32_t> queue_;
  std::vector<Vec3f> pressed_by_;  // per node: what the last answer moved it by
};

/// Compliance in mm/N of a half space of these layers under a flat round end: each layer by the share that it has in a
/// tool of that radius (King 1987).
double compliance_mm_N(std::span<const Layer> layers, double radius_mm);

}  // namespace limberg
