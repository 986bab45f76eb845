#pragma once
// The other end of the line: a FASTRAK that does not exist, for tests, rehearsals and demonstrations without a device.
//
// It understands the commands that the manual lists for output, stations, units, hemisphere, filters, status and
// reinitialisation, answers as the device does and sends records of a known motion: the active stations one after the
// other, 120 samples a second together. Its faults are seeded: noise, bytes lost, changed and put in, a station that is
// unplugged, an error letter. It knows no clock and no line: EmulatedPort gives it both.
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "devices/fastrak/protocol.h"
#include "devices/motion.h"

namespace limberg::fastrak {

/// Where a station truly is.
struct StationPose {
  Vec3 pos_mm = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  bool pressed = false;
};
using Motion = std::function<StationPose(int station, double t_s)>;

struct EmulatorSettings {
  uint64_t seed = 1;
  double noise_mm = 0.05, noise_rad = 0.0005;  // standard deviation per axis of a reading
  double damage_per_byte = 0;                  // share of bytes that are lost, changed or followed by a stray one
  std::array<bool, kStations> plugged{true, true, true, true};
  int64_t output_delay_ns = 4'200'000;  // from the sample to the first byte
};

class Emulator {
 public:
  Emulator(Motion motion, const EmulatorSettings& settings = {});

  /// Bytes that the computer sent.
  void receive(const uint8_t* bytes, size_t n, int64_t now_ns);
  /// Everything that it has sent up to now_ns, in order; times must grow.
  std::vector<uint8_t> send(int64_t now_ns);

  // What happens to the device.
  void plug(int station, bool in) { set_.plugged[size_t(station - 1)] = in; }
  void error(char letter) { error_ = letter; }  // of all records from now on; ' ': none
  EmulatorSettings& settings() { return set_; }

  const Layout& layout() const { return layout_; }
  bool centimetres() const { return centimetres_; }
  /// The records sent, before any damage; with the time of the sample, and its true pose.
  struct Sent {
    Record record;
    int64_t sample_ns = 0;
    Vec3 true_mm = Vec3::Zero();
  };
  std::vector<Sent> sent;  // grows while keep_sent is set
  bool keep_sent = false;

 private:
  void command(const std::string& text, int64_t now_ns);
  void answer(const std::string& text);
  void record(int station, int64_t sample_ns);
  void power_on();

  Motion motion_;
  EmulatorSettings set_;
  RandomStream random_;
  Layout layout_;  // of the present output; item lists per station
  std::array<std::vector<int>, kStations> items_;
  std::array<Vec3, kStations> hemisphere_;
  bool continuous_ = false, centimetres_ = false, stopped_ = false;
  char error_ = ' ';
  std::string line_;  // a command that waits for its CR
  int64_t next_sample_ns_ = 0, busy_until_ns_ = -1;
  int next_station_ = 0;
  std::vector<uint8_t> out_;
};

/// A hand in a glove: stations 1 and 2 on forefinger and thumb, station 3 a stylus in the other hand. It wanders about
/// the middle of the working space with the speed of a hand at work, closes and opens every two seconds, and trembles.
Motion hand_at_work(uint64_t seed);

}  // namespace limberg::fastrak
