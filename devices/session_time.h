#pragma once
// A session's time as its sources stamp it, where it may run slower than the wall's: slow motion for a live hand.
//
// SlowedTime is a line with bends: from a moment of the wall on, session time passes at a stated pace, and from a
// stated session time on at the least pace. So whoever falls behind puts the brake before it does, and need not come to
// its end for the clock to slow down. One thread bends the line (the solver's); any number read it, and never wait: a
// reader that was overtaken while it read begins again.
//
// Session time never stands still and never goes back, but for a reader that looked at the wall's clock just before a
// bend: by as much as lies between its look and its reading. Whoever needs more than that keeps its own last time.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

namespace limberg {

class SlowedTime {
 public:
  static constexpr int64_t kWhole = 1000;  // of a pace in thousandths: as fast as the wall's
  static constexpr int64_t kLeast = 200;   // no slower: a hand at 600 mm/s then seems one at 3000 (calibration.h)
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::max();

  /// Session time at a time of the wall; both in ns, and equal until the first bend. Before the newest bend: as if its
  /// pace had been that of the time before.
  int64_t at(int64_t wall_ns) const {
    const Bend b = newest();
    if (b.session_ns >= b.brake_ns) return b.session_ns + slowed(wall_ns - b.wall_ns, kLeast);
    const int64_t t = b.session_ns + slowed(wall_ns - b.wall_ns, b.pace);
    if (t <= b.brake_ns) return t;
    return b.brake_ns + slowed(wall_ns - b.wall_ns - stretched(b.brake_ns - b.session_ns, b.pace), kLeast);
  }
  /// When the wall's clock will have brought session time there, unless the line is bent before; at() of it is not
  /// less.
  int64_t wall_at(int64_t session_ns) const {
    const Bend b = newest();
    if (b.session_ns >= b.brake_ns) return b.wall_ns + stretched(session_ns - b.session_ns, kLeast);
    if (session_ns <= b.brake_ns) return b.wall_ns + stretched(session_ns - b.session_ns, b.pace);
    return b.wall_ns + stretched(b.brake_ns - b.session_ns, b.pace) + stretched(session_ns - b.brake_ns, kLeast);
  }
  /// From `wall_ns` on: the pace in thousandths (within [kLeast, kWhole]), and the session time from which on it is the
  /// least. One thread only, with growing times.
  void bend(int64_t wall_ns, int64_t pace, int64_t brake_ns) {
    const int64_t session_ns = at(wall_ns);
    const uint64_t next = newest_.load() + 1;
    Slot& s = slots_[next % kSlots];
    s.wall_ns = wall_ns, s.session_ns = session_ns, s.pace = std::clamp(pace, kLeast, kWhole), s.brake_ns = brake_ns;
    newest_ = next;
  }

 protected:
  struct Bend {
    int64_t wall_ns, session_ns, pace, brake_ns;
  };
  /// The newest bend, whole. `midway` is called in the midst of each reading, so that a test can overtake it.
  template <class F>
  Bend newest(F&& midway) const {
    for (;;) {
      const uint64_t k = newest_;
      const Slot& s = slots_[k % kSlots];
      Bend b{s.wall_ns, s.session_ns, 0, 0};
      midway();
      b.pace = s.pace, b.brake_ns = s.brake_ns;
      if (newest_ - k < kSlots - 1) return b;  // nobody has begun to write there again
    }
  }

 private:
  struct Slot {
    std::atomic<int64_t> wall_ns{0}, session_ns{0}, pace{kWhole}, brake_ns{kNever};
  };
  static constexpr size_t kSlots = 8;

  Bend newest() const {
    return newest([] {});
  }
  static int64_t slowed(int64_t wall_ns, int64_t pace) {
    const int64_t whole = wall_ns / kWhole, rest = wall_ns % kWhole;  // a day of ns times a thousand is too much
    return whole * pace + rest * pace / kWhole;
  }
  static int64_t stretched(int64_t session_ns, int64_t pace) {  // rounded up
    const int64_t whole = session_ns / pace, rest = session_ns % pace;
    return whole * kWhole + (rest * kWhole + (rest > 0 ? pace - 1 : 0)) / pace;
  }

  std::array<Slot, kSlots> slots_;
  std::atomic<uint64_t> newest_{0};
};

/// What a source with a thread of its own stamps by.
class SourceTime {
 public:
  /// `start_ns`: CLOCK_MONOTONIC at the source's time 0. With `slowed`: time 0 is `from_ns` of the session, which is
  /// also `from_ns` of the line's wall (a session that goes on after an earlier part).
  SourceTime(int64_t start_ns, std::shared_ptr<const SlowedTime> slowed = {}, int64_t from_ns = 0)
      : start_ns_(start_ns), from_ns_(from_ns), slowed_(std::move(slowed)) {}
  /// The wall's time since time 0: for how long a device was silent, how old its readings are.
  int64_t wall_ns(int64_t monotonic_ns) const { return monotonic_ns - start_ns_; }
  /// The stamp of what was read then.
  int64_t stamp_ns(int64_t wall_ns) const { return slowed_ ? slowed_->at(wall_ns + from_ns_) - from_ns_ : wall_ns; }

 private:
  int64_t start_ns_, from_ns_;
  std::shared_ptr<const SlowedTime> slowed_;
};

}  // namespace limberg
