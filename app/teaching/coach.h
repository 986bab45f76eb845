#pragma once
// Who teaches: hears what is done to the patient, looks at the hand, and says what comes next and why, how the present
// stroke lies against the plan, what is off and what to do about it. It draws nothing and does nothing to the patient.
//
//   Coach coach(make_lesson_plan(&lesson, script));
//   coach.hear(notice); coach.missed(press, patient);     // as they come
//   coach.look(patient, hand);                            // each frame
//   const CoachSays& says = coach.says();                 // for a panel
//
// Three modes. Guided: all of that. Free: the goal and why a press was missed. Examination: the same, and nothing is
// shown by the program; once begun it lasts as long as the session.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/session/notice.h"
#include "app/teaching/answers.h"
#include "app/teaching/progress.h"
#include "app/teaching/saw_watch.h"
#include "devices/skin_chart.h"
#include "devices/tool_event.h"

namespace limberg {

enum class LessonMode : uint8_t { guided, free_hand, examination };

/// What the hand is and does, as the coach sees it in a frame.
struct HandSeen {
  ToolState tool;
  std::optional<double> depth_mm, angle_deg;  // as the tool is set; nothing: not known
  bool showing = false;                       // it is the program's
};

/// A step in the list of a panel.
struct StepSeen {
  std::string name;
  enum State : uint8_t { ahead, now, done, off, shown } state = ahead;
};

/// A try, or the present one as far as it went.
struct Attempt {
  struct Row {
    std::string what, value;
    double share = 0;  // of what may be off; more than 1: off
    bool shown = false, judged = false;
  };
  std::vector<Row> rows;            // one for each step, then figures of the closure and of the hand
  std::vector<std::string> better;  // at most three
  std::vector<DrawnLine> cuts;      // the learner's own
};

struct CoachSays {
  std::string goal;
  std::vector<StepSeen> steps;
  size_t step = 0;                           // the present one; their number: all is done
  std::string limit;                         // how deep a blade may go; empty: nothing is cut now, or no limit is known
  std::string say, why, act;                 // of the present step; the act that is next
  std::optional<Tool> tool;                  // that does it; nothing: a panel does, or nothing is asked for
  std::string hint;                          // since the hand has been still for a while; mostly empty
  const LessonQuestion* question = nullptr;  // not answered yet
  std::string answer;                        // what was right, after it was answered
  bool answer_right = false;
  std::optional<ChartPoint> answer_place;  // where that is, of a place that was asked for
  std::string word;                        // the newest word on what was done; empty after a while
  bool word_is_praise = false;
  std::vector<LiveRow> stroke;  // while one is drawn
  std::string stroke_of;        // what it is meant to be
  int undos_to_plan = 0;        // what "from the plan" takes back first
  bool finished = false;
};

/// What is to be shown: first so many acts are taken back, then these are done.
struct Showing {
  int undos = 0;
  std::vector<Command> acts;
  std::string words;
};

class Coach {
 public:
  explicit Coach(LessonPlan plan, LessonMode mode = LessonMode::guided);

  void hear(const Notice& notice);
  void missed(const MissedPress& press, const Snapshot& patient);
  void look(const Snapshot& patient, const HandSeen& hand);
  /// The number of the answer, from 1. Nothing is asked: nothing happens.
  void answer(int number);
  /// Of a question about a place (of the chart, at rest), or a number. Another is asked, or none: nothing happens.
  void answer_place(const ChartPoint& at);
  void answer_number(double value);
  /// Something else was tried while a place is asked for.
  void ask_again();
  void set_mode(LessonMode mode);
  /// Keeps this try beside the next; how many acts are to be taken back for it.
  int try_again();

  LessonMode mode() const { return mode_; }
  const LessonPlan& plan() const { return plan_; }
  const CoachSays& says() const { return says_; }
  const PlanProgress& progress() const { return progress_; }
  const std::vector<StandingAct>& standing() const { return standing_; }
  /// Tries that have ended, the first first; and the present one.
  const std::vector<Attempt>& earlier() const { return earlier_; }
  Attempt present() const;
  /// Of the next act, from the learner's state or (`clean`) from the plan's. No acts: there is nothing to show.
  Showing showing(bool clean) const;
  /// Every word that was said, with its time: for a list, and for tests.
  struct Said {
    double t_s = 0;
    std::string word;
  };
  const std::vector<Said>& said() const { return said_; }

 private:
  void judge_newest(bool hangs_together);  // the bone that it sawed
  void follow_plan();
  void say(const std::string& word, bool praise = false);
  void tell_state();
  void follow_stroke(const Snapshot& patient, const HandSeen& hand);
  void answered(const Answered& a);
  void follow_saw(const Snapshot& patient, const HandSeen& hand);
  void tell_bites(const Snapshot& patient);
  std::string out_of_order(size_t act) const;
  std::string over_limit(const Command& c) const;

  LessonPlan plan_;
  LessonMode mode_;
  std::vector<Command> script_;
  std::vector<StandingAct> standing_;
  std::map<std::string, int> freed_;  // by a cut of bone, as a line of a script: how many pieces
  PlanProgress progress_;
  CoachSays says_;
  std::vector<Attempt> earlier_;
  std::vector<Said> said_;
  std::vector<int> answers_;  // of each step; 0: not answered
  bool shown_ = false;        // between the brackets
  double t_s_ = 0, active_s_ = 0, word_s_ = 0, began_s_ = 0;
  int undone_ = 0, missed_ = 0, refused_ = 0, shown_acts_ = 0;
  std::vector<SutureState> sutures_;
  bool sewing_ = false;  // a thread is not tied yet
  // The stroke that is being drawn.
  SurfaceIndex skin_{Ground::skin};
  int32_t touched_ = -1;
  LiveStroke stroke_;
  SurfaceIndex bone_{Ground::bone};
  bool lines_known_ = false;  // of planned cuts, on bone
  SawSeen saw_;
  double saw_off_s_ = -1;              // since when the saw has been off; less than 0: it is not
  bool saw_told_ = false;              // of this stroke
  std::vector<SutureBite> new_bites_;  // to be told of when the patient is seen
  bool pressed_ = false;
  int32_t tool_ = 0;
};

}  // namespace limberg
