#pragma once
// A simplex mesh deformed to an isosurface of a volume (skin or bone from a CT), or to the points of a range scan.
//
// Volume. At first every vertex follows the guide (prepare.h): along its normal by its distance to the sealed surface,
// so that a mesh from outside wraps the object and one from within fills it, chin and ears included. Where two sheets
// of the mesh meet in a tunnel (under a cheek bone) they are joined by t3, and the genus grows; where the mesh has
// drawn out to a thin tube between two bodies it is cut by t4. Then every vertex looks along its normal, both ways, for
// the nearest place where the volume itself falls through the isovalue going outwards, and is pulled there.
// The mesh begins stiff and ends supple: rigidity 8 to 1, weight of the data 0.05 to 0.5; between the stages its faces
// are adapted. At the end the mesh is opened: beyond the borders of the volume, and at the mouths of the cavities that
// the preparation has closed (orbits, nose, foramen; where none were looked for, wherever no isosurface lies within two
// voxels). The rims then come to rest where they belong (fit_rims.cpp): at the border in the last slice, at a mouth on
// the crest between the outer surface and the cavity's wall. Narrow gaps that the sealing ball spans stay closed.
//
// Points. Every vertex is pulled along its normal to the nearest point M, weight
// G(|PM| / D), G = 1 up to 1 and 1 / x^2 beyond; D shrinks from 20 % to 8 % of the
// cloud's size (Delingette 1994, as remembered). Regions without points are opened.
// How far apart points may lie in one is said by their own spacing, so that sparse ones are no holes. Where it is known
// which way the surface looks, only points that look the way of the mesh draw it. Rims go on along the scan to points
// that the mesh has not reached.
// A plane (scan_view.h) first comes down upon the heights of the scan with its edge held beyond the scan's; the apron
// is opened then. Rims of openings are drawn to the edge of the scan: outwards as long as the points under them are
// within it.
#include <functional>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/fit/prepare.h"
#include "sim/imaging/io/scan_view.h"
#include "sim/imaging/io/volume.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

enum class Start { sphere, plane, cylinder };

struct FitSettings {
  double iso = 0;          // in the numbers of the volume; inside is above
  double range_mm = 30;    // how far a vertex may be pulled in one look
  double edge_mm = 4;      // wanted edges at the end
  double chord_mm = 0;     // > 0: shorter edges where the surface is curved (adapt.h)
  double metric_gain = 0;  // vertices gather where it is curved (Law::metric_gain): 0 none, 0.05 useful
  int stages = 8;          // of `iterations` each
  int iterations = 50;
  double still_mm = 0.01;  // a stage ends when nothing moves farther, ten times in a row
  bool open_ends = true;
  bool skull = false;  // names openings after those of a skull (orbit, nose ...) where they lie so
  std::function<void(int stage, int32_t vertices, double max_move_mm)> progress;  // may be empty
};

/// An opening that the fit has made, or that the mesh began with.
struct FitHole {
  std::string place;  // "volume border, superior", "orbit, left", "anterior right" ...
  Vec3 centre_mm = Vec3::Zero();
  double around_mm = 0;  // length of its rim
  int32_t vertices = 0;
};

struct FitReport {
  int iterations = 0;
  int32_t vertices = 0;
  double found = 0;      // part of the vertices, less those on thin walls, that have the surface within two voxels
  int32_t on_walls = 0;  // vertices on thin walls (thin_walls.h) that have not
  double rms_mm = 0, p95_mm = 0,
         max_mm = 0;               // distance of those to the isosurface, |I - iso| / |grad I| where they see it
  int holes = 0;                   // opened
  std::vector<FitHole> hole;       // by size, largest first
  int joined = 0, cut = 0;         // t3 and t4 where the surface asked for them
  std::vector<std::string> notes;  // regions that could not be opened, joins that were refused, and why
  double reached = 0;  // part of the isosurface's places (Prepared::surface_mm) within two voxels of the mesh
  double surface_rms_mm = 0,
         surface_p95_mm = 0;  // distance of the places that are reached to the mesh: vertices and faces
  double voxel_mm = 0;        // smallest side of a voxel, or spacing of the points
  int64_t vertex_iterations = 0;
};

/// A mesh to begin with, around what was found: an ellipsoid of 2000 vertices around the box; a sheet before it (-y
/// side, normal to -y); a tube through the borders of the volume, about z or another `axis`.
simplex::Mesh start_mesh(Start kind, const Vec3& low_mm, const Vec3& high_mm, int axis = 2);

/// Throws InputError on settings that are not finite or positive.
FitReport fit(simplex::Mesh& mesh, const Prepared& target, const FitSettings& settings, Workers& workers);
/// The same with a preparation of its own: no smoothing, openings below two voxels sealed.
FitReport fit(simplex::Mesh& mesh, const Volume& volume, const FitSettings& settings, Workers& workers);
/// To points. `found`, rms and so on are of distances to the nearest points; a "voxel" is their median spacing.
/// settings.iso is unused.
/// `plane`: the mesh is start_plane(*plane), and the points are those that are seen from its front (seen_from_front): a
/// plane reaches no others.
/// `looks`: which way the surface looks at each point, as seen_from_around says; empty: not known.
FitReport fit(simplex::Mesh& mesh, const std::vector<Vec3>& points_mm, const FitSettings& settings, Workers& workers,
              const ScanView* plane = nullptr, const std::vector<Vec3>& looks = {});

}  // namespace limberg
