#pragma once
// A surgical act, as a script line or a gesture states it: chart points on the skin and mm, nothing of any mesh.
// How each is written in a script, with units, limits and what it means, stands in table.h;
// `limberg actions` prints it. Acts on bones and face are in head_command.h.
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
  bool no_memory = false;  // refused because memory ran out: with more of it the act may be done
};

}  // namespace limberg
