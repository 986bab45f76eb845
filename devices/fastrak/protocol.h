#pragma once
// Records of a Polhemus FASTRAK, to bytes and from bytes (manual OPM00PI002 rev G).
//
// Every station sends the items 2 (position), 11 (quaternion), 16 (switch, stylus only) and 1 (CR LF):
//   binary  '0' station error | 3 float32 | 4 float32 | [blank '0'/'1'] | CR LF     33 or 35 bytes, little-endian
//   ASCII   '0' station error | 3 Sxxx.xx | 4 Sx.xxxx | [blank '0'/'1'] | CR LF     54 or 56 bytes
// Replies to commands begin with '2' and end with CR LF. The device is told to speak in centimetres.
//
// The line has no checksum. A record is taken only when it stands directly
// behind a CR LF (the one of the record or reply before it), its station is one
// that was asked for, its error character is a blank or a letter, it ends with
// CR LF, its switch is a switch, its numbers are finite, its position lies
// within kReachMm and its quaternion has unit length to 1 %. accepted_share()
// says what damage still passes; the jump gate of the tracking stands behind it.
//
// Parser is a state machine fed byte by byte: no clock, no allocation, at most 2 * kLongest bytes looked at again.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "sim/geometry/vec.h"

namespace limberg::fastrak {

inline constexpr int kStations = 4;
inline constexpr double kReachMm = 5000;            // the long-range transmitter reaches 4.6 m
inline constexpr size_t kLongest = 64;              // of a record or reply
inline constexpr double kStationsTogetherHz = 120;  // readings a second, shared by the active stations

/// What the stations were told to send.
struct Layout {
  bool binary = true;
  std::array<bool, kStations> active{true, true, false, false};
  std::array<bool, kStations> has_switch{};
  size_t record_bytes(int station) const {  // station from 1
    return (binary ? 33u : 54u) + (has_switch[size_t(station - 1)] ? 2u : 0u);
  }
  int active_count() const;
};

struct Record {
  int station = 1;
  char error = ' ';
  Vec3 pos_mm = Vec3::Zero();
  std::array<double, 4> quat{1, 0, 0, 0};  // w, x, y, z, unit length
  bool pressed = false;
  int64_t t_ns = 0;  // when its first byte came
};

/// The bytes of a record, as the device would send them. Numbers too large for the ASCII fields are cut to fit.
size_t encode(const Record& r, const Layout& layout, std::span<uint8_t, kLongest> out);

/// Share of damaged records that pass every check with a pose that differs, when one byte of `r` is replaced by another
/// value, all bytes and values equally likely: by trying them all. `far_mm`, `far_deg`: only those whose pose differs
/// by more than this (0, 0: any difference). Of those that pass nearly all sit in the mantissas of the position.
double accepted_share(const Record& r, const Layout& layout, double far_mm, double far_deg);

class Parser {
 public:
  class Sink {
   public:
    virtual ~Sink() = default;
    virtual void on_record(const Record& record) = 0;
    virtual void on_reply(std::span<const char> text) = 0;  // from '2' up to before CR LF
  };
  struct Counts {
    int64_t bytes = 0, records = 0, replies = 0;
    int64_t damaged = 0;        // runs of bytes that are neither record nor reply
    int64_t skipped_bytes = 0;  // in them
    int64_t errors = 0;         // records with an error letter
  };

  /// A fresh stream: what comes first may be a record.
  void reset(const Layout& layout);
  void feed(uint8_t byte, int64_t t_ns, Sink& sink);
  const Counts& counts() const { return counts_; }

 private:
  enum class Look { more, no, record, reply };
  Look look(Record& record, size_t& length) const;
  Look look_at_record(Record& record, size_t& length) const;
  Look look_at_reply(size_t& length) const;
  void drop(size_t n);

  Layout layout_;
  std::array<uint8_t, kLongest> byte_{};
  std::array<int64_t, kLongest> t_ns_{};
  size_t n_ = 0;
  uint8_t before_[2] = {'\r', '\n'};  // the two bytes in front of byte_[0]
  bool in_step_ = true;
  Counts counts_;
};

}  // namespace limberg::fastrak
