#pragma once
// The state of the soft tissue as plain structs: what an act changes, what undo and redo bring back, what is hashed.
//
// Undo copies whole structs and the hash goes through fields(), whose lists do not compile when a field is missing
// (base/field_hash.h). The arrangement is no part of it: it takes its operations back by itself.
#include <memory>
#include <optional>
#include <vector>

#include "sim/base/field_hash.h"
#include "sim/contact/contact_memory.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/lattice/topology.h"
#include "sim/patient/anchors.h"
#include "sim/patient/rest_index.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// One version of the topology; immutable once made. Versions share what they have in common, so all of them are kept.
struct TissueVersion {
  std::shared_ptr<const LatticeTopology> lattice;
  std::shared_ptr<const FemModel> model;
  std::shared_ptr<const SurfaceTopology> surface;
  std::shared_ptr<const RestIndex> index;
  SharedArray<uint8_t> on_skin;    // point_depths.h
  std::vector<double> activation;  // per region of the body; of what is no muscle 0
  uint64_t arrangement_hash = 0;
};

/// What holds and loads the tissue from outside.
struct Holding {
  std::vector<Hook> hooks;
  std::vector<Stitch> stitches;  // threads' spans together, in their order
  std::vector<Thread> threads;
  std::vector<PlacedLoad> loads;  // of the scene
  int32_t next_spring = 1, next_stitch = 1, next_thread = 1;
};

/// Of the last solver step.
struct LastStep {
  double energy_uJ = 0;
  float residual = 0, distance_mm = 0;
};

/// What acts and steps change beside topology, solver and contacts.
struct TissueFigures {
  double volume_mm3 = 0, removed_volume_mm3 = 0;
  uint64_t cuts = 0;  // acts that have cut; their seeds depend on it
  // Energy of the open wound: of the last state at rest in which neither hook nor stitch held anything.
  std::optional<double> open_energy_uJ;
  LastStep last;
};

/// All that undo and redo bring back, except the arrangement.
struct TissueMoment {
  TissueVersion version;
  SolverState solver;
  std::shared_ptr<const SolverPath> path;  // by which the solver goes on; no part of the state, and not hashed
  ContactMemory contacts;
  Holding holding;
  TissueFigures figures;
};

template <class V>
void fields(const SurfacePoint& p, V&& v) {
  const auto& [triangle, bary] = p;
  v(triangle, bary);
}
template <class V>
void fields(const EmbeddedPoint& p, V&& v) {
  const auto& [node, w] = p;
  v(node, w);
}
template <class V>
void fields(const HeldPlace& p, V&& v) {
  v(p.node, p.w, p.share);
}
template <class V>
void fields(const Anchor& a, V&& v) {
  const auto& [X_mm, hint_mm, origin, at, embedded, bite_mm, wide, wall_normal] = a;
  v(X_mm, hint_mm, origin, at, embedded, bite_mm, wide, wall_normal);
}
template <class V>
void fields(const Hook& k, V&& v) {
  const auto& [id, spring, anchor, handle_mm] = k;
  v(id, spring, anchor, handle_mm);
}
template <class V>
void fields(const Stitch& s, V&& v) {
  const auto& [id, spring, a, b, slack_mm, thread, tied_N, peak_N, own_mm] = s;
  v(id, spring, a, b, slack_mm, thread, tied_N, peak_N);
  if (own_mm >= 0) v(own_mm);
}
template <class V>
void fields(const Thread& t, V&& v) {
  const auto& [id, length_mm, slack_mm, corner, closing, open, let_go] = t;
  v(id, length_mm, slack_mm, corner, closing);
  if (open) v(open);  // hashes of what was recorded before there were such threads stay
  if (let_go) v(let_go);
}
template <class V>
void fields(const PlacedLoad& l, V&& v) {
  const auto& [anchor, force_N, radius_mm] = l;
  v(anchor, force_N, radius_mm);
}
template <class V>
void fields(const Holding& k, V&& v) {
  const auto& [hooks, stitches, threads, loads, next_spring, next_stitch, next_thread] = k;
  v(hooks, stitches, threads, loads, next_spring, next_stitch, next_thread);
}
template <class V>
void fields(const LastStep& s, V&& v) {
  const auto& [energy_uJ, residual, distance_mm] = s;
  v(energy_uJ, residual, distance_mm);
}
template <class V>
void fields(const TissueFigures& f, V&& v) {
  const auto& [volume_mm3, removed_volume_mm3, cuts, open_energy_uJ, last] = f;
  v(volume_mm3, removed_volume_mm3, cuts, open_energy_uJ, last);
}
template <class V>
void fields(const SolverState& s, V&& v) {
  const auto& [displacement_mm, velocity_mm_s, pressure, since_update, displacement_before_mm, velocity_before_mm_s,
               before_s, memory] = s;
  v(displacement_mm, velocity_mm_s, pressure, since_update, before_s, memory);
  if (before_s > 0) v(displacement_before_mm, velocity_before_mm_s);  // else there is no step before
}
template <class V>
void fields(const Grip& g, V&& v) {
  const auto& [stick_mm, push_mN] = g;
  v(stick_mm, push_mN);
}
template <class V>
void fields(const HeldContact& c, V&& v) {
  const auto& [place, sheet, triangle, bary, normal, facet, apart_mm, gap_mm, weight, depth_tested, grip] = c;
  v(place, sheet, triangle, bary, normal, facet, apart_mm, gap_mm, weight, depth_tested, grip);
}
template <class V>
void fields(const ContactMemory::Damping& d, V&& v) {
  const auto& [place, projections, slid_mm] = d;
  v(place, projections, slid_mm);
}
template <class V>
void fields(const HeldByCollider& h, V&& v) {
  const auto& [place, projections, slid_mm, normal, plane_mm, at_mm, grip] = h;
  v(place, projections, slid_mm, normal, plane_mm, at_mm, grip);
}
template <class V>
void fields(const ContactMemory& m, V&& v) {
  const auto& [pairs, damping, colliders] = m;
  v(pairs, damping, colliders);
}
/// The model and the index follow from lattice and surface; the number of the surface's version grows with undo, too.
template <class V>
void fields(const TissueVersion& t, V&& v) {
  const auto& [lattice, model, surface, index, on_skin, activation, arrangement_hash] = t;
  v(lattice->hash(), arrangement_hash, std::vector<uint8_t>(on_skin.begin(), on_skin.end()));
  for (const Vec3& X : surface->view.X_mm) v(X);
  for (const Tri& tri : surface->view.tri) v(tri);
  for (const EmbeddedPoint& e : surface->embedding) v(e);
  for (const float d : surface->depth_mm.get()) v(d);
  if (!activation.empty()) v(activation);
}
template <class V>
void fields(const TissueMoment& m, V&& v) {
  const auto& [version, solver, path, contacts, holding, figures] = m;
  v(version, solver, contacts, holding, figures);
}

}  // namespace limberg
