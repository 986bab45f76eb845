#pragma once
// `limberg bench devices`: the hand's side in figures. Parts: wake (the 1 kHz loop), buffers,
// tracking (error against lag), calibration (error against noise and poses), grabs, force (passivity against stiffness
// and solver rate beside the naive methods).
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct DevicesSettings {
  bool quick = false;
  std::string only;  // parts whose name contains this
  std::function<void(const std::string&)> progress;
};

Result devices_suite(const DevicesSettings& settings);

}  // namespace limberg::bench
