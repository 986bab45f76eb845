#include "app/pictures/pictures.h"

#include <algorithm>
#include <filesystem>

#include "app/pictures/field_map.h"
#include "app/pictures/pen_sheet.h"
#include "app/pictures/pictures_drawn.h"
#include "app/pictures/skin_fields.h"
#include "app/report/parts.h"
#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "render/gl_context.h"
#include "render/picture.h"
#include "sim/measure/perfusion.h"
#include "sim/measure/skin_strain.h"

namespace limberg {

std::string picture_title(const Words& w, const std::string& english) { return capital(w.said(english)); }

namespace {

PictureOptions titled(const std::string& title, const Words& w = {}) {
  PictureOptions o;
  o.title = picture_title(w, title);
  return o;
}

}  // namespace

Camera scene_camera(const Scene& scene) {
  Camera c;
  c.target_mm = scene.camera.target_mm.cast<float>();
  c.eye_mm = scene.camera.eye_mm().cast<float>();
  c.up = scene.camera.up.cast<float>();
  c.fov_deg = float(scene.camera.fov_deg);
  return c;
}

namespace {

GlovePose glove_pose(const SecondHand& g) {
  GlovePose hand;
  hand.visible = g.valid != 0, hand.closed = g.closed != 0, hand.points = g.points != 0;
  hand.holds = g.held_hook != 0 || g.carried.holds != 0;
  for (int i = 0; i < 3; ++i) {
    hand.forefinger_mm[i] = float(g.forefinger_mm[i]), hand.thumb_mm[i] = float(g.thumb_mm[i]);
    hand.pointing[i] = float(g.pointing[i]), hand.pointed_mm[i] = float(g.pointed_mm[i]);
    hand.thumbwards[i] = float(g.thumbwards[i]);
  }
  return hand;
}

}  // namespace

ToolPose tool_pose(const ToolState& t, const SecondHand& glove, const SecondHand& other) {
  ToolPose p;
  p.visible = t.valid != 0;
  switch (Tool(t.tool)) {
    case Tool::hook:
    case Tool::hook_out:
      p.kind = ToolPose::Kind::hook;
      break;
    case Tool::suture:
    case Tool::suture_buried:
    case Tool::suture_corner:
    case Tool::suture_row:
    case Tool::suture_running:
    case Tool::suture_bites:
    case Tool::suture_knot:
    case Tool::suture_row_buried:
    case Tool::suture_deep:
      p.kind = ToolPose::Kind::needle_holder;
      break;
    case Tool::undermine:
      p.kind = ToolPose::Kind::dissector;
      break;
    case Tool::scissors:
      p.kind = ToolPose::Kind::scissors, p.closed = t.pressed != 0;
      break;
    case Tool::marker:
      p.kind = ToolPose::Kind::marker;
      break;
    case Tool::swab:
      p.kind = ToolPose::Kind::swab;
      break;
    case Tool::saw:
      p.kind = ToolPose::Kind::saw;
      break;
    case Tool::none:
    case Tool::grab:
      p.kind = ToolPose::Kind::stylus;
      break;
    default:
      p.kind = ToolPose::Kind::scalpel;
      break;
  }
  for (int i = 0; i < 3; ++i) p.tip_mm[i] = float(t.tip_mm[i]), p.shaft[i] = float(t.shaft[i]);
  p.bites = std::clamp(t.bites, 0, int(p.bite_mm.size()));
  for (int b = 0; b < p.bites; ++b)
    for (int i = 0; i < 3; ++i) p.bite_mm[size_t(b)][i] = float(t.bite_mm[b][i]);
  p.glove = glove_pose(glove), p.other_glove = glove_pose(other);
  // A hand that pushes the cursor has the tool there: it need not be seen whole, and hides what it works on.
  for (GlovePose* hand : {&p.glove, &p.other_glove})
    hand->whole &= !(p.visible && hand->points && hand->pointed_mm == p.tip_mm);
  p.other_glove.left = true;
  return p;
}

struct OffscreenFrames::Impl {
  Camera camera;
  int width, height;
  std::unique_ptr<PictureMaker> maker;
  SecondHand glove, other;
};

OffscreenFrames::OffscreenFrames(const Scene& scene, int width, int height)
    : impl_(new Impl{scene_camera(scene), width, height, nullptr, {}, {}}) {}
OffscreenFrames::~OffscreenFrames() = default;

void OffscreenFrames::prepare(const SurfaceTopology&) {
  try {
    // No worker threads of the driver's own: on two cores they would take time from the solver.
    impl_->maker = std::make_unique<PictureMaker>(impl_->width, impl_->height, PictureQuality::live, 0);
    impl_->maker->set_camera(impl_->camera);
  } catch (const RenderUnavailable& e) {
    say(std::string("no frames: ") + e.what());
  }
}

void OffscreenFrames::second_hand(const SecondHand& hand, const SecondHand& other) {
  impl_->glove = hand, impl_->other = other;
}

void OffscreenFrames::frame(const Snapshot& snapshot, const ToolState& tool) {
  if (!impl_->maker) return;
  PictureOptions o;
  o.tool = tool_pose(tool, impl_->glove, impl_->other);
  impl_->maker->skin(snapshot, o);
}

void OffscreenFrames::finish() { impl_->maker.reset(); }

void draw_member_picture(const std::string& file, const std::string& title, const Snapshot& shown) {
  try {
    PictureMaker pictures(960, 600);
    pictures.focus_from(shown);
    write_png(file, pictures.skin(shown, titled(title)));
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
}

namespace {

/// What cannot be seen: where the blood may not reach, and how hard the skin is pulled.
void draw_maps(const std::string& dir, const Snapshot& last, const Words& w) {
  const Skin skin(last.topology->body);
  const SurfaceView& view = last.topology->view;
  write_whole_file(dir + "/" + report_names::perfusion,
                   field_map_svg(view, skin.body(), perfusion(view, skin).index,
                                 {w("Perfusion index (dark: little)"), "", 0, 1, true, w}));
  const std::vector<MembraneState> states = skin_states(view, last.x_mm, skin.body());
  std::vector<float> stress(states.size(), -1);
  std::vector<std::pair<double, double>> all;
  for (size_t t = 0; t < states.size(); ++t)
    if (states[t].area_mm2 > 0)
      stress[t] = float(std::max(0.0, states[t].stress_kPa)), all.emplace_back(double(stress[t]), states[t].area_mm2);
  write_whole_file(dir + "/" + report_names::stress,
                   field_map_svg(view, skin.body(), stress,
                                 {w("Largest principal stress of the skin"), "kPa", 0,
                                  std::max(1.0, weighted_percentile(all, 0.99)), false, w}));
}

}  // namespace

void remove_report_pictures(const std::string& dir) {
  std::error_code none;
  for (const char* name : {report_names::overview, report_names::tension, report_names::perfusion, report_names::stress,
                           report_names::height, report_names::moved, report_names::risk, report_names::model})
    std::filesystem::remove(std::filesystem::path(dir) / name, none);
}

namespace {

constexpr int kReportWidth = 1280, kReportHeight = 720;

}  // namespace

Camera report_camera(const Snapshot& last) { return camera_on_operated(last, double(kReportWidth) / kReportHeight); }

bool draw_report_pictures(const std::string& dir, const std::vector<StageRow>& stages, const Snapshot& last,
                          const Words& w) {
  remove_report_pictures(dir);
  if (!last.topology) return true;
  draw_maps(dir, last, w);
  PicturesDrawn drawn(int(stages.size()) + 5);
  try {
    PictureMaker pictures(kReportWidth, kReportHeight);
    pictures.focus_from(last);
    if (!stages.empty()) prepare_folder(dir + "/" + report_names::stages_dir);
    for (const StageRow& s : stages) {
      if (!drawn.next() || !s.shown.topology) continue;
      PenSheet pen;
      for (const Command& c : s.pen) pen.hear(c);
      pen.draw(s.shown, w);
      PictureOptions stage = titled(s.name, w);
      stage.props = &pen.props();
      write_png(dir + "/" + report_names::stage_picture(s.number, s.name), pictures.skin(s.shown, stage));
    }
    if (drawn.next()) write_png(dir + "/" + report_names::overview, pictures.skin(last));
    PictureOptions tension = titled(english("Tension of the skin"), w);
    tension.legend = w("Skin stretch"), tension.unit = w("% of length"), tension.decimal = w.decimal();
    if (drawn.next() && !last.field.empty())
      write_png(dir + "/" + report_names::tension, pictures.tension(last, tension));
    SkinFields fields;
    for (const auto& [field, file] :
         {std::pair(SkinField::height, report_names::height), std::pair(SkinField::moved, report_names::moved),
          std::pair(SkinField::perfusion, report_names::risk)}) {
      if (!drawn.next()) break;
      const FieldShown& shown = fields.show(field, last);
      const SkinFieldLook& look = look_of(field);
      if (!shown.value.empty())
        write_png(dir + "/" + file, pictures.field(last, shown.value,
                                                   {w(look.title), look.unit[0] ? w(look.unit) : "", shown.lo, shown.hi,
                                                    look.scale, shown.above, shown.below, w.decimal()},
                                                   titled(look.name, w)));
    }
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
  return drawn.all();
}

}  // namespace limberg
