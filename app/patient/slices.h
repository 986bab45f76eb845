#pragma once
// Slices of a volume in grey with the contours of meshes over them: what a surgeon looks at first in a CT, and where
// one sees whether a mesh lies on its bone.
//
// Radiological convention, in the volume's frame (x to the patient's left, y posterior, z superior):
//
//   axial      seen from the feet:   the patient's right on the left, anterior up
//   coronal    seen from the front:  the patient's right on the left, superior up
//   sagittal   seen from the left:   anterior on the left, superior up
//
//   const simplex::FanTriangles fan = simplex::fan_triangles(mesh);
//   const SliceContour contours[] = {{"outer bone", fan.X_mm, fan.tri, slice_colours::bone}};
//   for (const ResultPicture& p : draw_head_slices(dir, ct, contours)) append(result, "/gallery", p);
#include <array>
#include <span>
#include <string>
#include <vector>

#include "app/result/schema.h"
#include "render/image.h"
#include "sim/geometry/vec.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

/// Told apart by any eye, on black, on grey and on white bone: after the palettes of Okabe and Ito (2008) and of IBM.
namespace slice_colours {
inline constexpr Rgb8 bone{255, 176, 0}, mandible{60, 150, 255}, skin{60, 200, 150}, other{230, 130, 190};
}

/// A surface that is cut by the slices; the caller keeps what the spans show. Places are in the volume's frame.
struct SliceContour {
  std::string name;
  std::span<const Vec3> x_mm;
  std::span<const Tri> tri;
  Rgb8 colour;
};

struct SliceLook {
  double pixel_mm = 0.5;  // larger where a side would have more than most_pixels
  int most_pixels = 1024;
  double centre_HU = 400, width_HU = 1800;  // black to white: a window for bone in which skin is still seen
  double offset = 0;                        // what the volume's numbers are above Hounsfield units
  bool words = true;                        // names, letters and the bar
};

enum class SlicePlane : uint8_t { axial, coronal, sagittal };
struct Slice {
  SlicePlane plane = SlicePlane::axial;
  double at_mm = 0;  // z, y or x
};

/// Which places a picture shows.
struct SliceFrame {
  int through = 2, across = 0, down = 1;  // axes: of the slice's normal, along a row and a column of the picture
  double down_sign = 1;                   // -1: that axis points up in the picture
  double at_mm = 0, left_mm = 0, top_mm = 0, pixel_mm = 1;
  int width = 0, height = 0;
  /// (0, 0) is the upper left corner of the picture; pixel (i, j) has its centre at (i + .5, j + .5).
  Vec3 place(double column, double row) const;
  Vec2 pixel(const Vec3& x_mm) const;
};
/// Of a box. Throws InputError when box or look are not finite, or the pixels or the window not above 0.
SliceFrame slice_frame(const Slice& slice, const Vec3& low_mm, const Vec3& high_mm, const SliceLook& look);

/// Where triangles cross the plane x[axis] = at_mm: a segment for each that does. A corner in the plane is taken for
/// one above it, so that a triangle in the plane adds nothing, an edge in it comes once (from a triangle below), and
/// segments of triangles that share an edge share their ends to the last bit: the contour of a closed surface is
/// closed, each piece there once.
std::vector<std::array<Vec3, 2>> cut_by_plane(std::span<const Vec3> x_mm, std::span<const Tri> tri, int axis,
                                              double at_mm);

/// Grey values, averaged within a pixel where voxels are smaller; black outside the volume. Contours are one pixel wide
/// and lie over one another in their order. In the corners: the slice, the contours' names in their colours, a bar of
/// 10 mm; at the borders R, L, A, P, S, I. Without the font (TextPainter) there is the bar only.
Image draw_slice(const Volume& volume, std::span<const SliceContour> contours, const Slice& slice,
                 const SliceFrame& frame, const SliceLook& look);

/// What the slice is and which way it is seen, in words.
std::string slice_caption(const Slice& slice);

struct SliceCounts {
  int axial = 6, coronal = 3, sagittal = 3;
};
/// At the middles of equal parts of the box: from above, from the front, from the patient's right.
std::vector<Slice> slices_of_box(const Vec3& low_mm, const Vec3& high_mm, const SliceCounts& counts);

/// Writes DIR/slices/axial-1.png and so on, evenly through the box of the contours (without any: of the volume), 12 mm
/// more of it at each border. Names relative to `dir`, with captions. InputError when a file cannot be written.
std::vector<ResultPicture> draw_head_slices(const std::string& dir, const Volume& volume,
                                            std::span<const SliceContour> contours, const SliceLook& look = {},
                                            const SliceCounts& counts = {});

}  // namespace limberg
