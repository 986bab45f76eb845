#pragma once
// A force device that is waited for, as a source. Its thread answers each reading as soon as it has come:
//
//   port ── reading ──► [thread: force loop] ── force ──► port         50 to 100 us, whatever the device thread does
//                         ▲              │
//                  models, ring     readings, ring
//                         │              ▼
//                       device thread (1 kHz): model of what is near, stylus samples for everybody else
//
// Where none has come for 2 ms the newest one is answered again each millisecond. After 20 ms without
// one the force is none, until one comes again.
// The thread asks for real-time priority, one below the device thread's, unless told not to, and says what it got.
#include <memory>

#include "devices/force/force_port.h"
#include "devices/force/model_maker.h"
#include "devices/force/tool_follower.h"
#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg {

class WaitedForceSource final : public Source, public ToolFollower {
 public:
  static constexpr int64_t kSilentNs = 20'000'000;

  WaitedForceSource(std::unique_ptr<ForcePort> port, const SourceTime& time, const ForceSourceSettings& settings = {},
                    std::shared_ptr<StiffnessLine> line = nullptr, bool real_time = true);
  ~WaitedForceSource() override;
  void look(const Snapshot& snapshot) override;
  void hold(const ToolState& state) override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override;
  std::string health() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
