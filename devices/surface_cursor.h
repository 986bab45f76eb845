#pragma once
// The surface cursor: a place of the surface that the hand pushes about.
//
// What the hand travels from tick to tick, times the gain, moves the cursor along the surface (surface_walk.h). So it
// goes wherever the surface goes: over edges, into folds, round to the hidden side with a gesture round the object; and
// it is as precise as the gain is small, whatever the tracker's absolute error. With the clutch down the hand moves and
// the cursor stays, bit for bit; tracking that is lost and comes back does not move it either.
//
// The cursor is a material place: it moves with the skin between two ticks. When a cut changes the topology it is found
// again at the same place at rest; when that place was cut away, at the nearest that is left.
//
// It leaves a path of places at rest (chart points for incisions, rest points for contours of any surface), at least
// step_mm apart; when its room is used up every second is left out and the steps double.
#include <cstdint>
#include <vector>

#include "devices/surface_walk.h"
#include "devices/tracking.h"

namespace limberg {

struct CursorSettings {
  double gain = 0.25;  // of the hand's way; 0.05 to 2
  Ground ground = Ground::skin;
  double step_mm = 0.4;  // of the path, at rest
};

struct CursorPoint {
  ChartPoint chart{0, 0};
  Vec3 X_mm = Vec3::Zero();  // at rest
  Vec3 x_mm = Vec3::Zero();  // where it was when it was drawn
};

class SurfaceCursor {
 public:
  static constexpr size_t kPathPoints = 4096;
  static constexpr double kMostPerTick_mm = 20;  // of the hand: a longer way is no motion but a new start

  explicit SurfaceCursor(const CursorSettings& settings = {});
  void set_gain(double gain);
  double gain() const { return set_.gain; }
  /// What its surface is; it is put anew when that changes.
  void set_ground(Ground ground);

  /// Puts it at the place nearest to x_mm. False: there is no surface.
  bool put(const Snapshot& s, const Vec3& x_mm);
  /// Puts it at a place that was pointed at.
  bool put(const Snapshot& s, const SurfacePlace& place);
  void remove() { placed_ = false; }
  bool placed() const { return placed_; }

  /// One tick: the hand is here. `drawing`: the path grows; it begins anew when drawing begins.
  void tick(const Snapshot& s, const Pose& hand, bool clutch, bool drawing);

  const SurfacePlace& place() const { return place_; }
  const Vec3& x_mm() const { return x_; }
  const Vec3& X_mm() const { return X_; }
  const Vec3& normal() const { return normal_; }

  size_t path_size() const { return path_n_; }
  const CursorPoint& path(size_t i) const { return path_[i]; }
  int64_t moved_by_cuts() const {
    return relocated_;
  }  // how often it had to be found anew, further than a micrometre off

 private:
  bool follow_topology(const Snapshot& s);
  void look(const Snapshot& s);
  void note(const Snapshot& s, bool first);

  CursorSettings set_;
  SurfaceWalk walk_;
  SurfacePlace place_;
  uint64_t version_ = 0;  // of the topology that place_ is of
  bool placed_ = false, hand_known_ = false, was_drawing_ = false;
  Vec3 hand_ = Vec3::Zero(), left_ = Vec3::Zero();  // left_: of the last tick's way, when it had too many crossings
  Vec3 x_ = Vec3::Zero(), X_ = Vec3::Zero(), normal_ = Vec3::UnitZ();
  std::vector<CursorPoint> path_;
  size_t path_n_ = 0;
  double step_ = 0.4;
  int64_t relocated_ = 0;
};

}  // namespace limberg
