#include "devices/head_surgeon.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "devices/motion.h"
#include "devices/sample.h"
#include "sim/geometry/polyline.h"
#include "sim/geometry/rotation.h"
#include "sim/geometry/triangle.h"
#include "sim/patient/snapshot.h"

namespace limberg {

namespace {

constexpr double kOpen_mm = 62, kClosed_mm = 12;  // between the finger tips
constexpr double kPoint_mm = 45;                  // from the forefinger's tip to the bone that it points at
constexpr double kClose_s = 0.45;                 // a hand closes or opens
constexpr int32_t kGloveDevice = 101;
constexpr double kBend_rad = 0.6;    // a finger's end of the glove that works alone, closed
constexpr double kSawGain = 0.5;     // of the glove that saws
constexpr double kCorrects = 0.08;   // share of what the eye sees the cursor beside, in a reading
const Vec3 kRest_mm{-150, 190, 40};  // where the hands wait

/// A place on the bone as it lies now.
struct OnBone {
  bool found = false;
  Vec3 x_mm = Vec3::Zero(), normal = Vec3::UnitY();
  int32_t object = -1;
};

}  // namespace

struct EmulatedHeadSurgeon::Impl {
  /// One thing that the hands do.
  struct Act {
    enum Kind {
      hold,
      saw_to,
      saw_along,
      press,
      let_go,
      carry_tip,
      reach,
      close,
      carry,
      open,
      push_to,
      push_along,
      control,
      next
    };
    Kind kind = hold;
    double seconds = 0;
    Vec3 to_mm = Vec3::Zero();  // saw_to: on the bone at rest; reach: the pointed place, at rest
    double height_mm = 0;       // saw_to: above the bone
    std::vector<Vec3> path;     // saw_along, push_along: at rest
    RigidMove move;             // carry, carry_tip
    Sample sample;              // of a control or a command
  };

  Impl(std::vector<Command> commands, const SurgeonSettings& s, HeadHands which)
      : script(std::move(commands)),
        set(s),
        glove(which != HeadHands::stylus),
        stylus(which != HeadHands::glove),
        tremor{Tremor(s.seed * 8 + 1, s.tremor_mm, s.tremor_low_hz, s.tremor_high_hz),
               Tremor(s.seed * 8 + 2, s.tremor_mm, s.tremor_low_hz, s.tremor_high_hz)},
        noise(s.seed * 8 + 3),
        dropouts(s.seed * 8 + 4, s.dropouts_per_s, s.dropout_max_s) {}

  std::vector<Command> script;
  SurgeonSettings set;
  bool glove, stylus;
  Tremor tremor[2];
  RandomStream noise;
  Dropouts dropouts;
  std::vector<std::string> problems;
  const Snapshot* seen = nullptr;
  ToolState tip_seen;  // of the tool, as it was seen last

  std::deque<Act> acts;
  size_t command = 0;
  bool begun = false, act_begun = false, finished = false, pressed = false;
  double act_from_s = 0, act_seconds = 0;
  Vec3 tip = kRest_mm + Vec3(60, 0, 0), tip_from = tip, up = Vec3::UnitY();
  Eigen::Quaterniond tip_turn = Eigen::Quaterniond::Identity();  // of the stylus since it gripped a fragment
  // The glove: where the middle between its tips is, how it is turned, how far it is open.
  Vec3 centre = kRest_mm, centre_from = kRest_mm, pointed = Vec3::Zero();
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity(), turn_from = turn;
  double aperture = kOpen_mm;
  Eigen::Isometry3d carried = Eigen::Isometry3d::Identity();
  Vec3 meant = Vec3::Zero();  // push_along: where the cursor was meant to be at the last reading
  int stages = 0;
  int64_t sample = 0, stylus_seq = 0, control_seq = 0, command_seq = 0, station_seq[2] = {0, 0}, sent = 0;

  // ---- looking ----

  bool open_eyes() const { return seen && seen->topology && seen->x_mm.size() == seen->topology->view.X_mm.size(); }

  /// The bone nearest to a place at rest, where it is now. One pass over the bone.
  OnBone on_bone(const Vec3& X) const {
    OnBone out;
    const SurfaceTopology& top = *seen->topology;
    double best = 1e60;
    for (size_t t = 0; t < top.view.tri.size(); ++t) {
      if (!top.is_ground(t, Ground::bone)) continue;
      const Tri& k = top.view.tri[t];
      const Vec3 &a = top.view.X_mm[size_t(k[0])], &b = top.view.X_mm[size_t(k[1])], &c = top.view.X_mm[size_t(k[2])];
      const double reach = (a - X).norm() - std::max((b - a).norm(), (c - a).norm());
      if (reach > 0 && reach * reach >= best) continue;
      const TrianglePoint p = closest_on_triangle(X, a, b, c);
      const double d2 = (p.point - X).squaredNorm();
      if (d2 >= best) continue;
      best = d2;
      out.found = true;
      out.object = top.object.empty() ? -1 : top.object[t];
      const Vec3 xa = now(k[0]), xb = now(k[1]), xc = now(k[2]);
      out.x_mm = p.bary[0] * xa + p.bary[1] * xb + p.bary[2] * xc;
      const Vec3 n = (xb - xa).cross(xc - xa);
      if (n.norm() > 0) out.normal = n.normalized();
    }
    return out;
  }
  Vec3 now(int32_t v) const { return seen->x_mm[size_t(v)].cast<double>(); }

  /// The middle of a fragment as it lies now.
  Vec3 middle(int32_t object) const {
    Vec3 sum = Vec3::Zero();
    double n = 0;
    const SurfaceTopology& top = *seen->topology;
    for (size_t t = 0; t < top.view.tri.size(); ++t)
      if (!top.object.empty() && top.object[t] == object)
        for (const int32_t v : top.view.tri[t]) sum += now(v), n += 1;
    return n > 0 ? Vec3(sum / n) : Vec3(Vec3::Zero());
  }
  /// The outermost bone of a fragment, seen from the front: what a hand would point at.
  Vec3 front_of(int32_t object) const {
    Vec3 best = Vec3::Zero(), at = Vec3::Zero();
    double front = -1e30;
    const SurfaceTopology& top = *seen->topology;
    const Vec3 mid = middle(object);
    for (size_t t = 0; t < top.view.tri.size(); ++t) {
      if (top.object.empty() || top.object[t] != object) continue;
      for (const int32_t v : top.view.tri[t]) {
        at = now(v);
        const double score = at.y() - 2 * Vec2(at.x() - mid.x(), at.z() - mid.z()).norm();
        if (score > front) front = score, best = top.view.X_mm[size_t(v)];
      }
    }
    return best;
  }

  // ---- planning ----

  void add(Act::Kind kind, double seconds = 0) {
    Act a;
    a.kind = kind;
    a.seconds = seconds;
    acts.push_back(a);
  }
  void choose(int32_t kind, Tool tool = Tool::none, std::array<double, 4> value = {}, const std::string& text = {}) {
    Act a;
    a.kind = Act::control;
    ControlSample c;
    c.kind = kind, c.tool = tool, c.value = value, c.text = ShortText(text);
    a.sample = c;
    acts.push_back(a);
  }
  void tell(const HeadCommand& c) {
    Act a;
    a.kind = Act::control;
    a.sample = command_sample(c);
    acts.push_back(a);
    add(Act::hold, set.settle_s);
  }
  void problem(const std::string& what) { problems.push_back("command " + std::to_string(command + 1) + ": " + what); }

  /// Sets the tip down at a place, from above it, and presses; the way there, for the way back.
  Act press_down(const Vec3& at_mm) {
    Act to;
    to.kind = Act::saw_to;
    to.to_mm = at_mm, to.height_mm = set.hover_mm;
    acts.push_back(to);
    to.height_mm = 0;
    acts.push_back(to);
    add(Act::hold, set.corner_pause_s);
    add(Act::press);
    add(Act::hold, set.corner_pause_s);
    return to;
  }

  void plan(const CutBone& c) {
    if (c.contour_mm.size() < 3) return tell(c);
    choose(ControlSample::select_tool, Tool::saw);
    if (!stylus) return plan_pushed(c);
    Act to = press_down(c.contour_mm.front());
    Act along;
    along.kind = Act::saw_along;
    along.path = c.contour_mm;
    along.path.push_back(c.contour_mm.front());
    acts.push_back(along);
    add(Act::hold, set.corner_pause_s);
    add(Act::let_go);
    to.height_mm = 4 * set.hover_mm;
    acts.push_back(to);
    add(Act::hold, set.settle_s);
  }

  void plan_pushed(const CutBone& c) {
    Act reach;
    reach.kind = Act::reach;
    reach.to_mm = c.contour_mm.front();
    acts.push_back(reach);
    add(Act::hold, 0.2);
    choose(ControlSample::glove, Tool::none, {kGlovePushesCursor, kSawGain, 0, 0});
    Act push;
    push.kind = Act::push_to;
    push.seconds = 0.8, push.to_mm = c.contour_mm.front();
    acts.push_back(push);
    add(Act::close, kClose_s);
    add(Act::hold, 0.2);
    push.kind = Act::push_along;
    push.path = c.contour_mm;
    push.path.push_back(c.contour_mm.front());
    acts.push_back(push);
    push.kind = Act::push_to;
    push.seconds = 0.4;
    acts.push_back(push);
    add(Act::open, kClose_s);
    add(Act::hold, 0.2);
    choose(ControlSample::glove, Tool::none, {kGlovePoints, 0, 0, 0});
    reach.to_mm = kRest_mm, reach.height_mm = -1;
    acts.push_back(reach);
    add(Act::hold, set.settle_s);
  }

  void plan(const MoveFragment& m) {
    Vec3 at = m.fragment.at_mm;
    OnBone place;
    if (m.fragment.id >= 0) at = front_of(m.fragment.id);
    place = on_bone(at);
    if (!place.found) return problem("there is no bone to grab");
    if (!glove) return plan_grip(m, at, middle(place.object));
    Act reach;
    reach.kind = Act::reach;
    reach.to_mm = at;
    acts.push_back(reach);
    add(Act::hold, 0.35);  // the place that is pointed at is found within a few sweeps
    add(Act::close, kClose_s);
    add(Act::hold, 0.2);
    Act carry;
    carry.kind = Act::carry;
    carry.move = m.by;
    if (!carry.move.about_mm) carry.move.about_mm = middle(place.object);
    carry.seconds = std::max(m.seconds, 0.5);
    acts.push_back(carry);
    add(Act::hold, 0.4);
    add(Act::open, kClose_s);
    Act back;
    back.kind = Act::reach;
    back.to_mm = kRest_mm, back.height_mm = -1;
    acts.push_back(back);
    add(Act::hold, set.settle_s);
  }
  void plan_grip(const MoveFragment& m, const Vec3& at, const Vec3& about_mm) {
    choose(ControlSample::select_tool, Tool::grab);
    Act to = press_down(at);
    Act carry;
    carry.kind = Act::carry_tip;
    carry.move = m.by;
    if (!carry.move.about_mm) carry.move.about_mm = about_mm;
    carry.seconds = std::max(m.seconds, 0.5);
    acts.push_back(carry);
    add(Act::hold, 0.4);
    add(Act::let_go);
    to.height_mm = 4 * set.hover_mm;
    acts.push_back(to);
    add(Act::hold, set.settle_s);
  }
  void plan(const Stage& s) {
    choose(ControlSample::stage, Tool::none, {double(++stages), 0, 0, 0}, s.name), add(Act::hold, set.corner_pause_s);
  }
  void plan(const Wait& w) { add(Act::hold, w.seconds); }
  void plan(const Shown&) {}
  void plan(const Undo&) { choose(ControlSample::undo), add(Act::hold, set.settle_s); }
  void plan(const Redo&) { choose(ControlSample::redo), add(Act::hold, set.settle_s); }
  void plan(const HeadCommand& h) {
    if (const auto* c = std::get_if<CutBone>(&h)) return plan(*c);
    if (const auto* m = std::get_if<MoveFragment>(&h)) return plan(*m);
    if (std::holds_alternative<GrabFragment>(h) || std::holds_alternative<DragFragment>(h) ||
        std::holds_alternative<LetGo>(h))
      return problem("a grab, drag or letting go is what the hand makes of a move; expected move_fragment");
    tell(h);
  }
  template <class Other>
  void plan(const Other&) {
    problem("an act on skin; expected acts on bone");
  }

  // ---- moving ----

  /// So that the forefinger's x axis points along `direction`, its z axis up as far as it can.
  static Eigen::Quaterniond pointing_along(const Vec3& direction) {
    const Vec3 x = direction.normalized();
    Vec3 z = Vec3::UnitZ() - Vec3::UnitZ().dot(x) * x;
    if (z.norm() < 0.1) z = Vec3::UnitX() - Vec3::UnitX().dot(x) * x;
    z.normalize();
    Mat3 r;
    r.col(0) = x, r.col(1) = z.cross(x), r.col(2) = z;
    return Eigen::Quaterniond(r);
  }

  double begin(Act& a) {
    tip_from = tip, centre_from = centre, turn_from = turn;
    switch (a.kind) {
      case Act::hold:
        return a.seconds;
      case Act::close:
      case Act::open:
        return a.seconds;
      case Act::saw_to:
        return std::max(0.25, (on_bone(a.to_mm).x_mm - tip).norm() / set.carry_mm_s);
      case Act::push_to:
      case Act::push_along:
        meant = on_bone(a.kind == Act::push_to ? a.to_mm : a.path.front()).x_mm;
        return a.kind == Act::push_to ? a.seconds : std::max(0.5, path_length(a.path) / set.draw_mm_s);
      case Act::saw_along:
        return std::max(0.5, path_length(a.path) / set.draw_mm_s);
      case Act::reach:
        return 1.2;
      case Act::carry:
      case Act::carry_tip:
        return a.seconds;
      default:
        return 0;
    }
  }

  static Vec3 along(const std::vector<Vec3>& path, double share) {
    double left = share * path_length(path);
    for (size_t i = 1; i < path.size(); ++i) {
      const double edge = (path[i] - path[i - 1]).norm();
      if (left <= edge || i + 1 == path.size())
        return path[i - 1] + (edge > 0 ? std::min(1.0, left / edge) : 0) * (path[i] - path[i - 1]);
      left -= edge;
    }
    return path.front();
  }

  void move(const Act& a, double share) {
    const double s = minimum_jerk(share);
    if (a.kind == Act::carry_tip) {
      RigidMove part = a.move;
      part.translation_mm *= s, part.rotation_deg *= s;
      const Eigen::Isometry3d m = isometry(part, Vec3::Zero());
      tip = m * tip_from, tip_turn = Eigen::Quaterniond(m.linear());
    } else if (a.kind == Act::saw_to || a.kind == Act::saw_along) {
      tip_turn.setIdentity();
      const OnBone b = on_bone(a.kind == Act::saw_to ? a.to_mm : along(a.path, s));
      if (!b.found) return;
      up = b.normal;
      const Vec3 to = b.x_mm + a.height_mm * b.normal;
      tip = a.kind == Act::saw_to ? Vec3(tip_from + s * (to - tip_from)) : to;
    } else if (a.kind == Act::push_to || a.kind == Act::push_along) {
      const OnBone b = on_bone(a.kind == Act::push_to ? a.to_mm : along(a.path, s));
      if (!b.found || !tip_seen.valid) return;
      // The hand goes as the cursor shall, and a little towards where it is not yet; along the surface, where it can.
      Vec3 beside = b.x_mm - Vec3(tip_seen.tip_mm[0], tip_seen.tip_mm[1], tip_seen.tip_mm[2]);
      beside -= beside.dot(b.normal) * b.normal;
      centre += (b.x_mm - meant + kCorrects * beside) / kSawGain;
      meant = b.x_mm;
    } else if (a.kind == Act::reach) {
      Vec3 to = a.to_mm;
      Eigen::Quaterniond wanted = turn_from;
      if (a.height_mm >= 0) {
        // The forefinger points at the place; the middle between the tips lies below its tip by half the opening.
        const OnBone b = on_bone(a.to_mm);
        if (!b.found) return;
        Vec3 from = b.normal + Vec3(0, 0.5, 0);  // from the front where it can
        from.normalize();
        wanted = pointing_along(-from);
        to = b.x_mm + kPoint_mm * from - wanted * Vec3(0, 0, kOpen_mm / 2);
      }
      centre = centre_from + s * (to - centre_from);
      turn = between(turn_from, wanted, s);
    } else if (a.kind == Act::close || a.kind == Act::open) {
      aperture =
          a.kind == Act::close ? kOpen_mm + s * (kClosed_mm - kOpen_mm) : kClosed_mm + s * (kOpen_mm - kClosed_mm);
    } else if (a.kind == Act::carry) {
      RigidMove part = a.move;
      part.translation_mm *= s, part.rotation_deg *= s;
      const Eigen::Isometry3d m = isometry(part, Vec3::Zero());
      centre = m * centre_from;
      turn = Eigen::Quaterniond(m.linear()) * turn_from;
    }
  }

  void advance(double t_s, int64_t t_ns, SampleSink& sink) {
    for (int guard = 0; guard < 1000; ++guard) {
      if (acts.empty() || acts.front().kind == Act::next) {
        if (!acts.empty()) acts.pop_front(), ++command;
        if (command >= script.size()) {
          finished = true;
          return;
        }
        std::visit([this](const auto& c) { plan(c); }, script[command]);
        add(Act::next);
      }
      Act& a = acts.front();
      if (!act_begun) act_seconds = begin(a), act_begun = true;
      if (act_seconds > 0 && t_s < act_from_s + act_seconds) return move(a, (t_s - act_from_s) / act_seconds);
      if (a.kind == Act::next) continue;
      move(a, 1);
      if (a.kind == Act::press) pressed = true;
      if (a.kind == Act::let_go) pressed = false;
      if (a.kind == Act::control) {
        if (auto* c = std::get_if<ControlSample>(&a.sample))
          c->device_id = set.device_id, c->seq = control_seq++, c->t_ns = t_ns;
        if (auto* c = std::get_if<CommandSample>(&a.sample))
          c->device_id = set.device_id, c->seq = command_seq++, c->t_ns = t_ns;
        ++sent;
        sink.on_sample(a.sample);
      }
      act_from_s += act_seconds;
      act_begun = false;
      acts.pop_front();
    }
  }

  std::array<double, 4> noisy(const Eigen::Quaterniond& q) {
    const Vec3 w = set.noise_rad * noise.normal3();
    const Eigen::Quaterniond d(1, w.x() / 2, w.y() / 2, w.z() / 2);
    const Eigen::Quaterniond r = (d.normalized() * q).normalized();
    return {r.w(), r.x(), r.y(), r.z()};
  }

  void send_stylus(double t_s, int64_t t_ns, SampleSink& sink) {
    StylusSample s;
    s.device_id = set.device_id, s.seq = stylus_seq++, s.t_ns = t_ns;
    s.tip_mm = tip + tremor[0].at(t_s) + set.noise_mm * noise.normal3();
    s.quat = noisy(tip_turn * Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up));
    s.buttons = pressed ? 1 : 0;
    ++sent;
    sink.on_sample(s);
  }
  void send_station(int finger, double t_s, int64_t t_ns, SampleSink& sink) {
    TrackerSample s;
    s.device_id = kGloveDevice, s.seq = station_seq[finger]++, s.t_ns = t_ns;
    s.true_ns = t_ns;
    s.station = finger + 1;
    s.role = finger == 0 ? StationRole::forefinger : StationRole::thumb;
    const double half = 0.5 * (finger == 0 ? aperture : -aperture);
    s.pos_mm = centre + turn * Vec3(0, 0, half) + tremor[1].at(t_s) + set.noise_mm * noise.normal3();
    // Fingers that close bend, one towards the other; the glove that works alone is drawn as it is.
    const double bend = stylus ? 0 : kBend_rad * (kOpen_mm - aperture) / (kOpen_mm - kClosed_mm);
    s.quat = noisy(bend == 0 ? turn : turn * turn_about(finger == 0 ? bend : -bend, Vec3::UnitY()));
    ++sent;
    sink.on_sample(s);
  }

  void poll(int64_t now_ns, SampleSink& sink) {
    while (!finished && open_eyes()) {
      const double t_s = double(sample) / set.rate_hz;
      const auto t_ns = int64_t(std::llround(t_s * 1e9));
      if (t_ns > now_ns) return;
      if (!begun) {
        begun = true;
        add(Act::hold, set.start_s);
        --command, add(Act::next);  // the mark of a command before the first
      }
      advance(t_s, t_ns, sink);
      const bool lost = dropouts.lost(t_s);
      if (!lost) {
        if (stylus) send_stylus(t_s, t_ns, sink);
        if (glove) send_station(int(sample % 2), t_s, t_ns, sink);
      }
      ++sample;
    }
  }
};

EmulatedHeadSurgeon::EmulatedHeadSurgeon(std::vector<Command> script, const SurgeonSettings& settings, HeadHands hands)
    : impl_(new Impl(std::move(script), settings, hands)) {}
EmulatedHeadSurgeon::~EmulatedHeadSurgeon() = default;
void EmulatedHeadSurgeon::look(const Snapshot& snapshot) { impl_->seen = &snapshot; }
void EmulatedHeadSurgeon::hold(const ToolState& tool) { impl_->tip_seen = tool; }
void EmulatedHeadSurgeon::poll(int64_t now_ns, SampleSink& sink) { impl_->poll(now_ns, sink); }
bool EmulatedHeadSurgeon::done() const { return impl_->finished; }
SourceCounts EmulatedHeadSurgeon::counts() const {
  SourceCounts c;
  c.samples = impl_->sent;
  return c;
}
const std::vector<std::string>& EmulatedHeadSurgeon::problems() const { return impl_->problems; }

}  // namespace limberg
