#pragma once
// A small block whose skin has a picture of four pixels.
#include "sim/body/skin_image.h"
#include "tests/sim/patient/small_block.h"

namespace limberg::test {

inline WorldSpec pictured_block() {
  WorldSpec spec = small_block();
  auto image = std::make_shared<SkinImage>();
  image->width = 2, image->height = 2;
  image->rgb = {255, 0, 0, 0, 255, 0, 0, 0, 255, 10, 20, 30};
  spec.image = image;
  return spec;
}

}  // namespace limberg::test
