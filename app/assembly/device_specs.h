#pragma once
// What `--device SPEC` names, for every command that listens to devices: one table of kinds (device_kinds()), of which
// help and error messages are made too. A further device is a further row, and its source.
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "devices/force/stiffness_line.h"
#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg {

struct HeadsetShared;

/// What a live source is given when the clock starts.
struct LiveStart {
  SourceTime time;
  std::shared_ptr<StiffnessLine> stiffness;  // to a patient that can be felt; null: none
  std::shared_ptr<HeadsetShared> headset;    // what a headset shows; null: it shows nothing
};
using LiveSource = std::function<std::unique_ptr<Source>(const LiveStart&)>;

/// "fastrak" of "fastrak:/dev/ttyS0", and the rest.
struct DeviceSpec {
  std::string kind, rest;
  explicit DeviceSpec(const std::string& text);
};

struct DeviceKind {
  const char* name;
  const char* form;     // of its spec, as help says it
  const char* meaning;  // in a few words
  bool from_file = false;
  bool tracked = false;   // its places are those of a tracker: they mean little without a calibration
  bool own_hand = true;   // something beside the mouse of the desk that a person operates with
  bool feels = false;     // pushes back, by the wall's clock
  bool shows = false;     // it is seen through: a headset
  bool over_lcm = false;  // what is published comes back through it
  /// Null: `run` makes it of the file. InputError where the spec is badly put; no source where it means nothing.
  LiveSource (*live)(const DeviceSpec& spec, int number) = nullptr;
};
std::span<const DeviceKind> device_kinds();
/// Null: there is none of this name.
const DeviceKind* device_kind(const DeviceSpec& spec);
/// The forms of all device kinds, or of the live kinds only: "lcm[:URL], spacemouse[:SOCKET] or ...".
std::string device_forms(bool live_only = false);

/// The live source that a spec names, or nothing when it names one of the others. InputError: a known kind that is
/// badly put. `number` tells devices of one kind apart.
LiveSource live_source(const DeviceSpec& spec, int number);

}  // namespace limberg
