#pragma once
// What a force loop needs of the patient near the tip (ForceModel), made from the newest snapshot, at the solver's rate
// and only then: facets of the skin around the tip; for a held hook the stiffness that the solver's own force and
// displacement give (a secant); for contact the secant that the solver finds for this tip at this place
// (sim/patient/press.h), asked for as long as the tip is near.
// Until it has answered, or where there is no line to it, that of a half space of the layer that is touched: 2 a E / (1
// - nu^2) for a flat tip of radius a (Boussinesq 1885). Bone is that half space always: the skull across its thickness,
// 2.4 GPa (McElhaney et al. 1970), thousands of times what any device holds, so that the coupling is what is felt.
//
// What is felt is what the hand holds (tool_feel.h): a scalpel punctures and is drawn, a needle pierces and draws its
// thread from where it went in until the button is let go, fat holds a dissector back; a hook that this hand holds
// pulls.
//
// On the device thread, with the rest of the sources; nothing allocates.
#include <memory>

#include "devices/force/force_loop.h"
#include "devices/force/stiffness_line.h"
#include "devices/force/tool_feel.h"
#include "devices/surface_index.h"
#include "devices/tool_event.h"

namespace limberg {

struct ForceSourceSettings {
  int32_t device_id = 300;
  double tip_radius_mm = 1.0;
  double young_kPa = 60, poisson = 0.45;  // of the layer that is touched
  double patch_mm = 8;                    // facets within this of the tip, or of where it went in
  double deepest_mm = 25;                 // a tip that is in the tissue is followed so far
  double bone_kPa = 2.4e6, bone_poisson = 0.22;
  double answer_reach_mm = 4;                 // an answer for a place within this of the tip is still good
  double puncture_N = 0.8, cutting_N = 0.35;  // of a scalpel
};

class ForceModelMaker {
 public:
  ForceModelMaker(const ForceSourceSettings& settings, std::shared_ptr<StiffnessLine> line);
  /// The newest patient, and what the hand holds, before each make().
  void look(const Snapshot& snapshot) { seen_ = &snapshot; }
  void hold(const ToolState& state);
  /// The model for a tip here, which the loop lets feel so: whenever there is a newer snapshot; else null.
  const ForceModel* make(int64_t now_ns, const Vec3& tip_mm, const ForceState& felt);

  const ForceModel& model() const { return model_; }
  int64_t answers() const { return answers_; }  // models whose stiffness the solver gave
  /// The tool breaks through skin, and is then engaged with or without a button.
  bool cuts() const { return feel_.presses; }

 private:
  /// The surfaces that a tip can meet, each found and followed by itself.
  struct Sheet {
    SurfaceIndex index;
    int32_t near = -1;  // the triangle touched last
  };
  double contact_stiffness(const Snapshot& s, const SkinTouch& touch);
  double half_space(double young_kPa, double poisson) const;
  SkinTouch closest(Sheet& sheet, const Snapshot& s);
  /// What the tip is in, or else nearest to.
  Sheet& met(const Snapshot& s, SkinTouch& touch);

  ForceSourceSettings set_;
  std::shared_ptr<StiffnessLine> line_;
  ForceModel model_;
  ForceState felt_;
  Sheet skin_{SurfaceIndex(Ground::skin)}, flesh_{SurfaceIndex(Ground::flesh)}, bone_{SurfaceIndex(Ground::bone)};
  const Snapshot* seen_ = nullptr;
  uint64_t step_ = ~uint64_t(0);
  int64_t answers_ = 0;
  int64_t now_ns_ = -1, last_model_ns_ = -1;
  Vec3 tip_ = Vec3::Zero();
  Tool tool_ = Tool::none;
  ToolFeel feel_;
  bool pressed_ = false, threaded_ = false;
  Vec3 thread_from_ = Vec3::Zero(), thread_normal_ = Vec3::UnitZ();
  int32_t held_hook_ = 0, hook_ = 0;
  Vec3 hook_home_ = Vec3::Zero();  // where its tissue was when the hook was set
  Vec3 shift_ = Vec3::Zero();      // ToolState::shift_mm
};

}  // namespace limberg
