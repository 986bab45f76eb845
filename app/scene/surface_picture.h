#pragma once
// Pictures on surfaces that a scene names, and the files in which they lie.
#include <memory>
#include <string>
#include <vector>

#include "sim/body/skin_image.h"

namespace limberg {

/// What an OBJ says of its picture: the material file beside it, and the PNG or JPEG that this one names, if it is
/// there. Both empty for other kinds of file, and where one is missing.
struct SurfacePicture {
  std::string materials, picture;
};
/// Throws InputError: the surface cannot be read.
SurfacePicture picture_of_surface(const std::string& surface);

/// InputError: no PNG or JPEG.
std::shared_ptr<const SkinImage> skin_image(const std::string& file);

}  // namespace limberg
