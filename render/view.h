#pragma once
// Where the eye is. A camera makes one view or several (left and right eye); the renderer draws a list of views.
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

using Mat4f = Eigen::Matrix4f;

/// One picture of the scene: clip = projection * to_eye * (world mm, 1), and the part of the image it fills.
struct View {
  Mat4f to_eye = Mat4f::Identity();
  Mat4f projection = Mat4f::Identity();
  Vec3f eye_mm = Vec3f::Zero();
  float x0 = 0, y0 = 0, x1 = 1, y1 = 1;  // of the image, from its top left corner

  /// The part of this view between u0 and u1 of its width (0..1, from the left), in that part of the image: what a wipe
  /// between two scenes shows on one side.
  View part(float u0, float u1) const;

  /// This view in another part of the image: between u0 and u1 of the width and v0 and v1 of the height of where it was
  /// meant to be all of it.
  View placed(float u0, float v0, float u1, float v1) const;

  /// The ray through a pixel: where it starts (the eye) and its unit direction.
  Vec3f ray_through(float x_px, float y_px, int width, int height) const;

  /// Pixel of a world point in an image of the given size (x right, y down), and its depth in clip space.
  Vec3f to_pixel(const Vec3f& world_mm, int width, int height) const;
};

/// A pin-hole camera that looks at a point.
struct Camera {
  Vec3f eye_mm{0, -100, 100}, target_mm = Vec3f::Zero(), up = Vec3f::UnitZ();
  float fov_deg = 26;  // vertical
  float near_mm = 5, far_mm = 2000;

  View view(double aspect) const;
  /// Left and right eye, off-axis frusta meeting in the plane
  /// of the target; each fills half of the image, side by side.
  std::vector<View> stereo_side_by_side(double aspect, double eye_distance_mm = 6) const;
  /// The same, but each fills the whole image: for an anaglyph.
  std::vector<View> stereo_pair(double aspect, double eye_distance_mm = 6) const;
};

/// A camera that sees the whole ball (centre, radius) from the direction `from` (towards the eye).
Camera look_at_ball(const Vec3f& centre_mm, float radius_mm, const Vec3f& from, const Vec3f& up, float fov_deg,
                    double aspect);

/// A camera that sees the box from the direction `from`, as near as it can with `margin` (1 = the box just fits).
Camera look_at_box(const Vec3f& low_mm, const Vec3f& high_mm, float margin, const Vec3f& from, const Vec3f& up,
                   float fov_deg, double aspect);

}  // namespace limberg
