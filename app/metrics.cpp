#include "app/metrics.h"

#include <algorithm>

namespace limberg {

KeyMetrics key_metrics(const World& world) {
  Snapshot s;
  world.fill(s);
  KeyMetrics k;
  for (const SutureState& x : s.sutures) {
    k.closure_force_N += double(x.force_N);
    k.suture_gap_max_mm = std::max(k.suture_gap_max_mm, double(x.gap_mm));
  }
  return k;
}

void fill_metrics(Result& r, const World& world) {
  Snapshot s;
  world.fill(s);
  r.set("/metrics/pieces", world.pieces());
  r.set("/metrics/volume_mm3", world.volume_mm3());
  r.set("/metrics/initial_volume_mm3", world.initial_volume_mm3());
  r.set("/metrics/removed_volume_mm3", world.removed_volume_mm3());
  r.set_empty_list("/metrics/sutures");
  double largest = 0;
  for (size_t i = 0; i < s.sutures.size(); ++i) {
    const std::string p = "/metrics/sutures/" + std::to_string(i);
    r.set(p + "/id", s.sutures[i].id);
    r.set(p + "/force_N", double(s.sutures[i].force_N));
    r.set(p + "/gap_mm", double(s.sutures[i].gap_mm));
    largest = std::max(largest, double(s.sutures[i].force_N));
  }
  const KeyMetrics k = key_metrics(world);
  r.set("/metrics/closure_force_N", k.closure_force_N);
  r.set("/metrics/suture_force_max_N", largest);
  r.set("/metrics/suture_gap_max_mm", k.suture_gap_max_mm);
}

}  // namespace limberg
