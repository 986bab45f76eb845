#include "app/room/room_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "app/scene/quoted_toml.h"
#include "app/scene/toml_table.h"
#include "sim/base/whole_file.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostBytes = 1 << 20, kMostDevices = 16, kMostChecks = 200;

RoomCheck check_of(const toml::table& table, const std::string& file) {
  RoomCheck c;
  Table t(&table, "check", file);
  t.text("step", c.step, 40);
  t.text("what", c.what, 200);
  if (t.has("unit")) t.text("unit", c.unit, 20);
  t.real("value", c.value, -1e9, 1e9), t.real("limit", c.limit, -1e9, 1e9);
  t.boolean("at_most", c.at_most);
  if (c.step.empty() || c.what.empty()) t.fail("what", "is missing; expected step, what, value, limit and at_most");
  t.finish();
  return c;
}

std::string file_of(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name / "room.toml").string();
}

Room read_room(const fs::path& dir) {
  const std::string file = (dir / "room.toml").string();
  Room r = parse_room(read_whole_file(file, kMostBytes, "a room, as limberg rooms NAME saves it"), file, dir.string());
  r.name = (dir / ".").parent_path().filename().string();
  return r;
}

}  // namespace

Room parse_room(const std::string& text, const std::string& file, const std::string& folder) {
  const toml::table root = parse_toml(text, file, "a room, as limberg rooms NAME saves it");
  Room r;
  Table t(&root, "", file);
  t.first_format("limberg_room");
  if (t.has("date")) t.text("date", r.date, 40);
  const toml::node* devices = t.node("devices");
  const toml::array* list = devices ? devices->as_array() : nullptr;
  const char* const expected = "; expected devices = [\"fastrak:/dev/ttyUSB0,fts\"]";
  if (!list || list->empty() || list->size() > kMostDevices)
    t.fail("devices", std::string("is no list of devices") + expected);
  for (const toml::node& e : *list) {
    const auto spec = e.value<std::string>();
    if (!e.is_string() || !spec || spec->empty() || spec->size() > 1000 || spec->find('\0') != std::string::npos)
      t.fail("devices", std::string("holds what is no device") + expected);
    r.devices.push_back(*spec);
  }
  if (t.has("calibrated")) {
    bool calibrated = false;
    t.boolean("calibrated", calibrated);
    if (calibrated) r.calibration = (fs::path(folder) / "calibration.toml").string();
  }
  if (const toml::node* n = t.node("check")) {
    const toml::array* a = n->as_array();
    if (!a || a->size() > kMostChecks) t.fail("check", "is no list of at most 200 tables; expected [[check]]");
    for (const toml::node& e : *a) {
      if (!e.is_table()) t.fail("check", "holds what is no table; expected [[check]]");
      r.checks.push_back(check_of(*e.as_table(), file));
    }
  }
  t.finish();
  return r;
}

std::string to_toml(const Room& r) {
  std::string s = "limberg_room = 1\n";
  if (!r.date.empty()) s += "date = " + quoted_toml(r.date) + "\n";
  s += "devices = [";
  for (size_t i = 0; i < r.devices.size(); ++i) s += (i ? ", " : "") + quoted_toml(r.devices[i]);
  s += std::string("]\ncalibrated = ") + (r.calibration.empty() ? "false" : "true") + "\n";
  for (const RoomCheck& c : r.checks) {
    s += "\n[[check]]\nstep = " + quoted_toml(c.step) + "\nwhat = " + quoted_toml(c.what) + "\n";
    if (!c.unit.empty()) s += "unit = " + quoted_toml(c.unit) + "\n";
    s += fmt::format("value = {:.6g}\nlimit = {:.6g}\nat_most = {}\n", std::isfinite(c.value) ? c.value : 1e9, c.limit,
                     c.at_most);
  }
  return s;
}

std::string rooms_folder() {
  if (const char* xdg = std::getenv("XDG_CONFIG_HOME"); xdg && *xdg) return (fs::path(xdg) / "limberg/rooms").string();
  if (const char* home = std::getenv("HOME"); home && *home) return (fs::path(home) / ".config/limberg/rooms").string();
  throw InputError("", 0, "neither XDG_CONFIG_HOME nor HOME is set; expected one of them, or --folder DIR");
}

void check_room_name(const std::string& name) {
  const bool fine = !name.empty() && name.size() <= 60 && name[0] != '.' && name[0] != ' ' && name[0] != '-' &&
                    name.back() != ' ' && std::all_of(name.begin(), name.end(), [](unsigned char c) {
                      return c >= 128 || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                             c == ' ' || c == '-' || c == '_' || c == '.';
                    });
  if (!fine)
    throw InputError(
        "", 0,
        "\"" + name.substr(0, 80) + "\" is no name of a room; expected letters, digits, blanks, - _ . (at most 60)");
}

std::vector<Room> rooms_in(const std::string& folder, std::vector<std::string>& broken) {
  std::vector<Room> all;
  std::error_code ec;
  std::vector<fs::path> dirs;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end && dirs.size() < 1000; it.increment(ec))
    if (std::error_code none; fs::exists(it->path() / "room.toml", none)) dirs.push_back(it->path());
  std::sort(dirs.begin(), dirs.end());
  for (const fs::path& d : dirs) {
    try {
      all.push_back(read_room(d));
    } catch (const InputError& e) {
      broken.push_back(e.what());
    }
  }
  return all;
}

bool has_room(const std::string& folder, const std::string& name) {
  std::error_code ec;
  return fs::exists(file_of(folder, name), ec);
}

Room open_room(const std::string& folder, const std::string& name) {
  check_room_name(name);
  if (has_room(folder, name)) return read_room(fs::path(folder) / name);
  std::vector<std::string> broken;
  std::string list;
  for (const Room& r : rooms_in(folder, broken)) list += (list.empty() ? "" : ", ") + r.name;
  throw InputError("", 0,
                   "there is no room \"" + name + "\" in " + folder + "; expected " +
                       (list.empty() ? "one that limberg rooms NAME has set up" : "one of: " + list));
}

Room open_room(const std::string& name_or_path) {
  std::error_code ec;
  if (name_or_path.find('/') != std::string::npos && fs::exists(fs::path(name_or_path) / "room.toml", ec))
    return read_room(name_or_path);
  return open_room(rooms_folder(), name_or_path);
}

}  // namespace limberg
