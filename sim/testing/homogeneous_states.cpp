#include "sim/testing/homogeneous_states.h"

#include <cmath>
#include <functional>

#include "sim/base/elementary.h"

namespace limberg {

std::vector<HomogeneousState> homogeneous_states() {
  using Load = HomogeneousState::Load;
  std::vector<HomogeneousState> out;
  // s dW/ds of one principal direction, all three stretches given.
  using Pull = std::function<double(double s, double sum_of_squares)>;
  const auto isotropic = [&](const std::string& name, const LawSpec& law, double young, const Pull& pull) {
    for (const double l : {1.1, 1.2, 1.5}) {
      const auto add = [&](const char* how, Load load, const Vec3& s) {
        const double I1 = s.squaredNorm();
        out.push_back({name + ", " + how, law, young, load, l, pull(s[0], I1) - pull(s[2], I1), s[1],
                       "closed form, incompressible"});
      };
      add("uniaxial", Load::uniaxial_along, {l, 1 / std::sqrt(l), 1 / std::sqrt(l)});
      add("equibiaxial", Load::equibiaxial, {l, l, 1 / (l * l)});
      add("planar", Load::planar, {l, 1, 1 / l});
    }
  };
  isotropic("stable neo-Hookean", {}, 60, [](double s, double) { return 20 * s * s; });
  isotropic("Mooney-Rivlin", {"mooney-rivlin", {{"c10_kPa", {6}}, {"c01_kPa", {4}}}}, 0,
            [](double s, double I1) { return 2 * s * s * (6 + 4 * (I1 - s * s)); });
  isotropic("Ogden", {"ogden", {{"mu_kPa", {3, -1}}, {"alpha", {9, -4}}}}, 0,
            [](double s, double) { return 3 * elementary::pow(s, 9) - elementary::pow(s, -4); });
  isotropic("corotated", {"corotated", {{"mu_kPa", {20}}}}, 0, [](double s, double) { return 2 * 20 * s * (s - 1); });
  isotropic("Saint Venant-Kirchhoff", {"saint-venant-kirchhoff", {{"mu_kPa", {20}}}}, 0,
            [](double s, double) { return 20 * s * s * (s * s - 1); });

  const LawSpec g1{
      "gasser-ogden-holzapfel",
      {{"mu_kPa", {201.4}}, {"k1_kPa", {24530}}, {"k2", {0.1327}}, {"kappa", {0.1404}}, {"fibre_angle_deg", {41}}}};
  const char* solved = "incompressible, solved independently";
  for (const auto& [l, stress, lateral] : {std::tuple{1.05, 84.584, 0.92912},
                                           {1.10, 343.830, 0.84134},
                                           {1.15, 1348.058, 0.76511},
                                           {1.20, 3291.599, 0.72905}})
    out.push_back({"skin G1, along", g1, 0, Load::uniaxial_along, l, stress, lateral, solved});
  for (const auto& [l, stress, lateral] : {std::tuple{1.05, 36.542, 0.95935},
                                           {1.10, 87.253, 0.91117},
                                           {1.20, 386.346, 0.78324},
                                           {1.30, 2637.876, 0.67480}})
    out.push_back({"skin G1, across", g1, 0, Load::uniaxial_across, l, stress, lateral, solved});
  const LawSpec g2{"gasser-ogden-holzapfel",
                   {{"mu_kPa", {10}}, {"k1_kPa", {100}}, {"k2", {1}}, {"kappa", {0.1}}, {"fibre_angle_deg", {0}}}};
  for (const auto& [l, stress] :
       {std::pair{1.05, 12.96555}, {1.1, 29.88648}, {1.2, 81.45616}, {1.3, 175.82198}, {1.5, 788.99019}})
    out.push_back(
        {"skin G2, along", g2, 0, Load::uniaxial_along, l, stress, 1 / std::sqrt(l), "closed form, incompressible"});
  for (const double l : {1.1, 1.2, 1.3})
    out.push_back({"skin G2, across", g2, 0, Load::uniaxial_across, l, 10 * (l * l - 1 / l), 1 / std::sqrt(l),
                   "closed form: slack fibres, the matrix alone"});
  return out;
}

}  // namespace limberg
