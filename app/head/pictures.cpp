// The pictures of a report on a head.
#include "app/pictures/pictures.h"

#include "app/head/report.h"
#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "render/gl_context.h"
#include "render/picture.h"

namespace limberg {

namespace {

/// Everything where it was at first, landmarks too.
Snapshot at_rest(const Snapshot& s, const Head& head) {
  Snapshot b = s;
  const SharedArray<Vec3>& X = s.topology->view.X_mm;
  for (size_t v = 0; v < b.x_mm.size(); ++v) b.x_mm[v] = X[v].cast<float>();
  b.plate_mm.clear();
  b.moved_mm.assign(b.moved_mm.size(), 0.0f);
  for (const auto& [name, at] : head.landmarks_at_rest())
    for (size_t i = 0; i < std::min(b.landmark_mm.size(), s.topology->landmark.size()); ++i)
      if (s.topology->landmark[i] == name) b.landmark_mm[i] = at.cast<float>();
  return b;
}

PictureOptions look(FaceLook face, const std::string& title, bool landmarks = false) {
  PictureOptions o;
  o.face = face, o.title = title, o.landmarks = landmarks;
  if (!o.title.empty() && o.title[0] >= 'a' && o.title[0] <= 'z') o.title[0] = char(o.title[0] - 'a' + 'A');
  return o;
}

}  // namespace

void draw_head_pictures(const std::string& dir, const std::vector<StageRow>& stages, const Snapshot& first,
                        const Snapshot& last, const Camera& camera, const Head& head) {
  remove_report_pictures(dir);
  if (!last.topology) return;
  const bool face = !last.moved_mm.empty();
  try {
    PictureMaker pictures(1080, 1080);
    pictures.set_camera(camera);
    const auto file = [&](const char* name) { return dir + "/head/" + name; };
    prepare_folder(dir + "/head");
    if (!stages.empty()) prepare_folder(dir + "/" + report_names::stages_dir);
    for (const StageRow& s : stages)
      if (s.shown.topology)
        write_png(dir + "/" + report_names::stage_picture(s.number, s.name),
                  pictures.skin(s.shown, look(FaceLook::clear, s.name)));
    const Snapshot before = at_rest(last, head);
    write_png(dir + "/" + report_names::overview, pictures.skin(last, look(FaceLook::clear, "")));
    write_png(file("bones-before.png"), pictures.skin(first, look(FaceLook::hidden, "Before")));
    write_png(file("bones-after.png"), pictures.skin(last, look(FaceLook::hidden, "After")));
    if (!face) return;
    write_png(file("before.png"), pictures.skin(before, look(FaceLook::solid, "Before")));
    write_png(file("after.png"), pictures.skin(last, look(FaceLook::solid, "After")));
    write_png(file("moved.png"), pictures.moved(last, look(FaceLook::solid, "Displacement")));
    PictureOptions lines = look(FaceLook::solid, "Triangles of face and bone");
    lines.wireframe = true;
    write_png(file("wireframe.png"), pictures.skin(last, lines));
    PictureOptions stereo = look(FaceLook::clear, "After, for red-cyan glasses");
    stereo.anaglyph = true;
    write_png(file("anaglyph.png"), pictures.skin(last, stereo));
    write_png(file("through.png"), pictures.skin(last, look(FaceLook::clear, "After", true)));
    if (!last.topology->strand.empty()) {
      PictureOptions net = look(FaceLook::hidden, "Tissue between face and bone");
      net.strands = true;
      write_png(file("tissue.png"), pictures.skin(last, net));
    }
    Camera side = camera;
    side.eye_mm = camera.target_mm - Vec3f((camera.eye_mm - camera.target_mm).norm(), 0, 0);
    pictures.set_camera(side);
    write_png(file("profile-before.png"), pictures.skin(before, look(FaceLook::solid, "Before", true)));
    write_png(file("profile-after.png"), pictures.skin(last, look(FaceLook::solid, "After", true)));
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
}

}  // namespace limberg
