#pragma once
// What a frame gets besides the scene when it is drawn for a headset: a picture on a board in the room (the tablet with
// the panels), and a copy of the frame in a texture of somebody else's.
#include <cstdint>
#include <map>
#include <memory>

#include "render/gl_functions.h"
#include "render/image.h"
#include "render/view.h"

namespace limberg {

/// A rectangle in the world, seen from its front: `right` and `up` reach from its centre to its sides.
struct BoardPlace {
  Vec3f centre_mm = Vec3f::Zero(), right_mm = Vec3f::UnitX(), up_mm = Vec3f::UnitY();
  Vec3f normal() const { return right_mm.cross(up_mm).normalized(); }
  /// Where a ray meets its front: shares of its width and height from the top left corner, and the way to there. False:
  /// it does not.
  bool meets(const Vec3f& from_mm, const Vec3f& towards, float& u, float& v, float& way_mm) const;
};

class Board {
 public:
  /// The context of these functions must be current here and wherever it is used.
  explicit Board(const GlFunctions& gl);
  ~Board();
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;
  void show(const Image& image);
  bool empty() const { return width_ == 0; }
  /// Into the frame that is bound, which has a depth: what stands before it hides it. u, v: a dot there, unless
  /// negative.
  void paint(const View& view, const BoardPlace& place, int width, int height, float u = -1, float v = -1);

 private:
  const GlFunctions& gl_;
  GLuint program_ = 0, array_ = 0, texture_ = 0;
  int width_ = 0, height_ = 0;
};

/// Copies the frame that is bound to a texture that is another's, enlarged where it is larger. The bytes stay as they
/// are, whatever the texture calls them: pictures are sRGB.
class TextureCopy {
 public:
  explicit TextureCopy(const GlFunctions& gl) : gl_(gl) {}
  ~TextureCopy();
  TextureCopy(const TextureCopy&) = delete;
  TextureCopy& operator=(const TextureCopy&) = delete;
  void copy(int from_width, int from_height, GLuint texture, int width, int height);

 private:
  const GlFunctions& gl_;
  std::map<GLuint, GLuint> frame_;  // of a texture
};

}  // namespace limberg
