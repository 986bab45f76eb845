#include "app/headset/headset_source.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <mutex>
#include <optional>

#include "app/session/thread.h"
#include "devices/monotonic.h"
#include "devices/sample_queue.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int64_t kReadEveryNs = 4'000'000;
constexpr int64_t kAgainNs = 3'000'000'000;  // it is looked for again
constexpr int64_t kIdleNs = 20'000'000;
constexpr int64_t kFarewellNs = 1'500'000'000;                             // for the runtime to end the session
constexpr double kTip_m = 0.05;                                            // of the stylus, before the controller
constexpr double kOpen_m = 0.070, kClosed_m = 0.008, kClosing_m_s = 0.35;  // of a hand that is a controller
constexpr float kPointing_m = 1.5f;                                        // so far does it point at the tablet

void pause(int64_t ns) {
  const timespec t{ns / 1'000'000'000, ns % 1'000'000'000};
  nanosleep(&t, nullptr);
}

Vec3 along(const RoomPose& p, double ahead_m) { return p.at_m - ahead_m * (p.turned * Vec3::UnitZ()); }

/// The sensor of a glove looks along its x, a finger of OpenXR along its -z.
Eigen::Quaterniond sensor_of(const Eigen::Quaterniond& finger) {
  constexpr double kHalf = 0.70710678118654752;
  return finger * Eigen::Quaterniond(kHalf, 0, kHalf, 0);
}

}  // namespace

HeadsetSettings parse_headset(const std::string& text) {
  HeadsetSettings s;
  for (size_t at = 0; at < text.size();) {
    const size_t comma = std::min(text.find(',', at), text.size());
    const std::string word = text.substr(at, comma - at);
    at = comma + 1;
    const size_t is = word.find('=');
    double value = 0;
    const char *from = word.c_str() + is + 1, *to = word.c_str() + word.size();
    const bool number = is != std::string::npos && std::from_chars(from, to, value).ptr == to && from != to;
    const std::string name = word.substr(0, is);
    if (word == "left" || word == "right")
      s.left_handed = word == "left";
    else if (number && name == "scale" && value >= 0.2 && value <= 20)
      s.eyes.room.scale = value;
    else if (number && name == "table" && value >= 0.3 && value <= 1.6)
      s.eyes.room.table_m = value;
    else
      throw InputError("", 0,
                       "\"" + word +
                           "\" means nothing to a headset; expected headset[:left][,scale=0.2 to 20][,table=0.3 to "
                           "1.6 (m)]");
  }
  return s;
}

void check_calibration(const Calibration& c) {
  const bool carries = c.world_from_tracker_mm != Vec3::Zero() || c.tip_offset_mm != Vec3::Zero() ||
                       std::abs(std::abs(c.world_from_tracker_quat[0]) - 1) > 1e-6 || !c.distortion.empty();
  if (carries)
    throw InputError("", 0,
                     "--calibration with a room or the tip of a stylus, and --device headset, whose places are the "
                     "patient's already; expected a calibration of filter and glove alone, or none");
}

TrackerSample HandStations::station(int which, StationRole role, int32_t device, const Vec3& at_mm,
                                    const Eigen::Quaterniond& q) {
  TrackerSample t;
  t.device_id = device;
  t.station = which;
  t.seq = seq_[which]++;
  t.role = role;
  t.pos_mm = at_mm;
  t.quat = {q.w(), q.x(), q.y(), q.z()};
  return t;
}

int HandStations::samples(const HandReading& hand, const PatientPlace& place, bool suppress, TrackerSample (&out)[3]) {
  if (has_stylus_ && hand.controller) {
    // The shaft is its +z, from the tip to the hand: so it is of a pose that looks along -z.
    out[0] = station(1, StationRole::stylus, HeadsetSettings::kDevice, place.to_patient(along(hand.aim, kTip_m)),
                     place.to_patient(hand.aim.turned));
    out[0].buttons = (hand.press && !suppress ? 1u : 0u) | (hand.clutch ? 2u : 0u);
    return 1;
  }
  RoomPose forefinger = hand.forefinger, thumb = hand.thumb;
  if (!hand.fingers && hand.controller) {
    // As fast as a hand closes: a tracker that leaps is not believed.
    const double step = kClosing_m_s * double(kReadEveryNs) * 1e-9;
    open_m_ = hand.press ? std::max(kClosed_m, open_m_ - step) : std::min(kOpen_m, open_m_ + step);
    forefinger = thumb = hand.aim;
    forefinger.at_m = along(hand.aim, kTip_m);
    thumb.at_m = forefinger.at_m + open_m_ * (hand.aim.turned * Vec3::UnitX());
  } else if (!hand.fingers) {
    return 0;
  }
  const int32_t device = HeadsetSettings::kDevice + (has_stylus_ ? 1 : 0);
  const Vec3 tip = place.to_patient(forefinger.at_m), apart = 1000 * place.direction(thumb.at_m - forefinger.at_m);
  out[0] = station(2, has_stylus_ ? StationRole::other_forefinger : StationRole::forefinger, device, tip,
                   place.to_patient(sensor_of(forefinger.turned)));
  out[1] = station(3, has_stylus_ ? StationRole::other_thumb : StationRole::thumb, device, tip + apart,
                   place.to_patient(sensor_of(thumb.turned)));
  return 2;
}

struct HeadsetSource::Impl {
  Impl(const HeadsetSettings& s, const SourceTime& t, std::shared_ptr<HeadsetShared> with)
      : set(s), time(t), shared(with ? std::move(with) : std::make_shared<HeadsetShared>()) {}

  bool over() const { return stop.load() || shared->over.load(); }
  bool wanted() const { return shared->wanted.load() && !over(); }

  void tell(const std::string& line, bool aloud = true) {
    if (aloud) shared->words.say(line), shared->shown_words.say(line);
    const std::lock_guard lock(mutex);
    said = line;
  }

  // ---- The drawing thread

  void run() {
    be_nice(set.nice);
    while (!over()) {
      if (!wanted()) {
        pause(kIdleNs);
        continue;
      }
      try {
        one_session();
        if (wanted())
          tell("the headset's runtime has ended the session; it is looked for again");
        else if (!over())
          tell("the headset is off");
      } catch (const std::exception& e) {
        tell(std::string(e.what()) + "; the session goes on without, and it is looked for again");
      }
      wear(false);
      for (int64_t waited = 0; waited < kAgainNs && wanted(); waited += kIdleNs) pause(kIdleNs);
    }
  }

  void one_session() {
    std::unique_ptr<GlContext> context;  // which the eyes then hold: the session ends before them
    std::unique_ptr<Eyes> eyes;
    const std::unique_ptr<HeadsetSession> session = open_headset([&](NativeContext::Kind kind) {
      context = kind == NativeContext::egl ? make_egl_context() : make_glx_context();
      context->make_current();
      return context->native();
    });
    const HeadsetFacts& f = session->facts();
    const std::string name = fmt::format("{} ({})", f.system, f.runtime);
    tell(fmt::format("headset: {}, {} x {} pixels an eye{}, pictures by {}", name, f.width, f.height,
                     f.hands ? ", sees hands" : "", f.context));
    eyes = std::make_unique<Eyes>(std::move(context), *shared, place, set.eyes, f.floor);
    place.forget();
    draw(*session, *eyes, name);
  }

  void draw(HeadsetSession& session, Eyes& eyes, const std::string& name) {
    std::atomic<bool> reading{true};
    ScheduledThread reader([&] { read(session, reading); });
    struct Joined {
      std::atomic<bool>& go_on;
      ScheduledThread& thread;
      ~Joined() { go_on = false, thread.join(); }
    } joined{reading, reader};
    const int64_t began = monotonic_ns();
    int64_t farewell_ns = 0, told_ns = began;
    for (;;) {
      if (!wanted() && farewell_ns == 0) session.end(), farewell_ns = monotonic_ns();
      if (farewell_ns != 0 && monotonic_ns() - farewell_ns > kFarewellNs) return;
      switch (session.step(eyes)) {
        case HeadsetSession::Step::ended:
          return;
        case HeadsetSession::Step::idle:
          if (!wanted()) return;
          pause(kIdleNs);
          break;
        case HeadsetSession::Step::frame:
          break;
      }
      if (const int64_t now = monotonic_ns(); now - told_ns > 500'000'000) {
        told_ns = now;
        tell(fmt::format("{}: {} frames, {:.1f} a second, {:.1f} ms to draw both eyes of one", name, eyes.frames(),
                         double(eyes.frames()) * 1e9 / double(now - began), eyes.mean_ms()),
             false);
      }
    }
  }

  // ---- The reading thread

  void read(HeadsetSession& session, const std::atomic<bool>& go_on) {
    request_exact_timers();
    try {
      for (HandsReading r; go_on; pause(kReadEveryNs)) {
        const bool worn = session.read(r);
        wear(worn);
        if (worn) take(r);
      }
    } catch (const std::exception& e) {
      tell(e.what());
    }
  }

  /// Then its stylus is the one that is followed, and after that whichever sends first.
  void wear(bool worn) {
    if (shared->worn.exchange(worn) == worn || !shared->takes_over) return;
    ControlSample c;
    c.device_id = HeadsetSettings::kDevice, c.kind = ControlSample::stylus, c.seq = control_seq++;
    c.value[0] = worn ? double(HeadsetSettings::kDevice) : 0;
    c.t_ns = time.stamp_ns(time.wall_ns(monotonic_ns()));
    queue.push(c);
  }

  void take(const HandsReading& r) {
    PatientPlace patient;
    BoardPlace tablet;
    const bool again = r.hand[0].place || r.hand[1].place;
    if (again && !place_pressed) place.forget();  // the next frame puts it before the person
    place_pressed = again;
    if (!place.get(patient, tablet)) return;
    const int64_t wall = time.wall_ns(r.at_ns), stamp = time.stamp_ns(wall);
    for (size_t h = 0; h < 2; ++h) {
      const bool stylus = h == (set.left_handed ? 0u : 1u);
      const bool on_tablet = stylus && point_at_tablet(r.hand[h], patient, tablet);
      TrackerSample out[3];
      const int n = (stylus ? stylus_hand : other_hand).samples(r.hand[h], patient, on_tablet, out);
      for (int k = 0; k < n; ++k) {
        out[k].t_ns = out[k].true_ns = stamp;
        if (!out[k].pos_mm.allFinite() || !queue.push(out[k])) lost.fetch_add(1, std::memory_order_relaxed);
      }
    }
  }

  /// Whether the hand means the tablet: a press that began there is the tablet's until it ends, and none else.
  bool point_at_tablet(const HandReading& hand, const PatientPlace& patient, const BoardPlace& tablet) {
    float u = -1, v = -1, way = 0;
    const Vec3f from = patient.to_patient(hand.aim.at_m).cast<float>(),
                towards = patient.direction(-(hand.aim.turned * Vec3::UnitZ())).cast<float>();
    const bool on =
        hand.controller && tablet.meets(from, towards, u, v, way) && way < kPointing_m * float(patient.mm_per_m());
    place.dot_u = on ? u : -1, place.dot_v = on ? v : -1;
    const bool pressed = hand.controller && hand.press;
    if (on && (u != last_u || v != last_v)) shared->events.push({u, v, false, false});
    if (on) last_u = u, last_v = v;
    if (pressed && !was_pressed && on) press_is_tablets = true, shared->events.push({u, v, true, true});
    if (!pressed && press_is_tablets) shared->events.push({last_u, last_v, true, false});
    const bool tablets = press_is_tablets;
    if (!pressed) press_is_tablets = false;
    was_pressed = pressed;
    return tablets;
  }

  const HeadsetSettings set;
  const SourceTime time;
  const std::shared_ptr<HeadsetShared> shared;
  SharedPlace place;
  SampleQueue queue{4096};
  HandStations stylus_hand{true}, other_hand{false};
  int64_t control_seq = 0;
  bool place_pressed = false, was_pressed = false, press_is_tablets = false;
  float last_u = -1, last_v = -1;
  std::atomic<int64_t> lost{0};
  std::atomic<bool> stop{false};
  mutable std::mutex mutex;  // for the words below: never taken by the polling thread
  std::string said = "not looked for yet";
  std::unique_ptr<ScheduledThread> thread;
};

HeadsetSource::HeadsetSource(const HeadsetSettings& settings, const SourceTime& time,
                             std::shared_ptr<HeadsetShared> shared)
    : impl_(std::make_unique<Impl>(settings, time, std::move(shared))) {
  setenv("XR_LOADER_DEBUG", "none", 0);  // what it finds is said by us
  impl_->thread = std::make_unique<ScheduledThread>([i = impl_.get()] { i->run(); });
}

HeadsetSource::~HeadsetSource() {
  impl_->stop = true;
  impl_->thread->join();
}

void HeadsetSource::poll(int64_t now_ns, SampleSink& sink) { impl_->queue.poll(now_ns, sink); }

SourceCounts HeadsetSource::counts() const {
  return {impl_->queue.handed_over(), 0, impl_->lost.load(std::memory_order_relaxed)};
}

std::string HeadsetSource::health() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->said;
}

}  // namespace limberg
