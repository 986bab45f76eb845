#pragma once
// The panels around the patient: what can be chosen and what is read off. State and drawing with Dear ImGui, nothing of
// GL, threads or devices: WindowFrames (window_frames.h) feeds it and carries out what it asks for.
#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "app/assembly/desk_memory.h"
#include "app/pictures/skin_fields.h"
#include "app/session/gauges.h"
#include "app/session/notice.h"
#include "app/window/act_history.h"
#include "app/window/desk_head.h"
#include "app/window/desk_history.h"
#include "app/window/desk_layout.h"
#include "app/window/desk_lesson.h"
#include "app/window/desk_tour.h"
#include "app/window/hand_feed.h"
#include "app/window/ruler.h"
#include "app/window/screen.h"
#include "app/words/words.h"
#include "devices/sample.h"
#include "sim/patient/snapshot.h"

namespace limberg {

enum class Compare { off, wipe, side_by_side };
enum class Stereo { off, side_by_side, anaglyph };

/// Of the panels, and of the window until there is a picture.
inline constexpr std::array<float, 4> kPaper{0.07f, 0.10f, 0.115f, 1};

/// What the session is, said once.
struct DeskFacts {
  std::string scene, device, recording;  // recording: its file, empty when nothing is recorded
  std::string goal;                      // of the lesson, or the scene's note
  bool head = false, skin = true;        // what the scene holds
  double max_depth_mm = 9;
  bool own_device = false;                     // another than the mouse
  bool calibrated = false;                     // a calibration of it was given
  std::vector<std::string> normal_files = {};  // of a head: the skull beside (HeadScene)
  std::string word = {};                       // said until something is done; may be empty
  Words w = {};                                // the language of the panels
};

/// What is chosen, and what is asked for once.
struct DeskState : HandChoice {
  SkinField field = SkinField::none;
  bool iso_lines = true, tension_lines = false, lattice = false;
  bool landmarks = false;  // of a head: all of them, not only those that were picked
  bool directions = false, wireframe = false, help = false, ruler = false, keep_recording = false;
  int quality = 0;  // 0: chosen from the time of a frame (quality.h), else a level, from 1
  int face = 0;     // of a head: solid, clear, hidden
  Compare compare = Compare::off;
  float wipe = 0.5f;
  Stereo stereo = Stereo::off;
  DeskHead head;
  DeskLesson lesson;
  bool summary = false;  // how the lesson's try went
  DeskMemory memory;
  DeskTour tour;
  bool history = false;                                             // the panel of acts is open
  enum class Keys { patient, tools, beside } keys = Keys::patient;  // whose the keys are: the hand's, or a panel's
  // Asked for in this frame:
  int release_hook = 0;          // its number
  std::optional<size_t> go_to;   // so many acts are to stand
  float turn_x = 0, turn_y = 0;  // of the view, in pixels of a mouse that drags
  int nearer = 0;                // notches of a wheel
  bool tool_changed = false, undo = false, redo = false, next = false, next_clean = false, picture = false,
       home = false, headset = false;
};

/// A named place in the frame.
struct DeskMark {
  float x = 0, y = 0;
  std::string name;
  bool hidden = false;  // something lies before it
  enum class Kind : uint8_t {
    landmark,
    letter,
    limit,
    length                  // of a line of the pen
  } kind = Kind::landmark;  // of a head, or of the drawing of a plan
};

/// What is read off in this frame.
struct DeskReading {
  const Snapshot* shown = nullptr;
  const LaneGauges* gauges = nullptr;
  Ruler::Reading ruler;
  const Coach* coach = nullptr;  // of a lesson; null: there is none
  bool earlier_try = false;      // it is what comparisons are with
  bool showing = false;
  std::optional<Tool> hand_tool;  // what the hand has that is there, where it is not the mouse's choice
  bool at_leisure = false;  // nothing moves: the picture was drawn as finely as a window can, and may take its time
  const FieldShown* field = nullptr;    // what is shown in colours; null or empty: nothing
  const SkinFieldLook* look = nullptr;  // of what is shown, where it is none of the fields of skin
  double samples_per_s = 0, pictures_per_s = 0;
  const std::vector<HeadMeasure>* measures = nullptr;  // of a head
  std::vector<DeskMark> marks;                         // its landmarks; letters of a plan; lengths of the pen
  const ActHistory* acts = nullptr;                    // null: not shown
  DeskHistory::Picture act_picture;
  bool pointed = false;  // keys lead the tool: where it points is shown
  float point_x = 0, point_y = 0;
};

class Desk {
 public:
  explicit Desk(DeskFacts facts) : facts_(std::move(facts)), last_word_(facts_.word) {}
  DeskState state;

  void notice(const Notice& n);
  /// A key that neither a text field nor the hand took (desk_keys.h).
  void key(int32_t code, uint32_t mods);
  /// The hand has taken a tool.
  void took(Tool tool);
  static const std::vector<DeskKey>& keys();
  /// Builds the panels: between ImGui::NewFrame and ImGui::Render. width, height: of the frame in the panels' units,
  /// pixels over desk_scale(); so are the places of marks and of the ruler's points.
  void draw(const DeskReading& reading, const std::vector<Vec3f>& ruler_px, int width, int height);
  void say(const std::string& line) { last_word_ = line; }
  /// What the panels of the last frame cover, in their own units; whether a list is open.
  const std::vector<FrameRect>& covered() const { return covered_; }
  bool popup() const { return popup_; }

 private:
  void panel(const char* name, const FrameRect& at);
  bool offered(Tool tool) const;
  void menu(float width);
  void menu_items(const char* menu);
  void tools(const DeskReading& r, const FrameRect& at);
  void tool_row(const DeskTool& tool, const DeskReading& r);
  void settings(Tool tool);
  void view_choices();
  void patient(const DeskReading& r, const FrameRect& at);
  void lanes(const DeskReading& r, const DeskLayout& at);
  void words(const DeskReading& r, const FrameRect& stage);
  void legend(const DeskReading& r, const FrameRect& stage);
  void compared(const DeskReading& r, const FrameRect& stage);
  void marks(const DeskReading& r, const FrameRect& stage);
  void ruler(const DeskReading& r, const std::vector<Vec3f>& ruler_px);
  void set_by_key(int steps);
  void help(int width, int height);
  void done_list();
  void hooks(const Snapshot& s);
  void device(const DeskReading& r);
  void choose(Tool tool);
  void choose_field(SkinField field);
  SkinField first_field() const { return facts_.skin ? SkinField::stretch : SkinField::moved; }

  DeskFacts facts_;
  struct Heard {
    Notice notice;
    std::string text;  // in the language of the panels
  };
  std::deque<Heard> notices_;
  uint64_t heard_ = 0, listed_ = 0;         // how many notices came; how many of them the list has shown
  float scroll_most_ = 0;                   // of the list
  bool shown_ = false;                      // what is heard of is shown by the program
  float stage_top_ = 0, stage_bottom_ = 0;  // what the words over the patient leave of it
  DeskHistory history_;
  DeskState::Keys keys_shown_ = DeskState::Keys::patient;
  std::string last_word_;
  std::vector<FrameRect> covered_;
  bool popup_ = false;
};

}  // namespace limberg
