#include "app/window/window_frames.h"

#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "app/pictures/pen_sheet.h"
#include "app/pictures/pictures.h"
#include "app/result/progress.h"
#include "app/session/pace_watch.h"
#include "app/teaching/why_missed.h"
#include "app/window/live_measures.h"
#include "app/window/orbit.h"
#include "app/window/painted.h"
#include "app/window/plan_sheet.h"
#include "app/window/ray_cast.h"
#include "app/window/skull_view.h"
#include "app/window/window_camera.h"
#include "app/window/window_style.h"
#include "render/picture.h"
#include "render/renderer.h"
#include "render/ui_painter.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr float kFontPx = 14;
constexpr double kSkullScale_mm = 5;  // of the distance from another skull
constexpr float kRadiansPerPixel = 0.008f;
constexpr double kFrameBudget_ms = 22;  // two thirds of the frame's period: the rest is for the desktop and for jitter
constexpr int kStillCalls = 10;         // a third of a second without a change: the picture may be drawn at leisure
constexpr int kStillLevel = kLiveLevels - 1;
constexpr float kClearTool_mm = 14;  // so far above its tip a tool begins to be seen through
constexpr float kClick_px = 4;       // a press that moves by less turns nothing
constexpr int kRefreshFrames = 15;   // the figures on the panels move twice a second even when nothing else does

}  // namespace

struct WindowFrames::Impl {
  HandFeed& feed;
  const LaneGauges* gauges;
  WindowSettings set;
  const Words w = set.facts.w;
  Desk desk;
  Ruler ruler;
  LiveMeasures measures;
  std::optional<Coach> coach;
  PlanSheet sheet;
  PenSheet pen;
  ActHistory acts;
  DeskMemory remembered;              // as it stands in the file
  Vec3f toured_view = Vec3f::Zero();  // when the tour looked last: the eye, the tool, how many acts stood
  Tool toured_tool = Tool::none;
  size_t toured_acts = 0;
  DeskColours colours = DeskColours::dark;
  bool by_keys = false;                 // keys have led the tool last
  size_t staged = 0;                    // steps of the lesson whose stage was told
  std::optional<Snapshot> earlier_try;  // as it was left; before and after compare with it
  const Snapshot* now = nullptr;        // during a frame
  ToolState hand;
  Vec3f guarded_mm = Vec3f::Constant(1e9f);  // the eye when it was kept out of the tissue last
  SkullView skull;
  bool skull_shown = false;
  SceneBuilder skull_builder;
  Camera camera;
  QualityLadder ladder{kFrameBudget_ms};
  SceneBuilder builder, before_builder;
  std::optional<Snapshot> first;  // for "before"; keeps its topology
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<UiPainter> ui;
  ImGuiContext* panels = nullptr;
  std::deque<WindowEvent> waiting;
  float x = 0, y = 0;  // the mouse, pixels
  float press_x = 0, press_y = 0;
  float scale = 1;  // pixels for one unit of the panels
  bool buttons[3]{};
  bool turning = false, shifting = false;
  bool answering = false;  // a press on the patient that is no act: a place is asked for
  uint64_t taken = 0;      // number of the last event
  SecondHand glove, other_glove;
  int unseen = 2;  // frames still to be drawn after the last event: panels need two to settle
  int since_frame = 0;
  SkinFields fields;
  const FieldShown* field = nullptr;
  FieldShown distance;  // of the skull from another: what its legend needs
  LatticeShown lattice;
  Painted painted;
  int level = kFastLevel;   // of the picture as it stands
  int quiet = 0;            // calls of wants_frame since the patient was drawn last
  bool at_leisure = false;  // nothing moves: the picture is drawn at kStillLevel
  int64_t drawn = 0;
  int64_t rate_tick = 0, rate_samples = 0, rate_frames = 0;
  PaceWatch pace;
  double samples_per_s = 0, pictures_per_s = 0;
  int pictures = 0;
  std::chrono::steady_clock::time_point on_tablet;  // the last frame on a headset's tablet

  Impl(HandFeed& f, const LaneGauges* g, WindowSettings s)
      : feed(f), gauges(g), set(std::move(s)), desk(set.facts), camera(set.camera) {
    builder.seen_from(camera), before_builder.seen_from(camera);
    if (set.lesson) coach.emplace(std::move(*set.lesson), set.mode);
    remember();
    desk.state.tension_lines = coach && coach->mode() == LessonMode::guided && set.facts.skin && !set.facts.head;
  }

  /// What an earlier session has left; the tour where there was none.
  void remember() {
    if (set.memory_file.empty()) return;
    try {
      desk.state.memory = remembered = read_desk_memory(set.memory_file);
    } catch (const InputError& e) {
      desk.say(e.what());
    }
    if (!remembered.toured) desk.state.tour.begin();
  }
  void keep_memory() {
    DeskMemory& m = desk.state.memory;
    if (!desk.state.tour.open()) m.toured |= !set.memory_file.empty();
    if (m == remembered || set.memory_file.empty()) return;
    remembered = m;
    try {
      write_desk_memory(set.memory_file, m);
    } catch (const InputError& e) {
      desk.say(e.what());
    }
  }

  DeskStage stage(int width, int height) const { return desk_stage(width, height, scale, desk.state.history); }
  Camera seen(double aspect) const { return fitted(camera, aspect); }
  View look(int width, int height) const {
    const DeskStage g = stage(width, height);
    return seen(g.aspect).view(g.aspect).placed(g.u0, g.v0, g.u1, g.v1);
  }

  /// A 30th of the distance to what is looked at, the rule of stereo photography: a head wants more than a patch of
  /// skin.
  double eyes_apart_mm() const { return double((camera.eye_mm - camera.target_mm).norm()) / 30; }

  /// The lesson asks for a place on the skin.
  bool place_asked() const { return coach && coach->says().question && coach->says().question->place; }

  bool on_panel(float px, float py) const {
    return std::any_of(desk.covered().begin(), desk.covered().end(),
                       [&](const FrameRect& r) { return r.holds(px / scale, py / scale); });
  }

  bool drag_turns(const WindowEvent& e) const {
    return (e.code == 1 && !(e.mods & WindowEvent::shift)) ||
           (e.code == 0 && desk.state.tool == Tool::none && !desk.state.ruler && !feed.showing);
  }

  void take(const WindowEvent& e, const Snapshot& s, int width, int height) {
    ImGuiIO& io = ImGui::GetIO();
    switch (e.kind) {
      case WindowEvent::pointer: {
        const float dx = e.x - x, dy = e.y - y;
        x = e.x, y = e.y, by_keys = e.by_keys;
        io.MousePos = {x / scale, y / scale};
        if (turning) turn(camera, kRadiansPerPixel * dx, kRadiansPerPixel * dy);
        if (shifting) shift(camera, dx, dy, int((stage(width, height).v1 - stage(width, height).v0) * float(height)));
        break;
      }
      case WindowEvent::button: {
        buttons[e.code] = e.down;
        io.MouseDown[e.code] = e.down;
        // A press beside the panels ends typing and touches none of them, wherever they have moved since it was made.
        io.MousePos = e.down && !e.for_panels ? ImVec2(-FLT_MAX, -FLT_MAX) : ImVec2(x / scale, y / scale);
        if (!e.down && e.code == 0 && (turning || answering) && place_asked()) {
          if (std::hypot(x - press_x, y - press_y) < kClick_px)
            desk.state.head.pick = true;
          else if (answering)
            coach->ask_again();
        }
        if (!e.down) turning = shifting = answering = false;
        if (e.down && e.for_panels && e.code == 0 && place_asked() && !on_panel(x, y))
          press_x = x, press_y = y, answering = true;
        if (!e.down || e.for_panels) break;
        press_x = x, press_y = y;
        if (drag_turns(e))
          turning = true;
        else if (e.code == 2 || e.code == 1)
          shifting = true;
        else if (desk.state.ruler) {
          const View v = look(width, height);
          ruler.add(s, cast_ray(s, v.eye_mm, v.ray_through(x, y, width, height)));
        }
        break;
      }
      case WindowEvent::wheel:
        if (e.for_panels)
          io.MouseWheel += e.y;
        else if (!buttons[0])
          approach(camera, std::pow(0.9f, e.y));
        break;
      case WindowEvent::key:
        io.KeyCtrl = e.mods & WindowEvent::control, io.KeyShift = e.mods & WindowEvent::shift,
        io.KeyAlt = e.mods & WindowEvent::alt;
        if (imgui_key(e.code) >= 0) io.KeysDown[e.code] = e.down;
        if (e.for_hand)
          mirror(e);
        else if (e.down && (!e.for_panels || leads_panels(e)))
          desk.key(e.code, e.mods);
        break;
      case WindowEvent::text:
        if (e.for_panels)
          io.AddInputCharacter(unsigned(e.code));
        else if (e.code == '?')
          desk.key(WindowEvent::question, 0);
        break;
      default:
        break;
    }
  }

  /// A key that ends what has the keys.
  bool leads_panels(const WindowEvent& e) const {
    if (ImGui::GetIO().WantTextInput) return false;
    return e.code == WindowEvent::f10 || e.code == WindowEvent::escape ||
           (desk.state.tour.open() && e.code == WindowEvent::enter);
  }

  /// A key that the hand has heard: what is seen of it.
  void mirror(const WindowEvent& e) {
    const DeskKey* k = desk_key(e.code, e.mods);
    if (!k) return;
    if (k->hand == HandKey::tool && e.down) desk.took(tool_of_key(e.code, e.mods)->tool);
    if (k->hand == HandKey::cursor && e.down) desk.say(w("the surface cursor of a stylus has another gain, or is off"));
    if (k->hand == HandKey::clutch) desk.say(e.down ? w("clutch: the hands move, what they hold does not") : "");
  }

  /// A command of a panel, on its way to the patient. What no script can hold is said instead.
  void give(const Command& c) {
    try {
      feed.answers.push(command_sample(c));
    } catch (const InputError& e) {
      desk.say(e.what());
    }
  }

  // What the panels asked for in this frame.
  void carry_out() {
    DeskState& d = desk.state;
    const auto control = [&](const ControlSample& c) { feed.answers.push(c); };
    const auto plain = [&](ControlSample::Kind kind) {
      ControlSample c;
      c.kind = kind;
      control(c);
    };
    if (d.tool_changed) feed.answers.push(static_cast<const HandChoice&>(d));
    if (d.undo) plain(ControlSample::undo);
    if (d.redo) plain(ControlSample::redo);
    if (d.go_to && !feed.showing) {
      constexpr size_t kAtOnce = 200;  // of the room in the ring
      const size_t standing = acts.standing(), wanted = std::min(*d.go_to, acts.entries().size());
      for (size_t i = 0; i < std::min(kAtOnce, wanted > standing ? wanted - standing : standing - wanted); ++i)
        plain(wanted > standing ? ControlSample::redo : ControlSample::undo);
    }
    d.go_to.reset();
    if (d.turn_x != 0 || d.turn_y != 0)
      turn(camera, kRadiansPerPixel * d.turn_x, kRadiansPerPixel * d.turn_y), d.turn_x = d.turn_y = 0;
    if (d.nearer != 0) approach(camera, std::pow(0.9f, float(d.nearer))), d.nearer = 0;
    keep_memory();
    if (d.release_hook > 0) {
      ControlSample c;
      c.kind = ControlSample::release_hook, c.value[0] = d.release_hook;
      control(c);
      d.release_hook = 0;
    }
    if (set.headset) {
      if (d.headset) set.headset->wanted = !set.headset->wanted;
      if (d.headset && set.headset->wanted) desk.say(w("the headset is looked for"));
      for (std::string line; set.headset->shown_words.take(line);) desk.say(w.said(line));
    } else if (d.headset) {
      desk.say(w("no headset's runtime is installed here; expected OpenXR's (docs/devices.md)"));
    }
    if (coach) teach();
    if (d.home) camera = set.camera;
    if (!d.ruler) ruler.clear();
    if (d.head.tie)
      if (const auto c = d.head.tied()) give(*c);
    if (const auto c = d.head.laid_upon()) give(*c);
    for (const Command& c : d.head.asked()) give(c);
    d.head.ask = DeskHead::Ask::nothing;
    d.headset = d.tool_changed = d.undo = d.redo = d.next = d.next_clean = d.home = d.head.tie = false;
  }

  /// What was asked of the coach, and the stages that were reached.
  void teach() {
    DeskState& d = desk.state;
    if (d.lesson.mode) coach->set_mode(*d.lesson.mode);
    if (d.lesson.answer > 0) coach->answer(d.lesson.answer);
    if (d.lesson.number) coach->answer_number(*d.lesson.number);
    if ((d.next || d.next_clean) && !feed.showing) {
      const Showing show = coach->showing(d.next_clean);
      if (show.acts.empty())
        desk.say(w(coach->mode() == LessonMode::examination ? english("In an examination nothing is shown.")
                                                            : english("There is nothing more to show.")));
      else
        feed.answers.push(ShowActs{show.undos, std::make_shared<const std::vector<Command>>(show.acts)});
    }
    if (d.lesson.again && !feed.showing) {
      if (now) earlier_try = *now;
      if (const int undos = coach->try_again(); undos > 0) feed.answers.push(ShowActs{undos, nullptr});
      staged = 0, d.summary = false;
    }
    d.lesson.again = false, d.lesson.answer = 0, d.lesson.mode.reset(), d.lesson.number.reset();
    d.lesson.place = place_asked();
    // Stages of the session are those of the lesson.
    const auto& steps = coach->says().steps;
    for (; staged < std::min(coach->says().step, steps.size()); ++staged) {
      ControlSample c;
      c.kind = ControlSample::stage, c.value[0] = double(staged) + 1,
      c.text = ShortText(coach->plan().steps[staged].words.stage);
      feed.answers.push(c);
      if (staged + 1 == steps.size()) d.summary = coach->mode() != LessonMode::free_hand;
    }
  }

  /// What the person sees now, and that everything up to the last event has been answered.
  void tell(const View& view, int width, int height) {
    FrameSeen& f = feed.seen.writing();
    f.view = view, f.width = width, f.height = height;
    f.panels = std::min(desk.covered().size(), f.panel.size());
    for (size_t i = 0; i < f.panels; ++i) {
      const FrameRect& r = desk.covered()[i];
      f.panel[i] = {r.x0 * scale, r.y0 * scale, r.x1 * scale, r.y1 * scale};
    }
    f.popup = desk.popup();
    f.typing =
        (ImGui::GetIO().WantTextInput && ImGui::IsAnyItemActive()) || desk.state.keys != DeskState::Keys::patient;
    f.tour = desk.state.tour.open();
    f.asks = place_asked() && desk.state.tool != Tool::none && !feed.showing;  // without a tool a press turns the view
    feed.seen.publish();
    feed.answered.store(taken, std::memory_order_release);
  }

  void save_picture(const Image& image) {
    std::string file;
    std::error_code ec;
    do file = set.picture_dir + "/limberg-" + std::to_string(++pictures) + ".png";
    while (std::filesystem::exists(file, ec));
    try {
      write_png(file, image);
      desk.say(w("picture: {}", file));
    } catch (const InputError& e) {
      desk.say(e.what());
    }
  }

  DrawOptions options(int at_level, int width, int height) const {
    DrawOptions o = draw_options(kQualityLevels[size_t(at_level)], width, height);
    o.wireframe = desk.state.wireframe;
    if (o.wireframe) o.shrink = 1;  // lines that are enlarged are not lines any more
    o.tension_lines = desk.state.tension_lines;
    if (field && !field->value.empty()) {
      o.colour_field = true, o.scale = look_of(desk.state.field).scale;
      o.field_min = field->lo, o.field_max = field->hi;
      o.iso_lines = desk.state.iso_lines ? field->intervals : 0;
    }
    o.face = FaceLook(desk.state.face);
    o.clear_tool_mm = kClearTool_mm;
    for (int i = 0; i < 3; ++i) o.tool_tip_mm[i] = float(hand.tip_mm[i]);
    if (skull_shown) {  // drawn as a face: 0 to 5 mm
      o.colour_field = true, o.scale = ColourScale::magnitude, o.field_min = 0, o.field_max = kSkullScale_mm,
      o.iso_lines = 5;
      o.face = FaceLook::solid;
    }
    return o;
  }

  SceneLines lattice_lines() const {
    SceneLines lines;
    if (!desk.state.lattice || !lattice.edges) return lines;
    for (const LatticeShown::Edge& e : *lattice.edges)
      if (size_t(std::max(e.a, e.b)) < lattice.node_mm.size())
        lines.add(lattice.node_mm[size_t(e.a)], lattice.node_mm[size_t(e.b)],
                  e.copied ? Vec3f(1.0f, 0.32f, 0.02f) : Vec3f(0.02f, 0.16f, 0.28f));
    return lines;
  }

  /// Picked places always, the others when they are wanted. Whether one is hidden is found by a ray.
  std::vector<DeskMark> marks(const Snapshot& s, const View& view, int width, int height) const {
    constexpr float kBefore_mm = 2;
    std::vector<DeskMark> out;
    if (!s.topology) return out;
    const auto hidden = [&](const Vec3f& at) {
      const float far = (at - view.eye_mm).norm();
      const RayHit hit = cast_ray(s, view.eye_mm, (at - view.eye_mm) / far, desk.state.face == 2);
      return hit.triangle >= 0 && hit.distance_mm < far - kBefore_mm;
    };
    for (const SheetLetter& l : sheet.letters())
      if (const Vec3f px = view.to_pixel(l.at_mm, width, height); px.allFinite() && desk.state.compare == Compare::off)
        out.push_back({px.x() / scale, px.y() / scale, l.text, hidden(l.at_mm),
                       l.limit ? DeskMark::Kind::limit : DeskMark::Kind::letter});
    for (const PenSheet::Length& l : pen.lengths())
      if (const Vec3f px = view.to_pixel(l.at_mm, width, height); px.allFinite() && desk.state.compare == Compare::off)
        out.push_back({px.x() / scale, px.y() / scale, l.text, hidden(l.at_mm), DeskMark::Kind::length});
    if (!set.facts.head) return out;
    const std::vector<std::string>& names = s.topology->landmark;
    for (size_t i = 0; i < std::min(names.size(), s.landmark_mm.size()); ++i) {
      const bool picked = picked_number(names[i]) > 0;
      if (!picked && !desk.state.landmarks) continue;
      const Vec3f at = s.landmark_mm[i], px = view.to_pixel(at, width, height);
      const float far = (at - view.eye_mm).norm();
      if (!px.allFinite() || !(far > 0)) continue;
      const RayHit hit = cast_ray(s, view.eye_mm, (at - view.eye_mm) / far, desk.state.face == 2);
      out.push_back(
          {px.x() / scale, px.y() / scale, names[i], hit.triangle >= 0 && hit.distance_mm < far - kBefore_mm});
    }
    return out;
  }

  void paint_patient(const RenderScene& scene, int at_level, int width, int height) {
    const DeskStage g = stage(width, height);
    const auto placed = [&](const View& v) { return v.placed(g.u0, g.v0, g.u1, g.v1); };
    DrawOptions o = options(at_level, width, height);
    const View whole = placed(seen(g.aspect).view(g.aspect));
    if (desk.state.compare != Compare::off && first) {
      const RenderScene& then = before_builder.build(earlier_try ? *earlier_try : *first);
      const bool wipe = desk.state.compare == Compare::wipe;
      View left = wipe ? whole.part(0, std::max(0.001f, desk.state.wipe)) : seen(0.5 * g.aspect).view(0.5 * g.aspect),
           right = wipe ? whole.part(std::min(0.999f, desk.state.wipe), 1) : left;
      if (!wipe) {
        left.x1 = right.x0 = 0.5f;
        left = placed(left), right = placed(right);
      }
      DrawOptions plain = o;
      plain.colour_field = false;
      renderer->paint(then, std::span(&left, 1), plain);
      o.keep = true;
      renderer->paint(scene, std::span(&right, 1), o);
    } else if (desk.state.stereo == Stereo::anaglyph) {
      const auto eyes = seen(g.aspect).stereo_pair(g.aspect, eyes_apart_mm());
      renderer->paint_anaglyph(scene, placed(eyes[0]), placed(eyes[1]), o);
    } else if (desk.state.stereo == Stereo::side_by_side) {
      std::vector<View> eyes = seen(0.5 * g.aspect).stereo_side_by_side(g.aspect, eyes_apart_mm());
      for (View& v : eyes) v = placed(v);
      renderer->paint(scene, eyes, o);
    } else {
      renderer->paint(scene, std::span(&whole, 1), o);
    }
  }

  /// Letters as large as they are drawn, so that they are sharp.
  void fit_panels(int width, int height) {
    ImGuiIO& io = ImGui::GetIO();
    if (const float wanted = desk_scale(width, height, desk.state.memory.letters_percent); wanted != scale) {
      scale = wanted;
      io.Fonts->Clear();
      choose_ui_font(kFontPx * scale);
      io.FontGlobalScale = 1 / scale;
      ui = std::make_unique<UiPainter>(renderer->functions());
    }
    if (colours != desk.state.memory.colours) set_style(colours = desk.state.memory.colours);
    io.DisplaySize = {float(width) / scale, float(height) / scale};
    io.DeltaTime = 1.0f / 30;
  }

  /// One press or release a frame of a button, and of a key that the panels follow: they see each, however slow the
  /// frames are.
  void take_waiting(const Snapshot& s, int width, int height) {
    for (bool clicked = false; !waiting.empty();) {
      const WindowEvent e = waiting.front();
      const bool counts = e.kind == WindowEvent::button || (e.kind == WindowEvent::key && imgui_key(e.code) >= 0);
      if (counts && clicked) break;
      clicked |= counts;
      waiting.pop_front();
      take(e, s, width, height);
      taken = std::max(taken, e.number);
      if (desk.state.head.pick) break;  // of what lay under the mouse when the key was pressed
    }
  }

  /// What is to be seen: the patient, or the skull beside the one of another moment.
  const RenderScene& build_scene(const Snapshot& s, const ToolState& tool, const View& view, int width, int height) {
    ToolPose held = tool_pose(tool, glove, other_glove);
    if (!set.facts.own_device && desk.state.tool == Tool::none && !feed.showing)
      held.visible = false;  // a mouse that looks around holds nothing
    const RenderScene& patient = builder.build(s, held);
    if (desk.state.directions) builder.add_stretch_glyphs(s);
    if (desk.state.lattice) builder.add_lines(lattice_lines());
    if (coach) {
      // In the plane of what is looked at, as the camera stands.
      const Vec3f aside = (camera.target_mm - view.eye_mm).unitOrthogonal();
      const float px =
          (view.to_pixel(camera.target_mm + aside, width, height) - view.to_pixel(camera.target_mm, width, height))
              .head<2>()
              .norm();
      sheet.draw(*coach, s, px > 0 && std::isfinite(px) ? 1 / px : 0);
      builder.add_props(sheet.props());
      builder.add_lines(sheet.lines());
    }
    pen.follow(tool);
    pen.draw(s, w);
    builder.add_props(pen.props());
    if (Tool(tool.tool) == Tool::swab && tool.valid) builder.show_beds(s);
    field = desk.state.field == SkinField::none ? nullptr : &fields.show(desk.state.field, s);
    builder.show_field(field ? field->value : std::vector<float>());
    const Snapshot* beside = desk.state.head.beside == SkullBeside::off
                                 ? skull.show(SkullBeside::off, {}, s, s)
                                 : skull.show(desk.state.head.beside, set.facts.normal_files, *first, s);
    desk.state.head.skull_word = skull.word();
    skull_shown = beside != nullptr;
    if (!beside) return patient;
    const RenderScene& scene = skull_builder.build(*beside);
    skull_builder.show_field(beside->moved_mm);
    distance.value = beside->moved_mm, distance.lo = 0, distance.hi = kSkullScale_mm;
    distance.above =
        std::any_of(distance.value.begin(), distance.value.end(), [](float d) { return double(d) > kSkullScale_mm; });
    return scene;
  }

  void count_rates() {
    if (!gauges) return;
    if (const std::string words = pace.look(LaneGauges::get(gauges->tick), LaneGauges::get(gauges->behind_ms));
        !words.empty())
      desk.say(w.said(words));
    const int64_t tick = LaneGauges::get(gauges->tick), samples = LaneGauges::get(gauges->samples);
    if (tick - rate_tick < 1000) return;
    const double per_s = double(LaneGauges::get(gauges->pace_permille));  // ticks that pass in a second
    samples_per_s = per_s * double(samples - rate_samples) / double(tick - rate_tick);
    const int64_t frames = LaneGauges::get(gauges->frames);
    pictures_per_s = per_s * double(frames - rate_frames) / double(tick - rate_tick);
    rate_tick = tick, rate_samples = samples, rate_frames = frames;
  }

  void draw_panels(const Snapshot& s, const View& view, int width, int height) {
    DeskReading r;
    r.shown = &s, r.gauges = gauges, r.ruler = ruler.read(s);
    r.coach = coach ? &*coach : nullptr, r.showing = feed.showing;
    r.earlier_try = earlier_try.has_value();
    if (hand.valid && (set.facts.own_device || set.facts.device != "mouse" || feed.showing))
      r.hand_tool = Tool(hand.tool);
    r.at_leisure = at_leisure && desk.state.quality == 0;
    r.field = field, r.samples_per_s = samples_per_s, r.pictures_per_s = pictures_per_s;
    if (skull_shown) {
      static constexpr SkinFieldLook kDistance{english("Distance"), english("Distance from the other skull"), "mm",
                                               ColourScale::magnitude, 1};
      r.field = &distance, r.look = &kDistance;
    }
    if (set.facts.head) r.measures = &measures.read(s);
    r.marks = marks(s, view, width, height);
    r.pointed = by_keys, r.point_x = x / scale, r.point_y = y / scale;
    if (desk.state.history) {
      r.acts = &acts;
      r.act_picture = [this](const ActHistory::Entry& e) -> void* {
        return e.picture.empty() ? nullptr : ui->picture(3 * e.number + uint64_t(e.taken), e.picture);
      };
    }
    std::vector<Vec3f> ruler_px;
    for (const Vec3f& p : r.ruler.at_mm) ruler_px.push_back(view.to_pixel(p, width, height) / scale);
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::NewFrame();
    desk.draw(r, ruler_px, int(std::lround(size.x)), int(std::lround(size.y)));
    ImGui::Render();
  }

  /// The answer to where something will be: the skin under the mouse, else under the tip of a stylus.
  void point_at(const Snapshot& s, const View& view, int width, int height) {
    constexpr double kTip_mm = 8;
    std::optional<ChartPoint> at;
    RayHit hit;
    if (!ImGui::GetIO().WantCaptureMouse) hit = cast_ray(s, view.eye_mm, view.ray_through(x, y, width, height));
    if (hit.triangle >= 0 && s.topology->is_ground(size_t(hit.triangle), Ground::skin))
      at = touch_at(s, hit.triangle, {double(hit.bary[0]), double(hit.bary[1]), double(hit.bary[2])}, 0).chart;
    else if (set.facts.own_device && hand.valid && has_surface(s))
      if (const SkinTouch t =
              SurfaceIndex(Ground::skin).closest(s, Vec3(hand.tip_mm[0], hand.tip_mm[1], hand.tip_mm[2]), -1);
          t.triangle >= 0 && t.distance_mm < kTip_mm)
        at = t.chart;
    if (!at) return desk.say("point at a place on the skin");
    coach->answer_place(*at);
  }

  /// Asked for by a key, and done once the panels know where the mouse is.
  void pick(const Snapshot& s, const View& view, int width, int height) {
    if (!desk.state.head.pick) return;
    desk.state.head.pick = false;
    constexpr int kHidden = 2;
    RayHit hit;
    if (place_asked()) return point_at(s, view, width, height);
    if (!ImGui::GetIO().WantCaptureMouse)
      hit = cast_ray(s, view.eye_mm, view.ray_through(x, y, width, height), desk.state.face == kHidden);
    if (hit.triangle < 0 && !set.facts.own_device)
      return desk.say(w("nothing lies under the mouse: point at bone or face and press K"));
    const auto said = desk.state.head.picked(s, hit.triangle, hit.bary);
    if (const auto* c = std::get_if<Command>(&said)) give(*c);
    if (const auto* c = std::get_if<ControlSample>(&said)) feed.answers.push(*c);
  }

  /// Of the act that was done last, at once and again when the tissue has come to rest.
  void keep_act_picture(int width, int height) {
    ActHistory::Entry* const e = acts.unseen(at_leisure);
    if (!e || desk.state.compare != Compare::off || desk.state.stereo != Stereo::off) return;
    const DeskStage g = stage(width, height);
    const auto px = [](float u, int n) { return int(u * float(n)); };
    renderer->compose(width, height);
    constexpr float kAside = 0.2f;  // of the stage on each side: what is operated on lies in its middle
    const float du = kAside * (g.u1 - g.u0), dv = kAside * (g.v1 - g.v0);
    e->picture = thumbnail(renderer->read(), px(g.u0 + du, width), px(g.v0 + dv, height), px(g.u1 - du, width),
                           px(g.v1 - dv, height), 2 * DeskHistory::kPictureWidth, 2 * DeskHistory::kPictureHeight);
    e->taken = at_leisure ? 2 : 1;
  }

  /// The patient, where it would look different or finer than it stands. True: it has changed.
  bool paint_changed(const RenderScene& scene, const View& view, int width, int height) {
    if (desk.state.picture) {  // the patient alone, as well as it can be drawn
      paint_patient(scene, int(kQualityLevels.size()) - 1, width, height);
      save_picture(renderer->read());
      desk.state.picture = false;
      painted.forget();
    }
    const PictureWish wish{view,
                           options(kFastLevel, width, height),
                           desk.state.compare,
                           desk.state.stereo,
                           desk.state.wipe,
                           desk.state.quality};
    const bool same = painted.shows(scene, wish), finer = same && at_leisure && level < kStillLevel;
    if (!same) at_leisure = false;
    if (!same || finer) {
      level = desk.state.quality > 0 ? desk.state.quality - 1 : at_leisure ? kStillLevel : ladder.level();
      paint_patient(scene, level, width, height);
      painted.note(scene, wish);
      ++drawn;
      keep_act_picture(width, height);
      quiet = 0;
    }
    return !same;
  }

  /// The whole frame, some times a second while somebody wears the headset.
  void show_on_tablet() {
    constexpr std::chrono::milliseconds kEvery{150};
    const auto moment = std::chrono::steady_clock::now();
    if (!set.headset->worn || moment - on_tablet < kEvery) return;
    on_tablet = moment;
    set.headset->tablet.show(std::make_shared<const Image>(renderer->read()));
  }

  /// What the tour has asked for was done, by whichever hand.
  void tour() {
    DeskTour& t = desk.state.tour;
    if (!t.open()) return;
    const size_t standing = acts.standing();
    TourSeen seen;
    seen.turned = !turning && !shifting && toured_view != Vec3f::Zero() && (camera.eye_mm - toured_view).norm() > 1;
    const Tool has = set.facts.own_device ? Tool(hand.tool) : desk.state.tool;
    seen.chose = has != toured_tool && has != Tool::none;
    seen.acted = feed.showing || standing > toured_acts;
    seen.took_back = standing < toured_acts || desk.state.history;
    seen.looked_up = desk.state.help || desk.popup();
    if (!turning && !shifting) toured_view = camera.eye_mm;
    toured_tool = has, toured_acts = standing;
    if (t.see(seen)) unseen = 2;
  }

  void frame(const Snapshot& s, const ToolState& tool, Screen& screen) {
    const int width = screen.width, height = screen.height;
    ImGui::SetCurrentContext(panels);
    fit_panels(width, height);
    take_waiting(s, width, height);
    if (!first) {
      first = s;
      if (coach && look_at_plan(camera, coach->plan(), s)) {
        set.camera = camera;
        builder.seen_from(camera), before_builder.seen_from(camera);
      }
    }
    hand = tool, now = &s;
    if (coach) {
      HandSeen seen{tool, std::nullopt, std::nullopt, feed.showing};
      if (!set.facts.own_device)
        seen.depth_mm = double(desk.state.depth_mm), seen.angle_deg = double(desk.state.angle_deg);
      coach->look(s, seen);
    }
    if (s.topology) desk.state.head.see(s.topology->landmark, s.landmark_mm);
    carry_out();
    keep_out_of(s, desk.state.face == 2, camera, guarded_mm);

    const View view = look(width, height);
    const RenderScene& scene = build_scene(s, tool, view, width, height);
    count_rates();
    tour();
    draw_panels(s, view, width, height);
    pick(s, view, width, height);
    carry_out();

    const auto began = std::chrono::steady_clock::now();
    const bool changed = paint_changed(scene, view, width, height);
    renderer->compose(width, height);
    ui->paint(*ImGui::GetDrawData(), width, height);
    renderer->present(width, height);
    if (set.headset) show_on_tablet();
    tell(view, width, height);
    if (changed && desk.state.quality == 0)
      ladder.frame(1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    feed.keep_recording.store(desk.state.keep_recording, std::memory_order_relaxed);
    since_frame = 0, now = nullptr;
    if (unseen > 0) --unseen;
  }
};

WindowFrames::WindowFrames(Screen& screen, HandFeed& feed, const LaneGauges* gauges, WindowSettings settings)
    : screen_(screen), impl_(new Impl(feed, gauges, std::move(settings))) {}
WindowFrames::~WindowFrames() { finish(); }

void WindowFrames::prepare(const SurfaceTopology&) {
  Impl& i = *impl_;
  i.renderer = std::make_unique<Renderer>(screen_.context());
  i.panels = ImGui::CreateContext();
  ImGui::SetCurrentContext(i.panels);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // nothing is kept between sessions
  io.KeyMap[ImGuiKey_Space] = WindowEvent::space;
  for (int32_t code = 'A'; code <= WindowEvent::page_down; ++code)
    if (imgui_key(code) >= 0) io.KeyMap[imgui_key(code)] = code;
  set_style(i.colours = i.desk.state.memory.colours);
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  choose_ui_font(kFontPx);
  i.ui = std::make_unique<UiPainter>(i.renderer->functions());
}

void WindowFrames::second_hand(const SecondHand& hand, const SecondHand& other) {
  impl_->glove = hand, impl_->other_glove = other;
}

void WindowFrames::frame(const Snapshot& snapshot, const ToolState& tool) {
  if (impl_->renderer) impl_->frame(snapshot, tool, screen_);
}

void WindowFrames::notice(const Notice& notice) {
  impl_->desk.notice(notice);
  impl_->acts.hear(notice);
  if (notice.kind != Notice::refused && notice.command) impl_->pen.hear(*notice.command);
  if (impl_->coach) impl_->coach->hear(notice);
  impl_->unseen = 2;
}

void WindowFrames::missed(const MissedPress& press, const Snapshot& snapshot) {
  if (impl_->coach)
    impl_->coach->missed(press, snapshot);
  else
    impl_->desk.say(why_missed(press, snapshot, impl_->w));
  impl_->unseen = 2;
}

int WindowFrames::tour_card() const { return impl_->desk.state.tour.card(); }

const Coach* WindowFrames::coach() const { return impl_->coach ? &*impl_->coach : nullptr; }

bool WindowFrames::wants_frame() {
  Impl& i = *impl_;
  for (WindowEvent e; screen_.events.pop(e);) i.waiting.push_back(e), i.unseen = 2;
  if (i.set.headset && i.set.headset->shown_words.waiting()) i.unseen = 2;
  if (i.unseen > 0) return true;
  if (++i.quiet >= kStillCalls && !i.at_leisure && i.desk.state.quality == 0) return i.at_leisure = true;
  return ++i.since_frame >= kRefreshFrames;
}

bool WindowFrames::wants_lattice() const { return impl_->desk.state.lattice; }
void WindowFrames::lattice(const LatticeShown& lattice) { impl_->lattice = lattice; }
int64_t WindowFrames::patient_drawn() const { return impl_->drawn; }

void WindowFrames::finish() {
  Impl& i = *impl_;
  if (!i.renderer) return;
  i.ui.reset();
  i.renderer.reset();
  ImGui::DestroyContext(i.panels);
  i.panels = nullptr;
}

Image WindowFrames::picture() { return impl_->renderer ? impl_->renderer->read() : Image{}; }

}  // namespace limberg
