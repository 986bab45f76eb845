#include <algorithm>

#include "devices/message_codec.h"
#include "devices/recording.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr size_t kMaxBlobBytes = kPiece * 65'536;
constexpr size_t kRows = std::extent_v<decltype(limberg_msg::schedule_t::row)>;

template <class M>
M own_message(int64_t seq, int64_t t_ns) {
  M m{};
  m.seq = seq;
  m.t_host_ns = t_ns;
  m.t_device_ns = -1;
  m.device_id = -1;  // the recorder itself
  return m;
}

void check_name(const std::string& path, const std::string& name, size_t limit) {
  if (name.size() >= limit)
    throw InputError(path, 0,
                     "cannot be recorded: the name \"" + name.substr(0, 40) + "...\" is too long; expected at most " +
                         std::to_string(limit - 1) + " bytes");
}

}  // namespace

void RecordingWriter::open(const std::string& path, const SessionInfo& info, const std::vector<Blob>& blobs,
                           bool replace) {
  check_name(path, info.scene_name, sizeof(limberg_msg::session_t::scene_name));
  check_name(path, info.program, sizeof(limberg_msg::session_t::program));
  for (const Blob& b : blobs) {
    check_name(path, b.name, sizeof(limberg_msg::chunk_t::name));
    if (b.data.size() > kMaxBlobBytes)
      throw InputError(path, 0, "cannot be recorded: \"" + b.name + "\" is larger than 256 MiB");
  }
  log_.open(path, replace);
  for (Rows& rows : rows_) rows = {}, rows.row.reserve(kRows);
  tick_ns_ = info.tick_ns;
  start_us_ = info.utc_start_ns / 1000;
  last_us_ = start_us_;
  seq_ = 0;

  info_ = info;
  write_session(false);
  ++seq_;
  MessageBytes bytes;
  for (size_t b = 0; b < blobs.size(); ++b) {
    const std::string& data = blobs[b].data;
    const size_t total = std::max<size_t>(1, (data.size() + kPiece - 1) / kPiece);
    for (size_t i = 0; i < total; ++i) {
      auto c = own_message<limberg_msg::chunk_t>(seq_++, 0);
      c.blob = int32_t(b);
      c.kind = int32_t(blobs[b].kind);
      c.index = int32_t(i);
      c.total = int32_t(total);
      c.bytes = int64_t(data.size());
      put_text(c.name, blobs[b].name);
      c.n = int32_t(std::min(kPiece, data.size() - i * kPiece));
      std::memcpy(c.data, data.data() + i * kPiece, size_t(c.n));
      log_.write(last_us_, kChunkChannel, bytes.data(), encode_message(c, bytes));
    }
  }
  log_.flush();
}

/// The first event of the file.
void RecordingWriter::write_session(bool again) {
  const SessionInfo& info = info_;
  auto m = own_message<limberg_msg::session_t>(0, 0);
  m.format_version = SessionInfo::kFormat;
  put_text(m.program, info.program);
  put_text(m.scene_name, info.scene_name);
  m.scene_hash = int64_t(info.scene_hash);
  m.calibration_hash = int64_t(info.calibration_hash);
  for (size_t i = 0; i < 4; ++i) m.seeds[i] = int64_t(info.seeds[i]);
  m.tick_ns = info.tick_ns;
  m.ticks_per_solver_step = info.ticks_per_solver_step;
  m.ticks_per_frame = info.ticks_per_frame;
  m.solver_delay_ticks = info.solver_delay_ticks;
  m.utc_start_ns = info.utc_start_ns;
  MessageBytes bytes;
  const size_t n = encode_message(m, bytes);
  if (again)
    log_.write_first_again(last_us_, kSessionChannel, bytes.data(), n);
  else
    log_.write(last_us_, kSessionChannel, bytes.data(), n);
}

void RecordingWriter::began(int64_t utc_start_ns) {
  if (!log_.is_open() || !log_.error().empty()) return;
  info_.utc_start_ns = utc_start_ns;
  write_session(true);
  start_us_ = utc_start_ns / 1000;
  last_us_ = std::max(last_us_, start_us_);
}

void RecordingWriter::on_sample(const Sample& sample) {
  MessageBytes bytes;
  std::visit(
      [&](const auto& s) {
        last_us_ = std::max(last_us_, start_us_ + s.t_ns / 1000);
        log_.write(last_us_, channel_of(sample), bytes.data(), encode_message(to_message(s), bytes));
      },
      sample);
}

void RecordingWriter::checkpoint(int64_t tick, uint64_t hash) {
  const int64_t t_ns = tick * tick_ns_;
  last_us_ = std::max(last_us_, start_us_ + t_ns / 1000);
  auto m = own_message<limberg_msg::checkpoint_t>(seq_++, t_ns);
  m.tick = tick;
  m.hash = int64_t(hash);
  MessageBytes bytes;
  log_.write(last_us_, kCheckpointChannel, bytes.data(), encode_message(m, bytes));
}

void RecordingWriter::state(const StateSample& s) {
  auto m = own_message<limberg_msg::state_t>(seq_++, std::max<int64_t>(0, (last_us_ - start_us_) * 1000));
  m.step = s.step, m.topology = int64_t(s.topology), m.vertices = s.vertices, m.n = s.n;
  for (size_t k = 0; k < size_t(s.n); ++k) std::copy(s.at_mm[k].begin(), s.at_mm[k].end(), m.at_mm[k]);
  m.sutures_N = s.sutures_N, m.hooks_N = s.hooks_N;
  MessageBytes bytes;
  log_.write(last_us_, kStateChannel, bytes.data(), encode_message(m, bytes));
}

void RecordingWriter::schedule(const DeviceRun& r) {
  add_row(1, r.tick, {r.tick, r.snapshot, r.count, r.samples, 0, 0, 0});
}

void RecordingWriter::schedule(const SolverTake& t) {
  add_row(2, t.tick, {t.step, t.tick, t.hand_tick, t.events, t.stop_at, int64_t(t.adopted), int64_t(t.hash)});
}

void RecordingWriter::schedule_lost() {
  if (said_lost_ || !log_.is_open()) return;
  said_lost_ = true;
  auto m = own_message<limberg_msg::schedule_t>(0, std::max<int64_t>(0, (last_us_ - start_us_) * 1000));
  m.kind = 3;
  MessageBytes bytes;
  log_.write(last_us_, kScheduleChannel, bytes.data(), encode_message(m, bytes));
}

void RecordingWriter::add_row(int kind, int64_t tick, const std::array<int64_t, 7>& row) {
  const int64_t half_a_second = 500'000'000 / tick_ns_;
  Rows& rows = rows_[kind - 1];
  if (rows.row.empty()) rows.first_tick = tick;
  rows.row.push_back(row);
  if (rows.row.size() == kRows || tick - rows.first_tick > half_a_second) write_rows(kind, tick);
}

void RecordingWriter::write_rows(int kind, int64_t tick) {
  Rows& rows = rows_[kind - 1];
  if (rows.row.empty()) return;
  const int64_t t_ns = tick * tick_ns_;
  last_us_ = std::max(last_us_, start_us_ + t_ns / 1000);
  auto m = own_message<limberg_msg::schedule_t>(rows.seq++, t_ns);
  m.kind = kind;
  m.n = int32_t(rows.row.size());
  for (size_t i = 0; i < rows.row.size(); ++i) std::copy(rows.row[i].begin(), rows.row[i].end(), m.row[i]);
  rows.row.clear();
  MessageBytes bytes;
  log_.write(last_us_, kScheduleChannel, bytes.data(), encode_message(m, bytes));
}

bool RecordingWriter::cut_short() {
  if (!log_.is_open()) return log_.error().empty();
  const int64_t tick = (last_us_ - start_us_) * 1000 / tick_ns_;
  write_rows(1, tick), write_rows(2, tick);
  return log_.close();
}

bool RecordingWriter::finish(int64_t tick, uint64_t hash) {
  if (!log_.is_open()) return log_.error().empty();
  write_rows(1, tick), write_rows(2, tick);
  const int64_t t_ns = tick * tick_ns_;
  auto m = own_message<limberg_msg::end_t>(seq_++, t_ns);
  m.tick = tick;
  m.events = log_.events();
  m.hash = int64_t(hash);
  MessageBytes bytes;
  log_.write(std::max(last_us_, start_us_ + t_ns / 1000), kEndChannel, bytes.data(), encode_message(m, bytes));
  return log_.close();
}

}  // namespace limberg
