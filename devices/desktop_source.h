#pragma once
// Pointing devices of a desk as a stylus: a SpaceMouse through the socket of its daemon (spacenavd), and a mouse.
//
//   SpaceMouse  pushed, it moves the tip; twisted, it turns the shaft;
//               speed grows with the square of the push, so that a light
//               touch is precise. Button 0 presses, button 1 is the clutch.
//   mouse       moves the tip in the plane z = const; left button
//               presses, right button is the clutch; made for the
//               surface cursor, which takes motions and not places.
//
// A thread of its own reads and reconnects; readings come at 125 Hz while the device is there. No library is needed:
// the daemon's first protocol is packets of eight 32-bit numbers in the machine's byte order, type (0 motion, 1 press,
// 2 release), x, y, z, rx, ry, rz, period, or type and button number; a mouse is three bytes of /dev/input/mice.
#include <memory>
#include <string>

#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg {

struct DesktopSettings {
  enum Kind { space_mouse, mouse } kind = space_mouse;
  std::string path;        // empty: SPNAV_SOCKET or /var/run/spnav.sock; /dev/input/mice
  double full_mm_s = 120;  // SpaceMouse: speed at a full push (350 counts)
  double full_rad_s = 2;
  double mm_per_count = 0.1;  // mouse: 10 counts a mm are some 250 dots an inch
  double box_mm = 150;        // the tip stays within this of the origin, each way
  int32_t device_id = 400;
};

/// Bytes to a pose; no file, no clock.
class DesktopDecoder {
 public:
  explicit DesktopDecoder(const DesktopSettings& settings) : set_(settings) { pose_.device_id = settings.device_id; }
  void feed(const uint8_t* bytes, size_t n);
  /// Goes on for so long with what is pushed now.
  void advance(double dt_s);
  void let_go();  // the device is gone: nothing is pushed, no button is down
  const StylusSample& pose() const { return pose_; }
  int64_t malformed() const { return malformed_; }

 private:
  void packet();
  DesktopSettings set_;
  StylusSample pose_;
  Vec3 push_ = Vec3::Zero(), twist_ = Vec3::Zero();
  uint8_t byte_[32]{};
  size_t n_ = 0;
  int64_t malformed_ = 0;
};

class DesktopSource final : public Source {
 public:
  DesktopSource(const DesktopSettings& settings, const SourceTime& time);
  ~DesktopSource() override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override;
  std::string health() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
