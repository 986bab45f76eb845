#pragma once
// Where the patient lies in the room of a headset. The room is in metres with y upwards, as OpenXR has it; the patient
// in mm. Whoever looks or works is carried into the patient's frame, so that pictures, recordings and gestures are
// those of any other session: nothing after this knows of a room.
//
//   x_patient = anchor + (1000 / scale) R (x_room - at)
//
// `scale`: how many times larger than life the patient lies there; a hand then goes so much less far in the patient.
#include "app/headset/room_pose.h"
#include "render/board.h"
#include "render/props.h"
#include "render/view.h"
#include "sim/geometry/vec.h"

namespace limberg {

struct RoomSettings {
  double scale = 2;       // times life size: a headset has a third of a screen's pixels for a degree
  double table_m = 1.00;  // height of what is operated on above the floor
  double reach_m = 0.35;  // from the head to it, along the floor
  double below_m = 0.35;  // it lies at least so far below the eyes of one who sits
};

class PatientPlace {
 public:
  PatientPlace() = default;
  Vec3 to_patient(const Vec3& room_m) const { return anchor_mm_ + mm_per_m_ * (turn_ * (room_m - at_m_)); }
  Eigen::Quaterniond to_patient(const Eigen::Quaterniond& q) const {
    return (Eigen::Quaterniond(turn_) * q).normalized();
  }
  Vec3 direction(const Vec3& room) const { return turn_ * room; }
  Vec3 to_room(const Vec3& x_mm) const { return at_m_ + turn_.transpose() * (x_mm - anchor_mm_) / mm_per_m_; }
  double mm_per_m() const { return mm_per_m_; }
  const Vec3& at_m() const { return at_m_; }    // of the patient, in the room
  const Vec3& ahead() const { return ahead_; }  // from the person to the patient, along the floor; unit

  /// Before a person whose head is there: what the scene's camera looks at lies within reach at the height of a table,
  /// seen from the side from which the camera sees it, with the camera's `up` upwards. The head's tilt does not matter.
  /// `floor`: whether y = 0 is the floor; else the eyes are what is known.
  static PatientPlace before(const RoomPose& head, bool floor, const Camera& camera, const RoomSettings& settings);

 private:
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();  // patient from room
  Vec3 at_m_ = Vec3::Zero(), anchor_mm_ = Vec3::Zero(), ahead_ = -Vec3::UnitZ();
  double mm_per_m_ = 1000;
};

/// Floor and table below a patient, in the patient's frame. `low`, `high`: the box around the tissue.
PropMesh room_props(const PatientPlace& place, const Vec3f& low_mm, const Vec3f& high_mm, double floor_below_m);

/// The tablet: behind the patient to the left, turned to the person.
BoardPlace tablet_place(const PatientPlace& place, const RoomPose& head, double width_over_height);

}  // namespace limberg
