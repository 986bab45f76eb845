#pragma once
// A headset as a source of views. The renderer draws whatever list of views it is given, so all that a headset adds is
// where each eye is and how far it sees to each side.
//
// With LIMBERG_OPENXR the loader of OpenXR is asked what is there. Drawing into a headset (a session with its frame
// loop and swap chains) is not built: it could not be tried here but with a runtime of our own
// (tests/render/openxr_stub.cpp).
#include <string>

#include "render/view.h"

namespace limberg {

/// Angles from straight ahead, in radians; left and down are negative, as in OpenXR.
struct EyeAngles {
  float left = -0.8f, right = 0.8f, up = 0.8f, down = -0.8f;
};

/// The view of an eye at a place of the world that looks along
/// -z of `turned`, with +y of it upwards. Near and far in mm.
View eye_view(const Vec3f& at_mm, const Eigen::Quaternionf& turned, const EyeAngles& angles, float near_mm = 5,
              float far_mm = 2000);

struct Headset {
  std::string runtime, system;  // their names
  int views = 0;                // 2: stereo
  int width = 0, height = 0;    // of one view, pixels, as the runtime recommends
};

/// The headset that the machine's OpenXR runtime offers. RenderUnavailable says why there is none: built without
/// OpenXR, no runtime, no headset.
Headset find_headset();

}  // namespace limberg
