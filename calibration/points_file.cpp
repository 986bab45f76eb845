#include "calibration/points_file.h"

#include <sstream>

#include "sim/base/error.h"

namespace limberg {

std::vector<Vec3> parse_points(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  std::vector<Vec3> p;
  std::string line;
  for (int n = 1; std::getline(in, line); ++n) {
    if (const size_t hash = line.find('#'); hash != std::string::npos) line.resize(hash);
    for (char& ch : line)
      if (ch == ',' || ch == ';') ch = ' ';
    std::istringstream words(line);
    Vec3 v;
    std::string rest;
    if (!(words >> rest)) continue;
    words.clear(), words.str(line);
    if (!(words >> v.x() >> v.y() >> v.z()) || (words >> rest) || !v.allFinite() || v.norm() > 1e5)
      throw InputError(name, n, "is no point; expected x y z in mm of the world");
    p.push_back(v);
  }
  return p;
}

}  // namespace limberg
