#pragma once
// The synthetic head: meshes, landmarks and a CT of the analytic head (head_shape.h). Needs no file.
//
//   HeadModel head = make_head({}, workers);            // about 10,000 vertices of bone
//                                                       and 5,000 of skin, a second or two
//   Volume ct = head_ct({}, 1.0, workers);              // Hounsfield units with blur and noise
//
// The frame is that of head_shape.h: x right, y forwards, z up, right-handed. A Volume's places are
// left, posterior, superior: the place p of the head is (-x, -y, z) there, half a turn about z.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/fit/level_set.h"
#include "sim/imaging/io/volume.h"
#include "sim/imaging/synthetic/head_shape.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct HeadModel {
  simplex::Mesh cranium, mandible, face;  // cranium: both tables, closed; face: the skin, one hole at the neck
  std::vector<std::pair<std::string, Vec3>> landmarks;
  LevelSetReport cranium_report, mandible_report, face_report;
};

/// Throws InputError as HeadShape does.
HeadModel make_head(const HeadSpec& spec, Workers& workers);

/// How a landmark is found: rays along `look` from 25 mm before places within reach
/// of `place` (along two axes across `look`; 0 mm on the first keeps the plane x =
/// const) meet the surface; of the places met, the farthest along `score` is it.
struct LandmarkRule {
  const char* name;  // of one in the middle, or of a pair without _L, _R
  enum class Surface : uint8_t { skull, mandible, skin } surface;
  Vec3 place, look, score;  // of the normal head; of a pair, the right one
  double reach_mm[2];       // across the plane of look and z (or y), and in it
  double back_mm = 25;
  bool pair = false;
  bool carried = false;  // moves with the mandible (HeadShape::mandible_place)
};
const std::vector<LandmarkRule>& landmark_rules();

/// Where rules are applied: distances that grow by no more than `lipschitz` a mm. `place`: where a rule that is carried
/// with the mandible looks; may be empty.
struct LandmarkGround {
  std::function<double(const Vec3&)> skull, mandible, skin;
  double lipschitz = 1;
  std::function<Vec3(const Vec3&)> place;
};
std::vector<std::pair<std::string, Vec3>> landmarks_by(const std::vector<LandmarkRule>& rules,
                                                       const LandmarkGround& ground);

/// Landmarks of the shape, by the names of measure/cephalometry.h: on bone N, S, A, B, ANS, PNS, Pog, Gn, Me, Ba, Op,
/// Is, Ii, G, Rhi, V, and of pairs (_L, _R) Or, Po, Zy, Go, Co, Eu; on the skin g', n', prn, sn, ls, sto, li, sl, pog',
/// gn', me', v', and of pairs en, ex,
/// al, ch, zy', go', t. S is the stated centre of the sella. A landmark that no ray meets is left out.
std::vector<std::pair<std::string, Vec3>> head_landmarks(const HeadShape& shape);

struct HeadCt {
  double blur_mm = 0.7;  // standard deviation of the scanner's point spread
  double noise_HU = 15;  // standard deviation
  uint64_t seed = 1;
  bool sinuses = true;
  bool ear_canals = false;  // of air, 8 mm wide, from the skin inwards; the top of each at the porion
  int slices_in_one = 1;    // so many are averaged: tall slices, their height a box
};
/// Air -1000, fat -90, muscle and skin 45, brain 35, fat of the
/// orbit -60, eye 20, cortical bone 1100, diploe 450 (deeper than
/// 2.2 mm). Throws InputError when a voxel is not 0.3 to 10 mm.
Volume head_ct(const HeadSpec& spec, double voxel_mm, Workers& workers, const HeadCt& settings = {});

}  // namespace limberg
