#pragma once
// A session with a window: what `limberg run` makes unless it is told not to. Built everywhere; where the program was
// built without a window (LIMBERG_WINDOW=OFF) open_window says so.
#include <memory>
#include <optional>
#include <string>

#include "app/assembly/lesson.h"
#include "app/headset/shared.h"
#include "app/scene/scene.h"
#include "app/session/session.h"
#include "app/teaching/coach.h"
#include "app/words/words.h"

namespace limberg {

struct WindowCall {
  std::string device;       // in words; empty: the mouse alone
  bool own_device = false;  // another device than the mouse, and not a file
  bool calibrated = false;  // a calibration of it was given, or it needs none
  std::string recording;    // the file, or empty
  std::string picture_dir = ".";
  std::vector<Command> script;   // what the lesson shows; may be empty
  std::optional<Lesson> lesson;  // its words, its plan, its tolerances
  LessonMode mode = LessonMode::guided;
  std::string word;                        // said first; may be empty
  bool mouse = true;                       // the mouse uses tools (else it only chooses and looks)
  Words w;                                 // the language of all that is seen
  std::shared_ptr<HeadsetShared> headset;  // its tablet is the window; null: there is none
};

/// The window, its picture sink and its device. Belongs to the main thread, outlives the session.
class SessionWindow {
 public:
  virtual ~SessionWindow() = default;
  virtual PictureSink& sink() = 0;
  /// The mouse and the palette, as a device of a session with these channels.
  virtual std::unique_ptr<Source> pointer(Channels& channels) = 0;
  virtual LaneGauges& gauges() = 0;
  virtual void pump() = 0;
  /// Whether the operator wants to keep the recording that was made in any case.
  virtual bool keep_recording() const = 0;
};

/// RenderUnavailable where no window can be opened.
std::unique_ptr<SessionWindow> open_window(const Scene& scene, const WindowCall& call);

}  // namespace limberg
