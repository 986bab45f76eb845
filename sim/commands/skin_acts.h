#pragma once
// Acts on skin, at places of a chart (body.h) and in mm. How each is written in a script stands in table.h.
#include <cstdint>
#include <span>
#include <vector>

#include "sim/body/chart.h"

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
  double above_held_mm =
      0;  // where what is held (bone under its periosteum) lies nearer, so far above it; 0: does not ask
};
struct Excise {
  std::vector<ChartPoint> outline;
  double depth_mm = 4;
  bool floor = true;
};
/// A piece that is loose already is taken out by touching it.
struct ExcisePiece {
  ChartPoint at{0, 0};
};
/// A cut through the body from one side to the other, as of a lip or an ear. Between its posts the blade is ruled: it
/// goes along the normals of the posts, evenly between two of them.
struct CutThrough {
  std::vector<Vec3> path;                     // posts, at rest
  std::vector<Vec3> normals;                  // out of the skin, one for each post; empty: those of the skin there
  bool open_start = false, open_end = false;  // goes on over the body's free margin there
  // Begins on the bed that a pocket has left there, below the flap, which stays whole; else on the skin.
  bool from_bed = false;
};
/// What a hook or a needle goes into.
enum class HeldSide : uint8_t {
  skin,
  under,  // a cut face that looks away from the skin: a flap's underside
  bed,    // a cut face that looks towards the skin: what the flap was raised from
  wall    // the nearest cut face
};
inline constexpr const char* kHeldSides[] = {"skin", "under", "bed", "wall"};
struct SetHook {
  int id = 0;
  ChartPoint at{0, 0};
  HeldSide side = HeldSide::skin;
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
  HeldSide side_a = HeldSide::skin, side_b = HeldSide::skin;
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
/// One bite of a thread that is sewn on: in beside one edge, out beside the other. The first begins the thread with a
/// knot; each further one draws what lies behind it tight. There is one such thread at a time. How far from its edge a
/// bite lies is how much of the skin it holds (kFarthest_mm at most).
struct SutureBite {
  static constexpr double kFarthest_mm = 6;
  ChartPoint a{0, 0}, b{0, 0};
  double depth_mm = 0;
  HeldSide side_a = HeldSide::skin, side_b = HeldSide::skin;
};
/// The thread that is sewn on is tied behind its last bite, and its needle is free for another.
struct TieSuture {
  double slack_mm = 0;
};
/// The hand lets go of the thread that is sewn on, without a knot: it slips through its bites until friction holds it,
/// and the edges part again (sim/patient/sutures.h). A further bite, or the knot, takes it up and draws it tight.
struct LetThreadGo {};
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
/// A muscle of the scene (body/region.h) pulls along its fibres, from 0 to 1 of what it can.
struct Activate {
  std::string region;
  double level = 0;
};
/// A line drawn on the skin with a pen, or what a swab wipes off: every line of the pen within kWiped_mm of the path.
/// Nothing of the tissue changes.
struct Mark {
  static constexpr double kWiped_mm = 4;
  std::vector<ChartPoint> path;  // one point: a dot
  bool wipes = false;
};
}  // namespace limberg
