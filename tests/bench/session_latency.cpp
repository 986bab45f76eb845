#include "tests/bench/session_latency.h"

#include <fmt/format.h>

#include "app/assembly/assembly.h"
#include "app/pictures/pictures.h"
#include "app/session/realtime.h"
#include "devices/log_source.h"
#include "tests/bench/devices/hogs.h"

namespace limberg::bench {

void add_session_latency(Result& out, const Scene& scene, const std::vector<Sample>& samples, bool quick,
                         const std::function<void(const std::string&)>& progress) {
  const auto ms = [](const Histogram& h, double p) { return double(h.percentile_ns(p)) * 1e-6; };
  for (const bool fifo : {true, false})
    for (const int hogs : {0, 2}) {
      if (quick && (!fifo || hogs == 0)) continue;
      if (progress) progress(std::string("latency, ") + (fifo ? "SCHED_FIFO" : "SCHED_OTHER") + (hogs ? ", hogs" : ""));
      AssemblyOptions o;
      o.real_time = true;
      o.draw_frames = true;
      OffscreenFrames frames(scene, 640, 480);
      o.sink = &frames;
      Assembly a(scene, Calibration{}, o);
      a.front.add(std::make_unique<LogSource>(samples));
      SessionSettings set = a.session_settings();
      set.settle_steps = 1;
      RealTimeSettings rt;
      if (!fifo) rt.fifo_priority = 0;
      const Hogs busy(hogs);
      const SessionFigures f = run_realtime(a.lanes(nullptr), set, rt);
      std::string text;
      const auto row = [&](const char* what, const Histogram& h) {
        text = fmt::format("p50 {:.2f}, p99 {:.2f}, p99.9 {:.2f}, max {:.1f} ms", ms(h, 0.5), ms(h, 0.99), ms(h, 0.999),
                           double(h.max_ns()) * 1e-6);
        Row r;
        r.name = what;
        r.method = std::string(f.scheduling.find("SCHED_FIFO") != std::string::npos ? "SCHED_FIFO" : "SCHED_OTHER") +
                   (hogs ? ", two hogs" : ", no hogs of ours");
        r.settings = text;
        r.error = ms(h, 0.99);
        r.error_unit = "ms";
        r.reference = "the reading's time stamp";
        out.rows.push_back(r);
      };
      row("sample to snapshot", f.sample_to_snapshot);
      row("sample to frame", f.sample_to_frame);
      row("device tick, wake-up", f.device.wake);
      row("device tick, work", f.device.work);
    }
}

}  // namespace limberg::bench
