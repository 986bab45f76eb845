#pragma once
// A body of skin above and what the text says below, for blades that need an underside.
#include <memory>
#include <string>

#include "sim/body/obj.h"

namespace limberg::test {

/// Of an OBJ text in mm whose materials are skin, cut (free without skin) and bone (held).
inline std::shared_ptr<const Body> body_on_bone(const std::string& obj) {
  ObjSpec spec;
  spec.path = "body.obj";
  spec.tags = {{"skin", ObjTag::What::skin}, {"cut", ObjTag::What::cut}, {"bone", ObjTag::What::held}};
  Layer skin, fat;
  skin.thickness_mm = 1.5, fat.thickness_mm = 100;
  spec.layers = {skin, fat};
  return std::make_shared<const Body>(parse_obj(obj, spec));
}

}  // namespace limberg::test
