#include "sim/imaging/register/landmark_pairs.h"

#include <cmath>
#include <sstream>

#include "sim/base/error.h"
#include "sim/imaging/io/surface_file.h"

namespace limberg {

LandmarkPairs parse_landmark_pairs(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  LandmarkPairs pairs;
  std::string line, word;
  for (int n = 1; std::getline(in, line); ++n) {
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    if (!(words >> word)) continue;
    double v[6];
    for (double& x : v)
      if (!(words >> x) || !(std::abs(x) <= SurfaceFileLimits::extent_mm))
        throw InputError(name, n, "expected a name and six numbers: x y z of it in A, then in B, in mm");
    pairs.a_mm.emplace_back(v[0], v[1], v[2]), pairs.b_mm.emplace_back(v[3], v[4], v[5]);
  }
  return pairs;
}

}  // namespace limberg
