#pragma once
// One layer of 30 kPa, 10 mm thick, in cells of 3.5 mm: a wound's walls are what the tests here look at.
#include <memory>

#include "sim/body/block.h"
#include "sim/patient/world.h"

namespace limberg::test {

inline WorldSpec plain_block(double side_mm) {
  BlockSpec b;
  b.size_mm = {side_mm, side_mm, 10};
  b.skin_cell_mm = 1.5;
  Material m;
  m.young_kPa = 30;
  b.layers = {{"skin", 10, m}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = 3.5;
  return spec;
}

}  // namespace limberg::test
