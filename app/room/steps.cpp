#include "app/room/steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/words/words.h"
#include "calibration/glove_range.h"
#include "calibration/pivot.h"
#include "calibration/registration.h"
#include "devices/calibrating.h"
#include "devices/glove.h"

namespace limberg {
namespace {

constexpr double kSheetLong_mm = 297, kSheetShort_mm = 210;
// Limits that are not those of a calibration: a reading must come before the last is stale (FilterParameters), and a
// resting sensor that is noisier than twice a FASTRAK's (0.44 mm an axis) makes hooks tremble. A FASTRAK has 120
// readings a second for all its stations: 30 each for four.
constexpr double kLeastRate_Hz = 29, kLongestGap_ms = 100, kMostMissing_percent = 2, kMostNoise_mm = 0.9;
constexpr double kStrokeOff_mm = 3, kStrokeLength_mm = 15;
constexpr double kReach_mm[3] = {200, 150, 60};
constexpr int kGrabs = 3;

RoomCheck at_most(const char* step, const std::string& what, double value, const char* unit, double limit) {
  return {step, what, unit, value, limit, true};
}
RoomCheck at_least(const char* step, const std::string& what, double value, const char* unit, double limit) {
  return {step, what, unit, value, limit, false};
}

const char* name_of(StationRole r) {
  constexpr const char* name[] = {english("station"), english("stylus"),           english("forefinger"),
                                  english("thumb"),   english("other forefinger"), english("other thumb")};
  return name[size_t(r)];
}

/// One stream of readings: a station of a tracker, a stylus by itself.
struct Readings {
  std::string name;
  std::vector<Vec3> at_mm;
  std::vector<int64_t> t_ns;
  int64_t missing = 0, last_seq = -1;
};
std::vector<Readings> streams_of(std::span<const Sample> samples) {
  std::map<std::pair<int32_t, int32_t>, Readings> all;
  const auto add = [&](int32_t device, int32_t station, const char* name, const Vec3& at, int64_t t, int64_t seq) {
    Readings& r = all[{device, station}];
    r.name = name;
    if (r.last_seq >= 0 && seq > r.last_seq + 1) r.missing += std::min<int64_t>(seq - r.last_seq - 1, 100'000);
    r.last_seq = seq, r.at_mm.push_back(at), r.t_ns.push_back(t);
  };
  for (const Sample& s : samples) {
    if (const auto* t = std::get_if<TrackerSample>(&s))
      add(t->device_id, t->station, name_of(t->role), t->pos_mm, t->t_ns, t->seq);
    else if (const auto* p = std::get_if<StylusSample>(&s))
      add(p->device_id, 0, "stylus", p->tip_mm, p->t_ns, p->seq);
  }
  std::vector<Readings> out;
  for (auto& [key, r] : all) out.push_back(std::move(r));
  return out;
}

double longest_gap_ms(std::span<const int64_t> t_ns) {
  int64_t longest = 0;
  for (size_t i = 1; i < t_ns.size(); ++i) longest = std::max(longest, t_ns[i] - t_ns[i - 1]);
  return double(longest) * 1e-6;
}

/// RMS of an axis about the median place, the tenth that lies farthest left out: a hand that leaves is no noise.
double noise_mm(const std::vector<Vec3>& at) {
  if (at.size() < 2) return 0;
  Vec3 middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> v;
    for (const Vec3& p : at) v.push_back(p[k]);
    std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
    middle[k] = v[v.size() / 2];
  }
  std::vector<double> off;
  for (const Vec3& p : at) off.push_back((p - middle).squaredNorm() / 3);
  std::sort(off.begin(), off.end());
  off.resize(std::max<size_t>(1, off.size() * 9 / 10));
  double sum = 0;
  for (const double x : off) sum += x;
  return std::sqrt(sum / double(off.size()));
}

StepOutcome rest(std::span<const Sample> samples, double seconds, Calibration&) {
  StepOutcome o;
  for (const Readings& r : streams_of(samples)) {
    const double span_s = r.t_ns.size() > 1 ? double(r.t_ns.back() - r.t_ns.front()) * 1e-9 : 0;
    const double rate = span_s > 0 ? double(r.t_ns.size() - 1) / span_s : 0;
    const double missing = 100 * double(r.missing) / double(r.missing + int64_t(r.t_ns.size()));
    o.checks.push_back(
        at_least("rest", fmt::format(english("{}: readings a second"), r.name), rate, "Hz", kLeastRate_Hz));
    o.checks.push_back(
        at_most("rest", fmt::format(english("{}: longest gap"), r.name), longest_gap_ms(r.t_ns), "ms", kLongestGap_ms));
    o.checks.push_back(at_most("rest", fmt::format(english("{}: readings that are missing"), r.name), missing, "%",
                               kMostMissing_percent));
    o.checks.push_back(at_most("rest", fmt::format(english("{}: noise of a reading at rest"), r.name),
                               noise_mm(r.at_mm), "mm", kMostNoise_mm));
    if (rate < kLeastRate_Hz)
      o.advice = english("too few readings: fewer stations, or a faster line; nothing else may use the device");
    else if (missing > kMostMissing_percent || longest_gap_ms(r.t_ns) > kLongestGap_ms)
      o.advice = english("readings are lost: look at the cable and its plugs, and at other programs of this machine");
    else if (noise_mm(r.at_mm) > kMostNoise_mm)
      o.advice = fmt::format(
          english("{} trembles though it lies still: nearer to the transmitter, away from metal, screens and mains"),
          r.name);
  }
  if (o.checks.empty()) {
    o.checks.push_back(at_least("rest", english("readings"), 0, "", seconds * kLeastRate_Hz));
    o.advice = english("nothing was heard: is the device switched on, its cable in, its program running?");
  }
  return o;
}

StepOutcome tip(std::span<const Sample> samples, double, Calibration& c) {
  std::vector<SensorPose> poses;
  for (const StylusSample& s : stylus_readings(samples))
    poses.push_back({s.tip_mm + c.distortion.at(s.tip_mm), rotation_of(s)});
  const PivotLimits limit;
  const PivotResult r = calibrate_pivot(poses, 1, limit);
  StepOutcome o;
  o.checks = {at_least("tip", english("poses"), r.poses, "", limit.poses),
              at_most("tip", english("residual of the calibration"), r.residual_mm, "mm", limit.residual_mm),
              at_least("tip", english("poses that agree"), r.poses ? 100.0 * r.agreeing / r.poses : 0, "%",
                       100 * limit.inliers),
              at_least("tip", english("how far it was turned"), r.cone_deg, "deg", limit.cone_deg),
              at_most("tip", english("first half against second"), r.repeat_mm, "mm", limit.repeat_mm)};
  if (r.accepted)
    c.tip_offset_mm = r.tip_mm;
  else
    o.advice = r.advice;
  return o;
}

StepOutcome on_table(std::span<const Sample> samples, double, Calibration& c) {
  const std::vector<Vec3> known = sheet_points();
  const std::vector<StylusSample> readings = stylus_readings(samples);
  const std::vector<Touch> touch = touches(readings, c.tip_offset_mm);
  StepOutcome o;
  o.checks.push_back(at_least("table", english("points touched"), double(touch.size()), "", double(known.size())));
  if (touch.size() != known.size()) {
    o.checks[0].at_most = touch.size() > known.size();
    o.advice = fmt::format(
        english("{} touches were felt, {} are expected: press for half a second at each point, and nowhere else"),
        touch.size(), known.size());
    return o;
  }
  std::vector<Vec3> tips;
  double unstill = 0;
  for (const Touch& t : touch) tips.push_back(t.tip_mm), unstill = std::max(unstill, t.spread_mm);
  const RegistrationLimits limit;
  const WorldRegistration r = calibrate_world(tips, known, limit);
  o.checks.push_back(at_most("table", english("the tip moved while it touched"), unstill, "mm", kStillTouch_mm));
  o.checks.push_back(at_most("table", english("residual of the corners"), r.residual_mm, "mm", limit.residual_mm));
  o.checks.push_back(at_most("table", english("error at the middle"), r.held_out_mm, "mm", limit.held_out_mm));
  if (unstill > kStillTouch_mm)
    o.advice = english("rest the tip on the point first, then press and hold for half a second");
  else if (!r.accepted)
    o.advice = r.advice;
  if (!o.good()) return o;
  c.world_from_tracker_mm = r.translation_mm;
  c.world_from_tracker_quat = {r.rotation.w(), r.rotation.x(), r.rotation.y(), r.rotation.z()};
  return o;
}

StepOutcome hand(std::span<const Sample> samples, double, Calibration& c) {
  const GloveLimits limit;
  const GloveResult r = calibrate_glove(apertures(samples, c, false), kAperturesHz, limit);
  const double band = (limit.release_share - limit.grab_share) * (r.open_mm - r.closed_mm);
  StepOutcome o;
  o.checks = {at_least("hand", english("closings"), r.cycles, "", limit.cycles),
              at_least("hand", english("between open and closed"), r.open_mm - r.closed_mm, "mm", limit.range_mm),
              at_most("hand", english("spread of the closed hand"), r.spread_mm, "mm", band / limit.band_sigma)};
  if (r.accepted) {
    c.glove.closed_mm = r.closed_mm, c.glove.open_mm = r.open_mm;
    c.glove.grab_share = limit.grab_share, c.glove.release_share = limit.release_share;
  } else {
    o.advice = r.advice;
  }
  return o;
}

/// Where the tip is in the room.
Vec3 world_of(const StylusSample& s, const Calibration& c) {
  const Eigen::Quaterniond turn(c.world_from_tracker_quat[0], c.world_from_tracker_quat[1],
                                c.world_from_tracker_quat[2], c.world_from_tracker_quat[3]);
  return turn * (s.tip_mm + c.distortion.at(s.tip_mm) + rotation_of(s) * c.tip_offset_mm) + c.world_from_tracker_mm;
}

StepOutcome stroke(std::span<const Sample> samples, double, Calibration& c) {
  std::vector<Vec3> at;
  std::vector<int64_t> t_ns;
  int strokes = 0;
  bool down = false;
  for (const StylusSample& s : stylus_readings(samples)) {
    const bool pressed = s.buttons & 1;
    strokes += pressed && !down, down = pressed;
    if (pressed) at.push_back(world_of(s, c)), t_ns.push_back(s.t_ns);
  }
  StepOutcome o;
  o.checks.push_back(at_most("stroke", english("times that it was pressed"), strokes, "", 1));
  if (at.size() < 12) {
    o.checks.push_back(at_least("stroke", english("readings of the stroke"), double(at.size()), "", 12));
    o.advice = english("no stroke was felt: press the switch, keep it pressed along the edge, and let go at its end");
    return o;
  }
  // The far long edge: y and z are known, and where along it the hand was does not matter.
  const Vec3 edge = sheet_points()[0];
  double sum2 = 0, least = 1e9, most = -1e9;
  for (const Vec3& p : at)
    sum2 += (p - edge).tail<2>().squaredNorm(), least = std::min(least, p.x()), most = std::max(most, p.x());
  const double off = std::sqrt(sum2 / double(at.size())), wrong = std::abs(most - least - kSheetLong_mm);
  o.checks.push_back(at_most("stroke", english("beside the edge, in the middle (RMS)"), off, "mm", kStrokeOff_mm));
  o.checks.push_back(at_most("stroke", english("length against the sheet's"), wrong, "mm", kStrokeLength_mm));
  o.checks.push_back(
      at_most("stroke", english("longest gap within the stroke"), longest_gap_ms(t_ns), "ms", kLongestGap_ms));
  if (strokes > 1)
    o.advice = english("the switch let go in between: is it worn, or its cable loose? Else keep it pressed to the end");
  else if (off > kStrokeOff_mm)
    o.advice = english(
        "the line lies beside the edge: did the sheet move since its corners were touched? Then touch them again");
  else if (wrong > kStrokeLength_mm)
    o.advice = english("draw from corner to corner, all of the edge");
  else if (longest_gap_ms(t_ns) > kLongestGap_ms)
    o.advice =
        english("readings were lost while you drew: is your body or the arm of the lamp between hand and transmitter?");
  return o;
}

StepOutcome grab(std::span<const Sample> samples, double, Calibration& c) {
  GloveTracker tracker(c);
  int64_t next = -1, known = 0, ticks = 0;
  for (const Sample& s : samples) {
    const auto* t = std::get_if<TrackerSample>(&s);
    if (!t || (t->role != StationRole::forefinger && t->role != StationRole::thumb)) continue;
    if (next < 0) next = t->t_ns;
    for (; next < t->t_ns; next += 1'000'000) known += tracker.at(next).valid, ++ticks;
    tracker.add(*t);
  }
  const GloveCounts n = tracker.counts();
  StepOutcome o;
  const double seen = ticks > 0 ? 100.0 * double(known) / double(ticks) : 0;
  o.checks = {at_least("grab", english("grabs that were felt"), double(n.grabs), "", kGrabs),
              at_most("grab", english("grabs that nobody did"), double(std::max<int64_t>(0, n.grabs - kGrabs)), "", 0),
              at_least("grab", english("both fingers seen"), seen, "%", 95)};
  if (n.grabs < kGrabs)
    o.advice =
        english("not every grab was felt: close the fingers until their tips touch, hold for a second, open them wide");
  else if (n.grabs > kGrabs)
    o.advice = english("more grabs were felt than three: do the step \"hand\" again with the hand as it works");
  else if (seen < 95)
    o.advice = english("a finger was lost from sight: turn the hand so that both sensors are free");
  return o;
}

StepOutcome reach(std::span<const Sample> samples, double, Calibration& c) {
  const std::vector<StylusSample> readings = stylus_readings(samples);
  StepOutcome o;
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
  std::vector<int64_t> t_ns;
  for (const StylusSample& s : readings) {
    const Vec3 p = world_of(s, c);
    low = low.cwiseMin(p), high = high.cwiseMax(p), t_ns.push_back(s.t_ns);
  }
  const Vec3 wide = readings.empty() ? Vec3(Vec3::Zero()) : Vec3(high - low);
  constexpr const char* name[3] = {english("from left to right"), english("from far to near"),
                                   english("from the table upwards")};
  for (int k = 0; k < 3; ++k) o.checks.push_back(at_least("reach", name[k], wide[k], "mm", kReach_mm[k]));
  o.checks.push_back(at_most("reach", english("longest gap at its rim"), longest_gap_ms(t_ns), "ms", kLongestGap_ms));
  if (longest_gap_ms(t_ns) > kLongestGap_ms)
    o.advice = english("the hand was lost from sight on its way: move the transmitter nearer, or what stands between");
  else if (!o.good())
    o.advice = english("go as far as you will work: left, right, away from you, near, and a hand's width up");
  return o;
}

constexpr RoomStep kRest{"rest",
                         english("Hands off"),
                         english("Lay the devices on the table where the patient will be, and take your hands away."),
                         english("So one sees how steady they are."),
                         5,
                         false,
                         rest};
constexpr RoomStep kTip{
    "tip",
    english("The tip of the stylus"),
    english("Stand the tip in a small hollow (of a screw, of a block) and lean the stylus slowly round to "
            "all sides, the tip staying where it is."),
    english("So the program knows how far the tip is from the sensor."),
    15,
    true,
    tip};
constexpr RoomStep kTable{
    "table",
    english("Where the table is"),
    english("Fold a sheet of A4 paper twice, so that its creases cross in the middle. Unfold it and lay it where the "
            "patient "
            "will be, a long side towards you. Touch with the tip, pressing the switch for half a second each: the far "
            "left "
            "corner, the far right, the near right, the near left, then the middle. Leave the sheet where it is."),
    english("So the patient lies where your hand is. The middle checks the corners."),
    40,
    true,
    on_table,
    5};
constexpr RoomStep kHand{
    "hand",
    english("The hand of the glove"),
    english("Open the hand wide and hold it for a second, then close forefinger and thumb and hold them "
            "for a second; four times."),
    english("So the program knows your open and your closed hand."),
    12,
    true,
    hand};
constexpr RoomStep kStroke{
    "stroke",
    english("A stroke"),
    english("Put the tip on the far left corner of the sheet, press the switch, draw slowly along the "
            "edge to the far right corner, and let go."),
    english("So one sees that a cut will lie where it is drawn, in one piece."),
    12,
    false,
    stroke,
    1};
constexpr RoomStep kGrab{
    "grab",
    english("A grab"),
    english("Close the hand as if you took hold of skin, hold for a second, open it; three times."),
    english("So one sees that each grab is felt, and no other."),
    10,
    false,
    grab};
constexpr RoomStep kReach{
    "reach",
    english("How far you reach"),
    english("Carry the tip slowly over the table as far as you will work: left, right, away from you, "
            "near, and a hand's width up."),
    english("So one sees that the hand is seen wherever it works."),
    12,
    false,
    reach};

}  // namespace

bool StepOutcome::good() const {
  return advice.empty() && std::all_of(checks.begin(), checks.end(), [](const RoomCheck& c) { return c.good(); });
}

HeardDevices heard_in(std::span<const Sample> samples) {
  HeardDevices h;
  for (const Sample& s : samples) {
    if (const auto* t = std::get_if<TrackerSample>(&s)) {
      h.stylus |= t->role == StationRole::stylus;
      h.glove |= t->role == StationRole::forefinger;
    } else if (std::holds_alternative<StylusSample>(s)) {
      h.stylus = true;
    }
  }
  return h;
}

std::vector<RoomStep> room_steps(const HeardDevices& h) {
  std::vector<RoomStep> all{kRest};
  if (h.stylus && h.tracked) all.insert(all.end(), {kTip, kTable});
  if (h.glove) all.push_back(kHand);
  if (h.stylus && h.tracked) all.insert(all.end(), {kStroke, kReach});
  if (h.glove) all.push_back(kGrab);
  return all;
}

std::vector<Vec3> sheet_points() {
  const double x = kSheetLong_mm / 2, y = kSheetShort_mm / 2;
  return {{-x, y, 0}, {x, y, 0}, {x, -y, 0}, {-x, -y, 0}, {0, 0, 0}};
}

int presses_in(std::span<const Sample> samples) { return int(touches(stylus_readings(samples), Vec3::Zero()).size()); }

}  // namespace limberg
