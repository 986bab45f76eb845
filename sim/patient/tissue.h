#pragma once
// Soft tissue: what is left of the body after every cut, its lattice, its finite elements, the surface that is shown.
//
//   Tissue tissue(spec, workers);
//   TissueCut cut(tissue);               // tissue_cut.h: the only way to another topology
//   tissue.solver().step(settings);
//   tissue.find_skin(place, reason);     // what is there under a place of the chart
//
// Body -> Arrangement (cutting/) -> LatticeTopology (lattice/) -> FemModel and ElasticSolver (fem/) -> SurfaceTopology,
// embedded in the lattice.
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "sim/body/skin.h"
#include "sim/commands/skin_acts.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/patient/point_depths.h"
#include "sim/patient/rim_walk.h"
#include "sim/patient/tissue_state.h"
#include "sim/patient/world_spec.h"

namespace limberg {

struct BladeContext;  // cutting/strokes/blade_build.h

class Tissue {
 public:
  Tissue(WorldSpec spec, Workers& workers);

  const WorldSpec& spec() const { return spec_; }
  const Body& body() const { return *body_; }
  const Skin& skin() const { return *skin_; }
  Workers& workers() const { return workers_; }
  const Arrangement* arrangement() const { return arrangement_.get(); }  // null when the scene cannot be cut
  const TissueVersion& version() const { return version_; }
  const SurfaceTopology& surface() const { return *version_.surface; }
  ElasticSolver& solver() { return *solver_; }
  const ElasticSolver& solver() const { return *solver_; }
  double initial_volume_mm3() const { return initial_volume_mm3_; }
  uint64_t topology_hash() const;  // O(cells) once per version
  /// What a blade is built from.
  BladeContext blade_context() const;

  /// How the act that is carried out finds its places; null: on the body's chart. Whoever sets it takes it away again.
  struct Look {
    const SkinView* view = nullptr;  // of cuts: a plane of their own
    std::function<std::optional<SkinHit>(const ChartPoint&)> skin;
    std::function<Vec3(const ChartPoint&)> place_mm;  // as it was given, at rest
  };
  void look(const Look* look) { look_ = look; }
  /// The place as it was given, for messages: on the chart or, of an act in space, in space.
  std::string place_text(const ChartPoint& p) const;

  std::optional<SurfacePoint> find_skin(const ChartPoint& p, std::string& reason) const;
  /// on_rim: on the wound's edge, where one is within kStitchReach_mm.
  std::optional<Anchor> find_anchor(const ChartPoint& p, bool on_rim, std::string& reason) const;
  /// In a cut face of that kind, within kWallReach_mm of a place that was given in space.
  std::optional<Anchor> find_in_wall(const ChartPoint& p, HeldSide side, std::string& reason) const;
  EmbeddedPoint embed(const SurfacePoint& p) const;
  /// The places of the patch of skin around it that share what acts there (skin_patch.h).
  std::vector<HeldPlace> embed_patch(const Anchor& anchor, double radius_mm) const;
  /// Those of a stitch's bite whose middle is at `at` (bite_patch()).
  std::vector<HeldPlace> embed_bite(const SurfacePoint& at, double radius_mm) const;
  /// The same anchor on the present version; false: its tissue is gone.
  bool carry(Anchor& anchor) const;
  Vec3 position_mm(const EmbeddedPoint& e) const { return solver_->position_mm(e); }
  /// Where it is held now: the mean of its places.
  Vec3 held_mm(const Anchor& anchor) const;
  const RimWalk& rim() const;

  /// Every node goes to where(its place at rest) in the components that are held; the rest stays until the next step.
  void hold_at(const std::function<Vec3(const Vec3& X_mm)>& where);
  /// How active each region of the body is from now on (lattice/fem_assembly.h); shapes, nodes and cells stay.
  void activate(std::vector<double> activation);
  /// Goes back or forth to a version that was there. `parent`: per node of its model, the node of the present one (-1:
  /// none).
  void return_to(const TissueVersion& version, ParentList parent);

 private:
  friend class TissueCut;
  /// What is drawn of the arrangement, and the index for picking; from those of version_ when there are some. Reads
  /// only what the lattice's update reads, too, so both may run at once.
  struct Drawn {
    std::shared_ptr<SurfaceTopology> surface;
    ViewChange change;
    std::shared_ptr<const RestIndex> index;
    SharedArray<uint8_t> on_skin;
  };
  /// The place of the skin that p names, on the chart or as the act looks at it.
  std::optional<SkinHit> skin_at(const ChartPoint& p) const { return look_ ? look_->skin(p) : skin_->at(p); }
  Drawn draw_surface();
  void make_surface(TissueVersion& next, Drawn drawn);  // with its embedding in next.lattice

  WorldSpec spec_;
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const Skin> skin_;  // pictures may outlive the tissue
  Workers& workers_;
  std::unique_ptr<Arrangement> arrangement_;
  std::unique_ptr<StencilTable> stencils_;
  TissueVersion version_;
  std::unique_ptr<ElasticSolver> solver_;
  const Look* look_ = nullptr;
  PointDepths depths_, layers_{true};
  double initial_volume_mm3_ = 0;
  uint64_t next_version_ = 1;
  mutable uint64_t hash_ = 0, hash_version_ = 0;  // topology_hash() of that version
  mutable std::unique_ptr<RimWalk> rim_;          // of the surface rim_version_; absent until a stitch needs it
  mutable uint64_t rim_version_ = 0;
};

}  // namespace limberg
