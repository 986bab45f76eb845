#pragma once
// What may touch what in one version of the topology: made at a cut, never changed after it.
//
//   triangles   all wound walls, and the skin within a few mm of a wound's rim: what can be touched
//   places      points of the walls that must not enter other tissue, each
//               standing for its share of the wall, whatever the
//               triangles: one in each cell copy where the wall runs on
//               evenly, one for every half cell in each direction (at most
//               1.75 mm) within a cell of its borders, and one for every
//               such length of its sharp edges and corners, which go
//               deepest; finer ones could not move apart from each other
//
// A point of a triangle hangs on the eight nodes of the cell copy that holds it, so
// what carries it changes smoothly when it slides on from one triangle to the next.
#include <memory>
#include <span>
#include <vector>

#include "sim/contact/sheets.h"
#include "sim/cutting/arrangement/surface_view.h"
#include "sim/fem/model/fem_model.h"
#include "sim/lattice/topology.h"

namespace limberg {

struct ContactPlace {
  int32_t triangle = 0;  // it lies on
  std::array<double, 3> bary{1.0 / 3, 1.0 / 3, 1.0 / 3};
  int32_t copy = 0;  // the cell copy that carries it
  EmbeddedPoint embedded;
  Vec3 X_mm = Vec3::Zero();
  double area_mm2 = 0;       // of the wall that it stands for, at rest
  double stiffness_kPa = 0;  // of the tissue there: 3 mu, Young's modulus of what is nearly incompressible
};

struct ContactSurface {
  std::vector<int32_t> vertex;           // vertex of the view, per vertex here
  std::vector<Vec3> X_mm;                // at rest
  std::vector<EmbeddedPoint> embedding;  // as it is shown
  std::vector<Tri> tri;
  std::vector<int32_t> around_begin,
      around;                    // triangles around vertex v: around[around_begin[v]] ... [around_begin[v + 1]]
  std::vector<int32_t> in_view;  // triangle of the view, per triangle here
  std::vector<int32_t> carrier;  // the cell copy that holds its middle
  Sheets sheets;
  std::vector<ContactPlace> place;  // those of one cell copy together

  std::shared_ptr<const SurfaceView> view;
  std::shared_ptr<const LatticeTopology> lattice;

  /// A point of triangle t as its cell copy carries it.
  EmbeddedPoint embedded(int32_t t, const std::array<double, 3>& bary) const;
  Vec3 rest_mm(int32_t t, const std::array<double, 3>& bary) const {
    const Tri& c = tri[size_t(t)];
    return bary[0] * X_mm[size_t(c[0])] + bary[1] * X_mm[size_t(c[1])] + bary[2] * X_mm[size_t(c[2])];
  }
  std::span<const int32_t> triangles_around(int32_t v) const {
    return {around.data() + around_begin[size_t(v)], size_t(around_begin[size_t(v) + 1] - around_begin[size_t(v)])};
  }
};

/// Nothing (null) where there is no wall. `embedding`: per vertex of the view.
std::shared_ptr<const ContactSurface> contact_surface(std::shared_ptr<const SurfaceView> view,
                                                      const SharedArray<EmbeddedPoint>& embedding,
                                                      std::shared_ptr<const LatticeTopology> lattice,
                                                      const FemModel& model);

}  // namespace limberg
