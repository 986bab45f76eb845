// The pictures of a report on a head.
#include "app/pictures/pictures.h"

#include "app/head/report.h"
#include "app/pictures/pictures_drawn.h"
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

/// `title`: in the language of the pictures.
PictureOptions look(FaceLook face, const std::string& title, bool landmarks = false) {
  PictureOptions o;
  o.face = face, o.title = title, o.landmarks = landmarks;
  return o;
}

}  // namespace

bool draw_head_pictures(const std::string& dir, const std::vector<StageRow>& stages, const Snapshot& first,
                        const Snapshot& last, const Camera& camera, const Head& head, const Words& w) {
  remove_report_pictures(dir);
  if (!last.topology) return true;
  const bool face = !last.moved_mm.empty(), net = face && !last.topology->strand.empty();
  PicturesDrawn drawn(int(stages.size()) + 3 + (face ? 8 : 0) + (net ? 1 : 0));
  try {
    PictureMaker pictures(1080, 1080);
    pictures.set_camera(camera);
    prepare_folder(dir + "/head");
    if (!stages.empty()) prepare_folder(dir + "/" + report_names::stages_dir);
    const auto skin = [&](const std::string& file, const Snapshot& shown, const PictureOptions& o) {
      if (drawn.next()) write_png(dir + "/" + file, pictures.skin(shown, o));
    };
    for (const StageRow& s : stages)
      if (s.shown.topology)
        skin(report_names::stage_picture(s.number, s.name), s.shown, look(FaceLook::clear, picture_title(w, s.name)));
    const Snapshot before = at_rest(last, head);
    skin(report_names::overview, last, look(FaceLook::clear, ""));
    skin("head/bones-before.png", first, look(FaceLook::hidden, w("Before")));
    skin("head/bones-after.png", last, look(FaceLook::hidden, w("After")));
    if (!face) return drawn.all();
    skin("head/before.png", before, look(FaceLook::solid, w("Before")));
    skin("head/after.png", last, look(FaceLook::solid, w("After")));
    PictureOptions moved = look(FaceLook::solid, w("Displacement"));
    moved.legend = w("The face has moved"), moved.decimal = w.decimal();
    if (drawn.next()) write_png(dir + "/head/moved.png", pictures.moved(last, moved));
    PictureOptions lines = look(FaceLook::solid, w("Triangles of face and bone"));
    lines.wireframe = true;
    skin("head/wireframe.png", last, lines);
    PictureOptions stereo = look(FaceLook::clear, w("After, for red-cyan glasses"));
    stereo.anaglyph = true;
    skin("head/anaglyph.png", last, stereo);
    skin("head/through.png", last, look(FaceLook::clear, w("After"), true));
    if (net) {
      PictureOptions strands = look(FaceLook::hidden, w("Tissue between face and bone"));
      strands.strands = true;
      skin("head/tissue.png", last, strands);
    }
    Camera side = camera;
    side.eye_mm = camera.target_mm - Vec3f((camera.eye_mm - camera.target_mm).norm(), 0, 0);
    pictures.set_camera(side);
    skin("head/profile-before.png", before, look(FaceLook::solid, w("Before"), true));
    skin("head/profile-after.png", last, look(FaceLook::solid, w("After"), true));
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
  return drawn.all();
}

}  // namespace limberg
