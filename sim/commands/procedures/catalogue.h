#pragma once
// The repertoire: classical skin operations, each a figure from a few lengths and angles.
//
//   const Procedure& p = find_procedure("bilobed");
//   Figure f = p.figure(p.defaults());
//
// Sources: Limberg 1946 and Lister and Gibson 1972 (rhomboid), Dufourmentel 1962, Webster
// 1978 (30 degree flap), Zitelli 1989 (bilobed), McGregor (Z-plasty), Masson and Mendelson 1977 (banner), Behan 2003
// (keystone), Hammond 1979 (O-to-Z), and the usual textbook constructions. Where textbooks differ, the header of the
// function in the .cpp says what is drawn. Figures lie around the origin; +x is the direction that a placement turns.
#include <functional>
#include <string>
#include <vector>

#include "sim/commands/procedures/figure.h"

namespace limberg {

struct ProcedureParameter {
  std::string name, help;  // the name ends in its unit: _mm, _deg, or nothing for numbers and ratios
  double value = 0, lo = 0, hi = 0;
};

struct Procedure {
  std::string name, about;
  std::vector<ProcedureParameter> parameters;
  /// `values` in the order of `parameters`, each within its range.
  std::function<Figure(const std::vector<double>& values)> figure;
  std::vector<double> defaults() const;
};

const std::vector<Procedure>& procedures();
/// InputError that lists the names when there is none of this name.
const Procedure& find_procedure(const std::string& name);
/// Applies "name=value" settings to the defaults. InputError on
/// an unknown or repeated name, a broken or out-of-range number.
std::vector<double> procedure_values(const Procedure& p, const std::vector<std::string>& settings);

}  // namespace limberg
