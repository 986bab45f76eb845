#pragma once
// From where the window looks at the patient.
#include "app/teaching/lesson_plan.h"
#include "render/view.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// The camera for a picture of this shape: a narrow one sees as much from left to right as one of 5 by 4.
Camera fitted(const Camera& camera, double aspect);

/// On a body that is not flat the first view is of the lesson's plan, wherever the scene's camera looks. False: the
/// camera shows it well, or nothing is planned on skin.
bool look_at_plan(Camera& camera, const LessonPlan& plan, const Snapshot& patient);

/// The eye stays outside of the tissue: on the way from what is looked at it stops 12 mm before the outermost skin.
/// `no_face`: what the face hides counts. `guarded_mm`: the eye when it was kept out last.
void keep_out_of(const Snapshot& patient, bool no_face, Camera& camera, Vec3f& guarded_mm);

}  // namespace limberg
