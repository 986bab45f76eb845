#pragma once
// What the skin of a head looks like: taken from a surface that lies where the face lies at rest, as the scan does that
// the face was fitted to. It wears a picture by texture coordinates, or has colours of its vertices.
//
// A picture is cut along seams: the surface falls into charts, parts in which neighbours agree on the coordinates of
// the edge between them. A triangle of the face takes all its corners from one chart, the nearest to its middle, so
// that none is drawn across the picture. Farther than kNone_mm from the surface the face looks as it does without.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/geometry/bvh.h"

namespace limberg {

struct SkinImage;  // sim/body/skin_image.h

/// mm, in the frame of the face at rest. Per triangle texture coordinates of its corners (SkinImage); or, without a
/// picture, per vertex an sRGB colour, 0 to 1.
struct ColouredSurface {
  std::vector<Vec3> X_mm;
  std::vector<Tri> tri;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  std::shared_ptr<const SkinImage> image;
  std::vector<Vec3f> rgb;
};

class FaceTexture {
 public:
  static constexpr double kWhole_mm = 4, kNone_mm = 10;  // between them it fades

  /// At least one triangle; an image with uv, or rgb.
  explicit FaceTexture(const ColouredSurface& surface);

  const std::shared_ptr<const SkinImage>& image() const { return image_; }
  /// Of the corners of a triangle of the face at rest. Only with an image.
  std::array<Eigen::Vector2f, 3> uv(const std::array<Vec3, 3>& X_mm) const;
  /// The colour at a place of the face at rest, and how much of it is seen. With an image: how much of that is.
  std::array<uint8_t, 4> colour(const Vec3& X_mm) const;

 private:
  struct Chart {
    Bvh bvh;
    std::vector<int32_t> triangle;  // of the surface, per triangle of bvh
  };
  std::shared_ptr<const SkinImage> image_;
  std::vector<Tri> tri_;
  std::vector<std::array<Eigen::Vector2f, 3>> uv_;
  std::vector<Vec3f> rgb_;
  Bvh all_;
  std::vector<int32_t> chart_of_;  // per triangle
  std::vector<Chart> chart_;
};

}  // namespace limberg
