#pragma once
// A headset as a source of views. The renderer draws whatever list of views it is given, so all that a headset adds is
// where each eye is and how far it sees to each side.
// The room, the session and the hands are the program's (app/headset).
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

}  // namespace limberg
