#pragma once
// The emulated surgeon: carries out an operation script with a stylus, as samples at 120 Hz.
//
// It looks at the newest snapshot before each sample and aims at the present place of each material point, as a surgeon
// does who sees the wound. Hands move along minimum-jerk paths (Flash and Hogan 1985), pause at corners, tremble at
// 8-12 Hz, and the tracker adds noise and gaps. Everything random comes from one seed, so that a stream follows from
// script, seed and patient alone. Drive it in lockstep with the session; it allocates when the topology changes.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "devices/source.h"
#include "sim/commands/command.h"

namespace limberg {

struct SurgeonSettings {
  uint64_t seed = 1;
  double rate_hz = 120;
  double draw_mm_s = 40;         // mean speed of a stroke
  double carry_mm_s = 150;       // mean speed through the air
  double corner_pause_s = 0.15;  // rest at corners, and before and after a press
  double settle_s = 0.25;        // look at the result after each command
  double hover_mm = 8;           // height above the skin between commands
  double tremor_mm = 0.12;       // amplitude, per axis
  double tremor_low_hz = 8, tremor_high_hz = 12;
  double noise_mm = 0.05;  // tracker, standard deviation per axis
  double noise_rad = 0.003;
  double dropouts_per_s = 0.1;  // mean rate of gaps
  double dropout_max_s = 0.06;  // their longest
  double start_s = 0.3;         // rest before the first command
  int32_t device_id = 100;
};

class EmulatedSurgeon final : public Source {
 public:
  explicit EmulatedSurgeon(std::vector<Command> script, const SurgeonSettings& settings = {});
  ~EmulatedSurgeon() override;
  void look(const Snapshot& snapshot) override;  // keeps a pointer until the next poll
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override;
  SourceCounts counts() const override;

  size_t command() const;  // the index of the script line being carried out; the script's length when done
  size_t commands() const;
  /// Aims that found no skin at their chart point, "command 3:
  /// point (x, y) is not on skin"; the command is passed over.
  const std::vector<std::string>& problems() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
