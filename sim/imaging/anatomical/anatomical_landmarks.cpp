// Where landmarks of the anatomical head are looked for.
#include "sim/imaging/anatomical/anatomical_head.h"

namespace limberg {

const std::vector<LandmarkRule>& anatomical_landmark_rules() {
  using enum LandmarkRule::Surface;
  static const Vec3 in(0, -1, 0), out(0, 1, 0), up(0, 0, 1), down(0, 0, -1), left(-1, 0, 0), right(1, 0, 0);
  static const std::vector<LandmarkRule> rules = {
      {"G", skull, {0, 96, 36}, in, out, {0, 8}},
      {"N", skull, {0, 92, 22}, in, in, {0, 6}},
      {"Rhi", skull, {0, 104, 0}, {0, -1, 0.5}, {0, 1, -0.7}, {0, 5}},
      {"ANS", skull, {0, 97, -29.8}, in, out, {0, 2}},
      {"A", skull, {0, 93, -36}, in, in, {0, 4}},
      {"Pr", skull, {0, 93, -44}, in, out, {0, 2}},
      {"Is", skull, {1.5, 96, -56}, {0, -0.3, 1}, {0, 0.3, -1}, {0, 4}},
      {"U6", skull, {25, 60, -54}, up, down, {3, 4}, 4, true},
      {"PNS", skull, {0, 42, -32}, out, in, {0, 3}, 8},
      {"Ba", skull, {0, -6, -21}, {0, 0.6, 1}, {0, -0.6, -1}, {0, 6}},
      {"Op", skull, {0, -40, -20}, {0, -0.6, 1}, {0, 0.6, -1}, {0, 6}},
      {"V", skull, {0, 2, 124}, down, up, {0, 20}},
      {"Ii", mandible, {1.5, 93, -56}, {0, -0.3, -1}, {0, 0.3, 1}, {0, 4}, 6},
      {"Id", mandible, {0, 90, -64}, in, out, {0, 2}},
      {"L6", mandible, {24, 62, -48}, down, up, {3, 4}, 3, true},
      {"B", mandible, {0, 89, -76}, in, in, {0, 6}},
      {"Pog", mandible, {0, 90, -90}, in, out, {0, 6}},
      {"Gn", mandible, {0, 88, -95}, {0, -1, 1}, {0, 1, -1}, {0, 8}},
      {"Me", mandible, {0, 80, -97}, up, down, {0, 8}},
      {"Or", skull, {31, 84, 0}, {0, -0.7, -1}, {0, 0.7, 1}, {0, 5}, 8, true},
      {"Po", skull, {62, 0, 0}, left, right, {0, 0}, 25, true},
      {"Zy", skull, {64, 28, -4}, left, right, {12, 6}, 25, true},
      {"Eu", skull, {70, -8, 56}, left, right, {25, 20}, 25, true},
      {"Ft", skull, {58, 62, 34}, left, left, {6, 4}, 25, true},
      {"Ms", skull, {50, -15, -33}, up, down, {6, 6}, 12, true},
      {"Co", mandible, {51, 10, -4}, down, up, {6, 6}, 2, true},
      {"Go", mandible, {48, 6, -64}, {-0.2, 1, 1}, {0.2, -1, -1}, {10, 10}, 25, true},
      {"g'", skin, {0, 100, 36}, in, out, {0, 8}},
      {"n'", skin, {0, 97, 20}, in, in, {0, 8}},
      {"prn", skin, {0, 123, -24}, in, out, {0, 6}},
      {"sn", skin, {0, 106, -35}, {0, -1, 1}, {0, -1, 1}, {0, 4}},
      {"ls", skin, {0, 110, -50}, in, out, {0, 3}},
      {"sto", skin, {0, 105, -55.8}, in, in, {0, 1.5}},
      {"li", skin, {0, 107, -61}, in, out, {0, 4}},
      {"sl", skin, {0, 98, -73}, in, in, {0, 7}},
      {"pog'", skin, {0, 100, -89}, in, out, {0, 8}},
      {"gn'", skin, {0, 96, -100}, {0, -1, 1}, {0, 1, -1}, {0, 8}},
      {"me'", skin, {0, 84, -105}, up, down, {0, 8}},
      {"v'", skin, {0, 2, 129}, down, up, {0, 20}},
      {"op'", skin, {0, -95, 30}, out, in, {0, 25}},
      {"en", skin, {16.6, 84, 13}, in, out, {0, 0}, 25, true},
      {"ex", skin, {45.6, 80, 15.4}, in, out, {0, 0}, 25, true},
      {"al", skin, {17, 104, -28}, left, right, {5, 4}, 12, true},
      {"ch", skin, {27, 92, -56}, in, out, {0, 0}, 25, true},
      {"zy'", skin, {69, 30, -3}, left, right, {8, 8}, 25, true},
      {"go'", skin, {53, 8, -64}, {-1, 0.4, 0.4}, {1, -0.4, -0.4}, {0, 0}, 25, true},
      {"eu'", skin, {75, -12, 55}, left, right, {25, 20}, 25, true},
      {"t", skin, {74, -3, -4}, left, right, {0, 0}, 25, true},
      {"sa", skin, {78, -14, 33}, down, up, {6, 10}, 12, true},
      {"sba", skin, {72, -4, -30}, up, down, {5, 6}, 8, true},
  };
  return rules;
}

}  // namespace limberg
