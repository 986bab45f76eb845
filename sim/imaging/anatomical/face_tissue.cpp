#include "sim/imaging/anatomical/face_tissue.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sim/geometry/bvh.h"
#include "sim/imaging/anatomical/cleft_shape.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/imaging/anatomical/mouth_bed.h"
#include "sim/imaging/anatomical/mouth_shape.h"
#include "sim/imaging/anatomical/skin_shape.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/imaging/fit/thinning.h"

namespace limberg {
namespace {

using namespace anatomical;

// What is kept of the head; for a flap that is turned down from the vertex the scalp over the top, too.
constexpr double kBack_mm = -46, kTop_mm = 108, kBottom_mm = -104;
constexpr double kScalpBack_mm = -62, kScalpTop_mm = 138;
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
// Of a cleft: how round the corners between its edges and the lip's margin are, and these edges themselves.
constexpr double kCleftCorner_mm = 3, kCleftMargin_mm = 1;
// Where the mouth's bed ends below, beside the chin, the tissue over it is hardly thicker than a cell of the grid.
const SmallCells kOverBedsEnd{{28.7, 74, -88.4}, 7, 1.5};
// A lip is 11 to 13 mm thick (as remembered of Stephan and Simpson 2008), less than a cheek.
constexpr double kThinner_mm = 6, kBeforeBed_mm = 0.4;
// What looks into the mouth lies deeper than this. The vestibule behind the lips: half its width, its folds above and
// below.
constexpr double kInMouth_mm = 1, kVestibule_mm = 30, kUpperFold_mm = -39, kLowerFold_mm = -75;

// Lids that are parted: the edges of their margins, how far skin goes on over them, and how near they lie to the globe.
constexpr double kLidEdge_mm = 0.35, kLidMargin_mm = 2, kBeforeGlobe_mm = 0.3;
// They run out, and mucosa turns over to the globe, at fornices so far before the globe's middle (the lower one is some
// 10 mm below the margin, the upper 13; as remembered).
constexpr double kFornix_mm = 2.5;
// Over the rim of the orbit, at its side and below, tissue is so much thinner.
const Vec3 kSideOfRim(50, 68, 14), kBelowRim(34, 80, -4);
constexpr double kThinAtSide_mm = 6, kThinBelow_mm = 4, kRimWide_mm = 9;
// The grid there: about the lids, along the globe, and at the margins.
const SmallCells kLidCells{{33, 78, 13}, 17, 1.1};
constexpr double kGlobeCell_mm = 1.2, kMarginCell_mm = 0.5;
// The picture has the globe between the margins: so far beside them it has lids.
constexpr double kPictureBelow_mm = 0.8, kPictureAbove_mm = 1.2;
constexpr double kLidsReach_mm = 21;     // from the globe's middle
const Vec3 kPinkOfPicture(6, 104, -60);  // red lip, which mucosa has the colour of

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

/// A place of a margin or of the skin beside it: the picture was taken where lids and globe are one.
Vec3 as_lid(const Vec3& p) {
  double low, high;
  Eye::margins(p.x(), low, high);
  low -= kPictureBelow_mm, high += kPictureAbove_mm;
  if (p.z() <= low || p.z() >= high) return p;
  return {p.x(), p.y(), p.z() - low < high - p.z() ? low : high};
}

double bump(const Vec3& p, const Vec3& c, double sd) { return elementary::exp(-(p - c).squaredNorm() / (2 * sd * sd)); }

struct Kept {
  double back_mm, top_mm, bottom_mm;
  double sides(const Vec3& p) const { return std::max({back_mm - p.y(), p.z() - top_mm, bottom_mm - p.z()}); }
};
Kept kept(FaceReach reach) {
  return reach == FaceReach::scalp ? Kept{kScalpBack_mm, kScalpTop_mm, kBottom_mm}
                                   : Kept{kBack_mm, kTop_mm, kBottom_mm};
}

double globes(const Vec3& p) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  return std::min((q - Eye::centre()).norm() - Eye::kGlobe_mm, (q - Eye::centre() - Vec3(0, 5.3, 0)).norm() - 7.9);
}

/// A slit through the tissue between free margins, and what lies behind it. mm.
struct Opening {
  std::function<double(const Vec3&)> slit, bed;  // above 0 within the slit; below 0 within the bed
  std::function<double(const Vec3&)> filled;     // tissue within the slit, below 0; may be empty
  std::function<double(const Vec3&)> thinner;    // by so much the tissue is
  std::function<double(const Vec3&)> cell;       // of the grid
  std::function<bool(const Vec3&)> free_behind;  // nothing holds what lies before the bed there
  std::function<Vec3(const Vec3&)> pictured;     // where the picture of such a place was taken
  double before_bed_mm, edge_mm, skin_mm;        // how near the bed; of the slit's edges; so deep a margin is skin
  FacePart bed_part;                             // what else lies before the bed

  double behind(const Vec3& p) const { return before_bed_mm - bed(p); }
  double cut(double shell, const Vec3& p) const {
    const double open = smax(smax(shell, behind(p), edge_mm), slit(p), edge_mm);
    return filled ? std::min(open, smax(filled(p), behind(p), edge_mm)) : open;
  }
};

Opening between_lips(const SkinShape& skin) {
  Opening o;
  o.slit = [](const Vec3& p) { return -Mouth::slit(p, kParted_mm); };
  o.bed = MouthBed(skin);
  o.thinner = [](const Vec3& p) {
    const Vec2 off(p.x() / 30, (p.z() - Mouth::line_mm(0)) / 18);
    return kThinner_mm * elementary::exp(-off.squaredNorm());
  };
  o.cell = [](const Vec3& p) {
    const double off = (Vec3(std::abs(p.x()), p.y(), p.z()) - kOverBedsEnd.c).norm() - kOverBedsEnd.r;
    return std::min(std::max(1., 0.7 * Mouth::slit(p, kParted_mm)),
                    kOverBedsEnd.cell + kCellSpread * std::max(0., off));
  };
  o.free_behind = in_vestibule;
  o.pictured = [&skin](const Vec3& p) { return skin(p) < -kInMouth_mm && in_vestibule(p) ? as_red_lip(p) : p; };
  o.before_bed_mm = kBeforeBed_mm, o.edge_mm = kMargin_mm, o.skin_mm = kRedLip_mm, o.bed_part = FacePart::deep;
  return o;
}

/// As between lips, and the gap of a cleft in the upper one. `face`: the skin that has it.
Opening between_cleft_lips(const SkinShape& skin, std::function<double(const Vec3&)> face) {
  Opening o = between_lips(skin);
  o.slit = [](const Vec3& p) {
    return smax(-Mouth::slit(Cleft::whole(p), kParted_mm), Cleft::gap(p), kCleftCorner_mm);
  };
  o.cell = [uncleft = o.cell](const Vec3& p) {
    return std::min(uncleft(Cleft::whole(p)), std::max(1., -0.8 * Cleft::gap(p)));
  };
  o.pictured = [face = std::move(face)](const Vec3& p) {
    const Vec3 seen = Cleft::pictured(p);
    return face(p) < -kInMouth_mm && in_vestibule(p) ? as_red_lip(seen) : seen;
  };
  o.edge_mm = kCleftMargin_mm;
  return o;
}

Opening between_lids() {
  Opening o;
  o.slit = Eye::fissure;
  o.bed = Eye::globe_mm;
  o.filled = [eye = Eye()](const Vec3& p) { return eye.caruncle(p); };
  o.thinner = [](const Vec3& p) {
    return kThinAtSide_mm * bump(p, kSideOfRim, kRimWide_mm) + kThinBelow_mm * bump(p, kBelowRim, kRimWide_mm);
  };
  o.cell = [](const Vec3& p) {
    const double off = (p - kLidCells.c).norm() - kLidCells.r;
    const double lids = kLidCells.cell + kCellSpread * std::max(0., off);
    const double globe = kGlobeCell_mm + 0.5 * std::max(0., Eye::globe_mm(p) - kBeforeGlobe_mm);
    return std::min({lids, globe, std::max(kMarginCell_mm, -0.7 * Eye::fissure(p))});
  };
  o.free_behind = [](const Vec3& p) { return p.x() > 0 && p.y() > Eye::parted_centre().y() + kFornix_mm; };
  o.pictured = [](const Vec3& p) { return (p - Eye::parted_centre()).norm() > kLidsReach_mm ? p : as_lid(p); };
  o.before_bed_mm = kBeforeGlobe_mm, o.edge_mm = kLidEdge_mm, o.skin_mm = kLidMargin_mm, o.bed_part = FacePart::globe;
  return o;
}

}  // namespace

FaceTissue make_face_tissue(Workers& workers, const FaceOpenings& open) {
  const bool bare_lids = open.lids == Lids::parted;
  const Kept keep = kept(open.reach);
  const bool cleft = open.lips == Lips::cleft;
  const SkinShape uncleft(bare_lids ? RightLids::bare : RightLids::upon_globe);
  const auto skin = [&](const Vec3& p) { return uncleft(cleft ? Cleft::whole(p) : p); };
  std::vector<Opening> openings;
  if (open.lips == Lips::parted) openings.push_back(between_lips(uncleft));
  if (cleft) openings.push_back(between_cleft_lips(uncleft, skin));
  if (bare_lids) openings.push_back(between_lids());
  const double lipschitz = SkinShape::kLipschitz * (cleft ? Cleft::kStretch : 1);
  // Far inside, the shape's function is no distance: that to its surface is looked up.
  LevelSet whole;
  whole.distance_mm = [&](const Vec3& p) { return skin(p); };
  whole.lipschitz = lipschitz;
  whole.low_mm = {-105, -122, -140}, whole.high_mm = {105, 138, 142};
  std::vector<Vec3> on_skin;
  std::vector<Tri> skin_tri;
  march_graded(whole, cell_at, workers, on_skin, skin_tri);
  const Bvh near_skin(on_skin, skin_tri);
  const auto thick_at = [&](const Vec3& p) {
    double thick = depth_at(p);
    for (const Opening& o : openings) thick -= o.thinner(p);
    return thick;
  };
  const auto deep = [&](const Vec3& p, double s) {
    return s > -1 ? -s - thick_at(p) : near_skin.closest(p).distance_mm - thick_at(p);
  };
  LevelSet set;
  set.distance_mm = [&](const Vec3& p) {
    const double s = skin(p);
    if (s > 10) return s;
    double shell = smax(smax(s, deep(p, s), kRound_mm), keep.sides(p), kRound_mm);
    for (const Opening& o : openings) shell = o.cut(shell, p);
    return shell;
  };
  set.lipschitz = std::max(lipschitz, openings.empty() ? 0 : MouthBed::kLipschitz);
  set.low_mm = {-105, keep.back_mm - 4, keep.bottom_mm - 4}, set.high_mm = {105, 138, keep.top_mm + 4};
  const auto cell = [&](const Vec3& p) {
    double at = skin(p) > -5 ? cell_at(p) : kDeepCell_mm;
    for (const Opening& o : openings) at = std::min(at, o.cell(p));
    return at;
  };
  FaceTissue f;
  march_graded(set, cell, workers, f.X_mm, f.tri);
  keep_largest(f.X_mm, f.tri);
  thin_edges(f.X_mm, f.tri, set, [&](const Vec3& p) {
    double edge = skin(p) > -5 ? kThin * cell_at(p) : kDeepEdge_mm;
    if (!openings.empty()) edge = std::min(edge, kThin * cell(p));
    return edge;
  });
  for (const Tri& t : f.tri) {
    const Vec3 c = (f.X_mm[size_t(t[0])] + f.X_mm[size_t(t[1])] + f.X_mm[size_t(t[2])]) / 3;
    const double s = skin(c), e = keep.sides(c);
    double d = deep(c, s);
    FacePart beneath = FacePart::deep;
    for (const Opening& o : openings)
      if (o.behind(c) > d) d = o.behind(c), beneath = o.bed_part;
    FacePart part = s >= std::max(d, e) ? FacePart::skin : d >= e ? beneath : FacePart::side;
    if (part == FacePart::skin && globes(c) < kGlobe_mm && !(bare_lids && c.x() > 0)) part = FacePart::globe;
    for (const Opening& o : openings) {
      if (o.slit(c) > std::max({s, d, e})) part = s > -o.skin_mm ? FacePart::skin : FacePart::mucosa;
      if (part == o.bed_part && o.free_behind(c)) part = FacePart::mucosa;
    }
    f.part.push_back(part);
  }
  for (const Vec3& X : f.X_mm) {
    Vec3 seen = X;
    for (const Opening& o : openings) seen = o.pictured(seen);
    f.uv.push_back(face_picture_place(seen));
  }
  if (bare_lids) f.uv_of_mucosa = face_picture_place(kPinkOfPicture);
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
