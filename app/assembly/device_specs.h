#pragma once
// What `--device SPEC` names, for every command that listens to devices:
//
//   emulated:SCRIPT                       the emulated surgeon (needs the patient that it operates on)
//   log:FILE                              a recording
//   lcm, lcm:URL                          LCM on this machine; lcm-from-anywhere:URL also what comes from others
//   fastrak:PORT[,ROLES][,ascii][,RATE]   a FASTRAK on a serial port; roles a letter a station: f forefinger, t thumb,
//   s stylus
//   fastrak-emulator[:ROLES]              the same with the emulator on a pseudo-terminal, a hand at work
//   spacemouse[:SOCKET]                   a SpaceMouse through spacenavd
//   mouse[:FILE]                          a mouse (/dev/input/mice); made for run --cursor
//   force-simulated                       a force device made of equations, in a hand that presses and strokes
#include <functional>
#include <memory>
#include <string>

#include "devices/force/stiffness_line.h"
#include "devices/source.h"

namespace limberg {

/// What a live source is given when the clock starts.
struct LiveStart {
  int64_t start_ns = 0;                      // CLOCK_MONOTONIC at tick 0
  std::shared_ptr<StiffnessLine> stiffness;  // to a patient that can be felt; null: none
};
using LiveSource = std::function<std::unique_ptr<Source>(const LiveStart&)>;

inline constexpr const char* kDeviceSpecs =
    "emulated:SCRIPT, log:FILE, lcm, lcm:URL, lcm-from-anywhere:URL, fastrak:PORT[,ROLES][,ascii][,RATE], "
    "fastrak-emulator[:ROLES], spacemouse, mouse or force-simulated";

/// "fastrak" of "fastrak:/dev/ttyS0", and the rest.
struct DeviceSpec {
  std::string kind, rest;
  explicit DeviceSpec(const std::string& text);
};

/// The live source that a spec names, or nothing when it names one of the others. InputError: a known kind that is
/// badly put. `number` tells devices of one kind apart.
LiveSource live_source(const DeviceSpec& spec, int number);

}  // namespace limberg
