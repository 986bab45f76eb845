#pragma once
// The solver thread's work on one step, without the thread: events become commands, held hooks follow the hand, the
// patient takes a step, and what came of it is published.
//
// Every command that was carried out is appended to the session's own script, flushed line by line, so that a session
// leaves an operation that can be carried out again at any resolution.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "app/session/channels.h"
#include "app/session/hand_motion.h"
#include "app/session/patient.h"
#include "app/session/story.h"
#include "devices/command_builder.h"

namespace limberg {

struct SolverSettings {
  StepSettings step;             // of one step of the session
  int64_t series_every = 1;      // keep every n-th step's figures
  bool progressive_cut = false;  // an incision opens while it is drawn
  bool in_space = true;          // what the chart does not see is said in space
  bool as_meant = true;          // drawn curves are curves
  bool schedule = false;         // pass what each step found on to Channels::solver_takes
  int64_t hash_every = 60;       // with `schedule`: the state's hash goes with every n-th step, about once a second
  bool sample_states = false;    // every n-th step's places go to Channels::states
  std::function<void(double t_s, const HandState& hands)> after_step = {};  // looks at the patient, changes nothing
};

/// A command that the patient refused: nothing was changed.
struct Refusal {
  double t_s = 0;
  std::string command, reason;
};

class SolverLane {
 public:
  /// What is told about a carried out command: the script writer, a line on screen.
  using OnCommand = std::function<void(const Command& command)>;
  /// ... and about one that was refused: whoever keeps a record of it.
  using OnRefusal = std::function<void(const Command& command, const std::string& reason)>;

  SolverLane(Patient& patient, Channels& channels, const SolverSettings& settings, OnCommand on_command = {},
             OnRefusal on_refusal = {});

  /// Publishes the patient before anything has happened; call before the first device tick.
  void start();
  /// One step at device tick `tick`. `stop_early` is asked between iterations (real time). Empty: lockstep, and a new
  /// preconditioner is taken after a number of steps, whenever it is there.
  void step(int64_t tick, const std::function<bool()>& stop_early = {});
  /// The step that a live session took, once more: with this hand, the events that it had, and cut short where it was.
  void step_as(const SolverTake& take, const HandState* hand);
  /// A step towards rest after the last event: hooks and sutures stay as they are.
  void settle_step(int64_t tick) { step(tick); }

  /// Nothing is going on any more and the residual is small enough.
  bool at_rest(double residual) const { return patient_.settled() && steps_ > 0 && last_.residual <= residual; }
  const StepReport& last() const { return last_; }
  uint64_t steps() const { return steps_; }
  int64_t newest_sample_ns() const { return hand_.sample_ns; }  // in what was published last
  bool published_new_sample() const { return new_sample_; }
  /// Over positions, topology, hooks, sutures and the hand.
  uint64_t state_hash() const;
  /// A replay: what was recorded of the states, steps ascending, is compared as the steps come.
  void expect(std::vector<StateSample> states) { expected_ = std::move(states); }
  const StateDifference& difference() const { return difference_; }
  const std::vector<Refusal>& refused() const { return refused_; }
  const std::vector<StageRow>& stages() const { return stages_; }
  const SolverSeries& series() const { return series_; }
  const HandFigures& hand() const { return motion_.figures(); }
  uint64_t commands() const { return commands_; }
  int dropped_gestures() const { return builder_.dropped(); }
  uint64_t events() const { return events_; }
  int64_t event_gaps() const { return event_gaps_; }

 private:
  void advance(int64_t tick, const StepSettings& s);
  void pass_on(SolverTake take);  // to the recording, with the hash of the state after the step
  void take(const ToolEvent& e, int64_t tick);
  void take(const Command& c, int64_t tick);   // of a panel or a program
  bool apply(const Command& c, int64_t tick);  // false: refused
  void refuse(const Command& c, const std::string& reason, int64_t tick);
  std::string moved_away(const ToolEvent& e);  // why an act there is refused; empty: the skin is where it was shown
  void notify_dropped(const ToolEvent& e, int64_t tick);
  void notify(int32_t kind, const Command& c, const std::string& text, int64_t tick, int32_t freed = -1);
  void follow_hand();
  void answer_press();
  void make_indices();
  void publish(int64_t tick);
  void sample_state(const Snapshot& shown);
  void note_closure(const Snapshot& shown);

  Patient& patient_;
  Channels& ch_;
  SolverSettings settings_;
  OnCommand on_command_;
  OnRefusal on_refusal_;
  CommandBuilder builder_;
  HandState hand_;
  bool hand_known_ = false;
  Snapshot now_;         // of the moment, when it is asked for
  std::string a_moved_;  // of a stitch that is begun
  // By hand: the stylus', the first glove's, the other one's.
  std::array<int32_t, kHands> held_hook_{};  // 0 none
  std::array<int32_t, kHands> carried_{};    // the grab whose fragment it holds, 0 none
  std::array<int64_t, kHands> held_since_{};
  int64_t next_event_ = 0, event_gaps_ = 0;
  bool new_sample_ = false;
  int64_t shown_sample_ns_ = -1;
  StepReport last_;
  uint64_t steps_ = 0, commands_ = 0, events_ = 0;
  std::vector<Refusal> refused_;
  std::vector<StageRow> stages_;
  std::vector<Command> pen_;
  size_t shown_stages_ = 0;  // those that have their snapshot
  SolverSeries series_;
  HandMotion motion_;
  std::vector<StateSample> expected_;
  size_t next_expected_ = 0;
  StateDifference difference_;
};

}  // namespace limberg
