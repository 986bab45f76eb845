#pragma once
// A force device as a source: its tip is a stylus reading a thousand times a second, and what it touches pushes back.
//
// The model of what is near is made at the rate of the solver (model_maker.h).
//
// What is felt is what the hand holds (tool_follower.h): a scalpel punctures, and from then on until it is drawn out
// the tool is engaged, with or without a button; a hook that this hand holds pulls. In contact the tool is where the
// surface holds it up (the proxy of force_loop.h), and so is the reading that goes on: the device itself is deeper by
// what the force is worth.
// A session without such a source computes none of this.
#include <memory>

#include "devices/force/force_device.h"
#include "devices/force/model_maker.h"
#include "devices/force/tool_follower.h"
#include "devices/source.h"

namespace limberg {

class ForceSource final : public Source, public ToolFollower {
 public:
  ForceSource(std::unique_ptr<ForceDevice> device, const ForceSourceSettings& settings = {},
              std::shared_ptr<StiffnessLine> line = nullptr);
  void look(const Snapshot& snapshot) override;
  void hold(const ToolState& state) override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override { return {seq_, 0, 0}; }
  std::string health() const override;

  const ForceModel& model() const { return maker_.model(); }
  const ForceLoop& loop() const { return loop_; }
  int64_t answers() const { return maker_.answers(); }  // models whose stiffness the solver gave

 private:
  std::unique_ptr<ForceDevice> device_;
  const int32_t device_id_;
  ForceModelMaker maker_;
  ForceLoop loop_;
  int64_t seq_ = 0;
};

}  // namespace limberg
