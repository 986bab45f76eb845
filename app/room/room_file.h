#pragma once
// A room: devices as they stand there, their calibration, and what the set-up measured, saved under a name.
//
//   FOLDER/NAME/room.toml          what it has (below)
//   FOLDER/NAME/calibration.toml   of its stylus and glove, as `limberg calibrate` makes it; absent: none is needed
//   FOLDER/NAME/STEP.lcm           what the hand did in a step, for `limberg calibrate` and `limberg check`
//
//   limberg_room = 1
//   date = "2026-11-28"
//   devices = ["fastrak:/dev/ttyUSB0,fts"]
//   [[check]]
//   step = "rest"
//   what = "stylus: noise of a reading at rest"
//   value = 0.21
//   unit = "mm"
//   limit = 0.5
//   at_most = true
//
// FOLDER is $XDG_CONFIG_HOME/limberg/rooms, else ~/.config/limberg/rooms.
#include <string>
#include <vector>

namespace limberg {

/// A figure of the set-up and what it may be.
struct RoomCheck {
  std::string step, what, unit;
  double value = 0, limit = 0;
  bool at_most = true;  // else at least
  bool good() const { return at_most ? value <= limit : value >= limit; }
};

struct Room {
  std::string name, date;
  std::vector<std::string> devices;  // specs, as --device takes them
  std::string calibration;           // path; empty: none
  std::vector<RoomCheck> checks;
};

/// Strict: InputError with file and line. `folder`: where calibration.toml is looked for.
Room parse_room(const std::string& text, const std::string& file, const std::string& folder);
std::string to_toml(const Room& room);

/// $XDG_CONFIG_HOME/limberg/rooms or ~/.config/limberg/rooms. InputError: neither is set.
std::string rooms_folder();
/// InputError: no name of a room: letters, digits, blanks, - _ . and at most 60 bytes, not beginning with a dot.
void check_room_name(const std::string& name);

/// Of all rooms below a folder, by name; what cannot be read is told in `broken`, a line each.
std::vector<Room> rooms_in(const std::string& folder, std::vector<std::string>& broken);
bool has_room(const std::string& folder, const std::string& name);
/// InputError: there is none, with the names that there are; or it cannot be read.
Room open_room(const std::string& folder, const std::string& name);
/// A name in rooms_folder(), or the path of a room's own folder.
Room open_room(const std::string& name_or_path);

}  // namespace limberg
