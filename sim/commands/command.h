#pragma once
// A surgical action, as a script line or a gesture states it: chart points on the skin and mm, nothing of any mesh.
//
// Script: JSON lines (script.h), one object a line, `action` first:
//   {"limberg_script":1,"scene":"rhomboid","note":"..."}                        first line
//   {"action":"excise","outline":[[x,y],...],"depth_mm":4}                       a plug: walls and floor, then taken
//   away.
//                                                                                "floor":false: walls only; what lies
//                                                                                within
//                                                                                must be free below, by undermining or
//                                                                                by
//                                                                                walls that reach through
//   {"action":"incise","path":[[x,y],...],"depth_mm":4,"angle_deg":90}           angle between blade and skin, in the
//   plane
//                                                                                across the path; 90 = upright.
//                                                                                "spline":true: a curve through the
//                                                                                points
//   {"action":"incise","stroke":3,"path":[...],"more":true}                      a piece of an incision that opens
//   while it is
//                                                                                drawn: further pieces go on from the
//                                                                                last
//                                                                                point, the one without "more" ends it.
//                                                                                Depth
//                                                                                and angle are those of the first piece
//   {"action":"undermine","outline":[[x,y],...],"depth_mm":4}                    a sheet at that depth under the
//   outline
//   {"action":"hook","id":1,"at":[x,y]}                                          skin hook, to be moved
//   {"action":"move","id":1,"to":[x,y,z],"seconds":1.5}                          its handle, world mm (block: z up,
//   skin at 0)
//   {"action":"release","id":1}
//   {"action":"suture","a":[x,y],"b":[x,y]}                                      one stitch; each point lies just
//   beside its edge.
//                                                                                "depth_mm":3: a buried one, whose
//                                                                                bites lie so deep
//                                                                                in the two walls of the wound
//   {"action":"suture_row","a":[[x,y],...],"b":[[x,y],...],"spacing_mm":4}       stitches along two paths, ends
//   included; also with
//                                                                                "depth_mm". "running":true: one
//                                                                                thread, the paths
//                                                                                may be curved; "slack_mm": so much of
//                                                                                it is left over
//   {"action":"suture_corner","tip":[x,y],"a":[x,y],"b":[x,y],"depth_mm":1}      half-buried mattress: one thread from
//   bank a through
//                                                                                the flap's tip to bank b, all within
//                                                                                the walls
//   {"action":"suture_between","from":1,"to":2,"spacing_mm":4}                   a row along the wound's edges between
//   two stitches, by
//                                                                                number (in order of tying) or by place
//                                                                                [x,y]; also
//                                                                                with "depth_mm", "running", "slack_mm"
//   {"action":"cut_suture","id":3}   or   {"action":"cut_suture","at":[x,y]}     the whole thread goes
//   {"action":"undo"}                                                            the last cut, excision, suture or cut
//   thread
//   {"action":"redo"}                                                            what was undone last; a new act ends
//   that
//   {"action":"stage","name":"flap cut"}                                         a picture and a row in the report
//   {"action":"wait","seconds":1}
//
// Acts on bones and face are in head_command.h.
#include <string>
#include <variant>
#include <vector>

#include "sim/body/body.h"
#include "sim/commands/head_command.h"

namespace limberg {

struct Incise {
  std::vector<ChartPoint> path;
  double depth_mm = 4;
  double angle_deg = 90;
  bool spline = false;
};
/// One more piece of stroke number `stroke`; one with another number begins another stroke. What has been drawn is cut
/// up to a few mm before its end, all of it with `last`. Undo takes the whole stroke back. A piece that cannot be cut
/// is refused and stops the stroke there: what was cut before stays, what comes after is refused too.
struct InciseMore {
  int stroke = 1;
  std::vector<ChartPoint> path;
  double depth_mm = 4;
  double angle_deg = 90;
  bool last = false;
};
struct Undermine {
  std::vector<ChartPoint> outline;
  double depth_mm = 4;
};
struct Excise {
  std::vector<ChartPoint> outline;
  double depth_mm = 4;
  bool floor = true;
};
struct SetHook {
  int id = 0;
  ChartPoint at{0, 0};
};
struct MoveHook {
  int id = 0;
  Vec3 to_mm{0, 0, 0};
  double seconds = 1;
};
struct ReleaseHook {
  int id = 0;
};
struct Suture {
  ChartPoint a{0, 0}, b{0, 0};
  double depth_mm = 0;
};  // depth 0: through the edges
/// How a row is sewn: single stitches, or one thread that runs through all of them and may slide. It is drawn until the
/// edges meet at every stitch (within 0.2 mm) or it would tear (5.9 N, USP 4-0), then slack_mm is given back and it is
/// tied.
struct RowKind {
  double spacing_mm = 4;
  double depth_mm = 0;
  bool running = false;
  double slack_mm = 0;
};
struct SutureRow {
  std::vector<ChartPoint> a, b;
  double spacing_mm = 4;
  double depth_mm = 0;
  bool running = false;
  double slack_mm = 0;
};
struct SutureCorner {
  ChartPoint tip{0, 0}, a{0, 0}, b{0, 0};
  double depth_mm = 1;
};
/// A stitch by its number, or (id 0) the one nearest to a place on the skin.
struct StitchPick {
  int id = 0;
  ChartPoint at{0, 0};
};
struct SutureBetween {
  StitchPick from, to;
  RowKind row;
};
struct CutSuture {
  StitchPick which;
};
struct Undo {};
struct Redo {};
struct Stage {
  std::string name;
};
struct Wait {
  double seconds = 1;
};

using Command = std::variant<Incise, InciseMore, Undermine, Excise, SetHook, MoveHook, ReleaseHook, Suture, SutureRow,
                             Undo, Redo, Stage, Wait, SutureCorner, SutureBetween, CutSuture, HeadCommand>;

/// What came of a command. A refused one has changed nothing.
struct Outcome {
  bool done = false;
  // when refused: what is wrong and what was expected, one line; when done: what is worth knowing, mostly nothing
  std::string reason;
};

}  // namespace limberg
