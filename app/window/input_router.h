#pragma once
// The one place through which everything passes that a person does in the window, on the main thread and in its order.
//
// Two things are decided here and nowhere else. Whose is a click: the panels', where they cover the frame that the
// person saw when it was made, else the patient's. Whose is a key: a text field's, the hand's (desk_keys.h) or the
// panels'. What is the hand's goes into one ring to the device thread (HandFeed::input), so that a tool chosen by a key
// is the tool of the click that follows. Every event goes on to the render thread too, with what was decided.
//
// What panels do with a click or a key is known when the render thread has drawn it: then a tool of the palette is
// chosen, a text field has the keys. Until then further events wait, in their order: a click after one on the palette
// acts with the tool that was chosen there, some frames late.
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "app/window/demonstration.h"
#include "app/window/hand_feed.h"
#include "app/window/screen.h"

namespace limberg {

class InputRouter {
 public:
  /// `mouse`: the mouse uses tools (else it only chooses and looks).
  InputRouter(Screen& screen, HandFeed& feed, bool mouse = true) : screen_(screen), feed_(feed), mouse_(mouse) {}
  /// Where the hand that shows sees the patient. Called with whether it looks; null: not yet.
  using Look = std::function<const Snapshot*(bool wanted)>;
  void look_with(Look look) { look_ = std::move(look); }

  /// Something happens in the window.
  void take(const WindowEvent& event);
  /// Every few ms: what the panels have answered, and the step that is being shown. The time is of any clock.
  void pump(int64_t now_ns);

 private:
  struct Happened {
    WindowEvent event;
    PointerReading ray;     // from the frame that was seen
    bool on_panel = false;  // of that frame
  };
  bool lead(const WindowEvent& key);
  void hear_panels();
  void go_on();
  void decide(Happened& h);
  void key(const DeskKey& key, const WindowEvent& e);
  void point(const Happened& h);
  void choose();
  void send(const HandInput& input);
  void show(int64_t now_ns);
  void begin_showing(const Snapshot& patient);
  void tell(const Command& command);

  Screen& screen_;
  HandFeed& feed_;
  Demonstration shown_;
  Look look_;
  bool mouse_;
  std::deque<Happened> waiting_;     // for the panels' answer
  uint64_t number_ = 0, asked_ = 0;  // of the last event; of the last one that panels may answer
  float x_ = 0, y_ = 0;
  bool led_press_ = false;  // by a key
  size_t cursor_ = 0;       // in kCursorGains
  bool of_panel_[3]{};      // the button went down on a panel
  bool pressed_ = false, clutch_ = false, glove_cursor_ = false;
  std::optional<ShowActs> wanted_;                    // to be shown as soon as the hand has let go
  std::shared_ptr<const std::vector<Command>> acts_;  // being shown, or as soon as what was taken back is gone
  bool begun_ = false;                                // the hand that shows them is there
  uint64_t shown_after_ = 0;                          // the step of the patient after which they may begin
  size_t gain_ = 0;                                   // of the glove's hand, in kHandGains
  float lift_mm_ = 0;
  HandChoice choice_;
  std::vector<std::shared_ptr<const Command>> told_;  // kept until the session has ended (CommandSample)
  PointerReading last_;
};

}  // namespace limberg
