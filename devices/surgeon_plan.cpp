#include "devices/surgeon_plan.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "devices/held_place.h"
#include "sim/base/elementary.h"
#include "sim/geometry/spline.h"

namespace limberg {

namespace {

constexpr double kPauseTurnDeg = 20;  // a sharper turn of a drawn path is a corner, where the hand rests

double turn_deg(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  const Vec2 u = b - a, v = c - b;
  return std::abs(elementary::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v))) * 180 / std::numbers::pi;
}

Aim on_skin(const ChartPoint& c) {
  Aim a;
  a.kind = Aim::skin;
  a.chart = c;
  return a;
}
Aim at_rest(const Vec3& X) {
  Aim a;
  a.kind = Aim::rest;
  a.rest_mm = X;
  return a;
}
Aim at_handle(int hook) {
  Aim a;
  a.kind = Aim::handle;
  a.hook = hook;
  return a;
}
Aim in_world(const Vec3& p) {
  Aim a;
  a.kind = Aim::world;
  a.world_mm = p;
  return a;
}

}  // namespace

const HookState* Sight::hook(int id) const {
  for (const HookState& h : seen->hooks)
    if (h.id == id) return &h;
  return nullptr;
}

void SurgeonPlan::begin(double rest_s) {
  hold(Aim{}, rest_s);
  mark(Step::next_command);
}

void SurgeonPlan::add(const std::vector<Command>& script, size_t index, const Sight& sight) {
  sight_ = &sight;
  next_ = index + 1 < script.size() ? &script[index + 1] : nullptr;
  number_ = index + 1;
  std::visit([this](const auto& c) { plan(c); }, script[index]);
  mark(Step::next_command);
  sight_ = nullptr;
  next_ = nullptr;
}

// ---- single steps ----

void SurgeonPlan::go(const Aim& aim, double seconds) {
  Step s;
  s.kind = Step::go;
  s.aim = aim;
  s.seconds = seconds;
  steps_.push_back(s);
}

void SurgeonPlan::hold(const Aim& aim, double seconds) {
  Step s;
  s.kind = Step::hold;
  s.aim = aim;
  s.seconds = seconds;
  steps_.push_back(s);
}

void SurgeonPlan::mark(Step::Kind kind) {
  Step s;
  s.kind = kind;
  steps_.push_back(s);
}

void SurgeonPlan::control(int32_t kind, Tool tool, std::array<double, 4> value, const std::string& text) {
  Step s;
  s.kind = Step::choose;
  s.control.kind = kind;
  s.control.tool = tool;
  s.control.value = value;
  s.control.text = ShortText(text);
  steps_.push_back(s);
}

// ---- movements ----

void SurgeonPlan::go_down(const Aim& target, double hover_mm) {
  Aim above = target;
  above.height_mm = hover_mm;
  go(above);
  go(target);
  hold(target, set_.corner_pause_s);
}

void SurgeonPlan::rise(const Aim& from) {
  Aim above = from;
  above.height_mm += set_.hover_mm;
  go(above);
  hold(above, set_.settle_s);
}

/// Press, draw the path with a rest at each corner, let go.
void SurgeonPlan::stroke(const std::vector<ChartPoint>& points, bool closed, double angle_deg, bool on_edge) {
  std::vector<ChartPoint> path;
  for (const ChartPoint& p : points)
    if (path.empty() || (p - path.back()).norm() > 1e-6) path.push_back(p);
  if (closed && (path.front() - path.back()).norm() > 1e-6) path.push_back(path.front());
  go_down(on_skin(path.front()), set_.hover_mm);
  mark(Step::press);
  hold(on_skin(path.front()), set_.corner_pause_s);
  for (size_t first = 0; first + 1 < path.size();) {
    size_t last = first + 1;
    while (last + 1 < path.size() && turn_deg(path[last - 1], path[last], path[last + 1]) < kPauseTurnDeg) ++last;
    Step s;
    s.kind = Step::draw;
    s.angle_deg = angle_deg, s.on_edge = on_edge;
    s.path.assign(path.begin() + long(first), path.begin() + long(last) + 1);
    s.length.push_back(0);
    for (size_t i = 1; i < s.path.size(); ++i) s.length.push_back(s.length.back() + (s.path[i] - s.path[i - 1]).norm());
    steps_.push_back(s);
    hold(on_skin(path[last]), set_.corner_pause_s);
    first = last;
  }
  mark(Step::let_go);
  rise(on_skin(path.back()));
}

void SurgeonPlan::stroke_in_space(const std::vector<Vec3>& places, const std::vector<Vec3>& shafts, bool closed,
                                  bool on_edge) {
  Step s;
  s.kind = Step::draw, s.on_edge = on_edge;
  for (size_t i = 0; i < places.size(); ++i) {
    if (!s.rest_path.empty() && (places[i] - s.rest_path.back()).norm() <= 1e-6) continue;
    s.length.push_back(s.rest_path.empty() ? 0 : s.length.back() + (places[i] - s.rest_path.back()).norm());
    s.rest_path.push_back(places[i]);
    if (!shafts.empty()) s.shaft.push_back(shafts[i].normalized());
  }
  if (const double gap = (s.rest_path.front() - s.rest_path.back()).norm(); closed && gap > 1e-6) {
    s.length.push_back(s.length.back() + gap);
    s.rest_path.push_back(s.rest_path.front());
    if (!s.shaft.empty()) s.shaft.push_back(s.shaft.front());
  }
  const Aim from = at_rest(s.rest_path.front()), to = at_rest(s.rest_path.back());
  const auto resting = [&](const Vec3& X, size_t i) {
    Step h;
    h.kind = Step::hold, h.aim = at_rest(X), h.seconds = set_.corner_pause_s;
    if (!s.shaft.empty()) h.shaft.push_back(s.shaft[i]);
    steps_.push_back(h);
  };
  go_down(from, set_.hover_mm);
  if (!s.shaft.empty()) resting(s.rest_path.front(), 0);  // the wrist has turned before the blade goes in
  mark(Step::press);
  resting(s.rest_path.front(), 0);
  for (size_t i = 1; i < s.rest_path.size(); ++i) {  // a rest at each post
    Step piece = s;
    piece.rest_path.assign(s.rest_path.begin() + long(i) - 1, s.rest_path.begin() + long(i) + 1);
    piece.length = {0, s.length[i] - s.length[i - 1]};
    if (!s.shaft.empty()) piece.shaft.assign(s.shaft.begin() + long(i) - 1, s.shaft.begin() + long(i) + 1);
    steps_.push_back(piece);
    resting(s.rest_path[i], i);
  }
  mark(Step::let_go);
  rise(to);
}

void SurgeonPlan::stroke_command(Tool tool, const std::vector<ChartPoint>& path, bool closed, double depth_mm,
                                 double angle_deg) {
  if (path.empty() || !reachable(path.front()) || !reachable(path.back())) return;
  control(ControlSample::select_tool, tool, {depth_mm, angle_deg, 0, 0});
  stroke(path, closed, angle_deg);
}

/// A hook stays in the hand when the very next thing is to move it (on).
void SurgeonPlan::let_go_unless_moved_next(const Aim& from) {
  if (next_)
    if (const auto* m = std::get_if<MoveHook>(next_); m && m->id == holding_) return;
  holding_ = 0;
  mark(Step::let_go);
  rise(from);
}

bool SurgeonPlan::reachable(const ChartPoint& c) {
  if (sight_->skin_at(c, Sight::kRimMm).triangle >= 0) return true;
  const std::string text = fmt::format("command {}: point ({:.2f}, {:.2f}) is not on skin", number_, c.x(), c.y());
  problems_.push_back(text);
  return false;
}

bool SurgeonPlan::reachable(const Vec3& X) {
  if (sight_->skin_at(X).triangle >= 0) return true;
  problems_.push_back(
      fmt::format("command {}: point ({:.2f}, {:.2f}, {:.2f}) is not on skin", number_, X.x(), X.y(), X.z()));
  return false;
}

// ---- commands ----

void SurgeonPlan::plan(const Incise& c) {
  stroke_command(Tool::scalpel, c.spline ? spline_through(c.path, 0.5) : c.path, false, c.depth_mm, c.angle_deg);
}
void SurgeonPlan::plan(const InciseMore& c) {
  problems_.push_back("a piece of stroke " + std::to_string(c.stroke) + " is no gesture; whole strokes were expected");
}
void SurgeonPlan::plan(const Undermine& c) { stroke_command(Tool::undermine, c.outline, true, c.depth_mm, 90); }
void SurgeonPlan::plan(const Excise& c) { stroke_command(Tool::excise, c.outline, true, c.depth_mm, 90); }

void SurgeonPlan::plan(const ExcisePiece& c) {
  if (!reachable(c.at)) return;
  control(ControlSample::select_tool, Tool::excise);
  tap(on_skin(c.at), set_.hover_mm);
}

void SurgeonPlan::plan(const CutThrough& c) {
  if (c.from_bed) {
    problems_.push_back("command " + std::to_string(number_) +
                        ": a cut right through from a bed is no gesture; one from the skin was expected");
    return;
  }
  for (const Vec3& X : c.path)
    if (!reachable(X)) return;
  control(ControlSample::select_tool, Tool::scalpel_through, {0, c.normals.empty() ? 90.0 : 0.0, 0, 0});
  stroke_in_space(c.path, c.normals, false);
}

void SurgeonPlan::plan(const SetHook& c) {
  if (reachable(c.at)) set_hook(c.id, on_skin(c.at));
}

void SurgeonPlan::set_hook(int id, const Aim& at) {
  control(ControlSample::select_tool, Tool::hook, {0, 0, 0, double(id)});
  go_down(at, set_.hover_mm);
  mark(Step::press);
  hold(Aim{}, set_.corner_pause_s);
  holding_ = id;
  let_go_unless_moved_next(at);
}

/// Press in one place.
void SurgeonPlan::tap(const Aim& at, double hover_mm) {
  go_down(at, hover_mm);
  mark(Step::press);
  hold(at, set_.corner_pause_s);
  mark(Step::let_go);
  rise(at);
}

void SurgeonPlan::plan(const MoveHook& c) {
  if (holding_ != c.id) {
    if (!sight_->hook(c.id)) {
      problems_.push_back("command " + std::to_string(number_) + ": there is no hook " + std::to_string(c.id));
      return;
    }
    control(ControlSample::select_tool, Tool::hook, {0, 0, 0, double(c.id)});
    go_down(at_handle(c.id), set_.hover_mm);
    mark(Step::press);
    hold(Aim{}, set_.corner_pause_s);
    holding_ = c.id;
  }
  go(in_world(c.to_mm), c.seconds);
  hold(in_world(c.to_mm), set_.corner_pause_s);
  let_go_unless_moved_next(in_world(c.to_mm));
}

void SurgeonPlan::plan(const ReleaseHook& c) {
  const HookState* hook = sight_->hook(c.id);
  if (!hook) {
    problems_.push_back("command " + std::to_string(number_) + ": there is no hook " + std::to_string(c.id));
    return;
  }
  control(ControlSample::select_tool, Tool::hook_out, {0, 0, 0, double(c.id)});
  go_down(at_handle(c.id), set_.hover_mm);
  mark(Step::press);
  hold(Aim{}, set_.corner_pause_s);
  mark(Step::let_go);
  hold(Aim{}, set_.settle_s);
}

void SurgeonPlan::plan(const Suture& c) {
  if (!reachable(c.a) || !reachable(c.b)) return;
  take_for(c);
  sew(on_skin(c.a), on_skin(c.b));
}

void SurgeonPlan::take_for(const Suture& c) {
  if (c.depth_mm > 0)
    control(ControlSample::select_tool, Tool::suture_buried, {c.depth_mm});
  else
    control(ControlSample::select_tool, Tool::suture);
}

/// The needle through one place and then another.
void SurgeonPlan::sew(const Aim& a, const Aim& b) {
  go_down(a, set_.hover_mm);
  mark(Step::press);
  hold(a, set_.corner_pause_s);
  go_down(b, 0.5 * set_.hover_mm);
  mark(Step::let_go);
  rise(b);
}

void SurgeonPlan::plan(const SutureRow& c) {
  if (c.a.empty() || c.b.empty()) return;
  for (const ChartPoint& p : {c.a.front(), c.a.back(), c.b.front(), c.b.back()})
    if (!reachable(p)) return;
  take_for(c);
  stroke(c.a, false, 90, true);
  stroke(c.b, false, 90, true);
}

void SurgeonPlan::take_for(const SutureRow& c) {
  if (c.depth_mm > 0 && !c.running)
    control(ControlSample::select_tool, Tool::suture_row_buried, {c.depth_mm, 0, c.spacing_mm, 0});
  else
    control(ControlSample::select_tool, c.running ? Tool::suture_running : Tool::suture_row, {0, 0, c.spacing_mm, 0});
}

void SurgeonPlan::plan(const SutureCorner& c) {
  if (reachable(c.a) && reachable(c.tip) && reachable(c.b))
    sew_corner(on_skin(c.a), on_skin(c.tip), on_skin(c.b), c.depth_mm);
}

void SurgeonPlan::sew_corner(const Aim& a, const Aim& tip, const Aim& b, double depth_mm) {
  control(ControlSample::select_tool, Tool::suture_corner, {depth_mm});
  sew(a, tip);
  tap(b, 0.5 * set_.hover_mm);
}

void SurgeonPlan::plan(const SutureBite& c) {
  if (!reachable(c.a) || !reachable(c.b)) return;
  if (c.depth_mm > 0 || c.side_a != HeldSide::skin || c.side_b != HeldSide::skin) {
    problems_.push_back("command " + std::to_string(number_) +
                        ": a bite in a wall is no gesture; a bite through the edges of the skin was expected");
    return;
  }
  control(ControlSample::select_tool, Tool::suture_bites);
  sew(on_skin(c.a), on_skin(c.b));
}

void SurgeonPlan::plan(const TieSuture&) {
  const SewnThread& t = sight_->seen->sewn;
  if (t.thread == 0) {
    problems_.push_back("command " + std::to_string(number_) + ": no thread is being sewn");
    return;
  }
  const Aim aim = in_world(t.end_mm.cast<double>());
  control(ControlSample::select_tool, Tool::suture_knot);
  tap(aim, set_.hover_mm);
}

/// The needle is laid down, and for a while nothing else is taken: a thread slips when the patient shows it in no hand.
void SurgeonPlan::plan(const LetThreadGo&) {
  control(ControlSample::select_tool, Tool::none);
  hold(Aim{}, set_.settle_s);
}

/// A stitch in cut faces, where these lie now.
void SurgeonPlan::deep_stitch(const Suture& c, const Vec3& a, const Vec3& b) {
  std::array<Vec3, 2> now;
  for (size_t k = 0; k < 2; ++k) {
    const Vec3& X = k == 0 ? a : b;
    const auto at = held_place(*sight_->seen, X, k == 0 ? c.side_a : c.side_b);
    if (!at)
      return problems_.push_back(
          fmt::format("command {}: no such face is at ({:.2f}, {:.2f}, {:.2f})", number_, X.x(), X.y(), X.z()));
    now[k] = *at;
  }
  control(ControlSample::select_tool, Tool::suture_deep);
  go(in_world(now[0] + set_.hover_mm * sight_->body().chart_normal()));
  go(in_world(now[0])), hold(in_world(now[0]), set_.corner_pause_s);
  mark(Step::press);
  hold(in_world(now[0]), set_.corner_pause_s);
  go(in_world(now[1])), hold(in_world(now[1]), set_.corner_pause_s);
  mark(Step::let_go);
  rise(in_world(now[1]));
}

/// Acts at places in space: what a hand does on the chart it does there as well.
void SurgeonPlan::plan(const InSpace& c) {
  const std::vector<Vec3> places = places_of(c);
  const auto no_gesture = [&](const char* why) {
    problems_.push_back(fmt::format("command {}: {} is no gesture", number_, why));
  };
  if (has_texture_places(c)) return no_gesture("a place by the texture");
  if (const auto* s = std::get_if<Suture>(&c.act); s && (s->side_a != HeldSide::skin || s->side_b != HeldSide::skin)) {
    if (s->depth_mm > 0) return no_gesture("a buried stitch in cut faces");
    return deep_stitch(*s, places[0], places[1]);
  }
  if (const auto* h = std::get_if<SetHook>(&c.act); h && h->side != HeldSide::skin)
    return no_gesture("a hook in a cut face");
  if (const auto* t = std::get_if<SutureBite>(&c.act);
      t && (t->depth_mm > 0 || t->side_a != HeldSide::skin || t->side_b != HeldSide::skin))
    return no_gesture("a bite in a wall");
  for (const Vec3& X : places)
    if (!reachable(X)) return;
  const auto choose = [&](Tool tool, std::array<double, 4> value = {}) {
    control(ControlSample::select_tool, tool, value);
  };
  std::visit(
      [&]<class A>(const A& a) {
        if constexpr (std::is_same_v<A, Incise>) {
          choose(Tool::scalpel, {a.depth_mm, a.angle_deg, 0, 0});
          stroke_in_space(places, {}, false);
        } else if constexpr (std::is_same_v<A, Undermine> || std::is_same_v<A, Excise>) {
          choose(std::is_same_v<A, Excise> ? Tool::excise : Tool::undermine, {a.depth_mm, 90, 0, 0});
          stroke_in_space(places, {}, true);
        } else if constexpr (std::is_same_v<A, ExcisePiece>) {
          choose(Tool::excise);
          tap(at_rest(places[0]), set_.hover_mm);
        } else if constexpr (std::is_same_v<A, SetHook>) {
          set_hook(a.id, at_rest(places[0]));
        } else if constexpr (std::is_same_v<A, Suture>) {
          take_for(a);
          sew(at_rest(places[0]), at_rest(places[1]));
        } else if constexpr (std::is_same_v<A, SutureBite>) {
          choose(Tool::suture_bites);
          sew(at_rest(places[0]), at_rest(places[1]));
        } else if constexpr (std::is_same_v<A, SutureCorner>) {
          sew_corner(at_rest(places[1]), at_rest(places[0]), at_rest(places[2]), a.depth_mm);
        } else if constexpr (std::is_same_v<A, SutureRow>) {
          take_for(a);
          const auto middle = places.begin() + long(a.a.size());
          stroke_in_space({places.begin(), middle}, {}, false, true);
          stroke_in_space({middle, places.end()}, {}, false, true);
        } else if constexpr (std::is_same_v<A, CutSuture>) {
          choose(Tool::scissors);
          tap(at_rest(places[0]), set_.hover_mm);
        } else if constexpr (std::is_same_v<A, Mark>) {
          choose(a.wipes ? Tool::swab : Tool::marker);
          stroke_in_space(places, {}, false);
        } else {
          no_gesture("a row between two stitches");
        }
      },
      c.act);
}

void SurgeonPlan::plan(const Mark& c) {
  if (c.path.empty() || !reachable(c.path.front()) || !reachable(c.path.back())) return;
  control(ControlSample::select_tool, c.wipes ? Tool::swab : Tool::marker);
  stroke(c.path, false, 90);
}

void SurgeonPlan::plan(const SutureBetween&) {
  problems_.push_back("command " + std::to_string(number_) +
                      ": a row between two stitches is no gesture; a row along two edges was expected");
}

void SurgeonPlan::plan(const CutSuture& c) {
  const SutureState* s = nullptr;
  for (const SutureState& k : sight_->seen->sutures)
    if (k.id == c.which.id) s = &k;
  if (c.which.id > 0 && !s) {
    problems_.push_back("command " + std::to_string(number_) + ": there is no stitch " + std::to_string(c.which.id));
    return;
  }
  if (!s && !reachable(c.which.at)) return;
  const Aim aim = s ? in_world(0.5 * (s->a_mm + s->b_mm).cast<double>()) : on_skin(c.which.at);
  control(ControlSample::select_tool, Tool::scissors);
  tap(aim, set_.hover_mm);
}

void SurgeonPlan::plan(const Undo&) {
  control(ControlSample::undo);
  hold(Aim{}, set_.settle_s);
}

void SurgeonPlan::plan(const Redo&) {
  control(ControlSample::redo);
  hold(Aim{}, set_.settle_s);
}

void SurgeonPlan::plan(const Stage& c) {
  control(ControlSample::stage, Tool::none, {double(++stages_), 0, 0, 0}, c.name);
  hold(Aim{}, set_.corner_pause_s);
}

void SurgeonPlan::plan(const Wait& c) { hold(Aim{}, c.seconds); }

void SurgeonPlan::plan(const HeadCommand&) {
  problems_.push_back("command " + std::to_string(number_) +
                      ": an act on bone is no gesture of the stylus on skin; a scene with a [head] was expected");
}

}  // namespace limberg
