#pragma once
// Ambient occlusion from the depth of a finished picture: creases, wound
// corners and what lies under a flap see little of the room and are darker.
//
// Two passes. The first, at half the size, looks from each pixel at twelve others
// on a spiral around it: each one that stands above the pixel's tangent plane
// hides some of the sky, the steeper the more, and less the farther it is (the
// estimate of McGuire, Osman, Bukowski and Hennessy 2011, with a falloff of ours).
// The spiral is turned from pixel to pixel in a pattern of 2 x 2. The second pass
// averages that pattern where the depth agrees, and multiplies the picture.
//
// How far is looked grows with the distance of the eye: a wound under the lamp shows its corners, a skull its orbits.
#include <memory>

#include "render/gl_objects.h"

namespace limberg {

class Occlusion {
 public:
  explicit Occlusion(const GlFunctions& gl);
  /// Darkens the part of the target that the view fills. Changes the
  /// bound framebuffer, viewport, blending and texture unit 0 and 1.
  void darken(const GlTarget& target, const View& view, const GlMesh& one_triangle);

  /// A pixel looks so far around it, as a share of its distance from the eye.
  static constexpr float kReach = 0.035f;

 private:
  const GlFunctions& gl_;
  GlProgram look_, darken_;
  std::unique_ptr<GlLayer> half_;
};

}  // namespace limberg
