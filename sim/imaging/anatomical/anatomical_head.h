#pragma once
// A head to teach on, made from published measures: meshes, landmarks, colours.
//
//   HeadModel head = make_anatomical_head({}, workers);      // half a minute; a scene keeps it (app/head/cache.h)
//
// The frame is that of the synthetic head: x right, y forwards, z up, origin between the porions, Frankfort's
// horizontal flat. It is a man of average measures (norms.h has them with their sources), left and right alike.
//
//   skin       skin_shape.h: sections of a head that a smooth body is pulled onto, and on it eyes, nose, lips, ears
//   bone       bone_shape.h: a braincase beneath that skin with an inner table, a face of its own, sinuses that open
//              into the nose, a mandible apart from it, fourteen teeth a jaw (teeth_shape.h)
//   landmarks  extremal places of the distance functions, found by rays to rounding: truth for tests
//   colours    skin_colour.h
//
// Edges are short where forms are small: 1.1 mm at lids and teeth, edge_mm and face_edge_mm at vault and neck.
#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {

/// Of the settings edge_mm and face_edge_mm count. Throws InputError where they are not 1.5 to 12 mm.
HeadModel make_anatomical_head(const HeadSpec& spec, Workers& workers);

/// Those of the head alone, without its meshes.
std::vector<std::pair<std::string, Vec3>> anatomical_landmarks();

/// As those of the synthetic head (synthetic_head.h), and more on bone: Me, Gn, Pr, Id, U6, L6, Ft, Ms.
const std::vector<LandmarkRule>& anatomical_landmark_rules();

}  // namespace limberg
