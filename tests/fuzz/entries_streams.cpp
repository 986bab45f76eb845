// What comes from devices and networks, and recordings of it: LCM logs and the messages in them, datagrams, lines.
#include <cmath>
#include <cstring>

#include "app/assembly/bundle.h"
#include "devices/big_endian.h"
#include "devices/desktop_source.h"
#include "devices/drivers/haply_line.h"
#include "devices/fastrak/link.h"
#include "devices/fastrak/protocol.h"
#include "devices/heard_streams.h"
#include "devices/lcm_local_link.h"
#include "devices/message_codec.h"
#include "devices/old_controls.h"
#include "devices/recording.h"
#include "sim/base/error.h"
#include "tests/fuzz/entry_parts.h"

namespace limberg::fuzz {
namespace {

std::vector<uint8_t> bytes_of(std::string_view s) { return {s.begin(), s.end()}; }

/// An event of a log.
std::string event(int64_t number, std::string_view channel, std::string_view data) {
  std::string e(LogReader::kHeader, '\0');
  auto* p = reinterpret_cast<uint8_t*>(e.data());
  put_big_endian<uint32_t>(p, LogReader::kSync);
  put_big_endian<int64_t>(p + 4, number), put_big_endian<int64_t>(p + 12, 1000 * number);
  put_big_endian<uint32_t>(p + 20, uint32_t(channel.size())), put_big_endian<uint32_t>(p + 24, uint32_t(data.size()));
  return e.append(channel).append(data);
}

/// The message's bytes; with a checksum, or without, as a hostile sender would leave it out.
template <class M>
std::string encoded(const M& m, bool with_checksum) {
  MessageBytes bytes;
  const size_t n = encode_message(m, bytes);
  if (!with_checksum && n >= 4) std::memset(bytes.data() + n - 4, 0, 4);
  return {bytes.begin(), bytes.begin() + ptrdiff_t(n)};
}

/// A log whose messages give no checksums: what is changed in them is not found out by that.
std::string without_checksums(std::string_view log) {
  LogReader reader(bytes_of(log));
  std::string out;
  LogEvent e;
  for (int64_t n = 0; reader.next(e); ++n) {
    std::string data(reinterpret_cast<const char*>(e.data), e.size);
    if (data.size() >= 4) data.replace(data.size() - 4, 4, 4, '\0');
    out += event(n, e.channel, data);
  }
  return out;
}

std::string unsound(const Recording& r) {
  for (const Sample& s : r.samples)
    if (const auto* stylus = std::get_if<StylusSample>(&s); stylus && !stylus->tip_mm.allFinite())
      return "a sample at no place was taken";
  for (size_t i = 1; i < r.checkpoints.size(); ++i)
    if (r.checkpoints[i].tick < r.checkpoints[i - 1].tick) return "checkpoints out of order";
  for (const StateSample& s : r.states)
    for (int32_t k = 0; k < s.n; ++k)
      for (const float x : s.at_mm[size_t(k)])
        if (!std::isfinite(x)) return "a state at no place was taken";
  for (const DeviceRun& d : r.schedule.device)
    if (d.count < 1 || d.samples < 0 || d.tick + d.count > kMostTicks + 1'000'000)
      return "a row of ticks that cannot be";
  if (r.end && r.end->tick > kMostTicks) return "a replay of it would not end";
  return "";
}

std::string read_whole_recording(const std::string& bytes) {
  const Recording r = read_recording(bytes_of(bytes), kNamed);
  if (std::string fault = unsound(r); !fault.empty()) return fault;
  for (const Sample& s : r.samples) {
    OldControls old;
    if (const auto* c = std::get_if<ControlSample>(&s)) old.read(*c, Snapshot{});
  }
  if (r.blob(BlobKind::scene)) unbundle_scene(r, kNamed);
  unbundle_calibration(r, kNamed);
  return "";
}

limberg_msg::session_t a_session() {
  limberg_msg::session_t m{};
  m.format_version = SessionInfo::kFormat, m.tick_ns = 1'000'000;
  m.ticks_per_solver_step = 8, m.ticks_per_frame = 16;
  put_text(m.program, "limberg"), put_text(m.scene_name, "small");
  return m;
}

/// A whole recording of a session: its scene, a sample, a checkpoint, a state, rows, the end.
std::string a_recording() {
  std::string log;
  int64_t n = 0;
  const auto add = [&](std::string_view channel, const auto& m) { log += event(n++, channel, encoded(m, false)); };
  add(kSessionChannel, a_session());
  for (int32_t k = 0; k < 2; ++k) {
    limberg_msg::chunk_t c{};
    const std::string text = k == 0 ? "v 0 0 0\n"
                                    : "[body]\nsource = \"block\"\nsize_mm = [9,9,9]\nskin_cell_mm = 3\n[[layer]]\n"
                                      "name = \"skin\"\nthickness_mm = 9\nyoung_kPa = 60\npoisson = 0.45\n[lattice]\n"
                                      "cell_mm = 3\n";
    c.blob = k, c.kind = k == 0 ? 3 : 1, c.total = 1, c.bytes = c.n = int32_t(text.size());
    std::memcpy(c.data, text.data(), text.size());
    put_text(c.name, k == 0 ? "m/a.obj" : "small");
    add(kChunkChannel, c);
  }
  StylusSample s;
  s.tip_mm = {1, 2, 3};
  add(kStylusChannel, to_message(s));
  add(kControlChannel, to_message(ControlSample{}));
  limberg_msg::checkpoint_t p{};
  p.tick = 5;
  add(kCheckpointChannel, p);
  limberg_msg::state_t state{};
  state.step = 1, state.vertices = 4, state.n = 2;
  add(kStateChannel, state);
  limberg_msg::schedule_t rows{};
  rows.kind = 1, rows.n = 1, rows.row[0][2] = 1, rows.row[0][3] = 2;
  add(kScheduleChannel, rows);
  limberg_msg::end_t end{};
  end.tick = 9, end.events = n;
  add(kEndChannel, end);
  return log;
}

Entry recording_entry() {
  return text_entry("recording",
                    {"devices/recording_reader.cpp", "app/assembly/bundle.cpp", "devices/old_controls.cpp"},
                    {a_recording(), without_checksums(shipped("recordings/hand-glove.lcm").substr(0, 20'000))},
                    [](const std::string& text) { return read_whole_recording(without_checksums(text)); });
}

/// The log itself: whatever the bytes are, events lie in them, one behind the other.
Entry log_entry() {
  return text_entry("log", {"devices/lcm_log_reader.cpp"},
                    {event(0, "A", "abc") + event(1, "LIMBERG_STYLUS", "") + event(2, "B", std::string(40, 'x'))},
                    [](const std::string& text) -> std::string {
                      LogReader reader(bytes_of(text));
                      LogEvent e;
                      int64_t end = 0, events = 0, bytes = 0;
                      for (; reader.next(e); ++events) {
                        if (e.offset < end) return "events overlap";
                        const auto size = int64_t(LogReader::kHeader + e.channel.size() + e.size);
                        end = e.offset + size, bytes += size;
                      }
                      if (end > int64_t(text.size())) return "an event ends behind the log";
                      const LogDamage& d = reader.damage();
                      if (bytes + d.skipped_bytes != int64_t(text.size())) return "bytes are neither read nor skipped";
                      if (events == 0) throw InputError(kNamed, 0, "holds no event of a log");
                      return "";
                    });
}

/// A message as it comes from the network: refused with a reason, or a sample that is encoded and read again.
template <class M, class S>
Entry sample_entry(const std::string& name, const S& sample) {
  Entry e{"packet_" + name,
          {"devices/message_codec.cpp", "devices/message_codec.h", "devices/lcm_net_source.cpp",
           "devices/force/lcm_force_port.cpp"},
          {},
          {}};
  e.sound = {encoded(to_message(sample), true), encoded(to_message(sample), false)};
  e.run = [](std::string_view packet, bool& taken) -> std::string {
    taken = false;
    M message;
    S got;
    if (decode_message(reinterpret_cast<const uint8_t*>(packet.data()), packet.size(), message)) return "";
    if (to_sample(message, got, true)) return "";
    taken = true;
    if constexpr (std::is_same_v<S, ControlSample>) OldControls{}.read(got, Snapshot{});
    HeardStreams heard;
    for (int64_t t = 0; t < 3; ++t) {
      int64_t seq = got.seq, gap = 0;
      if (heard.take({stream_of(got), got.device_id}, seq, t, true, gap) && gap < 0)
        return "less than none are missing";
    }
    const std::string again = encoded(to_message(got), true);
    M second;
    S back;
    if (decode_message(reinterpret_cast<const uint8_t*>(again.data()), again.size(), second) ||
        to_sample(second, back, true))
      return "a packet was taken that is refused when it is written again";
    return "";
  };
  return e;
}

/// A message that only leaves (LIMBERG_FORCE), as whoever listens reads it.
Entry force_entry() {
  limberg_msg::force_t force{};
  force.pose_seq = 3, force.state = 2, force.force_mN[2] = 280, force.normal[2] = 1;
  Entry e{"packet_force", {"devices/message_codec.h"}, {}, {}};
  e.sound = {encoded(force, true), encoded(force, false)};
  e.run = [](std::string_view packet, bool& taken) -> std::string {
    limberg_msg::force_t m, again;
    taken = !decode_message(reinterpret_cast<const uint8_t*>(packet.data()), packet.size(), m);
    if (!taken) return "";
    const std::string second = encoded(m, true);
    return decode_message(reinterpret_cast<const uint8_t*>(second.data()), second.size(), again)
               ? "a packet was taken that is refused when it is written again"
               : "";
  };
  return e;
}

/// A message that only recordings hold, read as the second event of one (a session: as its first).
template <class M>
Entry record_entry(const std::string& name, std::string_view channel, const M& message) {
  Entry e{"packet_" + name, {"devices/recording_reader.cpp", "devices/message_codec.h"}, {}, {}};
  e.sound = {encoded(message, true), encoded(message, false)};
  const std::string first =
      std::is_same_v<M, limberg_msg::session_t> ? std::string() : event(0, kSessionChannel, encoded(a_session(), true));
  e.run = [first, channel](std::string_view packet, bool& taken) {
    return outcome(kNamed, taken, [&]() -> std::string {
      if (packet.size() > LogReader::kMaxData) throw InputError(kNamed, 0, "is larger than any event of a log");
      const Recording r = read_recording(bytes_of(first + event(1, channel, packet)), kNamed);
      if (r.damage.bad_payload > 0) throw InputError(kNamed, 0, "damaged: " + r.damage.first_message);
      return unsound(r);
    });
  };
  return e;
}

/// A datagram as it comes from a socket: its parts, then the message of its channel.
Entry datagram_entry() {
  Entry e{"datagram", {"devices/lcm_local_link.cpp"}, {}, {}};
  StylusSample s;
  s.tip_mm = {1, 2, 3};
  for (const bool with : {true, false})
    e.sound.push_back(std::string("LC02\0\0\0\1", 8) + std::string(kStylusChannel) + '\0' +
                      encoded(to_message(s), with));
  e.run = [](std::string_view packet, bool& taken) -> std::string {
    taken = false;
    // On the heap, so that a read beyond it is seen.
    const std::vector<uint8_t> bytes = bytes_of(packet);
    std::string_view channel;
    const uint8_t* data = nullptr;
    size_t size = 0;
    if (!LcmLocalLink::parse(bytes.data(), bytes.size(), channel, data, size)) return "";
    taken = true;
    if (data < bytes.data() || data + size != bytes.data() + bytes.size()) return "a payload outside its packet";
    limberg_msg::stylus_t m;
    StylusSample got;
    if (channel == kStylusChannel && !decode_message(data, size, m)) to_sample(m, got, true);
    return "";
  };
  return e;
}

std::string tracker_line(bool binary) {
  fastrak::Layout layout;
  layout.binary = binary;
  std::string line;
  for (int station = 1; station <= 2; ++station) {
    fastrak::Record r;
    r.station = station, r.pos_mm = {120, -35.5, 8}, r.quat = {0.6, 0, 0.8, 0};
    std::array<uint8_t, fastrak::kLongest> bytes;
    line.append(reinterpret_cast<const char*>(bytes.data()), encode(r, layout, bytes));
  }
  return line;
}

/// A stretch of the tracker's line: whatever comes, records lie within reach and turn by unit quaternions.
Entry line_entry(bool binary) {
  using namespace fastrak;
  struct Take final : Parser::Sink {
    void on_record(const Record& r) override {
      ++records;
      double qq = 0;
      for (const double q : r.quat) qq += q * q;
      unsound |= !r.pos_mm.allFinite() || !(r.pos_mm.cwiseAbs().maxCoeff() <= kReachMm) || !(std::abs(qq - 1) < 1e-9) ||
                 r.station < 1 || r.station > kStations;
    }
    void on_reply(std::span<const char> text) override { unsound |= text.size() > kLongest; }
    int records = 0;
    bool unsound = false;
  };
  Entry e{binary ? "line_binary" : "line_ascii", {"devices/fastrak/protocol.cpp"}, {tracker_line(binary)}, {}};
  e.run = [binary](std::string_view bytes, bool& taken) -> std::string {
    Parser parser;
    Layout layout;
    layout.binary = binary;
    parser.reset(layout);
    Take take;
    for (const char c : bytes) parser.feed(uint8_t(c), 0, take);
    taken = take.records > 0;
    return take.unsound ? "a record out of range was taken" : "";
  };
  return e;
}

/// The conversation with a tracker that says what it likes: every byte is a lump of so many of the next ones, which
/// come half a second apart.
Entry conversation_entry() {
  using namespace fastrak;
  struct Take final : Link::Receiver {
    void on_reading(const TrackerSample& s) override { unsound |= !s.pos_mm.allFinite() || s.t_ns < 0; }
    bool unsound = false;
  };
  const std::string replies = "21S 0000 3.02 a FASTRAK that speaks for a test    \r\n", active = "21l1100\r\n";
  const auto lump = [](const std::string& s) { return char(s.size()) + s; };
  Entry e{"conversation",
          {"devices/fastrak/link.cpp", "devices/fastrak/source.cpp", "devices/fastrak/port.cpp"},
          {lump("") + lump(replies) + lump(active) + lump(tracker_line(true))},
          {}};
  e.run = [](std::string_view bytes, bool& taken) -> std::string {
    Link link{LinkSettings{}};
    Take take;
    int64_t now = 0, sent = 0;
    link.opened(now);
    for (size_t at = 0; at < bytes.size();) {
      const size_t wanted = uint8_t(bytes[at++]), n = std::min(wanted, bytes.size() - at);
      link.receive(reinterpret_cast<const uint8_t*>(bytes.data()) + at, n, now, take);
      at += n;
      for (int k = 0; k < 50; ++k) {
        link.tick(now);
        sent += int64_t(link.take_output().size());
        now += 10'000'000;
      }
    }
    taken = !bytes.empty() && !link.status().empty();
    return take.unsound                                  ? "a reading at no place"
           : sent > 50'000 + 100 * int64_t(bytes.size()) ? "it talks without end"
                                                         : "";
  };
  return e;
}

/// The line of a Haply board: whatever it says, the effector is within the linkage's reach, and its forces are finite.
Entry haply_entry() {
  const float angle[2] = {140, 40};
  std::string answer(1, char(haply::kDevice));
  answer.append(reinterpret_cast<const char*>(angle), sizeof angle);
  Entry e{"haply", {"devices/drivers/haply_2diy.cpp"}, {answer + answer}, {}};
  e.run = [](std::string_view bytes, bool& taken) -> std::string {
    haply::Answers answers;
    taken = false;
    for (size_t i = 0; i < bytes.size(); ++i)
      if (answers.take(uint8_t(bytes[i]), int64_t(i) * 100'000)) {
        taken = true;
        const haply::Linkage& l = answers.linkage;
        if (!(std::hypot(l.x_mm, l.y_mm) <= l.a_mm + l.b_mm + 1e-6)) return "out of reach";
        for (const auto& row : l.jacobian)
          for (const double j : row)
            if (!(std::abs(j) < 1e5)) return "a force without bounds";
      }
    return "";
  };
  return e;
}

/// A pointing device of a desk: whatever it says, the tip stays in its box.
Entry desktop_entry(DesktopSettings::Kind kind) {
  const bool mouse = kind == DesktopSettings::mouse;
  std::string sound;
  if (mouse) {
    sound = std::string("\x09\x05\xFB", 3);
  } else {
    const int32_t push[8] = {0, 100, -20, 300, 5, 6, 7, 16}, press[8] = {1, 0, 0, 0, 0, 0, 0, 0};
    sound.assign(reinterpret_cast<const char*>(push), sizeof push);
    sound.append(reinterpret_cast<const char*>(press), sizeof press);
  }
  Entry e{mouse ? "mouse" : "space_mouse", {"devices/desktop_source.cpp"}, {sound}, {}};
  e.run = [kind](std::string_view bytes, bool& taken) -> std::string {
    DesktopSettings set;
    set.kind = kind;
    DesktopDecoder decoder(set);
    for (size_t at = 0; at < bytes.size(); at += 50) {
      const std::string_view part = bytes.substr(at, 50);
      decoder.feed(reinterpret_cast<const uint8_t*>(part.data()), part.size());
      decoder.advance(0.01);
      double qq = 0;
      for (const double q : decoder.pose().quat) qq += q * q;
      if (!(decoder.pose().tip_mm.cwiseAbs().maxCoeff() <= set.box_mm) || !(std::abs(qq - 1) < 1e-6))
        return "the tip left its box";
    }
    taken = !bytes.empty() && decoder.malformed() == 0;
    return "";
  };
  return e;
}

}  // namespace

std::vector<Entry> stream_entries() {
  std::vector<Entry> all;
  all.push_back(recording_entry());
  all.push_back(log_entry());
  StylusSample stylus;
  stylus.tip_mm = {1, 2, 3};
  all.push_back(sample_entry<limberg_msg::stylus_t>("stylus", stylus));
  all.push_back(sample_entry<limberg_msg::control_t>("control", ControlSample{}));
  all.push_back(sample_entry<limberg_msg::tracker_t>("tracker", TrackerSample{}));
  all.push_back(sample_entry<limberg_msg::raw_t>("raw", RawSample{}));
  all.push_back(sample_entry<limberg_msg::command_t>("command", command_sample(Incise{{{0, 0}, {10, 0}}, 4, 90})));
  all.push_back(force_entry());
  all.push_back(record_entry("session", kSessionChannel, a_session()));
  limberg_msg::chunk_t chunk{};
  chunk.kind = 1, chunk.total = 1, chunk.bytes = chunk.n = 5;
  all.push_back(record_entry("chunk", kChunkChannel, chunk));
  limberg_msg::checkpoint_t checkpoint{};
  checkpoint.tick = 5;
  all.push_back(record_entry("checkpoint", kCheckpointChannel, checkpoint));
  limberg_msg::state_t state{};
  state.step = 1, state.vertices = 4, state.n = 2;
  all.push_back(record_entry("state", kStateChannel, state));
  limberg_msg::schedule_t rows{};
  rows.kind = 2, rows.n = 1, rows.row[0][0] = 1;
  all.push_back(record_entry("schedule", kScheduleChannel, rows));
  limberg_msg::end_t end{};
  end.tick = 9;
  all.push_back(record_entry("end", kEndChannel, end));
  all.push_back(datagram_entry());
  all.push_back(line_entry(true));
  all.push_back(line_entry(false));
  all.push_back(conversation_entry());
  all.push_back(haply_entry());
  all.push_back(desktop_entry(DesktopSettings::space_mouse));
  all.push_back(desktop_entry(DesktopSettings::mouse));
  return all;
}

}  // namespace limberg::fuzz
