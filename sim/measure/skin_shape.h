#pragma once
// The form of the operated skin: what stands up, what stands open, how long and how large it has become.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/body/skin.h"
#include "sim/cutting/arrangement/surface_view.h"
#include "sim/measure/plan.h"

namespace limberg {

/// Dog-ears: skin that stands above where the skin was before the operation. Height is the distance of a skin vertex
/// outside the original rest surface (Skin::depth_mm, sign changed); the body is held at its sides and its base, so
/// that surface is the reference that a ring of untouched skin around the wound would give. Volume is the integral of
/// the positive height over the original surface: the skin's area projected along the reference normal. Only skin whose
/// rest place lies within `radius_mm` of one of `centres_mm` counts; no centres: all skin. A piece that has been cut
/// free on all sides is no part of the body's form: nothing says where it lies, and its skin is left out. A cone is a
/// dog-ear where the tissue angles sewn together add up to less than 360 degrees (Limberg; Kang and Kang 2020).
struct DogEar {
  double height_mm = 0;       // highest
  double volume_mm3 = 0;      // above the original surface
  double rms_mm = 0;          // of the height, up or down, weighted by area
  Vec3 at_mm = Vec3::Zero();  // rest place of the highest vertex
};
DogEar dog_ear(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
               std::span<const Vec3> centres_mm = {}, double radius_mm = 0);

/// Middles, at rest, of all edges between skin and cut wall: where the skin has been cut, open or sewn.
std::vector<Vec3> rim_mm(const SurfaceView& view);

/// The open wound. A rim is an edge between skin and cut wall. From each rim point one looks
/// away from its own skin, within 60 degrees of the direction across the edge: the gape
/// there is the distance to the nearest other rim seen, or to any other rim nearer than 2 mm
/// (banks that lie over one another). Own rim within 3 mm along the edge counts only where the edge has turned back,
/// now or at rest, as round the end of a cut; what lay behind its skin within 3 mm at rest, with skin between,
/// as the other side of a flap's tip, does not. A piece that nothing holds, and that comes
/// no nearer than 2 mm to another edge, was taken out and does not count. A stretch of up to 1 mm between edges that
/// are apposed is no farther from the other bank than these, and the way to them.
struct WoundGape {
  double gape_mm = 0;        // which 95 % of the rim do not exceed
  double mean_mm = 0;        // over the length of the rim
  double rim_length_mm = 0;  // at rest, both banks
  double rim_now_mm = 0;     // the same as it lies now; a closed wound's scar is half of it
  // Edges that lie at different heights: the part of the way to the rim over there that runs along the skin's normal.
  // 95 % of the rim do not exceed step_mm.
  double step_mm = 0, step_mean_mm = 0;
  Vec3 gape_at_mm = Vec3::Zero();  // where it gapes by gape_mm; rest place, as all of them
  // Widest place, and all that gapes by more than kOpen_mm or looks at no other edge at all (a flap that stands up or
  // lies elsewhere): the length of edge at rest, both banks.
  double widest_mm = 0, open_mm = 0;
  Vec3 widest_at_mm = Vec3::Zero();
  double lost_mm = 0;  // of open_mm, what looks at no other edge
  // Edge at rest that lies over or under other skin by more than kOpen_mm (less is apposed). It gapes by nothing.
  double over_mm = 0;
  Vec3 over_at_mm = Vec3::Zero();
};
/// Edges nearer than this are apposed: "wound margin separation > 2 mm" is a fault of the Hollander wound evaluation
/// scale (Hollander, Singer, Valentine, Henry 1995, Ann. Emerg. Med. 25:675).
inline constexpr double kOpen_mm = 2;
/// An edge that goes farther over other skin lies elsewhere: what it left is open.
inline constexpr double kOver_mm = 5;
WoundGape wound_gape(const SurfaceView& view, std::span<const Vec3f> x_mm);

/// Skin that lies on its face or is turned inside out: skin whose outward normal now is more than 120 degrees from that
/// of the original surface there (90 is upright, as the wall of a fold; 30 more, so that skin that stands up is none).
/// Skin that has itself turned by less than 60 degrees does not lie on its face: in a thin fold, as an ear, the
/// original surface that is nearest now may be that of the other side.
struct TurnedSkin {
  double area_mm2 = 0;        // at rest
  Vec3 at_mm = Vec3::Zero();  // its middle at rest
};
TurnedSkin turned_skin(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin);

/// The surface's volume now, relative to rest, minus 1: how much the elastic solution compresses the tissue as a whole.
double compression(const SurfaceView& view, std::span<const Vec3f> x_mm);

/// Present area in mm2 of the skin whose rest place lies inside a chart polygon.
double skin_area_mm2(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body,
                     std::span<const ChartPoint> polygon);

/// Where the skin corner at chart point p is now. Several banks can meet in p; meant is the one whose skin lies most in
/// the direction of `towards` (chart). Nothing when there is no skin within 1 mm.
std::optional<Vec3> corner_position_mm(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const ChartPoint& p, const ChartPoint& towards);

/// The ends A and B of the limb now, and their distance at rest, taken in the skin outside the flaps.
struct LimbEnds {
  Vec3 a, b;
  double before_mm;
};
std::optional<LimbEnds> limb_ends(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                  const CentralLimb& limb);

/// Distance of the limb's ends now over their distance at rest, both taken in the skin outside the flaps.
std::optional<double> elongation(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                 const CentralLimb& limb);

}  // namespace limberg
