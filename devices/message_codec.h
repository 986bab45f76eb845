#pragma once
// Messages to bytes and back, with every check that the packaged decoder leaves out: exact size, fingerprint, schema
// version, CRC, finite numbers. Used by the parts that read logs and networks; nothing else sees the generated types.
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "devices/big_endian.h"
#include "devices/sample.h"
#include "limberg_msg/checkpoint_t.hpp"
#include "limberg_msg/chunk_t.hpp"
#include "limberg_msg/command_t.hpp"
#include "limberg_msg/control_t.hpp"
#include "limberg_msg/end_t.hpp"
#include "limberg_msg/force_t.hpp"
#include "limberg_msg/raw_t.hpp"
#include "limberg_msg/schedule_t.hpp"
#include "limberg_msg/session_t.hpp"
#include "limberg_msg/state_t.hpp"
#include "limberg_msg/stylus_t.hpp"
#include "limberg_msg/tracker_t.hpp"

namespace limberg {

inline constexpr int32_t kSchemaVersion = 1;
inline constexpr std::string_view kStylusChannel = "LIMBERG_STYLUS", kControlChannel = "LIMBERG_CONTROL",
                                  kSessionChannel = "LIMBERG_SESSION", kChunkChannel = "LIMBERG_CHUNK",
                                  kCheckpointChannel = "LIMBERG_CHECKPOINT", kEndChannel = "LIMBERG_END",
                                  kTrackerChannel = "LIMBERG_TRACKER", kRawChannel = "LIMBERG_RAW",
                                  kScheduleChannel = "LIMBERG_SCHEDULE", kCommandChannel = "LIMBERG_COMMAND",
                                  kStateChannel = "LIMBERG_STATE", kForceChannel = "LIMBERG_FORCE";

/// CRC-32 of IEEE 802.3 (reflected polynomial 0xEDB88320).
uint32_t checksum(const uint8_t* data, size_t n);

inline constexpr size_t kPiece = sizeof(limberg_msg::chunk_t::data);  // bytes of an embedded file in one message
inline constexpr size_t kMaxStreams = 64;                             // devices of a link that are heard at a time
inline constexpr size_t kMaxRecordedStreams = 65'536;  // of one recording: a link may have heard others before
inline constexpr size_t kMaxMessage = 8192;
using MessageBytes = std::array<uint8_t, kMaxMessage>;

/// Encodes with the schema version and CRC filled in; the number of bytes.
template <class M>
size_t encode_message(M message, MessageBytes& bytes) {
  message.schema_version = kSchemaVersion;
  message.crc = 0;
  const int n = message.encode(bytes.data(), 0, int(bytes.size()));
  if (n < 4) return 0;
  uint32_t crc = checksum(bytes.data(), size_t(n) - 4);
  if (crc == 0) crc = 1;  // 0 says "not given"
  put_big_endian<uint32_t>(bytes.data() + n - 4, crc);
  return size_t(n);
}

/// A command's line in a message.
inline constexpr size_t kMaxCommandLine = 8000;

/// The size that the bytes must have as a message of type M; 0 where they cannot be one.
template <class M>
size_t expected_size(const M& message, const uint8_t*, size_t) {
  return size_t(message.getEncodedSize());
}
/// Of the one message that is not of a fixed size: by the length of its line, which is not believed before it fits.
inline size_t expected_size(const limberg_msg::command_t&, const uint8_t* data, size_t n) {
  static const int kWithoutLine = limberg_msg::command_t{}.getEncodedSize();
  constexpr size_t kLength = 40;  // where it stands: behind fingerprint and prefix
  if (n < kLength + 4) return 0;
  const auto line = get_big_endian<int32_t>(data + kLength);
  return line < 0 || size_t(line) > kMaxCommandLine ? 0 : size_t(kWithoutLine) + size_t(line);
}

/// What is wrong with the bytes as a message of type M, or nullptr, and then `message` holds it. `has_checksum`:
/// whether a checksum was given, and then it was right. A stream that has given one gives them always (StreamOrder).
template <class M>
const char* decode_message(const uint8_t* data, size_t n, M& message, bool* has_checksum = nullptr) {
  const auto size = int(expected_size(message, data, n));
  if (size == 0 || n != size_t(size)) return "wrong message size";
  if (get_big_endian<int64_t>(data) != M::getHash()) return "wrong message fingerprint";
  if (get_big_endian<int32_t>(data + 8) != kSchemaVersion) return "unknown schema version";
  const auto given = get_big_endian<uint32_t>(data + n - 4);
  if (has_checksum) *has_checksum = given != 0;
  if (given != 0) {
    uint32_t crc = checksum(data, n - 4);
    if (crc == 0) crc = 1;
    if (crc != given) return "wrong checksum";
  }
  if (message.decode(data, 0, size) != size) return "not decodable";
  return nullptr;
}

/// Checks the numbers of a decoded message and turns it into a sample. Returns what is wrong, or nullptr.
/// Refused: numbers that are not finite, a tip further than 10 m, |q| outside [0.99, 1.01], times outside [0, 1 day]
/// for a recording's clock (`any_time`: not checked, for live streams), negative sequence numbers, unknown kinds.
const char* to_sample(const limberg_msg::stylus_t& m, StylusSample& s, bool any_time = false);
const char* to_sample(const limberg_msg::control_t& m, ControlSample& s, bool any_time = false);
const char* to_sample(const limberg_msg::tracker_t& m, TrackerSample& s, bool any_time = false);
const char* to_sample(const limberg_msg::raw_t& m, RawSample& s, bool any_time = false);
/// Reads the line too: memory is taken, so not on the device thread.
const char* to_sample(const limberg_msg::command_t& m, CommandSample& s, bool any_time = false);
limberg_msg::command_t to_message(const CommandSample& s);
limberg_msg::stylus_t to_message(const StylusSample& s);
limberg_msg::control_t to_message(const ControlSample& s);
limberg_msg::tracker_t to_message(const TrackerSample& s);
limberg_msg::raw_t to_message(const RawSample& s);

/// The channel of a sample and the number of its stream within a device: each counts for itself.
std::string_view channel_of(const Sample& s);
inline int stream_of(const StylusSample&) { return 0; }
inline int stream_of(const ControlSample&) { return 1; }
inline int stream_of(const RawSample&) { return 2; }
inline int stream_of(const TrackerSample& s) { return 2 + s.station; }  // 1 to 4
inline int stream_of(const CommandSample&) { return 7; }

/// Zero-filled fixed text; reading stops at the first zero. Control characters are refused on reading by to_sample.
template <size_t N>
void put_text(uint8_t (&field)[N], const std::string& text) {
  std::memset(field, 0, N);
  std::memcpy(field, text.data(), text.size() < N ? text.size() : N - 1);
}
template <size_t N>
std::string get_text(const uint8_t (&field)[N]) {
  const auto* p = reinterpret_cast<const char*>(field);
  return std::string(p, strnlen(p, N));
}

/// Follows one stream (type and device): sequence numbers and times must grow.
struct StreamOrder {
  bool started = false;
  bool checksums = false;  // one was seen: from then on a message without is a damaged one
  int64_t seq = 0, t_ns = 0;
  /// False: not newer than what came before. `gap` counts the numbers left out.
  bool accept(int64_t new_seq, int64_t new_t_ns, int64_t& gap) {
    if (started && (new_seq <= seq || new_t_ns < t_ns)) return false;
    gap = started ? new_seq - seq - 1 : 0;
    started = true;
    seq = new_seq;
    t_ns = new_t_ns;
    return true;
  }
};

}  // namespace limberg
