// The plan (surgeon_plan.h) says what to do next; here is how: where the tip should be now, against the newest
// snapshot, what the hand's tremor adds to that, and what of it the tracker sees.
#include "devices/emulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "devices/motion.h"
#include "devices/surgeon_plan.h"
#include "sim/base/elementary.h"
#include "sim/patient/snapshot.h"

namespace limberg {

namespace {

constexpr double kMinTravelS = 0.15;
constexpr double kDragDeg = 20;      // the handle of a drawing tool leans back along the path
constexpr double kRestLeanDeg = 30;  // otherwise it leans towards the surgeon
constexpr double kWristS = 0.08;     // time constant of turning the handle

}  // namespace

struct EmulatedSurgeon::Impl {
  Impl(std::vector<Command> commands, const SurgeonSettings& settings)
      : script(std::move(commands)),
        set(settings),
        plan(settings),
        tremor(settings.seed * 4 + 1, settings.tremor_mm, settings.tremor_low_hz, settings.tremor_high_hz),
        dropouts(settings.seed * 4 + 2, settings.dropouts_per_s, settings.dropout_max_s),
        noise(settings.seed * 4 + 3) {}

  std::vector<Command> script;
  SurgeonSettings set;
  SurgeonPlan plan;
  Tremor tremor;
  Dropouts dropouts;
  RandomStream noise;

  Sight sight;
  size_t command = 0;
  bool begun = false, started = false, finished = false, pressed = false;

  double step_start_s = 0, step_seconds = 0;
  bool step_begun = false;
  Vec3 step_from = Vec3::Zero();
  bool ends_known = false;  // of the present step's path in space
  uint64_t ends_version = 0;
  std::array<SkinTouch, 2> ends;
  Vec3 tip{0, -30, 40}, up = Vec3::UnitZ(), shaft = Vec3::UnitZ(), wanted_shaft = Vec3::UnitZ();
  int64_t sample = 0, stylus_seq = 0, control_seq = 0, sent = 0;

  // ---- looking ----

  /// The present place of an aim. When what it aims at is gone, the tip stays where it is.
  Vec3 place(const Aim& a) {
    if (a.kind == Aim::skin) {
      const SkinTouch t = sight.skin_at(a.chart, Sight::kRimMm);
      if (t.triangle < 0) return tip;
      up = t.normal;
      return t.x_mm + a.height_mm * t.normal;
    }
    if (a.kind == Aim::rest) {
      const SkinTouch t = sight.skin_at(a.rest_mm);
      if (t.triangle < 0) return tip;
      up = t.normal;
      return t.x_mm + a.height_mm * t.normal;
    }
    Vec3 p = a.world_mm;
    if (a.kind == Aim::handle) {
      const HookState* h = sight.hook(a.hook);
      if (!h) return tip;
      p = h->handle_mm.cast<double>();
    }
    return p + a.height_mm * sight.body().chart_normal();
  }

  struct Piece {
    size_t to;  // of the path: the place at its end
    double share;
  };
  static Piece piece_at(const Step& s, double l) {
    size_t i = 1;
    while (i + 1 < s.path.size() && s.length[i] < l) ++i;
    const double piece = s.length[i] - s.length[i - 1];
    return {i, piece > 0 ? std::clamp((l - s.length[i - 1]) / piece, 0.0, 1.0) : 0};
  }

  ChartPoint along(const Step& s, double l, Vec2* direction = nullptr) const {
    const auto [i, t] = piece_at(s, l);
    const double piece = s.length[i] - s.length[i - 1];
    if (direction) *direction = piece > 0 ? Vec2((s.path[i] - s.path[i - 1]) / piece) : Vec2(1, 0);
    return s.path[i - 1] + t * (s.path[i] - s.path[i - 1]);
  }

  /// `on` is the skin under a path along a wound's edge, at `share` between two of its places. A bent edge's chord
  /// crosses the cut: what lies there at rest may have been carried elsewhere, and a hand goes straight on.
  static Vec3 kept_on_edge(const Vec3& on, const Vec3& from, const Vec3& to, double share) {
    constexpr double kBeside_mm = 1, kBend = 0.5;  // of the chord; a half circle's
    const Vec3 straight = from + share * (to - from);
    return (on - straight).norm() <= std::max(kBeside_mm, kBend * (to - from).norm()) ? on : straight;
  }
  Vec3 kept_on_edge(const Step& s, double l, const Vec3& on) const {
    const auto [i, share] = piece_at(s, l);
    const SkinTouch a = sight.skin_at(s.path[i - 1], Sight::kRimMm), b = sight.skin_at(s.path[i], Sight::kRimMm);
    return a.triangle < 0 || b.triangle < 0 ? on : kept_on_edge(on, a.x_mm, b.x_mm, share);
  }

  /// Where the ends of a path in space lie now. They are looked for once: that is a pass over all the skin.
  std::array<SkinTouch, 2> ends_now(const Step& s) {
    const Snapshot& seen = *sight.seen;
    if (!ends_known || ends_version != seen.topology->version)
      ends = {sight.skin_at(s.rest_path.front()), sight.skin_at(s.rest_path.back())};
    ends_known = true, ends_version = seen.topology->version;
    return {touch_at(seen, ends[0].triangle, ends[0].bary, 0), touch_at(seen, ends[1].triangle, ends[1].bary, 0)};
  }

  /// The place on a path in space: on the skin that lies there at rest, the handle as the path says. Between two posts
  /// a blade stays in their plane, as the cut is told (sim/commands): the nearest skin leaves it where the skin bends.
  Vec3 place_at_rest(const Step& s, double l) {
    const double t = s.length.back() > 0 ? std::clamp(l / s.length.back(), 0.0, 1.0) : 0;
    const Vec3 X = (1 - t) * s.rest_path.front() + t * s.rest_path.back();
    SkinTouch on;
    if (!s.shaft.empty()) {
      wanted_shaft = (1 - t) * s.shaft.front() + t * s.shaft.back();
      on = sight.skin_under(X, wanted_shaft);
    }
    if (on.triangle < 0) on = sight.skin_at(X);
    if (on.triangle < 0) return tip;
    up = on.normal;
    if (!s.on_edge) return on.x_mm;
    const auto [a, b] = ends_now(s);
    return a.triangle < 0 || b.triangle < 0 ? on.x_mm : kept_on_edge(on.x_mm, a.x_mm, b.x_mm, t);
  }

  /// The place on a drawn path; over a hole, on the straight line between its rims.
  Vec3 place_on_path(const Step& s, double l) {
    Vec2 direction;
    const SkinTouch t = sight.skin_at(along(s, l, &direction), 1e-3);
    const Body& body = sight.body();
    if (t.triangle >= 0) {
      up = t.normal;
      // The path's direction on the deformed skin, for the way the handle leans.
      const SkinTouch ahead = sight.skin_at(along(s, std::min(l + 0.5, s.length.back())), 1e-3);
      Vec3 way = body.chart_e1 * direction.x() + body.chart_e2 * direction.y();
      if (ahead.triangle >= 0 && (ahead.x_mm - t.x_mm).norm() > 0.05) way = ahead.x_mm - t.x_mm;
      way -= way.dot(up) * up;
      if (way.norm() > 1e-9) {
        way.normalize();
        const double a = s.angle_deg * std::numbers::pi / 180, drag = kDragDeg * std::numbers::pi / 180;
        wanted_shaft = (elementary::sin(a) * up + elementary::cos(a) * up.cross(way)) * elementary::cos(drag) -
                       elementary::sin(drag) * way;
      }
      return s.on_edge ? kept_on_edge(s, l, t.x_mm) : t.x_mm;
    }
    constexpr double kLookMm = 0.5;
    double before = l, after = l;
    SkinTouch a, b;
    while (before > 0 && a.triangle < 0)
      a = sight.skin_at(along(s, before = std::max(0.0, before - kLookMm)), Sight::kRimMm);
    while (after < s.length.back() && b.triangle < 0)
      b = sight.skin_at(along(s, after = std::min(s.length.back(), after + kLookMm)), Sight::kRimMm);
    if (a.triangle < 0 && b.triangle < 0) return tip;
    if (a.triangle < 0) return b.x_mm;
    if (b.triangle < 0 || after <= before) return a.x_mm;
    return a.x_mm + (l - before) / (after - before) * (b.x_mm - a.x_mm);
  }

  // ---- moving ----

  /// Begins the step at the head of the plan; how long it takes.
  double begin(Step& s) {
    step_from = tip;
    wanted_shaft = Vec3::Zero();
    ends_known = false;
    if (s.aim.kind == Aim::here) {
      s.aim.kind = Aim::world;
      s.aim.world_mm = tip;
    }
    switch (s.kind) {
      case Step::go: {
        const double by_speed = (place(s.aim) - tip).norm() / set.carry_mm_s;
        return std::max(s.seconds > 0 ? s.seconds : by_speed, kMinTravelS);
      }
      case Step::draw:
        return std::max(s.length.back() / set.draw_mm_s, kMinTravelS);
      case Step::hold:
        return s.seconds;
      default:
        return 0;
    }
  }

  void move(Step& s, double share) {
    if (s.kind == Step::go) {
      const Vec3 target = place(s.aim);
      tip = step_from + minimum_jerk(share) * (target - step_from);
    } else if (s.kind == Step::draw) {
      const double l = minimum_jerk(share) * s.length.back();
      tip = s.rest_path.empty() ? place_on_path(s, l) : place_at_rest(s, l);
    } else if (s.kind == Step::hold) {
      tip = place(s.aim);
      if (!s.shaft.empty()) wanted_shaft = s.shaft.front();
    }
  }

  void send(ControlSample c, int64_t t_ns, SampleSink& sink) {
    c.device_id = set.device_id;
    c.seq = control_seq++;
    c.t_ns = t_ns;
    ++sent;
    sink.on_sample(c);
  }

  /// Carries the plan on to time t. Steps of no length happen at once; the rest of a finished step's last sample
  /// interval is given to the next, so that the plan does not depend on the rate.
  void advance(double t_s, int64_t t_ns, SampleSink& sink) {
    if (!sight.open()) return;
    if (!sight.chart.built_for(*sight.seen)) sight.chart.build(*sight.seen->topology);
    if (!begun) {
      begun = true;
      step_start_s = t_s;
      plan.begin(set.start_s);
    }
    while (!plan.empty()) {
      Step& s = plan.front();
      if (!step_begun) {
        step_begun = true;
        step_seconds = begin(s);
      }
      if (t_s < step_start_s + step_seconds) {
        move(s, (t_s - step_start_s) / step_seconds);
        return;
      }
      move(s, 1);
      const Step::Kind kind = s.kind;
      if (kind == Step::choose) send(s.control, t_ns, sink);
      if (kind == Step::press) pressed = true;
      if (kind == Step::let_go) pressed = false;
      step_start_s += step_seconds;
      step_begun = false;
      plan.pop();
      if (kind == Step::press || kind == Step::let_go) return;  // each state of the button is sent at least once
      if (kind == Step::next_command) {
        if (started) ++command;
        started = true;
        if (command >= script.size()) {
          finished = true;
          return;
        }
        plan.add(script, command, sight);
      }
    }
  }

  StylusSample reading(double t_s, int64_t t_ns) {
    // The wrist follows: towards the wanted direction while drawing, else leaning towards the surgeon.
    Vec3 want = wanted_shaft;
    if (want.norm() < 0.5 && sight.open()) {
      const double lean = kRestLeanDeg * std::numbers::pi / 180;
      Vec3 near = -sight.body().chart_e2;
      near -= near.dot(up) * up;
      want = elementary::cos(lean) * up +
             (near.norm() > 1e-6 ? Vec3(elementary::sin(lean) * near.normalized()) : Vec3::Zero());
    }
    if (want.norm() > 0.5)
      shaft = (shaft + (1 - elementary::exp(-1 / (set.rate_hz * kWristS))) * (want.normalized() - shaft)).normalized();

    StylusSample s;
    s.device_id = set.device_id;
    s.t_ns = t_ns;
    s.buttons = pressed ? 1 : 0;
    s.tip_mm = tip + tremor.at(t_s) + set.noise_mm * noise.normal3();
    const Vec3 w = set.noise_rad * noise.normal3();
    Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), shaft);
    q = (q * Eigen::Quaterniond(1, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z())).normalized();
    s.quat = {q.w(), q.x(), q.y(), q.z()};
    return s;
  }

  void poll(int64_t now_ns, SampleSink& sink) {
    while (!finished) {
      const double t_s = double(sample) / set.rate_hz;
      const auto t_ns = int64_t(std::llround(t_s * 1e9));
      if (t_ns > now_ns) return;
      ++sample;
      advance(t_s, t_ns, sink);
      StylusSample s = reading(t_s, t_ns);
      if (dropouts.lost(t_s)) continue;
      s.seq = stylus_seq++;
      ++sent;
      sink.on_sample(s);
    }
  }
};

EmulatedSurgeon::EmulatedSurgeon(std::vector<Command> script, const SurgeonSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(script), settings)) {}
EmulatedSurgeon::~EmulatedSurgeon() = default;
void EmulatedSurgeon::look(const Snapshot& snapshot) { impl_->sight.seen = &snapshot; }
void EmulatedSurgeon::poll(int64_t now_ns, SampleSink& sink) {
  // Bone without skin is another surgeon's (head_surgeon.h).
  if (impl_->sight.open() && !impl_->sight.seen->topology->body) impl_->finished = true;
  impl_->poll(now_ns, sink);
  impl_->sight.seen = nullptr;
}
bool EmulatedSurgeon::done() const { return impl_->finished; }
SourceCounts EmulatedSurgeon::counts() const { return {impl_->sent, 0, 0}; }
size_t EmulatedSurgeon::command() const { return impl_->command; }
size_t EmulatedSurgeon::commands() const { return impl_->script.size(); }
const std::vector<std::string>& EmulatedSurgeon::problems() const { return impl_->plan.problems(); }

}  // namespace limberg
