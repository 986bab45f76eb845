#pragma once
// From tool events back to surgical commands: the solver side collects the events it drains and gets, for each finished
// gesture, the command that a script line would state. Strokes are smoothed here (stroke_path.h).
#include <array>
#include <optional>
#include <vector>

#include "devices/hand_ground.h"
#include "devices/stroke_path.h"
#include "devices/tool_event.h"
#include "sim/commands/command.h"

namespace limberg {

class CommandBuilder {
 public:
  /// `progressive`: a stroke of the scalpel is told in pieces while it is drawn (InciseMore).
  /// `ground`: outlives the builder; null: every place is said on the chart, and no cut right through runs open.
  explicit CommandBuilder(const PathSettings& settings = {}, bool progressive = false,
                          const HandGround* ground = nullptr)
      : path_(settings), progressive_(progressive), ground_(ground) {}

  /// The command that this event completes, if any:
  ///   stroke_end -> Incise (scissors too), CutThrough, Undermine, Excise (ExcisePiece when it was no stroke) or Mark;
  ///   the second stroke of a pair -> SutureRow (turned when it was plainly drawn the other way);
  ///   hook_set -> SetHook; hook_leave -> MoveHook to where it was left, seconds 0; hook_release -> ReleaseHook;
  ///   suture_b -> Suture, or SutureCorner where suture_tip came before, of the running stitch SutureBite;
  ///   suture_knot -> TieSuture; suture_let_go -> LetThreadGo; suture_cut -> CutSuture;
  ///   undo -> Undo; redo -> Redo; stage -> Stage;
  ///   of the saw stroke_end -> CutBone (bone_contour.h), which need not divide; bone_grab -> GrabFragment;
  ///   bone_drag -> DragFragment to where it was taken, seconds 0; bone_release -> LetGo; told -> that command.
  /// Progressive: a stroke_point of the scalpel completes a piece of some 5 mm that lies a little behind the hand,
  /// smoothed over what is known by then, and stroke_end the last one; a stroke that ends before its first piece is an
  /// Incise.
  /// What the chart does not see, or sees something else over, becomes an act in space (InSpace), as a stitch in a cut
  /// face does; such an incision opens when it is drawn, also where it is progressive.
  /// Between hook_set or hook_take and hook_leave the hook follows ToolState::tip_mm.
  std::optional<Command> feed(const ToolEvent& event);
  /// The patient has refused a piece: nothing more comes of this stroke.
  void stop_stroke();
  /// Strokes too short to mean anything (fewer than two points apart after smoothing), and broken pairs.
  int dropped() const { return dropped_; }

 private:
  /// A stroke as it was drawn, at rest.
  struct Drawn {
    std::vector<ChartPoint> chart;
    std::vector<Vec3> X_mm, out;
  };
  /// What was meant by it. X_mm is empty where the chart says enough, else `chart` has as many points that say
  /// nothing.
  struct Way {
    std::vector<ChartPoint> chart;
    std::vector<Vec3> X_mm;
    double length_mm() const;
  };
  bool on_chart(const Drawn& d) const;
  Way meant(const Drawn& d, bool outline, bool in_space) const;
  std::optional<Command> row_with(Drawn b, const ToolEvent& e);
  std::optional<Command> cut_through(const Drawn& d, const ToolEvent& e);
  bool means(const ChartPoint& place, const Vec3& X_mm) const { return !ground_ || ground_->chart_means(place, X_mm); }
  std::optional<Command> draw_on(const ToolEvent& e);
  Command finish_drawing(const ToolEvent& e, const std::vector<ChartPoint>& drawn);

  PathSettings path_;
  bool progressive_ = false;
  const HandGround* ground_ = nullptr;
  int stroke_number_ = 0;   // of the newest stroke that was told in pieces
  bool in_pieces_ = false;  // the present stroke is; its stroke_ then begins where the last piece ended
  std::vector<Vec3> bone_stroke_;
  std::vector<ChartPoint> stroke_;
  std::vector<Vec3> stroke_X_, stroke_out_;  // of the same points, unless it is told in pieces
  bool off_chart_ = false;                   // the present stroke; it is not told in pieces
  Drawn row_a_;
  Vec3 stroke_begin_ = Vec3::Zero();  // in the world, as are the ends of row a
  std::array<Vec3, 2> row_a_ends_{Vec3::Zero(), Vec3::Zero()};
  bool have_row_a_ = false, have_suture_a_ = false;
  bool have_tip_ = false;
  ChartPoint suture_a_{0, 0}, suture_tip_{0, 0};
  Vec3 suture_a_rest_mm_ = Vec3::Zero(), suture_tip_rest_mm_ = Vec3::Zero();
  HeldSide side_a_ = HeldSide::skin;
  int dropped_ = 0;
};

}  // namespace limberg
