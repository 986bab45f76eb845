#pragma once
// Whose packets are heard on a link, and with which numbers they go on.
//
// Anybody on this machine can send packets. One with a number far ahead must not make all later ones old, and device
// ids that nobody has must not shut out the real stylus: numbers that jump begin anew where the stream was, and a
// device that was silent for long makes room for another. Numbers of a device that is handed on never fall.
#include <algorithm>
#include <map>
#include <utility>

#include "devices/message_codec.h"

namespace limberg {

class HeardStreams {
 public:
  static constexpr int64_t kSilenceNs = 300'000'000;       // longer than packets linger on a network of one room
  static constexpr int64_t kMostLost = 100'000;            // no number jumps further: a sender has begun anew
  static constexpr int64_t kMostSeq = int64_t(1) << 61;    // no sender counts so far: sums of two stay numbers
  static constexpr int64_t kForgottenNs = 10'000'000'000;  // a device so long silent makes room for another
  using Name = std::pair<int, int32_t>;                    // kind of sample, device id

  /// Whether it is taken; then `seq` is the number with which it goes on and `gap` how many before it are missing.
  bool take(const Name& name, int64_t& seq, int64_t t_ns, bool has_checksum, int64_t& gap) {
    if (seq > kMostSeq) return false;
    Stream* s = at(name, seq, t_ns);
    if (!s || (s->checksums && !has_checksum)) return false;
    // What came before the first checksum was damaged, its number too.
    if (s->started && has_checksum && !s->checksums) s->shift = s->seq + 1 - seq;
    // A sender that was silent and counts from a lower number has begun anew (restarted, plugged in again), and so has
    // one that jumps ahead. Without the silence a lower number is an old packet, or one that came twice.
    if (s->started) {
      const int64_t ahead = seq + s->shift - s->seq;
      if ((ahead <= 0 && t_ns - s->t_ns > kSilenceNs) || ahead > kMostLost) s->shift = s->seq + 1 - seq;
    }
    seq += s->shift;
    if (!s->accept(seq, t_ns, gap)) return false;
    s->checksums |= has_checksum;
    return true;
  }

 private:
  struct Stream : StreamOrder {
    int64_t shift = 0;  // of its numbers, since the sender began anew
  };

  /// Null: there is no room.
  Stream* at(const Name& name, int64_t seq, int64_t t_ns) {
    if (const auto found = streams_.find(name); found != streams_.end()) return &found->second;
    if (streams_.size() >= kMaxStreams) {
      const auto oldest = std::min_element(streams_.begin(), streams_.end(),
                                           [](const auto& a, const auto& b) { return a.second.t_ns < b.second.t_ns; });
      if (t_ns - oldest->second.t_ns < kForgottenNs) return nullptr;
      forgotten_seq_ = std::max(forgotten_seq_, oldest->second.seq);
      streams_.erase(oldest);
    }
    Stream& fresh = streams_[name];
    if (seq <= forgotten_seq_) fresh.shift = forgotten_seq_ + 1 - seq;  // the stream may be one that was forgotten
    return &fresh;
  }

  std::map<Name, Stream> streams_;
  int64_t forgotten_seq_ = -1;  // the highest number of a device that made room
};

}  // namespace limberg
