#pragma once
// The operation as the model in its page (report.html), which the browser turns, plays and colours: a valid glTF 2.0
// file, small.
//
//   Places     whole steps of kPageStep_mm (KHR_mesh_quantization); for each version of the surface a mesh with a
//              primitive for each part, split where pictures split it; how it moves is morph targets of whole steps.
//   Picture    that on the skin, where it has one, as PNG, and its places (TEXCOORD_1). Colours of regions lie over it
//              (_COLOUR: sRGB, and how much of it is seen).
//   Colliders  what the tissue lies against, once, marked as still in the extras of their meshes.
//   Fields     what the report's maps show (pictures/skin_fields.h), a byte per vertex and frame: 0 to 255 over the
//              scale, which is that of the last frame for all.
//   The rest   in asset.extras: acts, stages, frames with stitches (way, force, gap), hooks and plates, the layers'
//              colours, the eye and the lamp of the report's pictures. Lengths in mm, forces in N, z up.
//
// A surface lasts until half way to the first frame of the next: between a cut and the frame before it there is a step,
// and everywhere else motion.
//
// Pictures are of the same scene and the same colours: make_tissue_mesh, stitch_way, SkinFields, scale_texture.
#include <string>
#include <vector>

#include "render/view.h"
#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

inline constexpr double kPageStep_mm = 0.02;  // of a patient up to 655 mm large; else its size over 32,767

class PageModel {
 public:
  /// `unit` of times: "s", or "act": each act is 1.
  explicit PageModel(std::string unit) : unit_(std::move(unit)) {}

  /// Times ascend; a frame at the time of the one before it replaces it. Frames without a surface are left out.
  void frame(double at, const Snapshot& snapshot);
  /// What was done and has ended then.
  void act(double at, const std::string& words) { marks_.push_back({at, words, false}); }
  /// A stage of the report; its frame is kept whatever happens.
  void stage(double at, const std::string& name, const Snapshot& snapshot);

  /// An act that was done, in words. A stroke that comes in pieces is one, told when it ends with its whole length.
  void done(double at, const Command& command);

  /// Of a script, each act of which is 1 on the axis: one has been carried out, and the patient is at rest.
  void acted(const Command& command, const Snapshot& snapshot);
  /// As it is at the end, in place of the last frame.
  void ended(const Snapshot& snapshot);

  /// Leaves out every other frame between stages.
  void thin();

  bool empty() const { return frames_.empty(); }
  /// The file. `most_bytes`: frames between stages are left out until it is about as small, 0: none is.
  std::string bytes(const std::string& title, const Camera& camera, double aspect, size_t most_bytes = 0) const;
  /// DIR/model.glb, for report.html. InputError: it cannot be written.
  void leave(const std::string& dir, const std::string& title, const Camera& camera, double aspect) const;

 private:
  double at_ = 0;  // acts of a script so far
  struct Frame {
    double at;
    bool stage;
    Snapshot shown;
  };
  struct Mark {
    double at;
    std::string words;
    bool stage;
  };
  std::string unit_;
  std::vector<Frame> frames_;
  std::vector<Mark> marks_;
  std::vector<Command> stroke_;  // the pieces of one that is being drawn
};

}  // namespace limberg
