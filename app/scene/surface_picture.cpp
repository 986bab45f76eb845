#include "app/scene/surface_picture.h"

#include <cctype>
#include <filesystem>

#include "render/image.h"
#include "sim/base/whole_file.h"
#include "sim/body/obj.h"
#include "sim/body/obj_material.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;
constexpr size_t kMostMaterial = size_t(1) << 20;

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

}  // namespace

SurfacePicture picture_of_surface(const std::string& surface) {
  if (ending_of(surface) != ".obj") return {};
  const std::string named = materials_of_obj(read_whole_file(surface, ObjLimits::file_bytes, "an OBJ surface"));
  std::error_code ec;
  const fs::path folder = fs::path(surface).parent_path(), materials = folder / named;
  if (named.empty() || !fs::is_regular_file(materials, ec)) return {};
  const std::string name =
      picture_of_material(read_whole_file(materials.string(), kMostMaterial, "the material file of a surface"));
  const fs::path picture = folder / name;
  const std::string ending = ending_of(picture);
  const bool taken = ending == ".png" || ending == ".jpg" || ending == ".jpeg";
  if (name.empty() || !taken || !fs::is_regular_file(picture, ec)) return {};
  return {materials.lexically_normal().string(), picture.lexically_normal().string()};
}

std::shared_ptr<const SkinImage> skin_image(const std::string& file) {
  Image image = read_picture(file);
  auto out = std::make_shared<SkinImage>();
  out->width = image.width, out->height = image.height, out->rgb = std::move(image.rgb);
  return out;
}

}  // namespace limberg
