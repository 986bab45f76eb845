#pragma once
// Fourteen teeth a jaw, in occlusion: crowns and the roots' bulges of one half, set along half an ellipse.
//
// Widths (mesiodistal), depths (buccolingual) and heights of crowns: Wheeler's means (Ash and Nelson, Wheeler's dental
// anatomy, tables of each tooth). Third molars are not there.
#include <vector>

#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

class Teeth {
 public:
  enum class Jaw { upper, lower };
  explicit Teeth(Jaw jaw);
  /// Crowns and roots; right half.
  double crowns(const Vec3& q) const;
  double roots(const Vec3& q) const;
  bool near(const Vec3& q, double d) const;
  /// The middle of the incisors' edge.
  Vec3 incisal_mm() const { return incisal_; }

 private:
  struct Tooth {
    Vec3 neck;
    Mat3 axes;  // mesiodistal, buccal, towards the edge
    double wide, deep, high, root;
    int kind;  // 0 incisor, 1 canine, 2 premolar, 3 molar
    double operator()(const Vec3& p) const;
  };
  std::vector<Tooth> tooth_;
  std::vector<Tube> root_;
  Vec3 incisal_ = Vec3::Zero();
};

}  // namespace limberg::anatomical
