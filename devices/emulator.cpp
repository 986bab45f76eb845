// The surgeon's plan is a queue of small steps (go, draw, hold, press, let go, choose a tool), made from one command at a
// time. A step says where the tip should be now, against the newest snapshot; the hand adds tremor, the tracker noise.
#include "devices/emulator.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "devices/motion.h"
#include "devices/surface_index.h"
#include "sim/snapshot.h"

namespace limberg {

namespace {

constexpr double kRimMm = 2.5;         // a point this near to remaining skin is meant to be on it
constexpr double kPauseTurnDeg = 20;   // a sharper turn of a drawn path is a corner
constexpr double kMinTravelS = 0.15;
constexpr double kDragDeg = 20;        // the handle of a drawing tool leans back along the path
constexpr double kRestLeanDeg = 30;    // otherwise it leans towards the surgeon
constexpr double kWristS = 0.08;       // time constant of turning the handle

/// Where the tip should be.
struct Aim {
  enum Kind { skin, world, handle } kind = world;
  ChartPoint chart{0, 0};
  Vec3 world_mm = Vec3::Zero();
  int hook = 0;
  double height_mm = 0;  // above that place
};

struct Step {
  enum Kind { go, draw, hold, press, let_go, choose, next_command } kind = hold;
  Aim aim;                        // go, hold
  double seconds = 0;             // go: 0 = by speed
  std::vector<ChartPoint> path;   // draw
  std::vector<double> length;     // draw: along the path, from 0
  double angle_deg = 90;          // draw
  ControlSample control;          // choose
};

double turn_deg(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  const Vec2 u = b - a, v = c - b;
  return std::abs(std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v))) * 180 / std::numbers::pi;
}

}  // namespace

struct EmulatedSurgeon::Impl {
  Impl(std::vector<Command> commands, const SurgeonSettings& settings)
      : script(std::move(commands)),
        set(settings),
        tremor(settings.seed * 4 + 1, settings.tremor_mm, settings.tremor_low_hz, settings.tremor_high_hz),
        dropouts(settings.seed * 4 + 2, settings.dropouts_per_s, settings.dropout_max_s),
        noise(settings.seed * 4 + 3) {}

  std::vector<Command> script;
  SurgeonSettings set;
  Tremor tremor;
  Dropouts dropouts;
  RandomStream noise;

  const Snapshot* seen = nullptr;
  SurfaceIndex index;
  std::deque<Step> plan;
  size_t command = 0;
  bool begun = false, started = false, finished = false, pressed = false;
  int holding = 0;  // the hook that the hand holds, 0 = none
  int stages = 0;
  std::vector<std::string> problems;

  double step_start_s = 0, step_seconds = 0;
  bool step_begun = false;
  Vec3 step_from = Vec3::Zero();
  Vec3 tip{0, -30, 40}, up = Vec3::UnitZ(), shaft = Vec3::UnitZ(), wanted_shaft = Vec3::UnitZ();
  int64_t sample = 0, stylus_seq = 0, control_seq = 0, sent = 0;

  // ---- looking ----

  bool can_see() const { return seen && seen->topology && seen->x_mm.size() == seen->topology->view.X_mm.size(); }

  SkinTouch look_for(const ChartPoint& c, double slack_mm) const { return index.at_chart(*seen, c, slack_mm); }

  /// The present place of an aim. When what it aims at is gone, the tip stays where it is.
  Vec3 place(const Aim& a) {
    if (a.kind == Aim::skin) {
      const SkinTouch t = look_for(a.chart, kRimMm);
      if (t.triangle < 0) return tip;
      up = t.normal;
      return t.x_mm + a.height_mm * t.normal;
    }
    if (a.kind == Aim::handle) {
      for (const HookState& h : seen->hooks)
        if (h.id == a.hook) return h.handle_mm.cast<double>() + a.height_mm * seen->topology->body->chart_normal();
      return tip;
    }
    return a.world_mm;
  }

  ChartPoint along(const Step& s, double l, Vec2* direction = nullptr) const {
    size_t i = 1;
    while (i + 1 < s.path.size() && s.length[i] < l) ++i;
    const double piece = s.length[i] - s.length[i - 1];
    const double t = piece > 0 ? std::clamp((l - s.length[i - 1]) / piece, 0.0, 1.0) : 0;
    if (direction) *direction = piece > 0 ? Vec2((s.path[i] - s.path[i - 1]) / piece) : Vec2(1, 0);
    return s.path[i - 1] + t * (s.path[i] - s.path[i - 1]);
  }

  /// The place on a drawn path; over a hole, on the straight line between its rims.
  Vec3 place_on_path(const Step& s, double l) {
    Vec2 direction;
    const SkinTouch t = look_for(along(s, l, &direction), 1e-3);
    const Body& body = *seen->topology->body;
    if (t.triangle >= 0) {
      up = t.normal;
      // The path's direction on the deformed skin, for the way the handle leans.
      const SkinTouch ahead = look_for(along(s, std::min(l + 0.5, s.length.back())), 1e-3);
      Vec3 way = body.chart_e1 * direction.x() + body.chart_e2 * direction.y();
      if (ahead.triangle >= 0 && (ahead.x_mm - t.x_mm).norm() > 0.05) way = ahead.x_mm - t.x_mm;
      way -= way.dot(up) * up;
      if (way.norm() > 1e-9) {
        way.normalize();
        const double a = s.angle_deg * std::numbers::pi / 180, drag = kDragDeg * std::numbers::pi / 180;
        wanted_shaft = (std::sin(a) * up + std::cos(a) * up.cross(way)) * std::cos(drag) - std::sin(drag) * way;
      }
      return t.x_mm;
    }
    constexpr double kLookMm = 0.5;
    double before = l, after = l;
    SkinTouch a, b;
    while (before > 0 && a.triangle < 0) a = look_for(along(s, before = std::max(0.0, before - kLookMm)), kRimMm);
    while (after < s.length.back() && b.triangle < 0)
      b = look_for(along(s, after = std::min(s.length.back(), after + kLookMm)), kRimMm);
    if (a.triangle < 0 && b.triangle < 0) return tip;
    if (a.triangle < 0) return b.x_mm;
    if (b.triangle < 0 || after <= before) return a.x_mm;
    return a.x_mm + (l - before) / (after - before) * (b.x_mm - a.x_mm);
  }

  // ---- planning ----

  void add_go(const Aim& aim, double seconds = 0) {
    Step s;
    s.kind = Step::go;
    s.aim = aim;
    s.seconds = seconds;
    plan.push_back(s);
  }
  void add_hold(const Aim& aim, double seconds) {
    Step s;
    s.kind = Step::hold;
    s.aim = aim;
    s.seconds = seconds;
    plan.push_back(s);
  }
  void add(Step::Kind kind) {
    Step s;
    s.kind = kind;
    plan.push_back(s);
  }
  void add_control(int32_t kind, Tool tool = Tool::none, std::array<double, 4> value = {}, const std::string& text = {}) {
    Step s;
    s.kind = Step::choose;
    s.control.kind = kind;
    s.control.tool = tool;
    s.control.value = value;
    s.control.text = ShortText(text);
    plan.push_back(s);
  }
  static Aim on_skin(const ChartPoint& c, double height_mm = 0) {
    Aim a;
    a.kind = Aim::skin;
    a.chart = c;
    a.height_mm = height_mm;
    return a;
  }
  static Aim at_handle(int hook, double height_mm = 0) {
    Aim a;
    a.kind = Aim::handle;
    a.hook = hook;
    a.height_mm = height_mm;
    return a;
  }
  static Aim in_world(const Vec3& p) {
    Aim a;
    a.world_mm = p;
    return a;
  }

  bool reachable(const ChartPoint& c) {
    if (look_for(c, kRimMm).triangle >= 0) return true;
    char text[120];
    std::snprintf(text, sizeof text, "command %zu: point (%.2f, %.2f) is not on skin", command + 1, c.x(), c.y());
    problems.push_back(text);
    return false;
  }

  void go_down(const Aim& target, double hover_mm) {
    Aim above = target;
    above.height_mm = hover_mm;
    add_go(above);
    add_go(target);
    add_hold(target, set.corner_pause_s);
  }
  void rise(const Aim& from) {
    Aim above = from;
    above.height_mm += set.hover_mm;
    if (from.kind == Aim::world) above.world_mm += set.hover_mm * seen->topology->body->chart_normal();
    add_go(above);
    add_hold(above, set.settle_s);
  }

  /// Press, draw the path with a rest at each corner, let go.
  void add_stroke(const std::vector<ChartPoint>& points, bool closed, double angle_deg) {
    std::vector<ChartPoint> path;
    for (const ChartPoint& p : points)
      if (path.empty() || (p - path.back()).norm() > 1e-6) path.push_back(p);
    if (closed && (path.front() - path.back()).norm() > 1e-6) path.push_back(path.front());
    go_down(on_skin(path.front()), set.hover_mm);
    add(Step::press);
    add_hold(on_skin(path.front()), set.corner_pause_s);
    for (size_t first = 0; first + 1 < path.size();) {
      size_t last = first + 1;
      while (last + 1 < path.size() && turn_deg(path[last - 1], path[last], path[last + 1]) < kPauseTurnDeg) ++last;
      Step s;
      s.kind = Step::draw;
      s.angle_deg = angle_deg;
      s.path.assign(path.begin() + long(first), path.begin() + long(last) + 1);
      s.length.push_back(0);
      for (size_t i = 1; i < s.path.size(); ++i) s.length.push_back(s.length.back() + (s.path[i] - s.path[i - 1]).norm());
      plan.push_back(s);
      add_hold(on_skin(path[last]), set.corner_pause_s);
      first = last;
    }
    add(Step::let_go);
    rise(on_skin(path.back()));
  }

  void stroke_command(Tool tool, const std::vector<ChartPoint>& path, bool closed, double depth_mm, double angle_deg) {
    if (path.empty() || !reachable(path.front()) || !reachable(path.back())) return;
    add_control(ControlSample::select_tool, tool, {depth_mm, angle_deg, 0, 0});
    add_stroke(path, closed, angle_deg);
  }

  void make_plan(const Command& c) {
    if (const auto* i = std::get_if<Incise>(&c)) {
      stroke_command(Tool::scalpel, i->path, false, i->depth_mm, i->angle_deg);
    } else if (const auto* u = std::get_if<Undermine>(&c)) {
      stroke_command(Tool::undermine, u->outline, true, u->depth_mm, 90);
    } else if (const auto* e = std::get_if<Excise>(&c)) {
      stroke_command(Tool::excise, e->outline, true, e->depth_mm, 90);
    } else if (const auto* h = std::get_if<SetHook>(&c)) {
      if (!reachable(h->at)) return;
      add_control(ControlSample::select_tool, Tool::hook, {0, 0, 0, double(h->id)});
      go_down(on_skin(h->at), set.hover_mm);
      add(Step::press);
      add_hold(in_world(Vec3::Constant(std::nan(""))), set.corner_pause_s);  // at the place reached
      holding = h->id;
      leave_unless_moved_next(on_skin(h->at));
    } else if (const auto* m = std::get_if<MoveHook>(&c)) {
      if (holding != m->id) {
        if (std::none_of(seen->hooks.begin(), seen->hooks.end(), [&](const HookState& k) { return k.id == m->id; })) {
          problems.push_back("command " + std::to_string(command + 1) + ": there is no hook " + std::to_string(m->id));
          return;
        }
        add_control(ControlSample::select_tool, Tool::hook, {0, 0, 0, double(m->id)});
        go_down(at_handle(m->id), set.hover_mm);
        add(Step::press);
        add_hold(at_handle(m->id), set.corner_pause_s);
        holding = m->id;
      }
      add_go(in_world(m->to_mm), m->seconds);
      add_hold(in_world(m->to_mm), set.corner_pause_s);
      leave_unless_moved_next(in_world(m->to_mm));
    } else if (const auto* r = std::get_if<ReleaseHook>(&c)) {
      add_control(ControlSample::release_hook, Tool::none, {double(r->id), 0, 0, 0});
      add_hold(in_world(Vec3::Constant(std::nan(""))), set.settle_s);
    } else if (const auto* s = std::get_if<Suture>(&c)) {
      if (!reachable(s->a) || !reachable(s->b)) return;
      add_control(ControlSample::select_tool, Tool::suture);
      go_down(on_skin(s->a), set.hover_mm);
      add(Step::press);
      add_hold(on_skin(s->a), set.corner_pause_s);
      go_down(on_skin(s->b), 0.5 * set.hover_mm);
      add(Step::let_go);
      rise(on_skin(s->b));
    } else if (const auto* w = std::get_if<SutureRow>(&c)) {
      if (w->a.empty() || w->b.empty()) return;
      for (const ChartPoint& p : {w->a.front(), w->a.back(), w->b.front(), w->b.back()})
        if (!reachable(p)) return;
      add_control(ControlSample::select_tool, Tool::suture_row, {0, 0, w->spacing_mm, 0});
      add_stroke(w->a, false, 90);
      add_stroke(w->b, false, 90);
    } else if (std::get_if<Undo>(&c)) {
      add_control(ControlSample::undo);
      add_hold(in_world(Vec3::Constant(std::nan(""))), set.settle_s);
    } else if (const auto* g = std::get_if<Stage>(&c)) {
      add_control(ControlSample::stage, Tool::none, {double(++stages), 0, 0, 0}, g->name);
      add_hold(in_world(Vec3::Constant(std::nan(""))), set.corner_pause_s);
    } else if (const auto* wait = std::get_if<Wait>(&c)) {
      add_hold(in_world(Vec3::Constant(std::nan(""))), wait->seconds);
    }
  }

  /// A hook stays in the hand when the very next thing is to move it (on).
  void leave_unless_moved_next(const Aim& from) {
    if (command + 1 < script.size())
      if (const auto* m = std::get_if<MoveHook>(&script[command + 1]); m && m->id == holding) return;
    holding = 0;
    add(Step::let_go);
    rise(from);
  }

  // ---- moving ----

  /// Begins the step at the head of the plan; how long it takes.
  double begin(Step& s) {
    step_from = tip;
    wanted_shaft = Vec3::Zero();
    if (s.kind == Step::hold && s.aim.kind == Aim::world && !s.aim.world_mm.allFinite()) s.aim.world_mm = tip;
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
      tip = place_on_path(s, minimum_jerk(share) * s.length.back());
    } else if (s.kind == Step::hold) {
      tip = place(s.aim);
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
    if (!can_see()) return;
    if (!index.built_for(*seen)) index.build(*seen->topology);
    if (!begun) {
      begun = true;
      step_start_s = t_s;
      add_hold(in_world(tip), set.start_s);
      add(Step::next_command);
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
      plan.pop_front();
      if (kind == Step::press || kind == Step::let_go) return;  // each state of the button is sent at least once
      if (kind == Step::next_command) {
        if (started) ++command;
        started = true;
        if (command >= script.size()) {
          finished = true;
          return;
        }
        make_plan(script[command]);
        add(Step::next_command);
      }
    }
  }

  StylusSample reading(double t_s, int64_t t_ns) {
    // The wrist follows: towards the wanted direction while drawing, else leaning towards the surgeon.
    Vec3 want = wanted_shaft;
    if (want.norm() < 0.5 && can_see()) {
      const double lean = kRestLeanDeg * std::numbers::pi / 180;
      Vec3 near = -seen->topology->body->chart_e2;
      near -= near.dot(up) * up;
      want = std::cos(lean) * up + (near.norm() > 1e-6 ? Vec3(std::sin(lean) * near.normalized()) : Vec3::Zero());
    }
    if (want.norm() > 0.5) shaft = (shaft + (1 - std::exp(-1 / (set.rate_hz * kWristS))) * (want.normalized() - shaft)).normalized();

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
void EmulatedSurgeon::look(const Snapshot& snapshot) { impl_->seen = &snapshot; }
void EmulatedSurgeon::poll(int64_t now_ns, SampleSink& sink) {
  impl_->poll(now_ns, sink);
  impl_->seen = nullptr;
}
bool EmulatedSurgeon::done() const { return impl_->finished; }
SourceCounts EmulatedSurgeon::counts() const { return {impl_->sent, 0, 0}; }
size_t EmulatedSurgeon::command() const { return impl_->command; }
size_t EmulatedSurgeon::commands() const { return impl_->script.size(); }
const std::vector<std::string>& EmulatedSurgeon::problems() const { return impl_->problems; }

}  // namespace limberg
