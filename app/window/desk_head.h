#pragma once
// What the window's panel asks for and shows of a head: picking places, tissue between two of them, figures, the skull beside another.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/head/measures.h"
#include "app/window/skull_view.h"
#include "devices/sample.h"
#include "sim/snapshot.h"

namespace limberg {

struct DeskHead {
  std::array<char, 16> name{"M1"};   // of the next place picked
  int layers = 2;
  int mode = int(TissueKind::finite_elements);
  float face_radius_mm = 25, bone_radius_mm = 0, young_kPa = 10;  // bone 0: all of it
  SkullBeside beside = SkullBeside::off;
  std::string skull_word;
  // Asked for in this frame:
  bool pick = false, tie = false;

  /// Builds its part of a panel.
  void draw(const std::vector<HeadMeasure>& measures, bool has_face, float height);
  /// The control of a place picked at a triangle of the snapshot (-1: where the tool touches); its name is counted on.
  ControlSample picked(const Snapshot& snapshot, int32_t triangle, const Vec3f& bary);
  /// The control of tissue between the last places picked on face and bone; nothing until both are there.
  std::optional<ControlSample> tied() const;
  /// The control that tells the patient what the skull is to be shown beside, once after each choice: so that it is recorded.
  std::optional<ControlSample> laid_upon();
  /// What was done, in words: the skull laid upon another by a script or a recording is shown so here.
  void hear(const std::string& words);

 private:
  std::string on_face_, on_bone_;    // last names
  int next_ = 1;
  SkullBeside told_ = SkullBeside::off;
};

}  // namespace limberg
