#pragma once
// What `bench accuracy` does to a scene: one incision, one hook, one pull; as plain finite elements, so that element,
// material and step can be exchanged.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "sim/fem/solver/elastic_solver.h"

namespace limberg::bench {

/// A scene on one lattice, cut and at rest.
struct Probe {
  std::shared_ptr<const FemModel> model;
  Spring hook;                       // at rest
  Vec3 pull_mm = Vec3::Zero();       // of its handle, all in all
  Vec3 gravity_m_s2 = Vec3::Zero();  // the scene's; its other loads are left out
  std::vector<Vec3> X_mm;            // places of the skin: rest position
  std::vector<EmbeddedPoint> place;
};

inline constexpr int probe_frames = 24;

/// `cut`: try the incision; a scene that refuses it is pulled uncut.
Probe make_probe(const Scene& scene, std::shared_ptr<const Body> body, double cell_mm, Workers& workers);

/// The same with another element or material; null when the model
/// cannot have it (cells that already carry laws, divided cells).
std::shared_ptr<const FemModel> with_full_integration(const FemModel& model);
std::shared_ptr<const FemModel> with_tetrahedra(const FemModel& model);
std::shared_ptr<const FemModel> with_poisson(const FemModel& model, double poisson);
std::shared_ptr<const FemModel> with_mooney_rivlin(const FemModel& model);  // for flat skin: normal z

/// Positions of the probe's places, in its order.
std::vector<Vec3> places_mm(const Probe& probe, const ElasticSolver& solver);

}  // namespace limberg::bench
