#pragma once
// Acts in space of a plan that a hand will say on the chart.
#include "app/teaching/lesson_plan.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// An act whose places are given in space becomes the same on the chart where the chart sees all of them, as the hand's
/// act there does (devices/hand_ground.h), so that the two can be compared. `uncut`: the patient before anything was
/// done. Others stay as they are.
void say_on_chart(LessonPlan& plan, const Snapshot& uncut);

}  // namespace limberg
