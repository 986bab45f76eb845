#pragma once
// One call from a snapshot to a finished picture: skin or tension map, with caption and legend.
//
//   PictureMaker pictures(1280, 720);
//   pictures.focus_from(last_snapshot);                 // frame the operated region
//   write_png(file, pictures.skin(snapshot, {.title = "flap cut"}));
//
// The camera of a PictureMaker does not move from picture to picture, so that stages can be laid side by side. It is
// fixed by focus_from / set_camera, or else from the first picture's snapshot. Use one maker per thread: it
// owns a GL context and belongs to the thread that made it.
#include <memory>
#include <span>
#include <string>

#include "render/image.h"
#include "render/overlay.h"
#include "render/renderer.h"
#include "render/tool_pose.h"
#include "render/view.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct PropMesh;

struct PictureOptions {
  std::string title;    // top left, bold; empty = none
  std::string caption;  // below the title
  ToolPose tool{};
  const PropMesh* props = nullptr;  // what lies about besides. skin() only
  FaceLook face = FaceLook::solid;
  bool strands = false;    // the tissue between face and bone as a net
  bool wireframe = false;  // triangles as lines
  bool anaglyph = false;   // for red-cyan glasses; without landmarks. skin() only
  bool landmarks = false;  // named dots: of the bone, or of the face where it is solid
  std::string legend;      // over the colour scale of tension() or moved(); empty: English words
  std::string unit;        // of tension(), in words; empty: English
  char decimal = '.';      // of the scale's figures
  double field_max = 0;    // end of the tension scale; 0 = a round number above the 99th percentile of this snapshot
};

enum class PictureQuality {
  still,  // smooth edges, soft shadow: for reports
  film,   // the same light on a quarter of the pixels: for a picture of many that are kept
  live    // no extras: for a frame many times a second on a software renderer
};

struct RenderScene;
/// Where a colour scale of moved_mm ends: a round number above the 99.5th percentile of the face, at least 1 mm.
double moved_scale_end(const RenderScene& scene);

/// Where PictureMaker::focus_from puts the eye, for a picture so many times wider than high.
Camera camera_on_operated(const Snapshot& snapshot, double aspect);

class PictureMaker {
 public:
  /// RenderUnavailable (gl_context.h) when there is no off-screen context.
  /// software_threads: see OsMesaSettings::threads.
  PictureMaker(int width, int height, PictureQuality quality = PictureQuality::still, int software_threads = -1);
  ~PictureMaker();
  PictureMaker(PictureMaker&&) noexcept;

  /// Looks at what was operated: cuts, sutures and hooks of the snapshot; the whole skin when there are none.
  void focus_from(const Snapshot& snapshot);
  void set_camera(const Camera& camera);
  const Camera& camera() const;

  Image skin(const Snapshot& snapshot, const PictureOptions& options = {});
  /// Colour map of Snapshot::field (largest principal stretch -
  /// 1, prestretch included, shown in per cent) with a legend.
  Image tension(const Snapshot& snapshot, const PictureOptions& options = {});

  /// A value per vertex of the view in colours, with its legend:
  /// title, unit, range, map. Iso-lines at the legend's ticks.
  Image field(const Snapshot& snapshot, std::span<const float> per_vertex, const Legend& legend,
              const PictureOptions& options = {});

  /// How far every place of a face is from where it was at first, with a legend in mm.
  Image moved(const Snapshot& snapshot, const PictureOptions& options = {});

  std::string describe() const;  // the GL driver, in words

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
