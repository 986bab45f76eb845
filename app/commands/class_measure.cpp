#include "app/commands/class_measure.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "app/assembly/exercise.h"
#include "app/assembly/operation.h"
#include "app/class/walk.h"
#include "app/commands/recorded_call.h"
#include "app/head/report.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/result/metrics.h"
#include "app/result/progress.h"
#include "app/session/as_recorded.h"
#include "app/session/lockstep.h"
#include "app/session/workers_pool.h"
#include "devices/surface_index.h"
#include "render/gl_context.h"
#include "render/picture.h"
#include "sim/base/error.h"
#include "sim/commands/strokes.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Places on the patient as they are drawn: of skin on its chart at rest, of bones on the plane of the scene's picture.
class Places {
 public:
  Places(const World& world, const Camera& camera) : skin_(world.skin() != nullptr) {
    const Vec3 eye = camera.eye_mm.cast<double>();
    middle_ = camera.target_mm.cast<double>();
    right_ = (middle_ - eye).cross(camera.up.cast<double>()).normalized();
    up_ = right_.cross(middle_ - eye).normalized();
  }
  /// Not a number: it is far from the skin.
  ChartPoint at(const Snapshot& s, const Vec3& p_mm) {
    if (!skin_) return {right_.dot(p_mm - middle_), up_.dot(p_mm - middle_)};
    constexpr double kFar_mm = 60;
    if (!has_surface(s)) return {kNone, kNone};
    index_.another(s);
    const SkinTouch t = index_.closest(s, p_mm, -1);  // not from the last place: that may be another bank of a wound
    return t.triangle >= 0 && t.distance_mm < kFar_mm ? t.chart : ChartPoint(kNone, kNone);
  }

 private:
  bool skin_;
  Vec3 middle_, right_, up_;
  SurfaceIndex index_{Ground::skin};
};

std::string why_of(const MissedPress& m) {
  switch (m.kind) {
    case MissedPress::hook_stands:
      return "the hook stands elsewhere, out of reach";
    case MissedPress::second_bite:
      return "a stitch let go where there is no skin";
    case MissedPress::same_edge:
      return "a stitch with both bites in one edge";
    case MissedPress::place:
      return "no bone under the tip";
    case MissedPress::control:
      return "a choice that this patient does not know";
    default:
      return "nothing under the tip that the tool acts on";
  }
}

/// Looks at a session while it is done again.
class Watcher {
 public:
  ClassExtra also;

  void begin(const World& world, const Camera& camera) { places_.emplace(world, camera); }
  void act(double) { also.act_s.push_back(t_s_); }
  /// After a step.
  void step(const World& world, double t_s, const HandState& hands, Channels& ch) {
    t_s_ = t_s;
    const ToolState& hand = hands.tool;
    // A glove that holds something is the hand that works, and so is one by itself.
    const bool by_glove = hands.glove.valid && (hands.glove.closed || !hand.valid);
    const bool pressed = by_glove ? hands.glove.closed : hand.valid && hand.pressed;
    const double tool = !pressed ? 0 : by_glove ? double(Tool::grab) : double(std::max(hand.tool, 1));
    const bool heard = ch.missed.front() || ch.notices.front();
    if (!heard && t_s < next_s_ && tool == last_tool_) return;
    world.fill(now_);
    tell_missed(ch);
    if (t_s < next_s_ && tool == last_tool_) return;
    next_s_ = t_s + every_s_;
    if (by_glove != by_glove_) add({kNone, kNone}, 0), by_glove_ = by_glove;  // from one hand to the other is no way
    const double* const tip = by_glove ? hands.glove.centre_mm : hand.tip_mm;
    const ChartPoint at =
        by_glove || hand.valid ? places_->at(now_, Vec3(tip[0], tip[1], tip[2])) : ChartPoint(kNone, kNone);
    add(at, tool);
    last_tool_ = tool;
  }
  void end(const Snapshot& last) {
    const auto count = [&] { return also.stitches.x_mm.size(); };
    for (const SutureState& s : last.sutures) {
      const ChartPoint at = places_->at(last, (s.a_mm + s.b_mm).cast<double>() / 2);
      if (count() < 10'000) also.stitches.x_mm.push_back(at.x()), also.stitches.y_mm.push_back(at.y());
    }
  }

 private:
  void tell_missed(Channels& ch) {
    for (MissedPress m; ch.missed.pop(m);) {
      const ChartPoint at = places_->at(now_, Vec3(m.tip_mm[0], m.tip_mm[1], m.tip_mm[2]));
      missed(why_of(m), at);
    }
    for (Notice n; ch.notices.pop(n);)
      if (n.kind == Notice::dropped) missed(n.text.data(), {kNone, kNone});
  }
  void missed(const std::string& why, const ChartPoint& at) {
    if (also.missed.why.size() >= 500) return;
    also.missed.why.push_back(why), also.missed.x_mm.push_back(at.x()), also.missed.y_mm.push_back(at.y());
  }
  /// Points that say nothing new are left out; a long session is looked at less often.
  void add(const ChartPoint& at, double tool) {
    constexpr double kNear_mm = 0.4;
    constexpr size_t kMost = 6000;
    ClassPath& p = also.path;
    const bool gap = !std::isfinite(at.x());
    if (!p.x_mm.empty()) {
      const bool was_gap = !std::isfinite(p.x_mm.back());
      if (gap && was_gap) return;
      if (!gap && !was_gap && p.tool.back() == tool &&
          std::hypot(p.x_mm.back() - at.x(), p.y_mm.back() - at.y()) < kNear_mm)
        return;
    }
    p.x_mm.push_back(at.x()), p.y_mm.push_back(at.y()), p.tool.push_back(gap ? kNone : tool);
    if (p.x_mm.size() < kMost) return;
    every_s_ *= 2;
    size_t kept = 0;
    for (size_t i = 0; i < p.x_mm.size(); ++i)
      if (i % 2 == 0 || !std::isfinite(p.x_mm[i]) || p.tool[i] != p.tool[i - 1])
        p.x_mm[kept] = p.x_mm[i], p.y_mm[kept] = p.y_mm[i], p.tool[kept] = p.tool[i], ++kept;
    p.x_mm.resize(kept), p.y_mm.resize(kept), p.tool.resize(kept);
  }

  std::optional<Places> places_;
  Snapshot now_;
  double t_s_ = 0, next_s_ = 0, every_s_ = 0.08, last_tool_ = -1;
  bool by_glove_ = false;
};

void draw(const std::string& file, const World& world, const Scene& scene, const Snapshot& last) {
  if (file.empty() || !last.topology) return;
  if (world.skin()) return draw_member_picture(file, "", last);
  try {
    PictureMaker pictures(480, 480);
    pictures.set_camera(scene_camera(scene));
    PictureOptions o;
    o.face = FaceLook::clear;
    write_png(file, pictures.skin(last, o));
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
}

std::optional<std::string> of_recording(const FoundSession& session, const ClassMeasure& how) {
  Recording rec = open_session(session.path);
  const bool whole = rec.end.has_value();
  const LogDamage damage = rec.damage;
  SessionCall call;
  call.command = "replay";
  take_session(call, rec, session.path);
  if (how.lesson) check_lesson(*how.lesson, call.scene);
  if (how.cell_mm > 0) call.scene.cell_mm = how.cell_mm;  // another lattice: there is nothing to compare with
  take_samples(call, std::move(rec), session.path, how.cell_mm <= 0);

  Watcher watcher;
  Channels* channels = nullptr;
  AssemblyOptions o;
  o.workers = how.workers;
  o.progressive_cut = call.progressive_cut, o.threads_slip = call.threads_slip, o.in_space = call.in_space;
  o.as_meant = call.as_meant;
  o.watch = [&](const World& world, const Command* act, double t_s, const HandState* hands) {
    if (act)
      watcher.act(t_s);
    else
      watcher.step(world, t_s, *hands, *channels);
  };
  Assembly a(std::move(call.scene), call.calibration, o);
  channels = &a.channels;
  watcher.begin(*a.world, scene_camera(a.scene));
  if (how.lesson) check_lesson(*how.lesson, a.head);
  call.scene_files.reset();
  TakenSource* taken = nullptr;
  if (call.schedule.usable()) {
    auto source = std::make_unique<TakenSource>(std::move(call.taken));
    taken = source.get();
    a.front.add(std::move(source));
  }
  for (auto& s : call.sources) a.front.add(std::move(s));

  SessionSettings set = a.session_settings();
  if (call.ticks_per_solver_step > 0) set.ticks_per_solver_step = call.ticks_per_solver_step;
  set.end_tick = call.end_tick;
  set.interrupted = interrupted;
  set.ticks_per_frame = 1000;
  if (taken && call.end_tick >= 0) set.settle_steps = 0;
  if (how.progress) set.progress = [&](int64_t tick) { how.progress(double(tick) * 1e-3, call.known_length_s, "s"); };
  const SessionFigures f =
      taken ? run_as_recorded(a.lanes(nullptr), set, call.schedule, *taken) : run_lockstep(a.lanes(nullptr), set);
  if (f.interrupted) return std::nullopt;

  Result r("class", a.scene.name);
  fill_session(r, a, f, false, how.lesson, false);
  fill_damage(r, damage);
  Snapshot last;
  a.patient->fill_with_field(last);
  watcher.end(last);
  watcher.also.kind = "recording";
  watcher.also.whole = whole;
  if (damage.total() > 0)
    watcher.also.damage = fmt::format("{} events lost; what is whole was done again", damage.total());
  write_fields(r, "/class", watcher.also);
  draw(how.picture, *a.world, a.scene, last);
  return r.text();
}

std::optional<std::string> of_script(const FoundSession& session, const ClassMeasure& how) {
  const Script script = load_script(session.path);
  const std::string named = script.header.scene.empty() ? how.scene : script.header.scene;
  if (named.empty()) throw InputError(session.path, 1, "names no scene; expected \"scene\" in its first line");
  Scene scene = open_scene(named);
  if (how.lesson) check_lesson(*how.lesson, scene);
  if (how.cell_mm > 0) scene.cell_mm = how.cell_mm;
  WorkersPool workers(how.workers);
  const std::unique_ptr<World> world = make_world(scene, workers);
  if (how.lesson) check_lesson(*how.lesson, world->head());
  WorldPatient patient(*world, scene.tools.max_depth_mm);
  std::vector<Command> done;
  OperationSettings set;
  set.interrupted = interrupted;
  set.keep_going = true;
  set.on_done = [&](const ScriptLine& l, const std::string&) { done.push_back(l.command); };
  if (how.progress) set.progress = [&](size_t n, size_t of) { how.progress(double(n), double(of), "acts"); };
  const OperationOutcome o = operate(patient, script, set);
  if (o.interrupted) return std::nullopt;

  Result r("class", scene.name);
  ResultRun run;
  run.scene_title = scene.name;
  run.residual = o.last.residual, run.distance_mm = o.last.distance_mm;
  write_fields(r, "", run);
  ClassExtra also;
  also.kind = "script", also.whole = true;
  Snapshot last;
  world->fill(last, true);
  if (world->skin()) {
    MeasureAlso more;
    more.plan = how.lesson ? how.lesson->plan : script.header.plan;
    more.landmarks = scene.landmarks;
    if (how.lesson)
      more.landmarks.insert(more.landmarks.end(), how.lesson->landmarks.begin(), how.lesson->landmarks.end());
    const Metrics metrics = measure_world(*world, done, more);
    fill_metrics(r, metrics);
    const Skin skin(world->skin()->spec().body);
    Exercise e = exercise(done, metrics, plan_of(skin, more.plan, join_strokes(done)));
    e.refused = int(o.refused.size());
    fill_exercise(r, e, lesson_values(metrics, e.design), how.lesson);
  } else if (const Head* head = world->head()) {
    fill_head(r, *head);
    Exercise e = exercise(done, {}, std::nullopt);
    e.refused = int(o.refused.size());
    std::optional<BoneOutside> outside;
    if (head->has_face()) outside = bone_outside(last);
    fill_exercise(r, e,
                  how.lesson && how.lesson->bone
                      ? bone_values(*how.lesson->bone, *head, outside, done, how.lesson->words.limits)
                      : LessonValues{},
                  how.lesson);
  }
  ResultStory story;
  story.script = script_of(done);
  write_fields(r, "", story);
  Watcher places;
  places.begin(*world, scene_camera(scene));
  places.end(last);
  also.stitches = places.also.stitches;
  write_fields(r, "/class", also);
  draw(how.picture, *world, scene, last);
  return r.text();
}

}  // namespace

std::optional<std::string> measured(const FoundSession& session, const ClassMeasure& how) {
  return session.kind == FoundSession::recording ? of_recording(session, how) : of_script(session, how);
}

void judge_by(ClassMember& m, const Lesson& lesson) {
  if (said(m.result.lesson.title) == lesson.title) return;
  LessonValues v = values_of_metrics(m.result.metrics);
  const auto figure = [&](const char* name) {
    const auto at = m.result.exercise.find(name);
    return at == m.result.exercise.end() ? Maybe() : Maybe(at->second);
  };
  // As a session is judged: what was never done is no merit.
  if (m.result.sutures().empty())
    for (const char* of_stitches : {"gap_mm", "suture_N", "suture_peak_N", "closure_N"}) v.value.erase(of_stitches);
  if (!(figure("cuts").value_or(0) > 0)) v.value.erase("wound_gape_mm"), v.value.erase("waste_mm2");
  for (const auto& [tolerance, name] :
       {std::pair("corner_mm", "design/corner_max_mm"), std::pair("angle_deg", "design/angle_max_deg"),
        std::pair("limb_percent", "design/limb_max_percent"), std::pair("undos", "undos"),
        std::pair("time_s", "time_s"), std::pair("path_mm", "path_mm"), std::pair("movements", "movements")})
    if (const Maybe x = figure(name)) v.value[tolerance] = *x;
  std::vector<Judgement> judged = judge(lesson, v);
  std::erase_if(judged, [](const Judgement& j) { return !j.value; });  // a result does not tell why
  withhold_shown(judged, acts_of(m).command);
  std::vector<ResultTolerance> all;
  for (const Judgement& j : judged) all.push_back({j.name, j.unit, j.limit, j.value, j.met, j.why});
  m.result.lesson = {};
  m.result.lesson.title = lesson.title;
  m.result.lesson.tolerances = std::move(all);
}

}  // namespace limberg
