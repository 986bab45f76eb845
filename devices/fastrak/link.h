#pragma once
// The conversation with a FASTRAK, without the line: bytes and times in, bytes and readings out.
//
//   hush       continuous output off; what still comes is thrown away until the line is quiet
//   ask        'S': the status record must come; every second failure asks for a reinitialisation (^Y, ten seconds)
//   configure  centimetres, output list, switch and hemisphere per station,
//              filters of the device off (they lag by up to 162 ms; manual,
//              appendix E), then which stations are active is read back
//   run        'C': records; when none has come for watchdog_ms, it starts again at hush
//
// A reading's time: the first byte of its record left the device kOutputDelayNs after the station was sampled.
// Operating systems hand bytes over late and in lumps, never early; so each station's arrivals are held
// against its steady period and an arrival later than that counts as late, not as a slower device (Stamps).
//
// A point and its mirror image through the transmitter look alike to the device. It answers within a hemisphere; a hand
// that crosses its edge appears mirrored, and is mirrored back while that continues the motion (MirrorGuard).
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "devices/fastrak/protocol.h"
#include "devices/sample.h"

namespace limberg::fastrak {

inline constexpr int64_t kOutputDelayNs = 4'200'000;  // apparent latency with light filters (manual, appendix E)

struct LinkSettings {
  std::array<StationRole, kStations> role{StationRole::forefinger, StationRole::thumb, StationRole::none,
                                          StationRole::none};
  bool binary = true;
  std::array<Vec3, kStations> hemisphere{Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX()};
  int baud = 115200;  // of the port; here it says how long a record takes
  int32_t device_id = 200;
  int64_t quiet_ms = 150, answer_ms = 1000, reinitialise_ms = 10'500, watchdog_ms = 1500, tell_ms = 40;
};

/// "ft", "s", "fts", "-s", "ftFT": the role of each station, f forefinger, t thumb, F and T those of a second glove, s
/// stylus, - none. InputError on others.
std::array<StationRole, kStations> parse_roles(const std::string& letters);

/// Times of readings that are taken at a steady period and arrive late by varying amounts.
class Stamps {
 public:
  explicit Stamps(double period_ns = 0) : period_(period_ns) {}
  int64_t stamp(int64_t arrival_ns);

 private:
  double period_ = 0, last_ = 0;
  bool started_ = false;
};

class MirrorGuard {
 public:
  /// Turns p into its mirror image where that is what continues the motion. True when it did.
  bool straighten(Vec3& p_mm, int64_t t_ns);

 private:
  Vec3 last_ = Vec3::Zero();
  int64_t last_ns_ = -1;
};

class Link final : private Parser::Sink {
 public:
  enum class Phase { closed, hush, ask, reinitialise, configure, confirm, run };
  class Receiver {
   public:
    virtual ~Receiver() = default;
    virtual void on_reading(const TrackerSample& sample) = 0;
  };
  struct Counts {
    Parser::Counts parser;
    int64_t readings = 0, restarts = 0, mirrored = 0, refused_setup = 0;
  };

  explicit Link(const LinkSettings& settings);
  /// The line is there (again), or gone. Nothing of a conversation survives it.
  void opened(int64_t now_ns);
  void closed();
  /// Bytes as they come; `now_ns`: when they were read.
  void receive(const uint8_t* bytes, size_t n, int64_t now_ns, Receiver& receiver);
  /// Call every 10 ms or so.
  void tick(int64_t now_ns);
  /// What is to be sent; empties it.
  std::vector<uint8_t> take_output();

  Phase phase() const { return phase_; }
  const char* phase_name() const;
  const std::string& status() const { return status_; }  // the device's own words, once it has answered
  Counts counts() const;

 private:
  void on_record(const Record& record) override;
  void on_reply(std::span<const char> text) override;
  void enter(Phase phase, int64_t now_ns);
  void say(const std::string& text) { out_.insert(out_.end(), text.begin(), text.end()); }
  void configure();

  LinkSettings set_;
  Layout layout_;
  Parser parser_;
  Phase phase_ = Phase::closed;
  int64_t since_ns_ = 0, last_byte_ns_ = 0, last_record_ns_ = 0;
  int failures_ = 0;
  int confirmed_ = 0, to_confirm_ = 0;
  std::string status_;
  std::vector<uint8_t> out_;
  std::array<Stamps, kStations> stamps_;
  std::array<MirrorGuard, kStations> mirror_;
  std::array<int64_t, kStations> seq_{};
  int64_t readings_ = 0, restarts_ = 0, mirrored_ = 0, refused_ = 0;
  Receiver* receiver_ = nullptr;  // during receive() only
  int64_t now_ns_ = 0;
};

}  // namespace limberg::fastrak
