#include "app/assembly/streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/fastrak/virtual_line.h"
#include "devices/force/force_device.h"
#include "devices/message_codec.h"
#include "devices/motion.h"
#include "devices/rehearsal.h"
#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/rotation.h"

namespace limberg {

namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;

std::string csv_of(const fastrak::Motion& motion, std::initializer_list<int> stations, double seconds) {
  std::string s = "t_s,station,x_mm,y_mm,z_mm,pressed\n";
  std::string line;
  for (double t = 0; t < seconds; t += 0.05)
    for (const int station : stations) {
      const fastrak::StationPose p = motion(station, t);
      line = fmt::format("{:.3f},{},{:.3f},{:.3f},{:.3f},{}\n", t, station, p.pos_mm.x(), p.pos_mm.y(), p.pos_mm.z(),
                         int(p.pressed));
      s += line;
    }
  return s;
}

ControlSample control(int32_t kind, Tool tool, std::array<double, 4> value, int64_t seq) {
  ControlSample c;
  c.device_id = 901;
  c.seq = seq;
  c.t_ns = 1'000'000 * (seq + 1);
  c.kind = kind, c.tool = tool, c.value = value;
  return c;
}

/// No hemisphere: the scenes lie around the middle of the tracker's frame.
fastrak::LinkSettings line_for(const char* roles) {
  fastrak::LinkSettings l;
  l.role = fastrak::parse_roles(roles);
  for (Vec3& h : l.hemisphere) h = Vec3::Zero();
  return l;
}

KnownStream glove(uint64_t seed) {
  auto tremor = Tremor(seed, 0.15, 8, 12);
  const fastrak::Motion motion = [tremor](int station, double t) {
    const auto shut_at = [&](double from, double to) {
      return minimum_jerk((t - from) / 0.3) - minimum_jerk((t - to) / 0.3);
    };
    const double aperture = 70 - 60 * (shut_at(2.0, 4.2) + shut_at(6.4, 8.6));
    const Vec3 way = minimum_jerk((t - 2.6) / 1.4) * Vec3(0, 20, 15) -
                     minimum_jerk((t - 4.6) / 1.4) * Vec3(20, 20, 15) +
                     minimum_jerk((t - 7.0) / 1.4) * Vec3(-15, 0, 20);
    fastrak::StationPose p;
    p.orientation = turn_about(std::numbers::pi / 2 + 0.1 * elementary::sin(t), Vec3::UnitY());
    p.pos_mm =
        Vec3(15, -10, 40) + way + tremor.at(t + station) + (station == 1 ? Vec3(Vec3::Zero()) : Vec3(0, -aperture, 0));
    return p;
  };
  KnownStream k;
  fastrak::EmulatorSettings device;
  device.seed = seed;
  k.samples = fastrak::readings_of(motion, 10, line_for("ft"), device);
  k.truth_csv = csv_of(motion, {1, 2}, 10);
  k.truth = "closes at 2.1 and 6.5 s, carries by (0, 20, 15) and (-15, 0, 20) mm, opens at 4.3 and 8.7 s";
  return k;
}

KnownStream cursor(uint64_t seed) {
  const Tremor tremor(seed, 0.3, 8, 12);
  constexpr double gain = 0.25;
  const fastrak::Motion motion = [tremor](int, double t) {
    // Three sides of a square of 24 mm on the skin: of 96 mm in the hand.
    constexpr double side = 24 / gain;
    const Vec3 at = Vec3(0, 0, 30) + side * (minimum_jerk((t - 1.5) / 2.0) * Vec3(0, 1, 0) +
                                             minimum_jerk((t - 3.8) / 2.0) * Vec3(1, 0, 0) -
                                             minimum_jerk((t - 6.1) / 2.0) * Vec3(0, 1, 0));
    fastrak::StationPose p;
    p.pos_mm = at + tremor.at(t);
    p.pressed = t > 1.3 && t < 8.3;
    return p;
  };
  KnownStream k;
  fastrak::EmulatorSettings device;
  device.seed = seed;
  k.samples = fastrak::readings_of(motion, 9, line_for("s"), device);
  k.samples.insert(k.samples.begin(), {control(ControlSample::select_tool, Tool::scalpel, {3, 90, 0, 0}, 0),
                                       control(ControlSample::cursor, Tool::none, {gain, 0, 0, 0}, 1)});
  k.truth_csv = csv_of(motion, {1}, 9);
  k.truth = "gain 0.25: three sides of 24 mm on flat skin, from where the stylus first is above it";
  return k;
}

KnownStream tremor(uint64_t seed) {
  const Tremor shake(seed, 0.35, 8, 12);
  const fastrak::Motion motion = [shake](int, double t) {
    fastrak::StationPose p;
    const double down = minimum_jerk((t - 0.8) / 0.5) - minimum_jerk((t - 4.4) / 0.5);
    p.pos_mm = Vec3(-30 + 60 * minimum_jerk((t - 1.6) / 2.4), 5, 12 - 12 * down) + shake.at(t);
    p.pressed = t > 1.4 && t < 4.2;
    return p;
  };
  KnownStream k;
  fastrak::EmulatorSettings device;
  device.seed = seed;
  device.damage_per_byte = 3e-4;
  Dropouts gaps(seed + 1, 1.0, 0.08);
  for (const Sample& s : fastrak::readings_of(motion, 5.5, line_for("s"), device))
    if (!gaps.lost(double(std::get<TrackerSample>(s).t_ns) * 1e-9)) k.samples.push_back(s);
  k.samples.insert(k.samples.begin(), control(ControlSample::select_tool, Tool::scalpel, {3, 90, 0, 0}, 0));
  k.truth_csv = csv_of(motion, {1}, 5.5);
  k.truth =
      "a line from (-30, 5) to (30, 5) mm, tremor of 0.35 mm, one byte in 3000 damaged, one gap a second of up to 80 "
      "ms";
  return k;
}

KnownStream force(uint64_t) {
  SimulatedHand hand;
  hand.target = [](double t) {
    return Vec3(8 * elementary::sin(kFullTurn * 0.4 * t), 0,
                4 - 7 * minimum_jerk((t - 0.3) / 0.6) + 7 * minimum_jerk((t - 2.0) / 0.4));
  };
  SimulatedForceDevice device(hand);
  ForceLoop loop;
  ForceModel m;
  m.facets = 2;
  m.facet[0] = {Vec3(-100, -100, 0), Vec3(100, -100, 0), Vec3(100, 100, 0)};
  m.facet[1] = {Vec3(-100, -100, 0), Vec3(100, 100, 0), Vec3(-100, 100, 0)};
  m.stiffness_N_mm = 0.2;
  KnownStream k;
  k.truth_csv = "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n";
  for (int64_t tick = 0; tick < 2500; ++tick) {
    const int64_t t = tick * 1'000'000;
    const ForceReading r = device.read(t);
    if (tick % 16 == 0) ++m.seq, m.t_ns = t, loop.take(m);
    const Vec3 f = loop.tick(t, r.tip_mm, true).force_N;
    device.push(f);
    StylusSample s;
    s.device_id = 300;
    s.seq = tick, s.t_ns = t + 1;
    s.tip_mm = r.tip_mm;
    k.samples.push_back(s);
    const std::string line = fmt::format("{:.3f},{:.2f},{:.2f},{:.2f},{:.4f},{:.4f},{:.4f}\n", double(tick) * 1e-3,
                                         r.tip_mm.x(), r.tip_mm.y(), r.tip_mm.z(), f.x(), f.y(), f.z());
    if (tick % 20 == 0) k.truth_csv += line;
  }
  k.truth = "tissue of 0.2 N/mm with its skin at z = 0, friction 0.2; the force that was given is in the table";
  return k;
}

}  // namespace

KnownStream known_stream(const std::string& name, uint64_t seed) {
  if (name == "glove") return glove(seed);
  if (name == "cursor") return cursor(seed);
  if (name == "tremor") return tremor(seed);
  if (name == "force") return force(seed);
  KnownStream k;
  fastrak::EmulatorSettings device;
  device.seed = seed;
  device.noise_mm = 0.2;
  std::string text;
  if (name == "open") {
    const fastrak::Motion motion = glove_opening(seed, 18, 85);
    k.samples = fastrak::readings_of(motion, 12, {}, device);
    k.truth_csv = csv_of(motion, {1, 2}, 12);
    k.truth = "closed 18 mm, open 85 mm";
    return k;
  }
  if (name == "forefinger" || name == "thumb") {
    PivotRehearsal r;
    r.seed = seed, r.tip_mm = name == "thumb" ? Vec3(15, -2, -9) : Vec3(17, 2, -8);
    const fastrak::Motion motion = finger_on_place(r, name == "thumb" ? 2 : 1);
    k.samples = fastrak::readings_of(motion, 12, {}, device);
    k.truth_csv = csv_of(motion, {1, 2}, 12);
    k.truth = fmt::format("the {}'s tip ({:g}, {:g}, {:g}) mm in its sensor's frame", name, r.tip_mm.x(), r.tip_mm.y(),
                          r.tip_mm.z());
    return k;
  }
  if (name == "pointing") {
    PointingRehearsal r;
    r.seed = seed;
    k.samples = fastrak::readings_of(pointing_at_place(r), 14, {}, device);
    k.truth_csv = csv_of(pointing_at_place(r), {1, 2}, 14);
    k.truth = fmt::format("the forefinger points along ({:.4f}, {:.4f}, {:.4f}) in its sensor's frame", r.direction.x(),
                          r.direction.y(), r.direction.z());
    return k;
  }
  fastrak::LinkSettings stylus;
  stylus.role = fastrak::parse_roles("s");
  if (name == "pivot") {
    PivotRehearsal r;
    r.seed = seed, r.slips_per_s = 0.3;
    k.samples = fastrak::readings_of(stylus_in_dimple(r), 12, stylus, device);
    k.truth_csv = csv_of(stylus_in_dimple(r), {1}, 12);
    text = fmt::format("tip ({:g}, {:g}, {:g}) mm in the sensor's frame", r.tip_mm.x(), r.tip_mm.y(), r.tip_mm.z());
    k.truth = text;
    return k;
  }
  if (name == "touch") {
    TouchRehearsal r;
    r.seed = seed;
    r.points_mm =
        k.points_mm = {{-60, -60, 0}, {60, -60, 0}, {60, 60, 0}, {-60, 60, 0}, {0, 0, 30}, {0, -40, 10}, {20, 20, 5}};
    k.samples = fastrak::readings_of(stylus_touching(r), seconds_for(r), stylus, device);
    k.truth_csv = csv_of(stylus_touching(r), {1}, seconds_for(r));
    text =
        fmt::format("tracker at ({:g}, {:g}, {:g}) mm, tip ({:g}, {:g}, {:g}) mm", r.world_from_tracker_mm.x(),
                    r.world_from_tracker_mm.y(), r.world_from_tracker_mm.z(), r.tip_mm.x(), r.tip_mm.y(), r.tip_mm.z());
    k.truth = text;
    return k;
  }
  if (name == "metal") {
    TouchRehearsal r;
    r.seed = seed;
    for (const double z : {0.0, 50.0, 100.0})
      for (const double y : {-90.0, -30.0, 30.0, 90.0})
        for (const double x : {-90.0, -30.0, 30.0, 90.0}) r.points_mm.push_back({x, y, z});
    r.points_mm.push_back({10, 20, 60});
    k.points_mm = r.points_mm;
    k.samples = fastrak::readings_of(stylus_touching(r), seconds_for(r), stylus, device);
    // A plate below: it draws positions towards itself, more the nearer they are; up to 12 mm.
    const Vec3 metal = r.world_from_tracker.conjugate() * (Vec3(60, 60, -60) - r.world_from_tracker_mm);
    for (Sample& s : k.samples)
      if (auto* t = std::get_if<TrackerSample>(&s)) {
        const Vec3 off = t->pos_mm - metal;
        t->pos_mm -= off.normalized() * (12 * elementary::exp(-off.norm() / 160));
      }
    k.truth_csv = csv_of(stylus_touching(r), {1}, seconds_for(r));
    k.truth = "as touch; readings are drawn by up to 12 mm towards a piece of metal";
    return k;
  }
  throw InputError("", 0,
                   "stream " + name +
                       ": unknown; expected glove, cursor, tremor, force, pivot, touch, metal, open, "
                       "forefinger, thumb or pointing");
}

void write_stream(const std::string& path, const std::vector<Sample>& samples, bool replace) {
  StreamWriter w(path, replace);
  for (const Sample& s : samples) w.write(s);
  w.close();
}

StreamWriter::StreamWriter(const std::string& path, bool replace) : path_(path) { log_.open(path, replace); }

void StreamWriter::write(const Sample& s) {
  MessageBytes bytes;
  const size_t n = std::visit([&](const auto& v) { return encode_message(to_message(v), bytes); }, s);
  last_us_ = std::max(last_us_, std::visit([](const auto& v) { return v.t_ns; }, s) / 1000);
  log_.write(last_us_, channel_of(s), bytes.data(), n);
}

void StreamWriter::close() {
  if (!log_.close()) throw InputError(path_, 0, log_.error());
}

}  // namespace limberg
