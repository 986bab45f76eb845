#pragma once
// What the window's panel asks for and shows of a head: picking places, sawing through them, fragments moved by
// numbers, snapped, plated and joined, tissue between face and bone, figures, the skull beside another.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "app/head/measures.h"
#include "app/window/skull_view.h"
#include "app/words/words.h"
#include "devices/sample.h"
#include "sim/commands/command.h"
#include "sim/geometry/vec.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct DeskHead {
  std::array<char, 16> name{"M1"};  // of the next place picked
  ConnectTissue tissue;             // as the panel shows it; its name and places are those of the picks
  bool outlined = false;            // within the places picked on the face, where there are three or more
  SkullBeside beside = SkullBeside::off;
  std::string skull_word;
  std::array<float, 3> shift_mm{}, turn_deg{};  // of the fragment that was picked last: right, forward, up
  int ring = 4;                                 // places of a closed line to saw along
  float saw_radius_mm = 0;                      // of a plane; 0: all that it cuts
  // Asked for in this frame:
  bool pick = false, tie = false;
  enum class Ask : uint8_t { nothing, saw_round, saw_plane, shift, snap, plate, join } ask = Ask::nothing;

  /// Builds its part of a panel.
  void draw(const std::vector<HeadMeasure>& measures, bool has_face, float height, const Words& words);
  /// The names of the landmarks that the patient has now: a place that was picked counts as long as it is among them.
  /// `now_mm`: where each of them is now.
  void see(const std::vector<std::string>& landmarks, std::span<const Vec3f> now_mm = {});
  /// Names a place picked at a triangle of the snapshot, or asks where the tool touches (-1); the name is counted on.
  std::variant<Command, ControlSample> picked(const Snapshot& snapshot, int32_t triangle, const Vec3f& bary);
  /// Tissue between the last places picked on face and bone, where they are now; nothing until both are there.
  std::optional<Command> tied() const;
  /// What the panel asked for of bone, from the places picked there; nothing where places are missing.
  std::vector<Command> asked() const;
  /// What the skull is to be shown beside, once after each choice: so that it is recorded.
  std::optional<Command> laid_upon();
  /// What was done, in words: the skull laid upon another by a script or a recording is shown so here.
  void hear(const std::string& words);

 private:
  bool button_for(const Words& w, size_t places, const char* what);
  void bones(const Words& w);
  void between(bool has_face, const Words& w);
  void figures(const std::vector<HeadMeasure>& measures, float height, const Words& w);
  std::string named(size_t last) const;  // the last so many places on bone, in words

  struct Pick {
    std::string name;
    Vec3 X_mm = Vec3::Zero();  // at rest; on bone, where the tool touched it, not known
    Vec3 now_mm = Vec3::Zero();
    enum class On : uint8_t { face, bone, touched } on = On::bone;
  };
  std::vector<Pick> picked_;  // in their order, what was undone too: it may be done again
  std::vector<Pick> on_face_, on_bone_,
      placed_;  // of those that the patient has: on the face, on bone, of these those whose place is known
  int next_ = 1;
  SkullBeside told_ = SkullBeside::off;
};

}  // namespace limberg
