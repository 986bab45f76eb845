#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "devices/message_codec.h"
#include "devices/recording.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int32_t kMaxBlobs = 256, kMaxPieces = 65'536;

/// An embedded file while its pieces come in. Pieces come in order; memory grows with what is there, not with what a
/// header promises.
struct OpenBlob {
  Blob blob;
  int32_t kind = 0, total = 0, next = 0;
  int64_t bytes = 0;
  bool broken = false;
};

class Reader {
 public:
  explicit Reader(LogReader& log) : log_(log) {}

  Recording read() {
    LogEvent e;
    while (log_.next(e)) {
      const char* wrong = nullptr;
      bool ours = true;
      if (e.channel == kStylusChannel)
        wrong = sample<limberg_msg::stylus_t, StylusSample>(e);
      else if (e.channel == kControlChannel)
        wrong = sample<limberg_msg::control_t, ControlSample>(e);
      else if (e.channel == kCommandChannel)
        wrong = sample<limberg_msg::command_t, CommandSample>(e);
      else if (e.channel == kTrackerChannel)
        wrong = sample<limberg_msg::tracker_t, TrackerSample>(e);
      else if (e.channel == kRawChannel)
        wrong = sample<limberg_msg::raw_t, RawSample>(e);
      else if (e.channel == kSessionChannel)
        wrong = session(e);
      else if (e.channel == kChunkChannel)
        wrong = chunk(e);
      else if (e.channel == kCheckpointChannel)
        wrong = checkpoint(e);
      else if (e.channel == kStateChannel)
        wrong = state(e);
      else if (e.channel == kScheduleChannel)
        wrong = schedule(e);
      else if (e.channel == kEndChannel)
        wrong = end(e);
      else
        ours = false;
      if (!ours) {
        ++log_.damage().unknown_channel;
      } else if (wrong == kOutOfOrder) {
        ++log_.damage().out_of_order;
        note(e, wrong);
      } else if (wrong) {
        ++log_.damage().bad_payload;
        note(e, wrong);
      } else {
        ++r_.events;
      }
    }
    leave_out_unchecked();
    // Only we write sessions: a name that is not known there was one of ours.
    if (r_.session && log_.damage().unknown_channel > 0) {
      log_.damage().bad_payload += log_.damage().unknown_channel;
      if (log_.damage().first_message.empty()) log_.damage().first_message = "a channel that no session has";
    }
    if (!r_.end) trim_schedule();
    for (auto& [index, b] : open_) {
      if (!b.broken && b.next == b.total && int64_t(b.blob.data.size()) == b.bytes)
        r_.blobs.push_back(std::move(b.blob));
      else
        incomplete_ = true;
    }
    if (incomplete_ && log_.damage().total() == 0) {
      ++log_.damage().bad_payload;
      log_.damage().first_message = "an embedded file is not whole";
    }
    r_.damage = log_.damage();
    return std::move(r_);
  }

 private:
  static constexpr const char* kNoChecksum = "no checksum in a stream that has them";
  static constexpr const char* kOutOfOrder = "sequence or time does not grow";
  static constexpr const char* kTooLate = "later than a day after the beginning";

  /// Samples without a checksum in front of the first one that has it, in a stream that has them: damaged as well.
  void leave_out_unchecked() {
    size_t out = 0, next = 0;
    for (size_t i = 0; i < r_.samples.size(); ++i) {
      if (next < unchecked_.size() && unchecked_[next].first == i) {
        const int64_t offset = unchecked_[next++].second;
        if (checksums_[r_.samples[i].index()]) {
          ++log_.damage().bad_payload, --r_.events;
          if (log_.damage().first_message.empty())
            log_.damage().first_message = std::string(kNoChecksum) + " in the event at byte " + std::to_string(offset);
          continue;
        }
      }
      if (out != i) r_.samples[out] = r_.samples[i];
      ++out;
    }
    r_.samples.resize(out);
  }

  void note(const LogEvent& e, const char* wrong) {
    if (log_.damage().first_message.empty())
      log_.damage().first_message =
          std::string(e.channel) + ": " + wrong + " in the event at byte " + std::to_string(e.offset);
  }

  template <class M, class S>
  const char* sample(const LogEvent& e) {
    M m;
    S s;
    bool has_checksum = false;
    if (const char* wrong = decode_message(e.data, e.size, m, &has_checksum)) return wrong;
    if (const char* wrong = to_sample(m, s)) return wrong;
    const size_t kind = Sample(S{}).index();
    const std::tuple<size_t, int, int32_t> stream{kind, stream_of(s), s.device_id};
    if (!order_.contains(stream) && order_.size() >= kMaxRecordedStreams) return "too many devices";
    int64_t gap = 0;
    // Damage that moves bytes can leave a message that says that it has no checksum, and can change whose it is: where
    // one message of a channel has a checksum, all must have.
    if (checksums_[kind] && !has_checksum) return kNoChecksum;
    // What came before the first checksum is damaged too (leave_out_unchecked()); its numbers put nothing behind it.
    if (has_checksum && !checksums_[kind])
      std::erase_if(order_, [&](const auto& o) { return std::get<0>(o.first) == kind; });
    checksums_[kind] |= has_checksum;
    if (!order_[stream].accept(s.seq, s.t_ns, gap)) return kOutOfOrder;
    log_.damage().stream_gaps += std::min(gap, LogDamage::kMostMissing);
    if (!has_checksum) unchecked_.emplace_back(r_.samples.size(), e.offset);
    r_.samples.push_back(s);
    return nullptr;
  }

  const char* session(const LogEvent& e) {
    limberg_msg::session_t m;
    if (const char* wrong = decode_message(e.data, e.size, m)) return wrong;
    if (r_.session) return "a second session in one file";
    if (m.format_version != SessionInfo::kFormat) return "unknown recording format";
    constexpr int64_t kSecond = 1'000'000'000;
    if (m.tick_ns <= 0 || m.tick_ns > kSecond || m.ticks_per_solver_step <= 0 || m.ticks_per_solver_step > 1000 ||
        m.ticks_per_frame <= 0 || m.ticks_per_frame > 100'000 || m.solver_delay_ticks < 0 ||
        m.solver_delay_ticks > 1000)
      return "rates that cannot be";
    SessionInfo s;
    s.program = get_text(m.program);
    s.scene_name = get_text(m.scene_name);
    s.scene_hash = uint64_t(m.scene_hash);
    s.calibration_hash = uint64_t(m.calibration_hash);
    for (size_t i = 0; i < 4; ++i) s.seeds[i] = uint64_t(m.seeds[i]);
    s.tick_ns = m.tick_ns;
    s.ticks_per_solver_step = m.ticks_per_solver_step;
    s.ticks_per_frame = m.ticks_per_frame;
    s.solver_delay_ticks = m.solver_delay_ticks;
    s.utc_start_ns = m.utc_start_ns;
    r_.session = s;
    return nullptr;
  }

  const char* chunk(const LogEvent& e) {
    limberg_msg::chunk_t m;
    if (const char* wrong = decode_message(e.data, e.size, m)) return wrong;
    if (m.blob < 0 || m.blob >= kMaxBlobs || m.total < 1 || m.total > kMaxPieces || m.index < 0 || m.index >= m.total ||
        m.bytes < 0 || m.kind < int32_t(BlobKind::scene) || m.kind > int32_t(BlobKind::tissues))
      return "a piece of a file that cannot be";
    const int64_t before = int64_t(m.index) * int64_t(kPiece);
    const int64_t expected = std::min<int64_t>(int64_t(kPiece), m.bytes - before);
    if (m.n != expected || m.n < 0 || (m.index + 1 < m.total) != (before + m.n < m.bytes))
      return "a piece of a file of the wrong length";
    OpenBlob& b = open_[m.blob];
    if (m.index == 0 && b.next == 0) {
      b.blob.kind = BlobKind(m.kind);
      b.blob.name = get_text(m.name);
      b.kind = m.kind;
      b.total = m.total;
      b.bytes = m.bytes;
    }
    if (b.next != m.index || b.kind != m.kind || b.total != m.total || b.bytes != m.bytes) {
      b.broken = true;
      return "a piece of a file out of turn";
    }
    b.blob.data.append(reinterpret_cast<const char*>(m.data), size_t(m.n));
    ++b.next;
    return nullptr;
  }

  const char* checkpoint(const LogEvent& e) {
    limberg_msg::checkpoint_t m;
    if (const char* wrong = decode_message(e.data, e.size, m)) return wrong;
    if (m.tick < 0) return "negative tick";
    if (m.tick > kMostTicks) return kTooLate;
    if (!r_.checkpoints.empty() && m.tick < r_.checkpoints.back().tick) return kOutOfOrder;
    r_.checkpoints.push_back({m.tick, uint64_t(m.hash)});
    return nullptr;
  }

  const char* state(const LogEvent& e) {
    limberg_msg::state_t m;
    if (const char* wrong = decode_message(e.data, e.size, m)) return wrong;
    StateSample s;
    if (m.n < 0 || m.n > StateSample::kPlaces || m.vertices < m.n || m.step < 1) return "places that cannot be";
    if (!r_.states.empty() && m.step <= r_.states.back().step) return kOutOfOrder;
    s.step = m.step, s.topology = uint64_t(m.topology), s.vertices = m.vertices, s.n = m.n;
    for (size_t k = 0; k < size_t(m.n); ++k)
      for (size_t j = 0; j < 3; ++j) {
        if (!std::isfinite(m.at_mm[k][j])) return "a place that is no number";
        s.at_mm[k][j] = m.at_mm[k][j];
      }
    if (!std::isfinite(m.sutures_N) || !std::isfinite(m.hooks_N)) return "a force that is no number";
    s.sutures_N = m.sutures_N, s.hooks_N = m.hooks_N;
    r_.states.push_back(s);
    return nullptr;
  }

  /// Of a session that was cut short: as much as is known for certain. Ticks whose samples are in the file, steps
  /// before which all ticks are known, and ticks before which all steps are.
  void trim_schedule() {
    std::vector<DeviceRun>& ticks = r_.schedule.device;
    std::vector<SolverTake>& steps = r_.schedule.solver;
    size_t samples = 0, n = 0;
    for (; n < ticks.size() && samples + size_t(ticks[n].samples) <= r_.samples.size(); ++n)
      samples += size_t(ticks[n].samples);
    ticks.resize(n);
    const int64_t known = ticks.empty() ? 0 : ticks.back().snapshot;
    while (!steps.empty() && steps.back().step > known) steps.pop_back();
    // Ticks that saw what came of a step that was not written down any more.
    const int64_t done = steps.empty() ? 0 : steps.back().step;
    while (!ticks.empty() && ticks.back().snapshot > done) ticks.pop_back();
  }

  /// A schedule from which a row is missing is of no use, and says so; the rest of the recording is not the worse for
  /// it.
  const char* schedule(const LogEvent& e) {
    limberg_msg::schedule_t m;
    const char* wrong = decode_message(e.data, e.size, m);
    if (!wrong && (m.kind < 1 || m.kind > 3 || m.n < 0 || m.n > int32_t(std::size(m.row))))
      wrong = "rows that cannot be";
    if (!wrong && m.kind == 3) return r_.schedule.broken = true, nullptr;
    if (!wrong && m.seq != schedule_seq_[m.kind - 1]) wrong = kOutOfOrder;
    for (int32_t i = 0; !wrong && i < m.n; ++i)
      if (!(m.kind == 1 ? device_row(m.row[i]) : solver_row(m.row[i]))) wrong = "rows that cannot be";
    if (wrong)
      r_.schedule.broken = true;
    else
      ++schedule_seq_[m.kind - 1];
    return wrong;
  }

  bool device_row(const int64_t* row) {
    const DeviceRun r{row[0], row[1], int32_t(row[2]), int32_t(row[3])};
    std::vector<DeviceRun>& all = r_.schedule.device;
    const bool follows = all.empty()
                             ? r.tick >= 0 && r.snapshot >= 0
                             : r.tick >= all.back().tick + all.back().count && r.snapshot >= all.back().snapshot;
    if (!follows || row[2] < 1 || row[2] > kMaxRun || row[3] < 0 || row[3] > kMaxRun || r.tick > kMostTicks)
      return false;
    all.push_back(r);
    return true;
  }

  bool solver_row(const int64_t* row) {
    const SolverTake t{row[0], row[1], row[2], row[3], row[4], uint64_t(row[5]), uint64_t(row[6])};
    std::vector<SolverTake>& all = r_.schedule.solver;
    const SolverTake before = all.empty() ? SolverTake{} : all.back();
    if (t.step != before.step + 1 || t.tick < before.tick || t.tick > kMostTicks || t.hand_tick < before.hand_tick ||
        t.hand_tick > kMostTicks || t.events < before.events || t.stop_at < 0)
      return false;
    all.push_back(t);
    return true;
  }

  const char* end(const LogEvent& e) {
    limberg_msg::end_t m;
    if (const char* wrong = decode_message(e.data, e.size, m)) return wrong;
    if (r_.end) return "a second end";
    if (m.tick < 0 || m.events < 0) return "negative count";
    if (m.tick > kMostTicks) return kTooLate;
    r_.end = RecordingEnd{m.tick, m.events, uint64_t(m.hash)};
    return nullptr;
  }

  static constexpr int64_t kMaxRun = 1'000'000;
  LogReader& log_;
  Recording r_;
  int64_t schedule_seq_[2] = {0, 0};                               // of the next message of each kind
  std::map<std::tuple<size_t, int, int32_t>, StreamOrder> order_;  // per kind of sample, stream, device
  std::map<int32_t, OpenBlob> open_;
  std::vector<std::pair<size_t, int64_t>> unchecked_;  // samples without a checksum, and where they stand in the file
  std::array<bool, std::variant_size_v<Sample>> checksums_{};  // per kind of sample
  bool incomplete_ = false;
};

Recording read(LogReader& log, const std::string& name) {
  if (log.size() == 0) throw InputError(name, 0, "is empty; expected an LCM event log of a stylus");
  Recording r = Reader(log).read();
  if (r.samples.empty() && !r.session) {
    std::string what = "holds no valid record; expected an LCM event log with channel LIMBERG_STYLUS";
    if (!r.damage.first_message.empty()) what += " (first finding: " + r.damage.first_message + ")";
    throw InputError(name, 0, what);
  }
  if (!r.session && !r.samples.empty()) {
    // A plain stream has its own clock: count from the first whole millisecond of its first sample.
    int64_t first = time_of(r.samples.front());
    for (const Sample& s : r.samples) first = std::min(first, time_of(s));
    first -= first % 1'000'000;
    for (Sample& s : r.samples) {
      std::visit([&](auto& v) { v.t_ns -= first; }, s);
      if (auto* t = std::get_if<TrackerSample>(&s)) t->true_ns -= first;
    }
  }
  return r;
}

}  // namespace

const Blob* Recording::blob(BlobKind kind, const std::string& name) const {
  for (const Blob& b : blobs)
    if (b.kind == kind && (name.empty() || b.name == name)) return &b;
  return nullptr;
}

Recording read_recording(const std::string& path) {
  LogReader log(path);
  return read(log, path);
}

Recording read_recording(std::vector<uint8_t> bytes, const std::string& name) {
  LogReader log(std::move(bytes));
  return read(log, name);
}

}  // namespace limberg
