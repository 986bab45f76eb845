#pragma once
// What the emulated surgeon is going to do: a queue of small steps, made from one command at a time.
#include <deque>
#include <string>
#include <vector>

#include "devices/emulator.h"
#include "devices/skin_chart.h"
#include "sim/body/skin_view.h"

namespace limberg {

/// What the surgeon sees: the newest snapshot and the chart of its skin.
struct Sight {
  static constexpr double kRimMm = 2.5;  // a point this near to remaining skin is meant to be on it
  const Snapshot* seen = nullptr;
  SkinChart chart;

  bool open() const { return seen && seen->topology && seen->x_mm.size() == seen->topology->view.X_mm.size(); }
  SkinTouch skin_at(const ChartPoint& c, double slack_mm) const { return chart.at(*seen, c, slack_mm); }
  SkinTouch skin_at(const Vec3& X_mm) const { return SkinChart::at_rest(*seen, X_mm, kOffSkin_mm); }
  /// Where a blade held like this meets it.
  SkinTouch skin_under(const Vec3& X_mm, const Vec3& shaft) const {
    return SkinChart::on_line_at_rest(*seen, X_mm, shaft, kOffSkin_mm);
  }
  const HookState* hook(int id) const;
  const Body& body() const { return *seen->topology->body; }
};

/// Where the tip should be.
struct Aim {
  // rest: on the skin that lies nearest at rest; here: where the tip is when the step begins
  enum Kind { skin, rest, world, handle, here } kind = here;
  ChartPoint chart{0, 0};
  Vec3 rest_mm = Vec3::Zero();
  Vec3 world_mm = Vec3::Zero();
  int hook = 0;
  double height_mm = 0;  // above that place
};

struct Step {
  enum Kind { go, draw, hold, press, let_go, choose, next_command } kind = hold;
  Aim aim;                       // go, hold
  double seconds = 0;            // go: 0 = by speed
  std::vector<ChartPoint> path;  // draw: on the chart ...
  std::vector<Vec3> rest_path;   // ... or at rest in space
  std::vector<Vec3> shaft;       // draw at rest: the handle's direction at each of its points; empty: as it comes
  std::vector<double> length;    // draw: along the path, from 0
  double angle_deg = 90;         // draw
  bool on_edge = false;          // draw: along a wound's edge, and not on what lies beyond it at rest
  ControlSample control;         // choose
};

class SurgeonPlan {
 public:
  explicit SurgeonPlan(const SurgeonSettings& settings) : set_(settings) {}

  /// Rest where the tip is, then ask for the first command.
  void begin(double rest_s);
  /// Appends the steps of command number `index` of the script, and the mark that asks for the next one. A command that
  /// cannot be carried out adds a line to problems() and no steps.
  void add(const std::vector<Command>& script, size_t index, const Sight& sight);

  bool empty() const { return steps_.empty(); }
  Step& front() { return steps_.front(); }
  void pop() { steps_.pop_front(); }
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  void go(const Aim& aim, double seconds = 0);
  void hold(const Aim& aim, double seconds);
  void mark(Step::Kind kind);
  void control(int32_t kind, Tool tool = Tool::none, std::array<double, 4> value = {}, const std::string& text = {});
  void go_down(const Aim& target, double hover_mm);
  void rise(const Aim& from);
  void stroke(const std::vector<ChartPoint>& points, bool closed, double angle_deg, bool on_edge = false);
  /// The same over places in space, with the handle held along `shafts`, one for each; empty: as it comes.
  void stroke_in_space(const std::vector<Vec3>& places, const std::vector<Vec3>& shafts, bool closed,
                       bool on_edge = false);
  void stroke_command(Tool tool, const std::vector<ChartPoint>& path, bool closed, double depth_mm, double angle_deg);
  void let_go_unless_moved_next(const Aim& from);
  bool reachable(const ChartPoint& c);
  bool reachable(const Vec3& X_mm);
  void deep_stitch(const Suture& c, const Vec3& a, const Vec3& b);
  void sew(const Aim& a, const Aim& b);
  void sew_corner(const Aim& a, const Aim& tip, const Aim& b, double depth_mm);
  void set_hook(int id, const Aim& at);
  void tap(const Aim& at, double hover_mm);
  void take_for(const Suture& c);
  void take_for(const SutureRow& c);

  void plan(const Incise& c);
  void plan(const InciseMore& c);
  void plan(const Undermine& c);
  void plan(const Excise& c);
  void plan(const ExcisePiece& c);
  void plan(const CutThrough& c);
  void plan(const SetHook& c);
  void plan(const MoveHook& c);
  void plan(const ReleaseHook& c);
  void plan(const Suture& c);
  void plan(const SutureRow& c);
  void plan(const SutureCorner& c);
  void plan(const SutureBite& c);
  void plan(const TieSuture& c);
  void plan(const LetThreadGo& c);
  void plan(const InSpace& c);
  void plan(const Mark& c);
  void plan(const SutureBetween& c);
  void plan(const CutSuture& c);
  void plan(const Undo& c);
  void plan(const Redo& c);
  void plan(const Stage& c);
  void plan(const Wait& c);
  void plan(const Shown&) {}  // says who does it, and is no gesture
  void plan(const HeadCommand& c);
  template <class Other>
  void plan(const Other&) {
    problems_.push_back("command " + std::to_string(number_) + ": no gesture; expected an act of a hand");
  }

  SurgeonSettings set_;
  std::deque<Step> steps_;
  std::vector<std::string> problems_;
  int holding_ = 0;  // the hook in the hand when the steps so far are done, 0 = none
  int stages_ = 0;
  // Valid during add() only.
  const Sight* sight_ = nullptr;
  const Command* next_ = nullptr;
  size_t number_ = 0;
};

}  // namespace limberg
