#pragma once
// The window as the session's picture sink: the patient, the panels over it, and what the operator does with both.
//
// The patient is drawn when it would look different from before (painted.h), else only the panels are. While things
// move the quality is what the time of a frame allows (quality.h); when nothing has moved for a while the picture is
// drawn once more with shadows and occlusion.
//
// Lives on the render thread. What a person does to the patient does not pass through here but through InputRouter
// (input_router.h), on the main thread; here are the camera, the panels and the ruler. What is chosen on a panel goes
// back to the InputRouter.
#include <memory>
#include <optional>
#include <string>

#include "app/headset/shared.h"
#include "app/session/picture_sink.h"
#include "app/window/desk.h"
#include "app/window/hand_feed.h"
#include "app/window/screen.h"
#include "render/image.h"

namespace limberg {

struct WindowSettings {
  DeskFacts facts;
  Camera camera;                  // the first view
  std::string picture_dir = ".";  // where pictures asked for are put: limberg-1.png, never replacing a file
  std::optional<LessonPlan> lesson = {};
  LessonMode mode = LessonMode::guided;
  std::string memory_file = {};  // what is remembered (desk_memory.h); empty: nothing, and there is no tour
  std::shared_ptr<HeadsetShared> headset = nullptr;  // its tablet shows the window's frames; null: there is none
};

class WindowFrames final : public PictureSink {
 public:
  /// All three must outlive it; `gauges` may be null.
  WindowFrames(Screen& screen, HandFeed& feed, const LaneGauges* gauges, WindowSettings settings);
  ~WindowFrames() override;

  void prepare(const SurfaceTopology& first) override;
  void second_hand(const SecondHand& hand, const SecondHand& other) override;
  void frame(const Snapshot& snapshot, const ToolState& tool) override;
  void stage(const std::string&, const Snapshot&) override {}
  void notice(const Notice& notice) override;
  void missed(const MissedPress& press, const Snapshot& snapshot) override;
  bool wants_frame() override;
  bool wants_lattice() const override;
  void lattice(const LatticeShown& lattice) override;
  void finish() override;
  bool open() const override { return screen_.open; }

  /// The frame drawn last, and how often the patient was drawn for one: for tests.
  Image picture();
  int64_t patient_drawn() const;
  /// Null: there is no lesson.
  const Coach* coach() const;
  /// Of the tour, from 1; 0: it is not open. For tests.
  int tour_card() const;

 private:
  struct Impl;
  Screen& screen_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
