#pragma once
// Draws a session for a headset's eyes: the newest patient and hands, a table and a floor below it, the tablet. Belongs
// to the headset's drawing thread.
#include <memory>
#include <mutex>
#include <optional>

#include "app/headset/room.h"
#include "app/headset/session.h"
#include "app/headset/shared.h"
#include "render/quality.h"
#include "render/render_scene.h"
#include "render/renderer.h"

namespace limberg {

struct EyesSettings {
  RoomSettings room;
  int level = -1;  // of kQualityLevels; -1: what the time of a frame allows
};

/// Where the patient lies, from whoever puts it to whoever needs it.
class SharedPlace {
 public:
  void set(const PatientPlace& place, const BoardPlace& tablet) {
    const std::lock_guard lock(mutex_);
    place_ = place, tablet_ = tablet;
  }
  bool get(PatientPlace& place, BoardPlace& tablet) const {
    const std::lock_guard lock(mutex_);
    if (place_) place = *place_, tablet = tablet_;
    return place_.has_value();
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    place_.reset();
  }
  std::atomic<float> dot_u{-1}, dot_v{-1};  // where the tablet is pointed at

 private:
  mutable std::mutex mutex_;
  std::optional<PatientPlace> place_;
  BoardPlace tablet_;
};

class Eyes final : public HeadsetPainter {
 public:
  /// The context is made current here.
  Eyes(std::unique_ptr<GlContext> context, HeadsetShared& shared, SharedPlace& place, const EyesSettings& settings,
       bool floor);
  ~Eyes() override;
  bool begin(const HeadsetFrame& frame) override;
  void eye(int which, unsigned texture, int width, int height) override;
  int64_t frames() const { return frames_; }
  /// What both eyes of a frame have taken so far, on average.
  double mean_ms() const { return frames_ > 0 ? double(all_ns_) * 1e-6 / double(frames_) : 0; }

 private:
  const RenderScene& build();
  void put(const RoomPose& head);
  void time_frame(const HeadsetFrame& frame);

  HeadsetShared& shared_;
  SharedPlace& place_;
  EyesSettings set_;
  bool floor_;
  Renderer renderer_;
  Board board_;
  TextureCopy copy_;
  SceneBuilder builder_;
  QualityLadder ladder_;
  HeadsetFrame frame_;
  PatientPlace patient_;
  BoardPlace tablet_;
  PropMesh room_;
  std::array<View, 2> view_;
  const RenderScene* scene_ = nullptr;
  std::shared_ptr<const Image> on_tablet_;
  int64_t tablet_version_ = 0, frames_ = 0, began_ns_ = 0, took_ns_ = 0, all_ns_ = 0, seen_ns_ = 0;
  bool placed_ = false;
};

/// The views of a frame's eyes in the patient's frame; near and far planes as a room needs them.
std::array<View, 2> views_of(const HeadsetFrame& frame, const PatientPlace& place);
/// How far below the patient the floor is; where it is not known, a table's height.
double floor_below_m(const PatientPlace& place, bool floor);
/// What is drawn for a headset: no background that goes with the head.
DrawOptions eye_options(const QualityLevel& level, int width, int height);

}  // namespace limberg
