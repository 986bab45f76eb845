#pragma once
// What the picture of the patient shows, so that it is drawn again only when it would look different. A frame in which
// only a panel has changed is the old picture with new panels.
#include <cstring>
#include <vector>

#include "app/session/visible.h"
#include "app/window/desk.h"
#include "render/renderer.h"

namespace limberg {

/// Everything beside the scene that a picture hangs on, at a fixed level of quality.
struct PictureWish {
  View view;
  DrawOptions options;
  Compare compare = Compare::off;
  Stereo stereo = Stereo::off;
  float wipe = 0;
  int quality = 0;

  bool operator==(const PictureWish& b) const {
    return view.to_eye == b.view.to_eye && view.projection == b.view.projection && view.x0 == b.view.x0 &&
           view.x1 == b.view.x1 && view.y0 == b.view.y0 && view.y1 == b.view.y1 && options == b.options &&
           compare == b.compare && stereo == b.stereo && wipe == b.wipe && quality == b.quality;
  }
};

class Painted {
 public:
  /// Whether a picture of this scene would differ from the one that was noted: tissue that has moved by less than
  /// kVisible_mm (visible.h) does not count.
  bool shows(const RenderScene& s, const PictureWish& wish) const {
    if (!valid_ || !(wish == wish_) || s.mesh != mesh_ || !same(s.field, field_) || !same(s.lines.x_mm, lines_) ||
        s.props.vertex.size() != props_.size())
      return false;
    for (size_t v = 0; v < props_.size(); ++v) {
      const PropVertex &a = s.props.vertex[v], &b = props_[v];
      if (visibly_moved(a.x_mm, b.x_mm) || a.id != b.id || a.colour != b.colour || a.metal != b.metal) return false;
    }
    return !visibly_moved(s.x_mm, x_mm_);
  }
  void note(const RenderScene& s, const PictureWish& wish) {
    valid_ = true, wish_ = wish, mesh_ = s.mesh;
    x_mm_ = s.x_mm, field_ = s.field, lines_ = s.lines.x_mm, props_ = s.props.vertex;
  }
  void forget() { valid_ = false; }

 private:
  template <class T>
  static bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
  }
  bool valid_ = false;
  PictureWish wish_;
  std::shared_ptr<const TissueMesh> mesh_;
  std::vector<Vec3f> x_mm_, lines_;
  std::vector<float> field_;
  std::vector<PropVertex> props_;
};

}  // namespace limberg
