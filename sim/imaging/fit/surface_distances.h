#pragma once
// How far a surface and an isosurface of a volume lie apart, both ways and over faces.
//
// Vertices alone flatter a mesh: they are what a fit has put on the surface, and between them flat faces cut corners.
// So points are spread evenly over the area of one surface, and the distance of each to the faces of the other is
// taken: the mesh to the isosurface says where the mesh lies wrong, the isosurface to the mesh what it has left out.
// The isosurface is that of the raw volume, in its own voxels, without smoothing or resampling.
#include <functional>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/geometry/bvh.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

/// Triangles of the surface where the volume is `iso`, counter-clockwise seen from where it is below, in mm. Each cube
/// of eight voxels is cut in six tetrahedra (level_set.h), on whose edges the volume is taken for linear; a crossing
/// stays .02 of an edge away from voxels. Where the object leaves the volume the surface ends. Vertices are shared
/// within slabs of 16 slices. `counts`: whether a triangle with that centre is meant; empty: all are. It is called
/// by the calling thread. No triangles: the isovalue is met nowhere, or the volume is one voxel thin.
Surface isosurface(const Volume& volume, double iso, Workers& workers,
                   const std::function<bool(const Vec3&)>& counts = {});

struct SurfaceDistanceSettings {
  double within_mm = 1;  // so near a point is reached
  double per_mm2 = 1;    // points
  int64_t most_samples = 200'000;
};

/// Of every sample, reached or not.
struct SurfaceDistances {
  double mean_mm = 0, rms_mm = 0, p95_mm = 0, max_mm = 0;
  double reached = 0;         // share of the samples, hence of the area, within `within_mm`
  double reached_rms_mm = 0;  // of the samples that are reached
  int64_t samples = 0;
};

struct DistancesBothWays {
  SurfaceDistances to_isosurface, from_isosurface;
  double surface_mm2 = 0, isosurface_mm2 = 0;  // areas
};

/// `surface` in the frame of the isosurface. Throws InputError when one of them has no area, or when the settings are
/// not positive and finite.
DistancesBothWays surface_distances(const Surface& surface, const Surface& isosurface,
                                    const SurfaceDistanceSettings& settings, Workers& workers);

/// Points spread over triangles, as many on each as its share of the area asks for: at even steps of the area, in the
/// order of the triangles, and in each by the R2 sequence (Roberts 2018), so the same triangles have the same points.
/// About `per_mm2` of them, at least one, at most `most`; none where there is no area.
std::vector<Vec3> spread_points(std::span<const Vec3> x_mm, std::span<const Tri> tri, double per_mm2, int64_t most);

/// From places to the nearest faces.
SurfaceDistances distances_to(const Bvh& faces, std::span<const Vec3> from_mm, double within_mm, Workers& workers);

}  // namespace limberg
