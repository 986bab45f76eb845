#pragma once
// What is connected to this machine, and what it can do there, in plain words; and whether what a room needs is there.
// Looks only: nothing is opened that another program may be using, but LCM, which many may hear at once.
#include <string>
#include <vector>

namespace limberg {

struct ConnectedThing {
  std::string what;    // "serial port /dev/ttyUSB0"
  bool there = false;  // false: it is looked for and is not here
  std::string can;     // what can be done with it, or what is missing
  std::string spec;    // of --device; empty: none
};

/// Mouse and keyboard, serial ports, SpaceMouse, drivers beside the program and in $LIMBERG_DRIVERS, headset.
std::vector<ConnectedThing> connected_things();

/// Why a device cannot be had now; empty: as far as can be told without opening it, it can. Of LCM: nothing is said,
/// it has to be heard. InputError: no spec of a device.
std::string missing_of(const std::string& device_spec);

/// Serial ports of this machine, by name.
std::vector<std::string> serial_ports();

}  // namespace limberg
