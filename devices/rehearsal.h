#pragma once
// What a user does while a device is calibrated, with known truth: rehearsals for `limberg calibrate` and its tests.
#include <cstdint>
#include <vector>

#include "devices/fastrak/emulator.h"

namespace limberg {

struct PivotRehearsal {
  uint64_t seed = 1;
  Vec3 tip_mm{2, -3, 130};       // in the sensor's frame
  Vec3 dimple_mm{380, 40, -90};  // in the tracker's
  double cone_deg = 50;          // full opening
  double slips_per_s = 0;        // the tip leaves the dimple by up to slip_mm for a moment
  double slip_mm = 20;
  bool one_plane = false;  // rocked, not turned to all sides
};
/// A stylus on station 1 whose tip stands in a dimple.
fastrak::Motion stylus_in_dimple(const PivotRehearsal& r);

struct TouchRehearsal {
  uint64_t seed = 1;
  Vec3 tip_mm{2, -3, 130};
  Eigen::Quaterniond world_from_tracker = Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized();
  Vec3 world_from_tracker_mm{-320, 60, 140};
  std::vector<Vec3> points_mm;  // in the world, touched in this order, a second each
  Vec3 slip_mm = Vec3::Zero();  // of the first point: touched so far beside it
};
/// A stylus on station 1 that touches points, its switch pressed while it rests on each.
fastrak::Motion stylus_touching(const TouchRehearsal& r);
double seconds_for(const TouchRehearsal& r);

/// A glove on stations 1 and 2 whose forefinger (station 1) or thumb (station 2), as r has its tip, is held on a place
/// while the hand turns about it; the other finger goes along.
fastrak::Motion finger_on_place(const PivotRehearsal& r, int station);

struct PointingRehearsal {
  uint64_t seed = 1;
  Vec3 tip_mm{17, 2, -8};  // of the forefinger, in its sensor's frame
  Vec3 direction = Vec3(0.94, 0.1, -0.32).normalized();
  Vec3 place_mm{380, 40, -90};  // in the tracker's
  double cone_deg = 60;         // of the directions that it points from, full opening
  double aim_deg = 0.7;         // how far beside the place it points, per axis
};
/// A glove on stations 1 and 2 whose forefinger points at one place from 150 to 300 mm, from several sides.
fastrak::Motion pointing_at_place(const PointingRehearsal& r);

/// A glove on stations 1 and 2 that is opened and closed every two seconds, in motion; tips at the sensors.
fastrak::Motion glove_opening(uint64_t seed, double closed_mm, double open_mm);

}  // namespace limberg
