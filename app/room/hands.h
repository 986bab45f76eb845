#pragma once
// Whose hand it is that a room is set up with: a person's at real devices, or an emulated one that does what the steps
// ask for, well or badly, as a file says.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/room/steps.h"
#include "calibration/calibration.h"

namespace limberg {

class RoomHands {
 public:
  virtual ~RoomHands() = default;
  /// Everything that comes in so many seconds, from the beginning of the step on. `asked`: the step's name; "look":
  /// what is there at all? `enough` ends it earlier; `shown` is told how far it is, in s. Ends when interrupted().
  virtual std::vector<Sample> during(const std::string& asked, double seconds,
                                     const std::function<bool(const std::vector<Sample>&)>& enough,
                                     const std::function<void(double s)>& shown) = 0;
  virtual std::vector<std::string> specs() const = 0;
  virtual bool tracked() const = 0;
  /// What the devices say of themselves, a line each.
  virtual std::vector<std::string> health() const = 0;
  virtual bool emulated() const { return false; }
};

/// InputError: no live device, or one that cannot be opened.
std::unique_ptr<RoomHands> live_hands(const std::vector<std::string>& specs);

/// An emulated hand, by a TOML file. A number, or a list with one for each try of a step (the last one goes on):
///
///   limberg_hand = 1
///   seed = 1               of noise and tremor
///   stylus = true          which devices it has
///   glove = true
///   noise_mm = 0.2         of a reading
///   lost = 0               share of readings that are lost
///   cone_deg = 50          how far the stylus is turned in the hollow
///   touch_off_mm = 0       how far beside the second corner it touches
///   touches = 5            how many points
///   closed_mm = 18, open_mm = 85
///   line_off_mm = 0        how far beside the edge the stroke is drawn
///   lets_go = 0            how often the switch lets go on the way
///   grabs = 3
///   reach_mm = 300         from left to right; the other directions in proportion
struct EmulatedHand {
  uint64_t seed = 1;
  bool stylus = true, glove = true;
  std::vector<double> noise_mm{0.2}, lost{0}, cone_deg{50}, touch_off_mm{0}, touches{5}, closed_mm{18}, open_mm{85},
      line_off_mm{0}, lets_go{0}, grabs{3}, reach_mm{300};
};
/// Strict: InputError with file and line.
EmulatedHand parse_emulated_hand(const std::string& text, const std::string& file);
std::unique_ptr<RoomHands> emulated_hands(const EmulatedHand& hand, const std::string& spec);

}  // namespace limberg
