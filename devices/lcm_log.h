#pragma once
// LCM event logs, read and written by ourselves, because a log may be damaged or hostile.
//
// Format (all integers big-endian), event after event, no file header, no index, no checksum:
//   u32 sync 0xEDA1DA01 | i64 event number | i64 time in us | u32 channel length | u32 data length | channel | data
// A log written here plays in lcm-logplayer, and a log of lcm-logger reads here. What is not an event is skipped up to
// the next sync word that begins a plausible one, and counted.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

/// What was wrong with a log. Counts are of events (or runs of bytes) skipped.
struct LogDamage {
  // In a row that count as missing: 12 days at 1 kHz. Hostile numbers leap, and their sum must be a number.
  static constexpr int64_t kMostMissing = 1'000'000'000;
  int64_t truncated = 0;        // the file ends within an event
  int64_t bad_sync = 0;         // bytes between events that are not an event
  int64_t bad_length = 0;       // a channel or data length beyond the limits
  int64_t bad_payload = 0;      // wrong size, fingerprint, version or checksum; or numbers that cannot be
  int64_t unknown_channel = 0;  // not ours: skipped, not an error
  int64_t out_of_order = 0;     // sequence or time does not grow
  int64_t missing = 0;          // events that the event numbers promise and the file does not hold
  int64_t stream_gaps = 0;      // samples that the device sent and the recorder never got: a property of the recording
  int64_t skipped_bytes = 0;
  std::string first_message;  // the first finding, with its byte offset

  /// Everything that means that something was lost.
  int64_t total() const { return truncated + bad_sync + bad_length + bad_payload + out_of_order + missing; }
};

struct LogEvent {
  int64_t number = 0, time_us = 0, offset = 0;  // offset: of the event's first byte
  std::string_view channel;                     // valid until the next call
  const uint8_t* data = nullptr;
  size_t size = 0;
};

class LogReader {
 public:
  static constexpr size_t kMaxChannel = 63, kMaxData = 64 * 1024;
  static constexpr size_t kMaxFile = size_t(4) << 30;
  static constexpr uint32_t kSync = 0xEDA1DA01u;
  static constexpr size_t kHeader = 28;

  /// Reads the file into memory. InputError: missing, a directory, unreadable, larger than 4 GiB.
  explicit LogReader(const std::string& path);
  /// Over bytes in memory.
  explicit LogReader(std::vector<uint8_t> bytes) : bytes_(std::move(bytes)) {}

  /// The next whole event; false at the end.
  bool next(LogEvent& event);
  const LogDamage& damage() const { return damage_; }
  LogDamage& damage() { return damage_; }  // for the decoder above, which counts what it refuses
  size_t size() const { return bytes_.size(); }

 private:
  std::vector<uint8_t> bytes_;
  size_t at_ = 0;
  int64_t expected_ = 0, jump_ = 0;  // next event number; size of the last jump in the numbers, while unconfirmed
  LogDamage damage_;

  enum class Look { event, not_sync, bad_length, beyond_end };
  Look look_at(size_t at, LogEvent& event) const;
  bool plausible(size_t at) const;
  size_t find_plausible(size_t from, size_t to) const;
  void note(const char* what, size_t offset);
  void check_number(int64_t number);
};

class LogWriter {
 public:
  LogWriter() = default;
  ~LogWriter() { close(); }
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Creates the file; refuses to replace an existing one unless told. InputError on failure. While it is open it is
  /// locked (flock), so that nobody takes it for one that was left.
  void open(const std::string& path, bool replace = false);
  /// Appends an event, with its number counted from 0. Whatever is older than a tenth of a second of log time is on its
  /// way to the disk when this returns. Takes no memory while the disk takes what it is given.
  /// False when the disk refuses, and error() says why: whole events written so far stay. A regular file is tried again
  /// at later writes, and what it refused is held until then, up to 64 MB; anything else is given up at once.
  bool write(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size) noexcept;
  /// The first event anew, of the same size: for what is known later than the beginning. Nothing where the file cannot
  /// be gone back in, a pipe.
  void write_first_again(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size);
  /// A file whose folder was removed is made again here, with all that was in it: in its old place, or else among the
  /// machine's temporary files; path() says where.
  bool flush() noexcept;
  /// To the disk itself (fdatasync), and closed.
  bool close() noexcept;
  /// Takes nothing more; what was taken until now stays, and error() too.
  void give_up() { given_up_ = true; }
  bool given_up() const { return given_up_; }
  const std::string& error() const { return error_; }
  const std::string& path() const { return path_; }
  int64_t events() const { return events_; }
  bool is_open() const { return fd_ >= 0; }

 private:
  void refused(int error_number, size_t done) noexcept;
  void bring_back() noexcept;
  void say_error(const char* what, const char* more = "", const char* end = "") noexcept;
  int fd_ = -1;
  bool regular_ = false, given_up_ = false;
  std::string path_, error_;
  std::vector<uint8_t> buffer_;
  std::vector<uint32_t> lengths_;  // of the events in the buffer
  int64_t events_ = 0, flushed_us_ = 0, file_bytes_ = 0;
};

}  // namespace limberg
