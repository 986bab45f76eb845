#pragma once
// The camera in the operator's hand: turn about the point looked at, shift, come nearer. Plain arithmetic, no window.
#include "render/view.h"

namespace limberg {

/// Turns the eye about the target: dx to the right, dy upwards, in radians. It stops short of the poles of `up`.
void turn(Camera& camera, float dx, float dy);
/// Shifts eye and target so that what lies in the target's plane follows the pointer: pixels of a frame so high.
void shift(Camera& camera, float dx_px, float dy_px, int height_px);
/// Comes nearer (factor < 1) or goes away, between 10 mm and 3 m; near and far planes follow.
void approach(Camera& camera, float factor);

}  // namespace limberg
