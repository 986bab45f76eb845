#include "sim/imaging/anatomical/face_tissue.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "sim/geometry/bvh.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/imaging/anatomical/mouth_bed.h"
#include "sim/imaging/anatomical/mouth_shape.h"
#include "sim/imaging/anatomical/skin_shape.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/imaging/fit/thinning.h"

namespace limberg {
namespace {

using namespace anatomical;

// What is kept of the head.
constexpr double kBack_mm = -46, kTop_mm = 108, kBottom_mm = -104;
constexpr double kRound_mm = 1.5;  // radius of the edges between skin, depth and sides
// The picture: angles about an axis between the ears, seen from above; 0 looks forwards.
constexpr double kAxis_y_mm = 10, kTurn = 2.3;  // radians to either side
constexpr double kLow_mm = -108, kHigh_mm = 112;
constexpr double kGlobe_mm = 0.45;  // so near to a globe the surface is its

struct SmallCells {
  Vec3 c;
  double r, cell;
};
// Cells of the grid that the surface is found on. Lids, nostrils, lips and ears want small ones.
const SmallCells kSmallCells[] = {
    {{31.5, 80, 15}, 18, 2}, {{0, 108, -32}, 20, 2}, {{14, 100, -55}, 14, 2}, {{78, -14, 3}, 32, 2}};
constexpr double kFlatCell_mm = 4, kCellSpread = 1, kDeepCell_mm = 4;  // halves of 16
constexpr double kThin = 0.8, kDeepEdge_mm = 4.5;                      // wanted edges: of skin by its cells

// Lips that are parted: the slit between them, its edges, and how deep skin goes on over a lip's edge before it is
// mucosa.
constexpr double kParted_mm = 1.6, kMargin_mm = 0.5, kRedLip_mm = 7;
// A lip is 11 to 13 mm thick (as remembered of Stephan and Simpson 2008), less than a cheek.
constexpr double kThinner_mm = 6, kBeforeBed_mm = 0.4;
// What looks into the mouth lies deeper than this. The vestibule behind the lips: half its width, its folds above and
// below.
constexpr double kInMouth_mm = 1, kVestibule_mm = 30, kUpperFold_mm = -39, kLowerFold_mm = -75;

double cell_at(const Vec3& p) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double cell = kFlatCell_mm;
  for (const SmallCells& f : kSmallCells)
    cell = std::min(cell, f.cell + kCellSpread * std::max(0., (q - f.c).norm() - f.r));
  return cell;
}

/// How thick the tissue is: 8 mm on the forehead and the scalp, 10 over the cheekbone, 14 in cheek and lips. Means of
/// adults are some 5, 9, and 11 to 20 mm (as remembered from Stephan and Simpson 2008; no table was at hand); thinner
/// than two cells of the grid a shell has holes.
double depth_at(const Vec3& p) {
  const double x = std::abs(p.x());
  const double brow = ramp(18, 40, p.z()), temple = ramp(52, 66, x) * ramp(-8, 12, p.z());
  const double cheekbone =
      4 * elementary::exp(-(Vec3(x, p.y(), p.z()) - Vec3(52, 60, -6)).squaredNorm() / (2 * 14 * 14));
  return kFaceDepth_mm - cheekbone * (1 - brow) - 6 * brow - 4 * temple * (1 - brow);
}

bool in_vestibule(const Vec3& p) {
  return std::abs(p.x()) < kVestibule_mm && p.y() > 70 && p.z() < kUpperFold_mm && p.z() > kLowerFold_mm;
}

/// A place of the red lip before it: the picture has none for what looks into the mouth.
Vec3 as_red_lip(const Vec3& p) {
  const double x = std::min(std::abs(p.x()), Mouth::kCorner_mm), line = Mouth::line_mm(x);
  return {p.x(), p.y(), (line + (p.z() > line ? Mouth::red_to_mm(x) : Mouth::red_from_mm(x))) / 2};
}

double sides(const Vec3& p) { return std::max({kBack_mm - p.y(), p.z() - kTop_mm, kBottom_mm - p.z()}); }

double globes(const Vec3& p) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  return std::min((q - Eye::centre()).norm() - Eye::kGlobe_mm, (q - Eye::centre() - Vec3(0, 5.3, 0)).norm() - 7.9);
}

}  // namespace

FaceTissue make_face_tissue(Workers& workers, Lips lips) {
  const SkinShape skin;
  const bool parted = lips == Lips::parted;
  // Far inside, the shape's function is no distance: that to its surface is looked up.
  LevelSet whole;
  whole.distance_mm = [&](const Vec3& p) { return skin(p); };
  whole.lipschitz = SkinShape::kLipschitz;
  whole.low_mm = {-105, -122, -140}, whole.high_mm = {105, 138, 142};
  std::vector<Vec3> on_skin;
  std::vector<Tri> skin_tri;
  march_graded(whole, cell_at, workers, on_skin, skin_tri);
  const Bvh near_skin(on_skin, skin_tri);
  const auto thick_at = [&](const Vec3& p) {
    const Vec2 off(p.x() / 30, (p.z() - Mouth::line_mm(0)) / 18);
    return depth_at(p) - (parted ? kThinner_mm * elementary::exp(-off.squaredNorm()) : 0);
  };
  const auto deep = [&](const Vec3& p, double s) {
    return s > -1 ? -s - thick_at(p) : near_skin.closest(p).distance_mm - thick_at(p);
  };
  const auto slit = [&](const Vec3& p) { return parted ? -Mouth::slit(p, kParted_mm) : -1e3; };
  std::optional<MouthBed> bed;  // lips lie before it
  if (parted) bed.emplace(skin);
  LevelSet set;
  set.distance_mm = [&](const Vec3& p) {
    const double s = skin(p);
    if (s > 10) return s;
    const double shell = smax(smax(s, deep(p, s), kRound_mm), sides(p), kRound_mm);
    return parted ? smax(smax(shell, kBeforeBed_mm - (*bed)(p), kMargin_mm), slit(p), kMargin_mm) : shell;
  };
  set.lipschitz = std::max(SkinShape::kLipschitz, parted ? MouthBed::kLipschitz : 0);
  set.low_mm = {-105, kBack_mm - 4, kBottom_mm - 4}, set.high_mm = {105, 138, kTop_mm + 4};
  const auto cell = [&](const Vec3& p) {
    const double at = skin(p) > -5 ? cell_at(p) : kDeepCell_mm;
    return parted ? std::min(at, std::max(1., -0.7 * slit(p))) : at;
  };
  FaceTissue f;
  march_graded(set, cell, workers, f.X_mm, f.tri);
  keep_largest(f.X_mm, f.tri);
  thin_edges(f.X_mm, f.tri, set, [&](const Vec3& p) {
    const double edge = skin(p) > -5 ? kThin * cell_at(p) : kDeepEdge_mm;
    return parted ? std::min(edge, kThin * cell(p)) : edge;
  });
  for (const Tri& t : f.tri) {
    const Vec3 c = (f.X_mm[size_t(t[0])] + f.X_mm[size_t(t[1])] + f.X_mm[size_t(t[2])]) / 3;
    const double s = skin(c), d = std::max(deep(c, s), bed ? kBeforeBed_mm - (*bed)(c) : -1e3), e = sides(c),
                 m = slit(c);
    FacePart part = s >= std::max(d, e) ? FacePart::skin : d >= e ? FacePart::deep : FacePart::side;
    if (part == FacePart::skin && globes(c) < kGlobe_mm) part = FacePart::globe;
    if (m > std::max({s, d, e})) part = s > -kRedLip_mm ? FacePart::skin : FacePart::mucosa;
    if (parted && part == FacePart::deep && in_vestibule(c)) part = FacePart::mucosa;
    f.part.push_back(part);
  }
  for (const Vec3& X : f.X_mm)
    f.uv.push_back(face_picture_place(parted && skin(X) < -kInMouth_mm && in_vestibule(X) ? as_red_lip(X) : X));
  return f;
}

Vec2 face_picture_place(const Vec3& p) {
  const double turn = elementary::atan2(p.x(), p.y() - kAxis_y_mm);
  return {std::clamp(0.5 - 0.5 * turn / kTurn, 0., 1.), std::clamp((p.z() - kLow_mm) / (kHigh_mm - kLow_mm), 0., 1.)};
}

Vec3 face_place_of_picture(const Vec2& uv) {
  static const SkinShape skin;
  const double turn = (0.5 - uv.x()) * 2 * kTurn;
  const Vec3 way(elementary::sin(turn), elementary::cos(turn), 0);
  Vec3 p(0, kAxis_y_mm, kLow_mm + uv.y() * (kHigh_mm - kLow_mm));
  p += 150 * way;
  for (int i = 0; i < 400; ++i) {  // inwards until the skin is met
    const double s = skin(p);
    if (s < 0.02) break;
    p -= s / SkinShape::kLipschitz * way;
    if ((p - Vec3(0, kAxis_y_mm, p.z())).dot(way) < 0) break;
  }
  return p;
}

}  // namespace limberg
