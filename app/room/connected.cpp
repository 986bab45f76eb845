#include "app/room/connected.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "app/assembly/device_specs.h"
#include "app/headset/session.h"
#include "devices/driver/driver_port.h"
#include "sim/base/error.h"
#include "sim/base/part.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

bool exists(const std::string& file) {
  std::error_code ec;
  return fs::exists(file, ec);
}

std::vector<std::string> names_in(const std::string& dir) {
  std::vector<std::string> out;
  std::error_code ec;
  for (fs::directory_iterator it(dir, ec), end; !ec && it != end && out.size() < 200; it.increment(ec))
    out.push_back(it->path().string());
  std::sort(out.begin(), out.end());
  return out;
}

std::string spacemouse_socket() {
  const char* socket = std::getenv("SPNAV_SOCKET");
  return socket && *socket ? socket : "/var/run/spnav.sock";
}

bool display() {
  const auto set = [](const char* name) {
    const char* v = std::getenv(name);
    return v && *v;
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

/// Shared libraries that may be drivers: beside the program, in an installation, and where one says.
std::vector<std::string> driver_files() {
  std::vector<std::string> out;
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec).parent_path();
  std::vector<fs::path> dirs{program / "drivers", program.parent_path() / "lib/limberg/drivers"};
  if (const char* more = std::getenv("LIMBERG_DRIVERS"); more && *more) dirs.emplace_back(more);
  for (const fs::path& d : dirs)
    for (const std::string& f : names_in(d.string()))
      if (f.ends_with(".so")) out.push_back(f);
  return out;
}

}  // namespace

std::vector<std::string> serial_ports() {
  std::vector<std::string> found;
  for (const std::string& p : names_in("/dev")) {
    const std::string name = fs::path(p).filename().string();
    if (name.starts_with("ttyUSB") || name.starts_with("ttyACM") || name.starts_with("ttyS")) found.push_back(p);
  }
  for (const std::string& p : names_in("/dev/serial/by-id")) found.push_back(p);
  found.resize(std::min<size_t>(found.size(), 64));
  return found;
}

std::vector<ConnectedThing> connected_things() {
  std::vector<ConnectedThing> all;
  all.push_back(
      {"mouse and keyboard", display(),
       display() ? "operate in the window: limberg run" : "there is no desktop (DISPLAY): no window can be opened",
       ""});
  const bool mice = access("/dev/input/mice", R_OK) == 0;
  all.push_back({"mouse as a stylus", mice,
                 mice                        ? "pushes the surface cursor: limberg run --cursor 0.5"
                 : exists("/dev/input/mice") ? "/dev/input/mice may not be read: belong to the group input"
                                             : "there is no /dev/input/mice",
                 "mouse"});
  const bool space = exists(spacemouse_socket());
  all.push_back(
      {"SpaceMouse", space,
       space ? "six directions, two buttons" : "its daemon (spacenavd) does not answer at " + spacemouse_socket(),
       "spacemouse"});
  const std::vector<std::string> ports = serial_ports();
  for (const std::string& p : ports) {
    const bool mine = access(p.c_str(), R_OK | W_OK) == 0;
    all.push_back({"serial port " + p, mine,
                   mine ? "a FASTRAK may be on it: stylus, and a glove by two stations"
                        : "may not be used: belong to the group dialout",
                   "fastrak:" + p + ",fts"});
  }
  if (ports.empty()) all.push_back({"serial ports", false, "none: a FASTRAK needs one, or a USB adapter", ""});
  for (const std::string& f : driver_files()) {
    ConnectedThing d{"driver " + fs::path(f).filename().string(), true, "", "driver:" + f};
    try {
      load_driver(f);
      d.can = "loads; pushes back where its device does. The device itself is looked for when it is used";
    } catch (const InputError& e) {
      d.there = false, d.can = e.what();
    }
    all.push_back(std::move(d));
  }
  const std::string runtime = headset_runtime_file();
  all.push_back({"headset", !runtime.empty(),
                 runtime.empty() ? "no runtime of OpenXR is installed (SteamVR, Monado)"
                                 : "runtime at " + runtime + "; both eyes, controllers, hands: needs ./do headset",
                 "headset"});
  return all;
}

std::string missing_of(const std::string& text) {
  const DeviceSpec spec(text);
  const DeviceKind* kind = device_kind(spec);
  if (!kind) throw InputError("", 0, "device " + text + ": unknown; expected " + device_forms());
  if (kind->from_file) return exists(spec.rest) ? "" : spec.rest + " is not there";
  const std::string head = spec.rest.substr(0, spec.rest.find(','));
  if (spec.kind == "fastrak")
    return !exists(head)                            ? head + " is not there: is the cable in?"
           : access(head.c_str(), R_OK | W_OK) != 0 ? head + " may not be used: belong to the group dialout"
                                                    : "";
  if (spec.kind == "spacemouse") {
    const std::string socket = spec.rest.empty() ? spacemouse_socket() : spec.rest;
    return exists(socket) ? "" : "spacenavd does not answer at " + socket;
  }
  if (spec.kind == "mouse") {
    const std::string file = spec.rest.empty() ? "/dev/input/mice" : spec.rest;
    return access(file.c_str(), R_OK) == 0 ? "" : file + " cannot be read";
  }
  if (spec.kind == "driver") {
    try {
      load_driver(head);
    } catch (const InputError& e) {
      return e.what();
    }
  }
  if (spec.kind == "headset" && headset_runtime_file().empty()) return "no runtime of OpenXR is installed";
  return "";
}

}  // namespace limberg
