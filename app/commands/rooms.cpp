// `limberg rooms`: what is connected, a set-up in five minutes, saved by name.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>

#include "app/assembly/device_specs.h"
#include "app/assembly/streams.h"
#include "app/commands/commands.h"
#include "app/program/interrupt.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/result.h"
#include "app/result/schema.h"
#include "app/room/connected.h"
#include "app/room/setup.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

struct RoomsOptions {
  std::string name, folder;
  std::vector<std::string> devices;
  bool check = false, replace = false, yes = false;
  CommonOptions common;
};

constexpr size_t kMostHand = 1 << 20;

std::string date_of_today() {
  const std::time_t now = std::time(nullptr);
  std::tm t{};
  gmtime_r(&now, &t);
  return fmt::format("{:04}-{:02}-{:02}", t.tm_year + 1900, t.tm_mon + 1, t.tm_mday);
}

std::unique_ptr<RoomHands> hands_of(const std::vector<std::string>& specs) {
  for (const std::string& text : specs) {
    const DeviceSpec spec(text);
    if (spec.kind != "emulated") continue;
    if (specs.size() > 1)
      throw InputError("", 0, "--device " + text + " beside others; expected an emulated hand by itself");
    return emulated_hands(parse_emulated_hand(read_whole_file(spec.rest, kMostHand, "an emulated hand"), spec.rest),
                          text);
  }
  return live_hands(specs);
}

/// What is heard over LCM in a moment.
ConnectedThing lcm_heard() {
  ConnectedThing t{"LCM on this machine", false, "nothing sends LIMBERG_STYLUS or LIMBERG_TRACKER", "lcm"};
  try {
    const std::unique_ptr<RoomHands> hands = live_hands({"lcm"});
    constexpr double kListen_s = 1;
    const std::vector<Sample> samples = hands->during("look", kListen_s, {}, {});
    const HeardDevices h = heard_in(samples);
    if (!samples.empty()) {
      t.there = true;
      t.can = fmt::format("{}, {:.0f} readings a second in all",
                          h.stylus && h.glove ? "a stylus and a glove"
                          : h.stylus          ? "a stylus"
                          : h.glove           ? "a glove"
                                              : "stations without a role",
                          double(samples.size()) / kListen_s);
    }
  } catch (const InputError& e) {
    t.can = e.what();
  }
  return t;
}

void tell_connected(const std::vector<ConnectedThing>& all) {
  std::printf("Connected now\n");
  for (const bool there : {true, false})
    for (const ConnectedThing& t : all) {
      if (t.there != there) continue;
      std::printf("  %-3s %-28s %s\n", there ? "yes" : "no", t.what.c_str(), t.can.c_str());
      if (there && !t.spec.empty()) std::printf("      %-28s --device %s\n", "", t.spec.c_str());
    }
}

/// Why a room cannot be used now; empty: it can.
std::string missing_in(const Room& r, const ConnectedThing& lcm) {
  std::string why;
  const auto add = [&](const std::string& text) { why += (why.empty() ? "" : "; ") + text; };
  for (const std::string& d : r.devices) {
    try {
      if (DeviceSpec(d).kind == "lcm" && DeviceSpec(d).rest.empty()) {
        if (!lcm.there) add("over LCM: " + lcm.can);
      } else if (const std::string missing = missing_of(d); !missing.empty()) {
        add(missing);
      }
    } catch (const InputError& e) {
      add(e.what());
    }
  }
  std::error_code ec;
  if (!r.calibration.empty() && !fs::exists(r.calibration, ec)) add("its calibration.toml is gone");
  return why;
}

int bad_checks(const Room& r) {
  return int(std::count_if(r.checks.begin(), r.checks.end(), [](const RoomCheck& c) { return !c.good(); }));
}

/// rooms: those that are saved; things: what is connected.
struct ResultThing {
  std::string what, can, device;
  bool there = false;
};
void fields(ResultThing& x, auto&& f) {
  f("what", x.what), f("there", x.there), f("can", x.can), f("device", x.device);
}
struct ResultRoomCheck {
  std::string step, what, unit;
  double value = 0, limit = 0;
  bool at_most = true, good = true;
};
void fields(ResultRoomCheck& x, auto&& f) {
  f("step", x.step), f("what", x.what), f("value", x.value), f("unit", x.unit), f("limit", x.limit);
  f("at_most", x.at_most), f("good", x.good);
}
struct ResultRoom {
  std::string name, date, missing;
  std::vector<std::string> devices;
  bool calibrated = false, usable_now = false;
  std::vector<ResultRoomCheck> checks;
};
void fields(ResultRoom& x, auto&& f) {
  f("name", x.name), f("date", x.date), f("devices", x.devices), f("calibrated", x.calibrated);
  f("usable_now", x.usable_now), f("missing", x.missing), f("checks", x.checks);
}
struct ResultRooms {
  MaybeList<ResultThing> connected;
  MaybeList<ResultRoom> rooms;
};
void fields(ResultRooms& x, auto&& f) { f("connected", x.connected), f("rooms", x.rooms); }

ResultRoom in_result(const Room& r, const std::string& missing) {
  ResultRoom x{r.name, r.date, missing, r.devices, !r.calibration.empty(), missing.empty(), {}};
  for (const RoomCheck& c : r.checks)
    x.checks.push_back({c.step, c.what, c.unit, c.value, c.limit, c.at_most, c.good()});
  return x;
}

void leave_rooms(const ResultRooms& rooms, bool ok, const CommonOptions& common) {
  if (common.json_file.empty()) return;
  Result r("rooms", "");
  write_fields(r, "", rooms);
  r.set_ok(ok);
  r.write(common.json_file);
}

int list_rooms(const RoomsOptions& o, const std::string& folder) {
  std::vector<ConnectedThing> things = connected_things();
  things.push_back(lcm_heard());
  tell_connected(things);
  std::vector<std::string> broken;
  const std::vector<Room> all = rooms_in(folder, broken);
  ResultRooms result{std::vector<ResultThing>(), std::vector<ResultRoom>()};
  for (const ConnectedThing& t : things) result.connected->push_back({t.what, t.can, t.spec, t.there});
  std::printf("\nRooms in %s\n", folder.c_str());
  for (const Room& r : all) {
    const std::string missing = missing_in(r, things.back());
    const int bad = bad_checks(r);
    std::string devices;
    for (const std::string& d : r.devices) devices += (devices.empty() ? "" : ", ") + d;
    std::printf("  %-24s %s, set up %s%s\n", r.name.c_str(), devices.c_str(), r.date.c_str(),
                bad > 0 ? fmt::format(", {} of its figures bad", bad).c_str() : "");
    std::printf("  %-24s %s\n", "",
                missing.empty() ? fmt::format("can be used: limberg run --room \"{}\"", r.name).c_str()
                                : ("cannot be used now: " + missing).c_str());
    result.rooms->push_back(in_result(r, missing));
  }
  if (all.empty()) std::printf("  none yet. limberg rooms NAME --device SPEC sets one up in five minutes\n");
  for (const std::string& b : broken) say(b);
  leave_rooms(result, broken.empty(), o.common);
  return broken.empty() ? kDone : kGoalMissed;
}

int tell_room(const RoomsOptions& o, const Room& r) {
  const bool over_lcm =
      std::any_of(r.devices.begin(), r.devices.end(), [](const std::string& d) { return DeviceSpec(d).kind == "lcm"; });
  const std::string missing = missing_in(r, over_lcm ? lcm_heard() : ConnectedThing{});
  std::printf("room        %s, set up %s\n", r.name.c_str(), r.date.c_str());
  for (const std::string& d : r.devices) std::printf("device      %s\n", d.c_str());
  std::printf("calibrated  %s\n", r.calibration.empty() ? "no" : r.calibration.c_str());
  for (const RoomCheck& c : r.checks) std::printf("  %s\n", in_words(c).c_str());
  std::printf("now         %s\n", missing.empty() ? "what it needs is connected" : missing.c_str());
  leave_rooms({{}, std::vector{in_result(r, missing)}}, missing.empty(), o.common);
  return missing.empty() ? kDone : kGoalMissed;
}

/// Writes it, whole, the room last: without room.toml there is no room.
void save_room(const std::string& folder, Room& r, const SetUpOutcome& o) {
  const std::string dir = (fs::path(folder) / r.name).string();
  prepare_folder(dir);
  std::error_code ec;
  fs::remove(fs::path(dir) / "room.toml", ec);
  if (o.calibrated) {
    Calibration c = o.calibration;
    c.name = r.name, c.date = r.date, c.device = r.devices.front();
    r.calibration = dir + "/calibration.toml";
    save_calibration(c, r.calibration);
  } else {
    fs::remove(fs::path(dir) / "calibration.toml", ec);
  }
  for (const auto& [step, samples] : o.heard)
    if (!samples.empty()) write_stream(dir + "/" + step + ".lcm", samples, true);
  write_whole_file(dir + "/room.toml", to_toml(r));
}

int set_room_up(const RoomsOptions& o, const std::string& folder) {
  const bool exists = has_room(folder, o.name);
  if (exists && !o.check && !o.replace)
    throw InputError("", 0,
                     "the room \"" + o.name +
                         "\" is set up already; expected another name, --replace to set it "
                         "up anew, or --check to try it");
  Room room;
  Calibration from;
  if (o.check) {
    room = open_room(folder, o.name);
    if (!room.calibration.empty()) from = load_calibration(room.calibration);
  }
  room.name = o.name;
  if (!o.devices.empty()) room.devices = o.devices;
  if (!o.check) prepare_folder(folder);
  const std::unique_ptr<RoomHands> hands = hands_of(room.devices);
  const SetUpOutcome done = set_up(*hands, {std::cin, std::cout, !o.yes, o.common.words()}, from, o.check);
  std::cout << std::flush;
  room.date = date_of_today();
  room.checks = done.checks;
  std::printf("\n");
  for (const std::string& title : done.not_good) std::printf("not good    %s\n", title.c_str());
  if (!done.usable && !o.check) {
    std::printf("nothing was saved\n");
    say(done.ended ? "ended before the room was set up" : "a step that calibrates was not good: the room is not saved");
    leave_rooms({{}, std::vector{in_result(room, "not set up")}}, false, o.common);
    return kGoalMissed;
  }
  if (!o.check) {
    save_room(folder, room, done);
    std::printf("room        %s/%s\nuse it      limberg run --room \"%s\"\n", folder.c_str(), room.name.c_str(),
                room.name.c_str());
  }
  const bool all = done.not_good.empty() && !done.ended;
  leave_rooms({{}, std::vector{in_result(room, "")}}, all, o.common);
  return all ? kDone : kGoalMissed;
}

int rooms(const RoomsOptions& o) {
  if (!o.common.json_file.empty()) o.common.prepare();
  const std::string folder = o.folder.empty() ? rooms_folder() : o.folder;
  if (o.name.empty()) {
    if (!o.devices.empty() || o.check)
      throw InputError("", 0, "rooms without a name; expected limberg rooms NAME --device SPEC");
    return list_rooms(o, folder);
  }
  check_room_name(o.name);
  if (o.devices.empty() && !o.check && !o.replace) {
    if (has_room(folder, o.name)) return tell_room(o, open_room(folder, o.name));
    throw InputError("", 0,
                     "there is no room \"" + o.name +
                         "\" yet; expected --device SPEC to set it up (limberg rooms lists what is connected)");
  }
  RoomsOptions with = o;
  if (o.devices.empty()) with.devices = open_room(folder, o.name).devices;
  return set_room_up(with, folder);
}

}  // namespace

void add_rooms(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<RoomsOptions>();
  CLI::App* c = app.add_subcommand("rooms", "What is connected; a room's devices set up in five minutes, by name");
  c->add_option("NAME", o->name, "Of a room: what it has; with --device it is set up, step by step");
  c->add_option("--device", o->devices,
                device_forms(true) + ", or emulated:FILE, a hand that does the steps (docs/rooms.md); may be repeated")
      ->type_name("SPEC");
  c->add_flag("--check", o->check, "Try a room that is set up: the steps that do not calibrate; nothing is saved");
  c->add_flag("--replace", o->replace, "Set up anew, with the room's own devices where none are named");
  c->add_flag("--yes", o->yes, "Begin each step by itself after three seconds, for hands that are full");
  c->add_option("--folder", o->folder,
                "Where rooms are kept (default: $XDG_CONFIG_HOME/limberg/rooms or "
                "~/.config/limberg/rooms)")
      ->type_name("DIR");
  o->common.add_json(*c), o->common.add_words(*c);
  c->footer(
      "Exit status 3: a step was not good, or what a room needs is not connected.\n"
      "Example: limberg rooms\n"
      "         limberg rooms theatre-2 --device fastrak:/dev/ttyUSB0,fts && limberg run --room theatre-2");
  c->callback([o, &chosen] { chosen = [o] { return rooms(*o); }; });
}

}  // namespace limberg
