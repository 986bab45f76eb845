#include "app/head/face_look.h"

#include "app/scene/surface_picture.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/body/obj.h"
#include "sim/geometry/io/mesh_file.h"
#include "sim/imaging/io/surface_file.h"

namespace limberg {
namespace {

constexpr size_t kMostBytes = size_t(1) << 30;  // a scan as scanners write it
constexpr ObjTextLimits kMost{20'000'000, 40'000'000};

/// Polygons become fans. With `pictured` only faces that have texture coordinates.
ColouredSurface coloured(ObjText text, bool pictured) {
  ColouredSurface s;
  s.X_mm = std::move(text.v);
  if (!pictured) s.rgb = std::move(text.rgb);
  for (const ObjText::Face& f : text.face) {
    const ObjText::Corner* c = text.corner.data() + f.first;
    for (size_t k = 1; k + 1 < f.corners; ++k) {
      const std::array<ObjText::Corner, 3> corner{c[0], c[k], c[k + 1]};
      if (pictured && (corner[0].vt < 0 || corner[1].vt < 0 || corner[2].vt < 0)) continue;
      s.tri.push_back({corner[0].v, corner[1].v, corner[2].v});
      if (pictured)
        s.uv.push_back({text.vt[size_t(corner[0].vt)], text.vt[size_t(corner[1].vt)], text.vt[size_t(corner[2].vt)]});
    }
  }
  return s;
}

}  // namespace

std::shared_ptr<const FaceTexture> face_look(const Scene& scene, simplex::Axes axes) {
  const HeadScene& h = *scene.head;
  if (h.texture_file.empty()) return nullptr;
  ObjText text = parse_mesh_file(read_whole_file(h.texture_file, kMostBytes, "a face's surface with colours"),
                                 h.texture_file, kMost);
  std::string picture = h.picture_file;
  if (picture.empty() && !text.vt.empty()) picture = picture_of_surface(h.texture_file).picture;
  const bool pictured = !picture.empty();
  if (!pictured && text.rgb.empty())
    throw InputError(h.texture_file, 0,
                     "has neither a picture (texture coordinates, and a PNG or JPEG that its material or "
                     "head.face_picture names) nor colours of its vertices; expected one of them");
  if (pictured && scene.flesh && !picture_on(scene).empty())
    throw InputError(scene.path, 0,
                     "head.face_texture wears a picture, and so does the surface of [body]; expected colours of "
                     "vertices in one of them");
  ColouredSurface s = coloured(std::move(text), pictured);
  if (s.tri.empty())
    throw InputError(h.texture_file, 0,
                     pictured ? "has no face with texture coordinates; expected a surface that wears " + picture
                              : "has no faces; expected a surface with colours");
  if (pictured) s.image = skin_image(picture);
  const bool turned = axes == simplex::Axes::left_posterior_superior;
  for (Vec3& x : s.X_mm) {
    x *= h.texture_scale_to_mm;
    if (turned) x.head<2>() *= -1;
    x += h.offset_mm;
    if (!(x.cwiseAbs().maxCoeff() <= SurfaceFileLimits::extent_mm))
      throw InputError(h.texture_file, 0, "a point is not at a place within 1000000 mm; expected a face's surface");
  }
  return std::make_shared<const FaceTexture>(s);
}

}  // namespace limberg
