#pragma once
// Relaxed skin tension lines of the face, as a list of places with the way that the lines run there
// (body/tension_lines.h).
//
//   Borges and Alexander 1962   Relaxed skin tension lines, Z-plasties on scars, and fusiform excision of lesions,
//                               Br J Plast Surg 15:242
//   Borges 1984                 Relaxed skin tension lines (RSTL) versus other skin lines, Plast Reconstr Surg 73:144
//
// Their drawings are known here from memory, and the ways are read off by eye, to ten or twenty degrees: across the
// forehead, falling off at the temples; round the lids, and fanned out beside the outer corner of the eye; across the
// bridge of the nose and down beside it; from the nose and the lower lid down and outwards over the cheek, upright
// before the ear; upright in the lips, as mouths pucker; along the crease between lip and chin; across below the chin.
// Between the brows drawings differ; here they run across. On the ear, which they leave out, along the rim.
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct FaceLine {
  Vec3 at_mm = Vec3::Zero(), along = Vec3::UnitX();  // along: unit; its sense means nothing
};

/// Of a face in the frame of the anatomical head (x right, y forwards, z up), both halves, on its triangles.
std::vector<FaceLine> face_tension_lines(std::span<const Vec3> X_mm, std::span<const Tri> tri);

}  // namespace limberg
