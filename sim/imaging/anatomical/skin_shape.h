#pragma once
// The skin of the anatomical head as a signed distance, with globes, lids, nose, lips and ears.
#include <cstdint>
#include <memory>

#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

/// Lids and globe as one surface; or lids of the right eye that are closed and have no globe (Eye::fissure and
/// Eye::globe_mm part them).
enum class RightLids : uint8_t { upon_globe, bare };

class SkinShape {
 public:
  explicit SkinShape(RightLids right = RightLids::upon_globe);
  ~SkinShape();
  /// mm, below 0 inside; grows by no more than kLipschitz a mm.
  double operator()(const Vec3& p) const;
  /// The braincase's skin alone: as above, without face, nape and neck.
  double cranium(const Vec3& p) const;
  static constexpr double kLipschitz = 1.9;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
  bool bare_;
};

}  // namespace limberg::anatomical
