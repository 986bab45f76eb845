#pragma once
// The emulated surgeon at a skull: a stylus in one hand draws osteotomies on the
// bone, a glove on the other points at fragments, closes, carries them and opens.
// Out come samples at 120 Hz: the stylus, and the two stations of the glove in turn.
//
//   osteotomy (contour)     the saw drawn round the contour with the stylus
//   move_fragment           the glove: points at the place that the line
//                           names (or at the middle of the fragment), closes,
//                           moves by the map that the line means, opens
//   everything else         told away from the hand, as from the panel of the window: planes and blades (no hand saws
//                           a plane free), plates, joins, work on the surface, tissue, landmarks, superpositions
//   stage, wait, undo, redo as the stylus does them
//
// With the stylus alone (HeadHands::stylus) a fragment is gripped by its tip and goes where the stylus is moved and
// turned. With the glove alone (HeadHands::glove) the saw is in the glove too: it points at where the contour begins,
// the surface cursor comes there, and thumb and forefinger close and push it round the contour. The eye sees where the
// cursor is (ToolFollower) and the hand corrects, as anybody's does; then it opens, points and grabs.
//
// A grab, drag or letting go of a script is no gesture: a line in problems(). Noise, tremor
// and gaps are those of SurgeonSettings; everything random comes from its seed. The glove is
// that of the shipped calibration: tips at the sensors, the forefinger along its sensor's x axis.
#include <memory>
#include <string>
#include <vector>

#include "devices/emulator.h"
#include "devices/force/tool_follower.h"

namespace limberg {

enum class HeadHands { stylus_and_glove, stylus, glove };

class EmulatedHeadSurgeon final : public Source, public ToolFollower {
 public:
  explicit EmulatedHeadSurgeon(std::vector<Command> script, const SurgeonSettings& settings = {},
                               HeadHands hands = HeadHands::stylus_and_glove);
  ~EmulatedHeadSurgeon() override;
  void look(const Snapshot& snapshot) override;  // keeps a pointer until the next poll
  void hold(const ToolState& tool) override;     // where the tool is seen
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override;
  SourceCounts counts() const override;
  const std::vector<std::string>& problems() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
