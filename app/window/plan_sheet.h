#pragma once
// The plan drawn on the patient as with a pen: thin tubes on the skin that go with it, letters at the corners, lines on
// bone. Violet: cuts. Green, dashed: what is undermined. Yellow: stitches, hooks, ways. Red: safe limits. Grey: the
// cuts of an earlier try. The next act stands out.
#include <string>
#include <vector>

#include "app/teaching/coach.h"
#include "devices/skin_chart.h"
#include "render/props.h"
#include "render/render_scene.h"

namespace limberg {

/// A letter or a name on the drawing.
struct SheetLetter {
  Vec3f at_mm = Vec3f::Zero();
  std::string text;
  bool limit = false;  // the name of a safe limit
};

class PlanSheet {
 public:
  /// What is to be drawn over this patient. `head`: the frame of places of acts on bone is the world's.
  /// `pixel_mm`: how large a pixel of the picture is there; lines are not drawn thinner than that.
  void draw(const Coach& coach, const Snapshot& patient, float pixel_mm = 0);
  const PropMesh& props() const { return props_; }
  const SceneLines& lines() const { return lines_; }  // of planes through bone
  const std::vector<SheetLetter>& letters() const { return letters_; }

 private:
  void pen(const Snapshot& s, const std::vector<ChartPoint>& path, bool closed, const Vec3f& colour, float radius_mm,
           bool dashed);
  void ring(const Vec3f& at, float radius_mm, const Vec3f& colour);
  void act(const Coach& coach, size_t i, const Snapshot& s);
  void on_bone(const HeadCommand& act, const Snapshot& s, bool next);
  void planes_on_bone(const Snapshot& s, const HeadCommand& cut);

  float least_mm_ = 0;  // radius of a line
  SkinChart chart_;
  PropMesh props_;
  SceneLines lines_;
  std::vector<SheetLetter> letters_;
};

}  // namespace limberg
