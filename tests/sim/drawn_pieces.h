#pragma once
// A path as a hand brings it: in pieces of about piece_mm, all corners kept. The first piece begins with the path's
// first point; each piece after it goes on where the one before it ended.
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg::test {

inline std::vector<std::vector<Vec2>> drawn_pieces(const std::vector<Vec2>& path, double piece_mm) {
  std::vector<std::vector<Vec2>> out{{path[0]}};
  double left = piece_mm;
  for (size_t i = 1; i < path.size(); ++i) {
    Vec2 at = path[i - 1];
    while ((path[i] - at).norm() > left) {
      at += (path[i] - at).normalized() * left;
      out.back().push_back(at);
      out.emplace_back();
      left = piece_mm;
    }
    left -= (path[i] - at).norm();
    out.back().push_back(path[i]);
  }
  return out;
}

}  // namespace limberg::test
