#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>

#include "app/commands/commands.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "calibration/distortion.h"
#include "calibration/glove_range.h"
#include "calibration/pivot.h"
#include "calibration/pointing.h"
#include "calibration/points_file.h"
#include "calibration/registration.h"
#include "devices/calibrating.h"
#include "devices/glove.h"
#include "devices/recording.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

struct CalibrateOptions {
  std::string what, log, out, from, points, device;
  bool replace = false, distortion = false, other = false;
};

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm t{};
  gmtime_r(&now, &t);
  return fmt::format("{:04}-{:02}-{:02}", t.tm_year + 1900, t.tm_mon + 1, t.tm_mday);
}

/// The readings of a stylus in a log, as a sensor's, in order.
std::vector<StylusSample> stylus_readings(const Recording& rec, const std::string& log) {
  std::vector<StylusSample> r = stylus_readings(rec.samples);
  if (r.empty())
    throw InputError(
        log, 0,
        "holds no reading of a stylus; expected one recorded with a station of role s, or LIMBERG_STYLUS messages");
  return r;
}

void line(const char* what, double value, const char* unit, double limit, bool at_most) {
  std::printf("  %-34s %8.3f %-4s  %s %.3g\n", what, value, unit, at_most ? "at most" : "at least", limit);
}

int refused(const CalibrateOptions& o, const std::string& advice) {
  say(o.log + ": not accepted: " + advice);
  std::printf("nothing was written\n");
  return kGoalMissed;
}

int finish(const CalibrateOptions& o, Calibration c) {
  c.date = today();
  if (!o.device.empty()) c.device = o.device;
  if (c.name == "identity") c.name = std::filesystem::path(o.out).stem().string();
  save_calibration(c, o.out);
  std::printf("calibration %s\n", o.out.c_str());
  return kDone;
}

void tell_pivot(const char* what, const char* residual, const PivotResult& r, const PivotLimits& limit) {
  std::printf("%-11s %d poses, %d agree\n", what, r.poses, r.agreeing);
  line(residual, r.residual_mm, "mm", limit.residual_mm, true);
  line("share of poses that agree", r.poses ? double(r.agreeing) / r.poses : 0, "", limit.inliers, false);
  line("cone, full opening", r.cone_deg, "deg", limit.cone_deg, false);
  line("weakest direction", r.weakest, "", limit.weakest, false);
  line("first half against second", r.repeat_mm, "mm", limit.repeat_mm, true);
  std::printf("  tip (%.3f, %.3f, %.3f) mm in the sensor's frame, +- %.3f mm\n", r.tip_mm.x(), r.tip_mm.y(),
              r.tip_mm.z(), r.uncertainty_mm);
}

int stylus(const CalibrateOptions& o, const Recording& rec, Calibration c) {
  std::vector<SensorPose> poses;
  for (const StylusSample& s : stylus_readings(rec, o.log))
    poses.push_back({s.tip_mm + c.distortion.at(s.tip_mm), rotation_of(s)});
  const PivotLimits limit;
  const PivotResult r = calibrate_pivot(poses, 1, limit);
  tell_pivot("stylus", "residual", r, limit);
  if (!r.accepted) return refused(o, r.advice);
  c.tip_offset_mm = r.tip_mm;
  return finish(o, c);
}

/// The poses of a finger's sensor in a log.
std::vector<SensorPose> finger_poses(const CalibrateOptions& o, const Recording& rec, StationRole role,
                                     const Calibration& c) {
  std::vector<SensorPose> poses;
  for (const Sample& s : rec.samples)
    if (const auto* t = std::get_if<TrackerSample>(&s); t && t->role == role)
      poses.push_back({t->pos_mm + c.distortion.at(t->pos_mm), rotation_of(as_stylus(*t))});
  if (poses.empty())
    throw InputError(o.log, 0,
                     std::string("holds no reading of the ") + o.what +
                         "; expected one recorded with stations of the roles f and t, of another glove F and T");
  return poses;
}

GloveParameters& glove_of(const CalibrateOptions& o, Calibration& c) {
  if (!o.other) return c.glove;
  if (!c.other_glove) c.other_glove = c.glove;
  return *c.other_glove;
}
StationRole role_of(const CalibrateOptions& o, bool thumb) {
  if (thumb) return o.other ? StationRole::other_thumb : StationRole::thumb;
  return o.other ? StationRole::other_forefinger : StationRole::forefinger;
}

int finger(const CalibrateOptions& o, const Recording& rec, Calibration c, bool thumb) {
  PivotLimits limit;
  limit.what = "hand", limit.where = "place";
  const PivotResult r = calibrate_pivot(finger_poses(o, rec, role_of(o, thumb), c), 1, limit);
  tell_pivot(thumb ? "thumb" : "forefinger", "residual (rms)", r, limit);
  if (!r.accepted) return refused(o, r.advice);
  (thumb ? glove_of(o, c).thumb_tip_mm : glove_of(o, c).forefinger_tip_mm) = r.tip_mm;
  return finish(o, c);
}
int forefinger(const CalibrateOptions& o, const Recording& rec, Calibration c) { return finger(o, rec, c, false); }
int thumb(const CalibrateOptions& o, const Recording& rec, Calibration c) { return finger(o, rec, c, true); }

int pointing(const CalibrateOptions& o, const Recording& rec, Calibration c) {
  const PointingLimits limit;
  GloveParameters& g = glove_of(o, c);
  const PointingResult r =
      calibrate_pointing(finger_poses(o, rec, role_of(o, false), c), g.forefinger_tip_mm, g.pointing, limit);
  std::printf("pointing    %d poses\n", r.poses);
  line("forefinger beside the place (rms)", r.residual_deg, "deg", limit.residual_deg, true);
  line("from how far around, full opening", r.cone_deg, "deg", limit.cone_deg, false);
  line("direction known to", r.uncertainty_deg, "deg", limit.uncertainty_deg, true);
  std::printf("  direction (%.4f, %.4f, %.4f) in the sensor's frame\n", r.direction.x(), r.direction.y(),
              r.direction.z());
  if (!r.accepted) return refused(o, r.advice);
  g.pointing = r.direction;
  return finish(o, c);
}

int world(const CalibrateOptions& o, const Recording& rec, Calibration c) {
  if (o.points.empty())
    throw InputError(
        "", 0, "calibrate world without --points; expected a file with a line x y z in mm for each touched point");
  const std::vector<Vec3> known = parse_points(read_whole_file(o.points, 1 << 20), o.points);
  const std::vector<Touch> touch = touches(stylus_readings(rec, o.log), c.tip_offset_mm);
  for (size_t i = 0; i < touch.size(); ++i)
    if (touch[i].spread_mm > kStillTouch_mm)
      return refused(o, "the tip moved by " + std::to_string(touch[i].spread_mm).substr(0, 4) + " mm during touch " +
                            std::to_string(i + 1) + ": rest it on the point, then press and hold for half a second");
  std::vector<Vec3> tips;
  for (const Touch& t : touch) tips.push_back(t.tip_mm);
  RegistrationLimits limit;
  if (o.distortion) limit.residual_mm = limit.held_out_mm = 50;  // judged once the field is corrected
  WorldRegistration r = calibrate_world(tips, known, limit);
  if (o.distortion && r.accepted) {
    // What the sensor should have read, so that the tip had been where it was.
    std::vector<Vec3> measured, right;
    for (size_t i = 0; i < touch.size(); ++i) {
      measured.push_back(touch[i].sensor_mm);
      right.push_back(touch[i].sensor_mm + r.rotation.conjugate() * (known[i] - r.translation_mm) - touch[i].tip_mm);
    }
    const DistortionSettings set;
    const DistortionResult d = calibrate_distortion(measured, right, set);
    std::printf("distortion  %zu points\n", measured.size());
    line("error at held-out points before", d.before_mm, "mm", d.before_mm, true);
    line("after", d.after_mm, "mm", d.before_mm / set.gain, true);
    if (!d.accepted) return refused(o, d.advice);
    c.distortion = d.grid;
    for (size_t i = 0; i < touch.size(); ++i) tips[i] += d.grid.at(touch[i].sensor_mm);
    limit = {};
    r = calibrate_world(tips, known, limit);
  }
  std::printf("world       %zu points touched, the last one held out\n", touch.size());
  line("residual at the fitted points", r.residual_mm, "mm", limit.residual_mm, true);
  line("error at the held-out point", r.held_out_mm, "mm", limit.held_out_mm, true);
  line("spread beside their line", r.spread_mm, "mm", limit.spread_mm, false);
  if (!r.accepted) return refused(o, r.advice);
  c.world_from_tracker_mm = r.translation_mm;
  c.world_from_tracker_quat = {r.rotation.w(), r.rotation.x(), r.rotation.y(), r.rotation.z()};
  return finish(o, c);
}

int glove(const CalibrateOptions& o, const Recording& rec, Calibration c) {
  Calibration of_glove = c;
  of_glove.glove = glove_of(o, c);
  int64_t readings = 0;
  const std::vector<double> aperture = apertures(rec.samples, of_glove, o.other, &readings);
  if (readings == 0)
    throw InputError(o.log, 0,
                     "holds no reading of a glove; expected one recorded with stations of the roles f and t, of "
                     "another glove F and T");
  const GloveLimits limit;
  const GloveResult r = calibrate_glove(aperture, kAperturesHz, limit);
  std::printf("glove       closed %.1f mm, open %.1f mm\n", r.closed_mm, r.open_mm);
  line("range", r.open_mm - r.closed_mm, "mm", limit.range_mm, false);
  line("closings", r.cycles, "", limit.cycles, false);
  const double band = (limit.release_share - limit.grab_share) * (r.open_mm - r.closed_mm);
  line("spread of the closed hand", r.spread_mm, "mm", band / limit.band_sigma, true);
  std::printf("  grabs below %.1f mm, releases above %.1f mm\n",
              r.closed_mm + limit.grab_share * (r.open_mm - r.closed_mm),
              r.closed_mm + limit.release_share * (r.open_mm - r.closed_mm));
  if (!r.accepted) return refused(o, r.advice);
  GloveParameters& g = glove_of(o, c);
  g.closed_mm = r.closed_mm, g.open_mm = r.open_mm;
  g.grab_share = limit.grab_share, g.release_share = limit.release_share;
  return finish(o, c);
}

int calibrate(const CalibrateOptions& o) {
  const std::map<std::string, int (*)(const CalibrateOptions&, const Recording&, Calibration)> procedures{
      {"stylus", stylus},         {"glove", glove}, {"world", world},
      {"forefinger", forefinger}, {"thumb", thumb}, {"pointing", pointing}};
  const auto procedure = procedures.find(o.what);
  if (procedure == procedures.end())
    throw InputError("", 0,
                     "calibrate " + o.what + ": unknown; expected stylus, glove, world, forefinger, thumb or pointing");
  if (std::error_code ec; std::filesystem::exists(o.out, ec) && !o.replace && o.out != o.from)
    throw InputError(o.out, 0, "exists already; expected the name of a new file, or --replace");
  const Calibration from = o.from.empty() ? Calibration{} : load_calibration(o.from);
  const Recording rec = read_recording(o.log);
  if (rec.damage.total() > 0)
    say(o.log + ": damaged: " + std::to_string(rec.damage.total()) + " events lost; what is whole is used");
  return procedure->second(o, rec, from);
}

}  // namespace

void add_calibrate(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<CalibrateOptions>();
  CLI::App* c =
      app.add_subcommand("calibrate", "From a recorded stream to a calibration file, or to what was wrong with it");
  c->add_option(
       "WHAT", o->what,
       "stylus: its tip, turned about in a dimple; world: where the tracker stands, from touched points; "
       "glove: how far apart the fingers of the open and closed hand are; forefinger, thumb: its tip, held on a "
       "place while the hand turns; pointing: which way the forefinger points, at one place from all sides")
      ->required();
  c->add_option("LOG", o->log, "The recorded stream")->required();
  c->add_option("--out", o->out, "The calibration file to write")->type_name("FILE")->required();
  c->add_option("--from", o->from, "A calibration to begin with: only the part that is calibrated now changes")
      ->type_name("FILE");
  c->add_option(
       "--points", o->points,
       "world: the points that were touched, a line x y z in mm each, in their order; the last one checks the others")
      ->type_name("FILE");
  c->add_flag("--distortion", o->distortion, "world: also correct a field that metal bends (40 points or more)");
  c->add_option("--device", o->device, "A word on the device, kept in the file")->type_name("TEXT");
  c->add_flag("--other-glove", o->other, "Of the glove on the other hand (stations of the roles F and T)");
  c->add_flag("--replace", o->replace, "Replace FILE if it exists");
  c->footer(
      "Example: limberg calibrate stylus pivot.lcm --out stylus.toml && limberg calibrate world touched.lcm --points "
      "board.txt --from stylus.toml --out room.toml");
  c->callback([o, &chosen] { chosen = [o] { return calibrate(*o); }; });
}

}  // namespace limberg
