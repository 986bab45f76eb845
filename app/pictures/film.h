#pragma once
// A film of a session: every frame of a replay on a virtual clock, through ffmpeg as a child process. What takes long
// to draw only makes the film later, never worse.
#include <memory>
#include <string>

#include "app/scene/scene.h"
#include "app/session/picture_sink.h"

namespace limberg {

struct FilmSettings {
  std::string file;  // .mp4 (H.264) or .webm (VP9)
  int frames_per_s = 25;
  int width = 1280, height = 720;  // even
};

class Film final : public PictureSink {
 public:
  /// InputError: an unknown ending, a folder that cannot be written to, or no ffmpeg on this machine.
  Film(const Scene& scene, const FilmSettings& settings);
  ~Film() override;  // a film that was not finished is taken away; what had the name before stays

  void prepare(const SurfaceTopology& first) override;  // RenderUnavailable when nothing can be drawn
  void second_hand(const SecondHand& hand, const SecondHand& other) override;
  void frame(const Snapshot& snapshot, const ToolState& tool) override;
  void stage(const std::string& name, const Snapshot& snapshot) override;  // its name is the title from now on
  bool wants_frame() override { return true; }
  bool open() const override;
  void finish() override;

  /// Closes the film and gives it its name. InputError when ffmpeg did not take it all.
  void close();
  int frames() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
