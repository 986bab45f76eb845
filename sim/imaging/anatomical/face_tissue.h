#pragma once
// The soft tissue of the anatomical face as one closed surface, to be operated: from the skin down to where bone
// would lie, or to the depth that matters to a flap.
//
//   FaceTissue face = make_face_tissue(workers);          // some seconds; app/scenes/anatomical_face.obj holds it
//   make_face_tissue(workers, {.lips = Lips::parted})     // app/scenes/anatomical_lips.obj
//   make_face_tissue(workers, {.lips = Lips::cleft})      // app/scenes/anatomical_cleft.obj
//   make_face_tissue(workers, {.lids = Lids::parted})     // app/scenes/anatomical_lids.obj
//   make_face_tissue(workers, {.reach = FaceReach::scalp})  // app/scenes/anatomical_scalp.obj
//
// It reaches from the scalp to beneath the chin and behind the ears. Skin is free; what lies on bone or was cut off
// deep is held, and so are the sides, where the face goes on, and the globes, which lids lie upon.
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/base/workers.h"
#include "sim/geometry/vec.h"

namespace limberg {

enum class FacePart : uint8_t { skin, deep, side, globe, mucosa };
inline constexpr const char* kFaceParts[] = {"skin", "deep", "side", "globe", "mucosa"};

struct FaceTissue {
  std::vector<Vec3> X_mm;  // frame of the head: x right, y forwards, z up
  std::vector<Tri> tri;    // outwards counter-clockwise, closed
  std::vector<FacePart> part;
  std::vector<Vec2> uv;              // per vertex: of a picture wound around the head (face_picture_place)
  std::optional<Vec2> uv_of_mucosa;  // of all of it, where the picture shows none at its places
};

/// The thickest tissue that is kept.
inline constexpr double kFaceDepth_mm = 14;

/// Parted, the lips have free margins: a slit between them through the tissue, and mucosa behind them, which nothing
/// holds up to the folds of the vestibule. Otherwise they are one surface. Cleft: parted, and the left half of the
/// upper one has a gap from its margin up to below the nostril (cleft_shape.h).
enum class Lips : uint8_t { one_surface, parted, cleft };

/// Parted, the lids of the right eye have free margins and the globe is no part of the tissue: mucosa lies before it
/// (lid_bed.h) by a third of a millimetre, and is held behind the fornices. Otherwise lids and globe are one surface.
enum class Lids : uint8_t { one_surface, parted };

/// How much of the head: the face and the forehead's scalp; or the scalp over the vertex, too.
enum class FaceReach : uint8_t { face, scalp };

struct FaceOpenings {
  Lips lips = Lips::one_surface;
  Lids lids = Lids::one_surface;
  FaceReach reach = FaceReach::face;
};

FaceTissue make_face_tissue(Workers& workers, const FaceOpenings& open = {});

/// Where a place near the skin lies on the picture, u from the right ear to the left, v upwards, both 0 to 1.
Vec2 face_picture_place(const Vec3& p_mm);
/// The place on the skin that the picture shows there; of several the outermost.
Vec3 face_place_of_picture(const Vec2& uv);

}  // namespace limberg
