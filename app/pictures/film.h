#pragma once
// A film of a session: every frame of a replay on a virtual clock, through ffmpeg as a child process. What takes long
// to draw only makes the film later, never worse. What takes the time is drawing in software, pixel by pixel: a film is
// drawn with one sample a pixel unless it is to be fine, a frame that looks like the one before it is not drawn again,
// and while a thread of the film's own draws a frame the session goes on to the next.
#include <memory>
#include <string>

#include "app/scene/scene.h"
#include "app/session/picture_sink.h"
#include "app/words/words.h"

namespace limberg {

struct FilmSettings {
  std::string file;  // .mp4 (H.264) or .webm (VP9)
  int frames_per_s = 20;
  int width = 1280, height = 720;  // even
  Words w{};                       // of the titles
  bool fine = false;               // edges as smooth as those of the report's pictures: four samples a pixel
};

/// Where the time of a film went, in s. drawn: how many of the frames were.
struct FilmTimes {
  int frames = 0, drawn = 0;
  double drawing_s = 0, encoding_s = 0;  // encoding: handing frames to ffmpeg, and waiting for it
};

class Film final : public PictureSink {
 public:
  /// InputError: an unknown ending, a folder that cannot be written to, or no ffmpeg on this machine.
  Film(const Scene& scene, const FilmSettings& settings);
  ~Film() override;  // a film that was not finished is taken away; what had the name before stays

  void prepare(const SurfaceTopology& first) override;  // RenderUnavailable when nothing can be drawn
  void second_hand(const SecondHand& hand, const SecondHand& other) override;
  void frame(const Snapshot& snapshot, const ToolState& tool) override;
  void same_frame() override;
  void stage(const std::string& name, const Snapshot& snapshot) override;  // its name is the title from now on
  bool wants_frame() override;                                             // for a new title
  bool open() const override;
  void finish() override;

  /// Closes the film and gives it its name. InputError when ffmpeg did not take it all.
  void close();
  const FilmTimes& times() const;  // after finish()

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
