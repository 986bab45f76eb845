#include "sim/commands/flaps.h"

#include <array>
#include <cmath>

#include "sim/base/error.h"
#include "sim/commands/flap_exchange.h"
#include "sim/commands/plan_numbers.h"

namespace limberg {
namespace {

// Writes the commands of one operation; points come in local units.
class Writer {
 public:
  Writer(const FlapFrame& f, const FlapSettings& s)
      : f_(f), s_(s), inset_(s.inset_mm / f.side_mm), corner_(s.corner_mm / f.side_mm) {}
  std::vector<Command> commands;

  void excise(std::initializer_list<Vec2> outline) { commands.push_back(Excise{path(outline), s_.depth_mm}); }
  void incise(std::initializer_list<Vec2> line) { commands.push_back(Incise{path(line), s_.depth_mm, 90}); }
  void undermine_disc() {
    Undermine u{{}, s_.depth_mm};
    for (int i = 0; i < 24; ++i) u.outline.push_back(point(turned({s_.undermine_radius, 0}, 15 * i)));
    commands.push_back(std::move(u));
  }
  void hook(int id, const Vec2& at) { commands.push_back(SetHook{id, point(at)}); }
  void move(int id, const Vec2& to, double z_mm, double seconds) {
    const ChartPoint p = point(to);
    commands.push_back(MoveHook{id, {p.x(), p.y(), z_mm}, seconds});
  }
  void release(int id) { commands.push_back(ReleaseHook{id}); }
  void suture(const Vec2& a, const Vec2& b) { commands.push_back(Suture{point(a), point(b)}); }
  void wait(double seconds) { commands.push_back(Wait{seconds}); }
  void stage(const char* name, double settle_s) {
    wait(settle_s);
    commands.push_back(Stage{name});
  }

  /// One edge from p to q, held on the side where `tissue` lies.
  struct Edge {
    Vec2 p, q, tissue;
  };
  /// The point beside the edge at arc length t (local units) from p.
  Vec2 beside(const Edge& e, double t) const {
    const Vec2 d = (e.q - e.p).normalized();
    Vec2 n(-d.y(), d.x());
    if (n.dot(e.tissue - e.p) < 0) n = -n;
    return e.p + t * d + inset_ * n;
  }
  /// The point inside a corner, on its bisector; `outer` = the corner opens the other way (tissue all around it).
  Vec2 in_corner(const Vec2& tip, const Vec2& side1, const Vec2& side2, bool outer = false) const {
    const Vec2 b = ((side1 - tip).normalized() + (side2 - tip).normalized()).normalized();
    return tip + (outer ? -corner_ : corner_) * b;
  }
  double corner() const { return corner_; }
  double pitch() const { return s_.spacing_mm / f_.side_mm; }

  /// Stitches from `first` spacings after the beginnings of both edges to `last` spacings before their ends.
  void row(const Edge& a, const Edge& b, double first = 1, double last = 1) {
    const double from = first * pitch(), to = (a.q - a.p).norm() - last * pitch();
    if (to <= from) return;
    commands.push_back(
        SutureRow{path({beside(a, from), beside(a, to)}), path({beside(b, from), beside(b, to)}), s_.spacing_mm});
  }

 private:
  ChartPoint point(const Vec2& local) const {
    const ChartPoint p = f_.chart(local);
    return {rounded(p.x()), rounded(p.y())};
  }
  std::vector<ChartPoint> path(std::initializer_list<Vec2> local) const {
    std::vector<ChartPoint> p;
    for (const Vec2& v : local) p.push_back(point(v));
    return p;
  }
  const FlapFrame& f_;
  const FlapSettings& s_;
  double inset_, corner_;
};

}  // namespace

ChartPoint FlapFrame::chart(const Vec2& local) const {
  return origin + side_mm * turned(mirrored ? Vec2(local.x(), -local.y()) : local, turn_deg);
}

Vec2 ZPlasty::C() const { return A() + turned({0, -1}, -angle_deg); }
Vec2 ZPlasty::D() const { return B() + turned({0, 1}, -angle_deg); }

std::vector<Command> operation(const Rhomboid& plan, const FlapSettings& settings) {
  const auto& [frame, A, B, C, D, E, F] = plan;
  Writer w(frame, settings);
  const Vec2 flap = 0.25 * (C + D + E + F), out = Vec2(0.5, 1),
             beyond = Vec2(2, -0.5);                                               // tissue on either side of the cuts
  const auto over = [&](const Vec2& p) -> Vec2 { return C + turned(p - C, 60); };  // where the flap's p comes to

  w.excise({A, B, C, D});
  w.stage("defect", 1);
  w.incise({D, E, F});
  w.stage("flap cut", 1);
  w.undermine_disc();
  w.stage("undermined", 1);

  // The flap is held at both its free corners, 3 mm inside.
  const double grip = 3 / frame.side_mm;
  const Vec2 at_E = E + grip * (flap - E).normalized(), at_D = D + grip * (flap - D).normalized();
  w.hook(1, at_E);
  w.hook(2, at_D);
  w.move(1, 0.5 * (at_E + over(at_E)), settings.lift_mm, 1.5);
  w.move(2, 0.5 * (at_D + over(at_D)), 0.6 * settings.lift_mm, 1.5);
  w.stage("flap raised", 0.5);

  // The donor wound first: the stitch that carries the tension.
  const Writer::Edge donor_D{D, E, out}, donor_F{F, E, beyond};
  w.suture(w.beside(donor_D, w.corner()), w.beside(donor_F, w.corner()));
  w.stage("donor closed", 1.5);

  w.move(1, over(at_E), 2, 1.5);
  w.move(2, over(at_D), 2, 1.5);
  w.suture(w.in_corner(D, C, E), w.in_corner(B, A, C, true));
  w.suture(w.in_corner(E, D, F), w.in_corner(A, B, D, true));
  w.wait(1);
  w.release(1);
  w.release(2);
  w.stage("flap set", 1);

  const Vec2 left = Vec2(-2, 0.5), below = Vec2(-1.5, -1.5);
  w.row(donor_D, donor_F);
  w.row({D, E, flap}, {B, A, left});
  w.row({E, F, flap}, {A, D, out}, 1,
        0.4);                          // its last stitch keeps the flap's base from gaping beside the donor stitch
  w.row({C, D, flap}, {C, B, below});  // up to one spacing from the pivot, whose skin is whole
  w.stage("closed", 4);
  return w.commands;
}

std::vector<Command> operation(const ZPlasty& plan, const FlapSettings& settings) {
  if (!(plan.angle_deg >= 15 && plan.angle_deg <= 120))
    throw InputError("Z-plasty", 0, "the angle must lie between 15 and 120 degrees");
  Writer w(plan.frame, settings);
  const Vec2 A = plan.A(), B = plan.B(), C = plan.C(), D = plan.D();
  const Vec2 flap1 = (A + B + C) / 3, flap2 = (A + B + D) / 3;
  const Vec2 above = A + (A - B) + (C - A), under = B + (B - A) + (D - B);  // outer tissue beyond AC and beyond BD

  w.incise({C, A, B, D});
  w.stage("limbs cut", 1);
  w.undermine_disc();
  w.stage("undermined", 1);

  const Writer::Edge outer_BD{D, B, under}, outer_AC{C, A, above};
  const double hold = 3 / plan.frame.side_mm;
  const auto flap = [&](const Vec2& tip, const Vec2& middle, const Vec2& base, const Vec2& end) {
    return exchanged_flap(base, tip + hold * (middle - tip).normalized(), end, hold);
  };
  const std::array<ExchangedFlap, 2> flaps{flap(A, flap1, 0.5 * (B + C), D), flap(B, flap2, 0.5 * (A + D), C)};
  for (int id : {1, 2}) w.hook(id, flaps[size_t(id - 1)].grip);
  for (int id : {1, 2})
    for (const HookPlace& p : folded_back(flaps[size_t(id - 1)], plan.frame.side_mm))
      w.move(id, p.at, p.height_mm, 1.5);
  w.stage("flaps raised", 0.5);
  for (int id : {2, 1}) {
    w.move(id, flaps[size_t(id - 1)].to, kLaidFrom_mm, 1.5);
    w.move(id, flaps[size_t(id - 1)].to, kLaidAt_mm, 1.5);
    if (id == 1)
      w.suture(w.in_corner(A, B, C), w.beside(outer_BD, w.corner()));
    else
      w.suture(w.in_corner(B, A, D), w.beside(outer_AC, w.corner()));
    w.release(id);
    if (id == 2) w.stage("first flap set", 0.5);
  }
  w.stage("flaps set", 1);

  w.row({A, B, flap1}, outer_BD);
  w.row({B, A, flap2}, outer_AC);
  w.row({A, C, flap1}, {D, B, flap2});
  w.stage("closed", 4);
  return w.commands;
}

// The tension lines of the scene run along x: turned by -30 degrees, the donor's line DF runs across them.
Rhomboid shipped_rhomboid() {
  Rhomboid r;
  r.frame.turn_deg = -30;
  return r;
}

ZPlasty shipped_zplasty() { return {}; }

Script shipped_script(const std::string& name) {
  Script s;
  s.name = "recordings/" + name + ".jsonl";
  s.header.scene = name;
  std::vector<Command> commands;
  if (name == "rhomboid") {
    s.header.note = "Limberg's rhomboid flap, sides 20 mm, donor closure across the tension lines";
    commands = operation(shipped_rhomboid());
  } else if (name == "zplasty") {
    s.header.note = "Z-plasty, limbs 20 mm at 60 degrees, central limb along y";
    commands = operation(shipped_zplasty());
  } else {
    throw InputError(name, 0, "no such shipped script; expected rhomboid or zplasty");
  }
  for (size_t i = 0; i < commands.size(); ++i) s.lines.push_back({int(i) + 2, std::move(commands[i])});
  return s;
}

}  // namespace limberg
