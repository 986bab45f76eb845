#pragma once
// Laws by name: what a scene may write in a layer, and how a layer's constants become what its cells are made of.
//
//   [[layer]]                                  Material::law              layer_response()
//   law = "gasser-ogden-holzapfel"       ->    name and constants    ->   matrix modulus,
//   k1_kPa = 50  k2 = 1.5                                                 law of the points,
//   ...                                                                   lambda
//
// A catalogue is a list of entries, each with the keys that it takes and their ranges, so that reading a scene, saying
// what was expected and listing the laws need no other place. To add a law, write one file that makes an Entry (law.h
// tells how; tests/app/test_own_law.cpp is one) and add it to a copy of the shipped catalogue, or to shipped_laws().
//
// Volume. The law holds the change of shape; the element holds the volume (fem_model.h). So that Poisson's ratio means
// the same for every law, the element's lambda is completed from the derivatives of the law at rest by principal
// stretches, s = dW/ds_1, W_11 and W_12:   mu = (W_11 - W_12 + s) / 2,   lambda = 2 mu nu / (1 - 2 nu) + s - W_12
// (the rest pressure s takes s (J - 1) off, whose second derivative is s; neo-Hookean: lambda_Lame + mu). Where fibres
// lie in a matrix, nu is the matrix's. A law that holds its volume by itself says so (LayerLaw::complete): its cells
// have lambda = 0, and the layer's `poisson` must be the law's own, s = 0 and nu = W_12 / (W_11 + W_12).
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/body/layers.h"
#include "sim/fem/materials/law.h"

namespace limberg {

/// A layer's resistance to change of shape, in the axes of the skin: x along the tension lines, y across, z out.
struct LayerLaw {
  double matrix_mu_kPa = 0;  // mu/2 (|F|^2 - 3), integrated exactly and at no cost; 0: none
  LawPtr points;             // beside it, or all there is; null: none
  int points_per_part = 8;   // per layer and cell: 8, or 1 for fibres in a matrix that holds the cell's shape
  bool complete = false;     // `points` resist change of volume by themselves: the cell has no lambda
};

class LawCatalogue {
 public:
  struct Constant {
    std::string key;  // with its unit
    double least = 0, most = 0;
    bool above = false;  // `least` itself is not allowed
    bool required = true;
    double otherwise = 0;  // when not required
    int most_values = 1;   // above 1: a list
  };
  /// Constants of a layer by key; complete and in range when an Entry's make sees them.
  class Values {
   public:
    Values(const LawSpec& spec, const std::vector<Constant>& known) : spec_(spec), known_(known) {}
    double number(const char* key) const;
    std::vector<double> list(const char* key) const;

   private:
    const LawSpec& spec_;
    const std::vector<Constant>& known_;
  };
  struct Entry {
    std::string name;
    std::string about;  // the energy and where it comes from, in a line
    std::vector<Constant> constants;
    std::function<LayerLaw(const Values&)> make;  // may throw InputError
  };

  /// InputError when the name is taken.
  LawCatalogue& add(Entry entry);
  const Entry* find(const std::string& name) const;
  const std::vector<Entry>& entries() const { return entries_; }
  std::string names() const;  // in a line, for messages

 private:
  std::vector<Entry> entries_;
};

/// The laws that come with the program.
std::shared_ptr<const LawCatalogue> shipped_laws();
inline constexpr const char* kDefaultLaw = "stable-neo-hookean";

/// What a layer's cells are made of.
struct LayerResponse {
  double matrix_mu_kPa = 0;
  LawPtr points;  // null: all in the matrix
  int points_per_part = 0;
  LawPtr whole;           // matrix and points together
  double mu_kPa = 0;      // at small strain (of the matrix, where there is one)
  double lambda_kPa = 0;  // of fem_model.h
  bool directed = false;  // not isotropic: the axes matter
};

/// `laws` null: the shipped ones. InputError names what is missing or out of range; also a law that resists change of
/// volume and does not say that it is complete, or is complete with another Poisson's ratio than the layer's.
LayerResponse layer_response(const Material& material, const LawCatalogue* laws = nullptr);

/// n . sigma n at the rest state F = I of a layer whose prestretch and axes are M; n unit. What the element's p0
/// balances.
double rest_pressure_kPa(const LayerResponse& r, const Mat3& M, const Vec3& n);

}  // namespace limberg
