#pragma once
// What is measured on a head from its landmarks, before and now: cephalometry, asymmetry, and lengths and angles
// between places that were picked. One list for the window, the report and the CSV file.
#include <string>
#include <utility>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

using NamedPlaces = std::vector<std::pair<std::string, Vec3>>;

struct HeadMeasure {
  enum class Group : uint8_t { cephalometry, asymmetry, picked } group = Group::cephalometry;
  std::string name, unit;  // mm or deg
  double before = 0, now = 0;
  std::string norm;  // empty: none
  double change() const { return now - before; }
};

/// Of the places that both lists name. cephalometry: every figure whose landmarks are there (measure/cephalometry.h);
/// asymmetry: rms of all pairs, and how far each left place is from mirroring the right one; picked: places named M and
/// a number, in that order: the length from each to the next, and the angle at the middle one of each three.
std::vector<HeadMeasure> head_measures(const NamedPlaces& before, const NamedPlaces& now);

/// The number of a picked place, M1, M2, ...; 0: the name is of another kind.
int picked_number(const std::string& name);

/// group,name,unit,before,now,change,norm
std::string to_csv(const std::vector<HeadMeasure>& measures);

}  // namespace limberg
