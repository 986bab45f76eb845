#include "tests/bench/devices/suite.h"

#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "calibration/pivot.h"
#include "calibration/registration.h"
#include "devices/rehearsal.h"
#include "sim/base/text.h"
#include "tests/bench/devices/force.h"
#include "tests/bench/devices/hand.h"
#include "tests/bench/devices/timing.h"

namespace limberg::bench {

namespace {

double us(int64_t ns) { return double(ns) * 1e-3; }

struct DevicesParts {
  DevicesSettings set;
  Result out;

  bool wants(const char* part) {
    if (!set.only.empty() && std::string(part).find(set.only) == std::string::npos) return false;
    if (set.progress) set.progress(part);
    return true;
  }
  Row& row(const std::string& name, const std::string& method, const std::string& settings, double error,
           const char* unit, const char* reference) {
    Row r;
    r.name = name, r.method = method, r.settings = settings;
    r.error = error, r.error_unit = unit, r.reference = reference;
    out.rows.push_back(r);
    return out.rows.back();
  }
  void bar(const char* name, double value, double limit, bool larger, const char* source) {
    out.bars.push_back({name, value, false, limit, larger, larger ? value >= limit : value <= limit, source});
  }

  void wake() {
    const double seconds = set.quick ? 2 : 8;
    for (const bool fifo : {true, false})
      for (const int hogs : {0, 2}) {
        const WakeFigures f = wake_trial(seconds, fifo, hogs);
        const double p99 = us(f.wake.percentile_ns(0.99));
        row("wake-up lateness", f.settings,
            text("p50 %.0f, p99 %.0f, p99.9 %.0f, max %.0f us; %llu of %llu late", us(f.wake.percentile_ns(0.5)), p99,
                 us(f.wake.percentile_ns(0.999)), us(f.wake.max_ns()), (unsigned long long)f.late,
                 (unsigned long long)f.ticks),
            p99, "us", "the tick's own time");
        if (fifo && hogs == 2 && f.settings.starts_with("SCHED_FIFO 80")) {
          bar("wake-up, FIFO, two hogs: p99, us", p99, 250, false,
              "a quarter of a tick; 50 to 105 us measured on 2026-11-21");
          bar("wake-up, FIFO, two hogs: share later than 1 ms", double(f.late) / double(std::max<uint64_t>(1, f.ticks)),
              0.005, false, "what remains is the host's, not ours");
        }
      }
  }

  void buffers() {
    for (const BufferFigures& f : buffer_trials(set.quick ? 100'000 : 400'000)) {
      row("buffer", f.name,
          text("alone %.0f / %.0f ns write / read; beside a spinning reader p50 %lld, p99 %lld, p99.9 %lld ns; %llu "
               "torn",
               f.ns_write, f.ns_read, (long long)f.writer.percentile_ns(0.5), (long long)f.writer.percentile_ns(0.99),
               (long long)f.writer.percentile_ns(0.999), (unsigned long long)f.torn),
          double(f.writer.percentile_ns(0.999)), "ns", "its own clock");
      if (f.name.starts_with("triple")) bar("triple buffer: torn values", double(f.torn), 0, false, "never");
    }
    for (const InversionFigures& f : inversion_trials(set.quick ? 1 : 4)) {
      row("priority inversion", f.name,
          text("FIFO writer, reader holds 20 us, two hogs: p50 %.1f, p99 %.1f, p99.9 %.1f, max %.1f us",
               us(f.writer.percentile_ns(0.5)), us(f.writer.percentile_ns(0.99)), us(f.writer.percentile_ns(0.999)),
               us(f.writer.max_ns())),
          us(f.writer.max_ns()), "us", "its own clock");
    }
  }

  void tracking() {
    const double seconds = set.quick ? 10 : 40;
    double best = 1e9;
    for (const double beta : {0.1, 0.5, 1.0, 2.0, 5.0}) {
      TrackingTrial t;
      t.seconds = seconds;
      t.filter.process_noise_mm2_s3 = 1e5;
      t.filter.euro_beta_per_mm = beta;
      const TrackingFigures f = tracking_trial(t);
      row("tracking, 60 Hz a station", text("One-Euro beta %.1f", beta),
          text("lag %.1f ms, at that lag %.2f mm, at rest %.3f mm, step %.2f mm, turn %.2f deg", f.lag_ms,
               f.rms_shifted_mm, f.jitter_mm, f.max_step_mm, f.turn_rms_deg),
          f.rms_mm, "mm", "where the hand was");
      if (f.lag_ms <= 2) best = std::min(best, f.rms_mm);
    }
    TrackingTrial d;
    d.seconds = seconds;
    const TrackingFigures f = tracking_trial(d);
    row("tracking, 60 Hz a station", "as calibration/identity.toml",
        text("lag %.1f ms, at rest %.3f mm, step %.2f mm", f.lag_ms, f.jitter_mm, f.max_step_mm), f.rms_mm, "mm",
        "where the hand was");
    d.two_stations = false;
    const TrackingFigures g = tracking_trial(d);
    row("tracking, 120 Hz", "as calibration/identity.toml",
        text("lag %.1f ms, at rest %.3f mm, step %.2f mm", g.lag_ms, g.jitter_mm, g.max_step_mm), g.rms_mm, "mm",
        "where the hand was");
    bar("tracking at 60 Hz, lag up to 2 ms: RMS, mm", best, 0.40, false,
        "a simulation with readings exactly 8.3 ms late (2026-11-21)");
  }

  void calibration() {
    double usual = 0;
    for (const double noise : {0.1, 0.44})
      for (const int poses : {50, 200, 800})
        for (const double cone : {20.0, 45.0}) {
          double sum2 = 0, worst = 0;
          const int rounds = set.quick ? 4 : 16;
          for (int k = 0; k < rounds; ++k) {
            PivotRehearsal r;
            r.seed = uint64_t(k + 1);
            r.cone_deg = 2 * cone;
            fastrak::LinkSettings link;
            link.role = fastrak::parse_roles("s");
            fastrak::EmulatorSettings device;
            device.seed = uint64_t(100 + k);
            device.noise_mm = noise, device.noise_rad = 0.0015;
            std::vector<SensorPose> p;
            for (const Sample& s : fastrak::readings_of(stylus_in_dimple(r), 8.5, link, device))
              if (const auto* t = std::get_if<TrackerSample>(&s))
                p.push_back({t->pos_mm, Eigen::Quaterniond(t->quat[0], t->quat[1], t->quat[2], t->quat[3])});
            std::vector<SensorPose> some;
            for (int i = 0; i < poses; ++i) some.push_back(p[size_t(i) * p.size() / size_t(poses)]);
            PivotLimits none;
            none.poses = 4;
            const double e = (calibrate_pivot(some, 1, none).tip_mm - r.tip_mm).norm();
            sum2 += e * e, worst = std::max(worst, e);
          }
          const double rms = std::sqrt(sum2 / rounds);
          row("stylus tip", text("%d poses within %.0f deg", poses, cone),
              text("noise %.2f mm an axis, 0.15 deg; worst of %d %.3f mm", noise, rounds, worst), rms, "mm",
              "the tip's truth");
          if (noise == 0.44 && poses == 200 && cone == 45) usual = worst;
        }
    bar("stylus tip, 200 poses within 45 deg: worst, mm", usual, 0.30, false,
        "0.20 mm in 95 of 100 by simulation (2026-11-21); the worst of 16 lies above");
  }

  void grabs() {
    GrabTrial idle;
    idle.idle_s = set.quick ? 600 : 3600;
    const GrabFigures a = grab_trial(idle);
    row("idle hand", text("%.0f s", a.idle_s),
        text("%lld readings, %lld damaged, opened no less than to %.0f mm", (long long)a.readings, (long long)a.damaged,
             a.least_aperture_mm),
        double(a.false_grabs), "", "no grab was meant");
    GrabTrial meant;
    meant.grabs = set.quick ? 200 : 1000;
    meant.seed = 3;
    const GrabFigures b = grab_trial(meant);
    row("grabs", text("%lld meant", (long long)b.meant),
        text("%lld within 50 ms, %lld missed, %lld extra; median %.0f ms, worst %.0f ms", (long long)b.in_time,
             (long long)b.missed, (long long)b.extra, b.median_ms, b.worst_ms),
        double(b.meant - b.in_time), "late", "the true crossing of the threshold");
    bar("idle hand: false grabs", double(a.false_grabs), 0, false, "none in an hour");
    bar("grabs seen within 50 ms, share", double(b.in_time) / double(std::max<int64_t>(1, b.meant)), 0.999, true,
        "999 of 1000");
  }

  void force() {
    const char* names[] = {"contact at 1 kHz, secant", "last force held", "tangent, contact frozen"};
    double least = 0, step = 0;
    for (const double k : {0.1, 0.3, 1.0, 3.0})
      for (const double hz : {30.0, 60.0, 120.0})
        for (const auto method : {ForceMethod::local, ForceMethod::hold, ForceMethod::tangent}) {
          ForceTrial t;
          t.method = method;
          t.stiffness_N_mm = k, t.solver_hz = hz, t.stiffening = 0.1;
          t.seconds = set.quick ? 4 : 10;
          const ForceFigures f = force_trial(t);
          row("force", names[int(method)],
              text("%.1f N/mm stiffening, solver %.0f Hz: least energy %.2f mJ, largest %.2f N, damper on %lld ticks, "
                   "slew %lld",
                   k, hz, f.least_energy_mJ, f.force_N, (long long)f.damped, (long long)f.slewed),
              f.largest_step_N, "N/ms", "from tick to tick");
          if (method == ForceMethod::local)
            least = std::min(least, f.least_energy_mJ), step = std::max(step, f.largest_step_N);
        }
    bar("force: least energy, mJ", least, -0.15, true, "the observer's spare of 0.1 mJ and a tick of the damper");
    bar("force: largest step, N/ms", step, 0.2 + 1e-9, false, "no felt step");
    ForceTrial s;
    s.seconds = 4;
    row("force", "cost", text("%.0f ns a tick", force_trial(s).ns_per_tick), 0, "", "process CPU time");
    for (const double k : {0.1, 0.5, 1.0}) {
      const StallFigures f = stall_trials(k, 0.03);
      row("force", "stall of 30 ms, 12 moments of a tap",
          text("%.1f N/mm: at the worst %.1f mm/s in the 100 ms after; %.1f without a stall, %.1f in free air; least "
               "energy %.2f mJ",
               k, f.stalled_mm_s, f.calm_mm_s, f.free_mm_s, f.energy_mJ),
          f.largest_step_N, "N/ms", "from tick to tick");
      bar("stall of 30 ms: the hand's speed after it, mm/s", f.stalled_mm_s, f.free_mm_s, false,
          "no more than the same hand moves in free air: it is let go, not thrown");
    }
  }
};

}  // namespace

Result devices_suite(const DevicesSettings& settings) {
  DevicesParts s{settings, {}};
  if (s.wants("wake")) s.wake();
  if (s.wants("buffers")) s.buffers();
  if (s.wants("tracking")) s.tracking();
  if (s.wants("calibration")) s.calibration();
  if (s.wants("grabs")) s.grabs();
  if (s.wants("force")) s.force();
  return s.out;
}

}  // namespace limberg::bench
