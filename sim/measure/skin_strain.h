#pragma once
// How far and how hard the skin is pulled: stretch and stress of each skin triangle, from its rest and present corners.
//
// A skin triangle is a membrane of the body's first layer with a free surface. With the in-plane deformation
// gradient F (2 x 2, rest axes along and across the tension direction), the layer's prestretch F0 = diag(p,
// q, 1/(pq)), A = F0 F0^T, and the energy of fem_model.h with lambda' = lambda + mu and p0 = mu A_nn,
//
//   sigma = (mu / J) F A F^T + (lambda' (J - 1) - p0) I,     J = det(F) s,   s the stretch of the thickness.
//
// sigma_nn = 0 is linear in s: s = (mu A_nn + lambda') / (mu A_nn / det F + lambda' det F), so that
//
//   principal stresses = (mu / J) (eigenvalues of sqrt(A) F^T F sqrt(A)  -  A_nn s^2).
//
// The pressure of the mixed cell below is not needed, hence the figure does not depend on how cells and layers meet.
//
// A layer with a law of its own (Material::law) has (1/J) P(F F0) F0 F^T in place
// of (mu/J) F A F^T, its lambda and its rest pressure (catalogue.h), and s is found
// by bisection. What relaxes is not counted: this is the stress once relaxed.
#include <span>
#include <vector>

#include "sim/body/body.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

struct LayerResponse;

struct MembraneState {
  double stretch = 1;           // largest principal stretch that the tissue carries, prestretch included
  double least_stretch = 1;     // smallest in the plane
  double stress_kPa = 0;        // largest principal Cauchy stress in the plane
  double least_stress_kPa = 0;  // the other principal stress in the plane
  // Between the direction of the greatest stress and the fibres (the tension direction), both as they lie now, 0 to 90;
  // less than 0 where the two stresses differ by less than 2 % of the greater: no direction then.
  double angle_deg = -1;
  double von_mises_kPa = 0;  // of the plane stress state
  double area_mm2 = 0;       // at rest
};

/// One triangle, corners at rest and now. `along` need not lie in its plane nor be unit. A triangle that has collapsed
/// now has stress 0 and the stretch that its edges show.
MembraneState membrane_state(const std::array<Vec3, 3>& X_mm, const std::array<Vec3, 3>& x_mm, const Material& material,
                             const Vec3& along);
/// The same of a layer whose law is known already: that of layer_response(material), with points.
MembraneState membrane_state(const std::array<Vec3, 3>& X_mm, const std::array<Vec3, 3>& x_mm, const Material& material,
                             const Vec3& along, const LayerResponse& law);

/// The state of every skin triangle, by triangle of the view; area 0 on what is no skin, and on triangles of less than
/// 0.02 mm height (slivers that cuts leave: positions are floats, so their stretch would carry an error above 0.1 %).
std::vector<MembraneState> skin_states(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body);

/// Where every law of skin ends: excised human skin tore at a strain of 54 +- 17 % (Ni Annaidh et al. 2012, J. Mech.
/// Behav. Biomed. Mater. 5:139, 56 samples; the fibre law's constants come from the same tests). What is stretched
/// further, prestretch included, is counted as area and has no stress of its own.
inline constexpr double kLawEnds_stretch = 1.54;
/// Stretched further than that in some direction: in its plane, or, volume kept, across it (skin that is crushed).
inline bool beyond_law(const MembraneState& s) {
  return !(s.stretch <= kLawEnds_stretch && s.stretch * s.least_stretch >= 1 / kLawEnds_stretch);
}
/// A largest value is one that more than a square mm of skin has: about what a bite of a stitch takes. One triangle, as
/// small as a cut left it, cannot make it.
inline constexpr double kLargest_mm2 = 1;

struct SkinStrain {
  // The greatest but for kLargest_mm2; stress over skin within the law's range, so that where more lies beyond it the
  // figure is the greatest that the law can tell.
  double stretch_max = 1, stretch_p99 = 1;
  double stress_max_kPa = 0, stress_p95_kPa = 0;
  double beyond_law_mm2 = 0;  // rest area of what is beyond_law
  double compressed_mm2 = 0;  // rest area with a least principal stress below 0: it would wrinkle
  double angle_deg = -1;      // mean of MembraneState::angle_deg over the 5 % of the area with the greatest stress
  Vec3 most_stressed_mm = Vec3::Zero();  // where the stress is greatest, at rest
  double area_mm2 = 0;                   // of the triangles counted
};

/// Over all skin triangles but slivers, percentiles weighted by rest area; skin beyond the law's range ranks above all
/// other. The maxima sit at the tips of cuts and at stitches and grow as cells shrink; the percentiles converge.
SkinStrain skin_strain(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body);

/// Value below which the fraction q of the weight lies; sorts `pairs` (value, weight). 0 when empty.
double weighted_percentile(std::vector<std::pair<double, double>>& pairs, double q);

}  // namespace limberg
