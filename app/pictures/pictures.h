#pragma once
// Pictures of a session: frames while it runs, and the still pictures of the report afterwards.
#include <memory>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "app/session/picture_sink.h"
#include "app/session/solver_lane.h"
#include "app/words/words.h"
#include "render/tool_pose.h"
#include "render/view.h"

namespace limberg {

/// Where a scene's camera stands, and what the hands are and hold, as pictures know them.
Camera scene_camera(const Scene& scene);
ToolPose tool_pose(const ToolState& tool, const SecondHand& glove = {}, const SecondHand& other = {});

/// Draws frames off screen and throws them away: what a session without a window costs is then what one with a window
/// costs. Where no context can be made it says so once and draws nothing.
class OffscreenFrames final : public PictureSink {
 public:
  OffscreenFrames(const Scene& scene, int width, int height);
  ~OffscreenFrames() override;
  void prepare(const SurfaceTopology& first) override;
  void second_hand(const SecondHand& hand, const SecondHand& other) override;
  void frame(const Snapshot& snapshot, const ToolState& tool) override;
  void stage(const std::string&, const Snapshot&) override {}
  void finish() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A stage's name, or another short English text, as it stands over a picture: with a capital.
std::string picture_title(const Words& w, const std::string& english);

/// The picture of one member of a study: its operated region, with the title. Says so when none can be made.
void draw_member_picture(const std::string& file, const std::string& title, const Snapshot& shown);

/// Removes the pictures that an earlier run has left under the
/// report's own names: another scene's would be shown as this one's.
void remove_report_pictures(const std::string& dir);

/// Where the eye of draw_report_pictures stands, and how many times wider than high these pictures are.
Camera report_camera(const Snapshot& last);
inline constexpr double kReportAspect = 1280. / 720, kHeadAspect = 1;

/// Draws DIR/stages/NN-name.png, DIR/overview.png and DIR/tension.png (report_names.h), all with one camera on what was
/// operated, and with words in one language. Says in one line when pictures cannot be made here; InputError when a file
/// cannot be written. False: a person has ended it meanwhile, and the pictures so far are there.
bool draw_report_pictures(const std::string& dir, const std::vector<StageRow>& stages, const Snapshot& last,
                          const Words& w = {});

}  // namespace limberg
