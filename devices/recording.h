#pragma once
// A recording: an LCM log that alone reproduces a run. In order:
//   LIMBERG_SESSION     what made it: format, version, commit, hashes, seeds, rates
//   LIMBERG_CHUNK ...   the scene file, the calibration and any mesh, byte for byte
//   LIMBERG_STYLUS, LIMBERG_TRACKER, LIMBERG_CONTROL, LIMBERG_COMMAND   every sample as received
//   LIMBERG_RAW         the bytes of serial devices from which samples were read
//   LIMBERG_SCHEDULE    of a live session: what its threads took from each other (schedule.h)
//   LIMBERG_CHECKPOINT  tick and state hash, once a second or so
//   LIMBERG_STATE       where some places were after a solver step, once a second or so (state_sample.h)
//   LIMBERG_END         number of events before it, final tick and hash; missing when the session was cut short
// All messages have a size that is known, a schema version, a sequence number and a CRC-32 (messages/*.lcm).
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/lcm_log.h"
#include "devices/sample.h"
#include "devices/schedule.h"
#include "devices/source.h"
#include "devices/state_sample.h"

namespace limberg {

struct SessionInfo {
  static constexpr int kFormat = 1;
  int32_t format_version = kFormat;
  std::string program;     // "limberg 0.1.0 (commit), compiler, processor instructions"; at most 95 bytes
  std::string scene_name;  // at most 63 bytes
  uint64_t scene_hash = 0, calibration_hash = 0;
  // World, emulated surgeon, options (bits below), the recording that this one goes on with (recording_mark(), or 0).
  std::array<uint64_t, 4> seeds{};
  static constexpr size_t kGoesOnWith = 3;
  static constexpr uint64_t kProgressiveCut = 1;  // option: incisions opened while they were drawn
  static constexpr uint64_t kThreadsSlip = 2;     // option: threads slipped that were laid down untied
  static constexpr uint64_t kInSpace = 4;         // option: hands were read as GestureSettings::in_space says
  static constexpr uint64_t kAsMeant = 8;  // option: likewise, GestureSettings::as_meant and PathSettings::curves
  int64_t tick_ns = 1'000'000;
  int32_t ticks_per_solver_step = 8;
  int32_t ticks_per_frame = 16;
  int32_t solver_delay_ticks = 0;
  int64_t utc_start_ns = 0;  // of tick 0; 0: unknown
};

/// A day of ticks: nothing in a recording is later, as no sample is, so that a replay comes to its end.
inline constexpr int64_t kMostTicks = 86'400'000;

enum class BlobKind : int32_t { scene = 1, calibration = 2, mesh = 3, script = 4, texture = 5, tissues = 6 };

/// A file that the run needs, embedded.
struct Blob {
  BlobKind kind = BlobKind::scene;
  std::string name;  // at most 63 bytes: the path by which the scene names it
  std::string data;
};

struct Checkpoint {
  int64_t tick = 0;
  uint64_t hash = 0;
};

struct RecordingEnd {
  int64_t tick = 0, events = 0;  // events: number of log events before this one
  uint64_t hash = 0;
};

struct Recording {
  std::optional<SessionInfo> session;
  std::vector<Blob> blobs;      // whole ones only
  std::vector<Sample> samples;  // in file order; times never decrease within a device
  std::vector<Checkpoint> checkpoints;
  std::vector<StateSample> states;  // steps grow
  LiveSchedule schedule;            // of a live session; empty otherwise
  std::optional<RecordingEnd> end;
  LogDamage damage;
  int64_t events = 0;  // events of ours that were taken
  const Blob* blob(BlobKind kind, const std::string& name = {}) const;
};

/// Reads a recording, or a plain stream of samples. Damage is skipped and counted, never fatal, except: InputError when
/// the file cannot be read or holds no valid sample and no session.
Recording read_recording(const std::string& path);
Recording read_recording(std::vector<uint8_t> bytes, const std::string& name);

/// Writes a recording as it happens. Allocates and writes to disk: call it from a logging thread, or in lockstep.
class RecordingWriter final : public SampleSink {
 public:
  /// Creates the file and writes the session and blobs. InputError: it exists and `replace` is false, it cannot be
  /// written, or a name is too long.
  void open(const std::string& path, const SessionInfo& session, const std::vector<Blob>& blobs, bool replace = false);
  /// Of a session whose tick 0 came after open(), before the first sample: when it was. A pipe keeps what it was told.
  void began(int64_t utc_start_ns);
  void on_sample(const Sample& sample) override;
  void checkpoint(int64_t tick, uint64_t hash);
  void state(const StateSample& state);
  /// Rows are gathered and written 32 at a time, or when they are half a second old. What throws has taken nothing.
  void schedule(const DeviceRun& run);
  void schedule(const SolverTake& take);
  /// Says that rows or samples were lost, so that nobody takes the schedule for whole.
  void schedule_lost();
  /// Writes the end event and closes. False, with error() set, when the disk refused anything; the whole events before
  /// that are kept.
  bool finish(int64_t tick, uint64_t hash);
  /// Writes what is still held and closes, without an end event.
  bool cut_short();
  bool flush() { return log_.flush(); }
  /// Why the disk does not take it; empty again once it does (LogWriter::write).
  const std::string& error() const { return log_.error(); }
  bool given_up() const { return log_.given_up(); }
  void give_up() { log_.give_up(); }
  const std::string& path() const { return log_.path(); }  // another than at the beginning where it was removed
  int64_t events() const { return log_.events(); }

 private:
  void write_session(bool again);
  LogWriter log_;
  SessionInfo info_;
  struct Rows {  // not yet written
    int64_t seq = 0, first_tick = 0;
    std::vector<std::array<int64_t, 7>> row;
  };
  void add_row(int kind, int64_t tick, const std::array<int64_t, 7>& row);
  void write_rows(int kind, int64_t tick);
  Rows rows_[2];  // device ticks, solver steps
  bool said_lost_ = false;
  int64_t tick_ns_ = 1'000'000, start_us_ = 0, last_us_ = 0, seq_ = 0;
};

}  // namespace limberg
