#pragma once
// What passes between a headset's threads and the rest of a session with one.
//
//   solver, device ──Channels: the patient, the hands──► its drawing thread
//   window (render thread) ──picture of the window─────► its drawing thread: the tablet
//   its reading thread ──ring: events on the tablet────► window (main thread)
//   both of its threads ──words────────────────────────► main thread
//
// The device thread takes samples from a ring alone (headset_source.h).
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "app/session/channels.h"
#include "devices/spsc_ring.h"
#include "render/image.h"
#include "render/view.h"

namespace limberg {

/// A press or a movement on the tablet, in shares of the window's width and height.
struct TabletEvent {
  float u = 0, v = 0;
  bool button = false;  // it is about the button
  bool down = false;
};

/// The newest picture of the window.
class TabletPicture {
 public:
  void show(std::shared_ptr<const Image> image) {
    const std::lock_guard lock(mutex_);
    image_ = std::move(image);
    ++version_;
  }
  /// Null: nothing newer than `version`.
  std::shared_ptr<const Image> newer(int64_t& version) const {
    const std::lock_guard lock(mutex_);
    if (version == version_) return nullptr;
    version = version_;
    return image_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Image> image_;
  int64_t version_ = 0;
};

/// Words for the person, in their order; the same are not said twice in a row.
class HeadsetWords {
 public:
  void say(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (line == last_) return;
    last_ = line;
    waiting_.push_back(line);
  }
  bool waiting() const {
    const std::lock_guard lock(mutex_);
    return !waiting_.empty();
  }
  bool take(std::string& line) {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return false;
    line = std::move(waiting_.front());
    waiting_.pop_front();
    return true;
  }

 private:
  mutable std::mutex mutex_;
  std::deque<std::string> waiting_;
  std::string last_;
};

/// Of a session; its headset holds it too.
struct HeadsetShared {
  Channels* channels = nullptr;     // until `over`; null: nothing is drawn
  Camera camera;                    // of the scene: from where the person looks
  std::atomic<bool> over{false};    // the session has ended
  std::atomic<bool> worn{false};    // it has the hands: somebody looks at the tablet
  std::atomic<bool> wanted{true};   // it is looked for, and drawn to
  bool takes_over = false;          // its stylus is the one that is followed while somebody wears it
  HeadsetWords words, shown_words;  // for the terminal; for the window
  TabletPicture tablet;
  SpscRing<TabletEvent> events{1 << 9};
};

}  // namespace limberg
