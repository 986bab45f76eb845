#include "devices/force/force_source.h"

#include <fmt/format.h>

namespace limberg {

ForceSource::ForceSource(std::unique_ptr<ForceDevice> device, const ForceSourceSettings& settings,
                         std::shared_ptr<StiffnessLine> line)
    : device_(std::move(device)),
      device_id_(settings.device_id),
      maker_(settings, std::move(line)),
      loop_(device_->limits()) {}

void ForceSource::look(const Snapshot& s) { maker_.look(s); }
void ForceSource::hold(const ToolState& state) { maker_.hold(state); }

void ForceSource::poll(int64_t now_ns, SampleSink& sink) {
  const ForceReading r = device_->read(now_ns);
  if (const ForceModel* model = maker_.make(now_ns, r.tip_mm, loop_.state())) loop_.take(*model);
  device_->push(loop_.tick(now_ns, r.tip_mm, r.valid).force_N);
  if (!r.valid) return;
  StylusSample s;
  s.device_id = device_id_;
  s.seq = seq_++;
  s.t_ns = now_ns;
  const ForceState& felt = loop_.state();
  s.tip_mm = felt.touching ? felt.proxy_mm : r.tip_mm;
  s.quat = r.quat;
  s.buttons = r.buttons | (maker_.cuts() && felt.cut ? 1u : 0u);
  sink.on_sample(s);
}

std::string ForceSource::health() const {
  const ForceCounts& c = loop_.counts();
  return fmt::format(
      "{}, force {:.2f} N, {} ticks, stiffness {:.3f} N/mm ({} models from the solver), {} saturated, {} slewed, {} "
      "with an old model, {} stalls, least energy {:.2f} mJ",
      device_->name(), loop_.state().force_N.norm(), c.ticks, model().stiffness_N_mm, answers(), c.saturated, c.slewed,
      c.stale, c.stalls, c.least_energy_mJ);
}

}  // namespace limberg
