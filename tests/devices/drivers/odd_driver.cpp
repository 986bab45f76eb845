// Drivers that are wrong in one way each, for the loader to refuse, and one that says what it is told to.
#include <cmath>
#include <cstdio>
#include <cstring>

#include "devices/driver/limberg_driver.h"

#ifndef ODD_ABI
#define ODD_ABI LIMBERG_DRIVER_ABI
#endif

namespace {
struct Device {
  char options[64] = "";
  int reads = 0;
};
}  // namespace

uint32_t limberg_driver_abi(void) { return ODD_ABI; }

void* limberg_driver_open(const char* options, char* why, size_t why_size) {
  if (std::strcmp(options, "absent") == 0) return std::snprintf(why, why_size, "no such device\n here"), nullptr;
  if (std::strcmp(options, "silent") == 0) return nullptr;
  auto* d = new Device;
  std::snprintf(d->options, sizeof d->options, "%s", options);
  return d;
}

void limberg_driver_describe(void* device, struct limberg_driver_description* d) {
  const char* o = static_cast<Device*>(device)->options;
  std::memset(d->name, 'x', sizeof d->name);  // without its end
  d->gives_force = std::strcmp(o, "forceful") == 0;
  if (std::strcmp(o, "late") == 0) d->delay_ms = 5, d->stiffness_N_mm = 2, d->damping_N_s_mm = 0.001;
  if (std::strcmp(o, "strong") == 0) d->peak_force_N = 1e6;
}

#ifndef ODD_WITHOUT_READ
int limberg_driver_read_pose(void* device, int, struct limberg_driver_pose* pose) {
  Device& d = *static_cast<Device*>(device);
  ++d.reads;
  pose->tip_mm[2] = d.reads;
  if (std::strcmp(d.options, "mad") == 0) pose->tip_mm[0] = std::nan("");
  if (std::strcmp(d.options, "twisted") == 0) pose->quat[0] = 7;
  if (std::strcmp(d.options, "leaves") == 0 && d.reads > 3) return LIMBERG_DRIVER_GONE;
  return std::strcmp(d.options, "mute") == 0 ? LIMBERG_DRIVER_NOTHING : LIMBERG_DRIVER_OK;
}
#endif

void limberg_driver_close(void* device) { delete static_cast<Device*>(device); }
