#pragma once
// A flat patient, small enough to be cut many times in a test: skin under tension over fat, or skin alone.
#include <memory>

#include "sim/body/block.h"
#include "sim/patient/world_spec.h"

namespace limberg::test {

struct SmallBlock {
  double side_mm = 60, thickness_mm = 10;
  double skin_cell_mm = 2, cell_mm = 5;
  double along = 1.08, across = 1.08;  // prestretch of the skin
  bool fat = true;                     // below 1.5 mm of skin; false: all of it is skin
};

inline WorldSpec small_block(const SmallBlock& s = {}) {
  BlockSpec b;
  b.size_mm = {s.side_mm, s.side_mm, s.thickness_mm};
  b.skin_cell_mm = s.skin_cell_mm;
  Material skin, fat;
  skin.poisson = 0.45, skin.prestretch_along = s.along, skin.prestretch_across = s.across;
  fat.young_kPa = 12, fat.poisson = 0.45;
  if (s.fat)
    skin.young_kPa = 60, b.layers = {{"skin", 1.5, skin}, {"fat", s.thickness_mm - 1.5, fat}};
  else
    b.layers = {{"skin", s.thickness_mm, skin}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = s.cell_mm;
  return spec;
}

}  // namespace limberg::test
