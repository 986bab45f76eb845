// The same script on other meshes, lattices and skins: does it cut and stitch where it was meant to?
//
// Every procedure of the repertoire is laid on a finely meshed skin once and written down as a script, in chart
// points. That script is carried out (cuts and stitches; nothing is moved) on the same skin with another mesh and
// another lattice. What was meant is known without any mesh: on a plane, a cylinder and a sphere the figure's points
// lie where walking straight ahead from its origin leads in closed form. Measured are the distances, at rest,
//   from every corner and every millimetre of the drawn lines to the nearest edge between skin and cut wall,
//   from every stitch's two ends, which sit on the edges of the cut, to the lines that were meant.
// On the face (a surface in the folder that LIMBERG_DATA names)
// the walk on its own triangles stands for the closed form.
#include "app/study/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <sstream>

#include "app/result/output.h"
#include "app/words/words.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/body/block.h"
#include "sim/body/obj.h"
#include "sim/body/skin.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/operation.h"
#include "sim/patient/world.h"

namespace limberg::study {

namespace {

enum Form { kPlane, kCylinder, kSphere, kFace };
constexpr double kRadius_mm = 60, kReference_mm = 0.8, kTurn_deg = 17, kDepth_mm = 4;
constexpr const char* kFaceFile = "/face/wholeFace_NasalCartilage.obj";

/// A point of the flat block bent onto the form: lengths through the origin are kept, x around the cylinder.
Vec3 bent(Form form, const Vec3& p) {
  constexpr double R = kRadius_mm;
  if (form == kCylinder) return {(R + p.z()) * std::sin(p.x() / R), p.y(), (R + p.z()) * std::cos(p.x() / R) - R};
  if (form == kSphere) {
    const double r = p.head<2>().norm(), a = r / R, s = r > 1e-12 ? (R + p.z()) * std::sin(a) / r : 1 + p.z() / R;
    return {s * p.x(), s * p.y(), (R + p.z()) * std::cos(a) - R};
  }
  return p;
}

std::string data_folder() {
  const char* d = std::getenv("LIMBERG_DATA");
  if (!d || !*d)
    throw InputError(
        "", 0, "study place: the face needs its surface; expected LIMBERG_DATA to name the folder that holds face/");
  return d;
}

std::shared_ptr<const Body> body_of(Form form, double skin_mm) {
  ObjSpec o;
  o.layers = {{"skin", 1.5, {}}, {"fat", 100, {}}};
  o.layers[1].material.young_kPa = 15;
  if (form == kFace) {
    o.path = data_folder() + kFaceFile;
    o.scale_to_mm = 10, o.deep_center_mm = Vec3(0, -40, -40), o.deep_angle_deg = 80;
    return std::make_shared<Body>(load_obj(o));
  }
  BlockSpec b;
  b.size_mm = {100, 100, 10}, b.skin_cell_mm = skin_mm;
  b.layers = o.layers;
  const Body block = make_block(b);
  if (form == kPlane) return std::make_shared<Body>(block);
  std::ostringstream text;
  text.precision(12);
  for (const Vec3& p : block.surface.X_mm) {
    const Vec3 x = bent(form, p);
    text << "v " << x.x() << " " << x.y() << " " << x.z() << "\n";
  }
  for (const Tri& t : block.surface.tri) text << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  o.path = form == kCylinder ? "cylinder" : "sphere";
  o.deep_angle_deg = 95;
  return std::make_shared<Body>(parse_obj(text.str(), o));
}

/// Figures whose defaults are larger than the form is wide are drawn smaller.
constexpr double kReach_mm = 36;
Figure fitted(Figure f, double reach) {
  double far = 0;
  for (const auto& w : f.wounds)
    for (const Vec2& p : w) far = std::max(far, p.norm());
  if (far <= reach) return f;
  for (auto* lists : {&f.excisions, &f.incisions, &f.wounds})
    for (auto& list : *lists)
      for (Vec2& p : list) p *= reach / far;
  return f;
}

class PlaceRim {
 public:
  explicit PlaceRim(const SurfaceView& v) {
    for (size_t t = 0; t < v.tri.size(); ++t)
      if (v.kind[t] == FaceKind::skin)
        for (size_t k = 0; k < 3; ++k)
          if (v.rim[t] >> k & 1) edge_.push_back({v.X_mm[size_t(v.tri[t][k])], v.X_mm[size_t(v.tri[t][(k + 1) % 3])]});
  }
  double distance_mm(const Vec3& p) const {
    double best = 1e300;
    for (const auto& [a, b] : edge_) {
      const Vec3 e = b - a;
      const double l = e.squaredNorm(), t = l > 0 ? std::clamp((p - a).dot(e) / l, 0.0, 1.0) : 0;
      best = std::min(best, (a + t * e - p).norm());
    }
    return best;
  }

 private:
  std::vector<std::pair<Vec3, Vec3>> edge_;
};

Row run_place(const Values& v, const Run& with) {
  const Form form = Form(int(v[0]));
  const auto reference = form == kFace ? body_of(form, 0) : body_of(form, kReference_mm);
  const Skin fine(reference);
  const Placement where{form == kFace ? ChartPoint(v[3], v[4]) : ChartPoint(0, 0), kTurn_deg, false};
  const OnSkin on(fine, where);
  const auto meant = [&](const Vec2& p) -> Vec3 {
    if (form == kFace) return on.spot(p).X_mm;
    const double c = std::cos(kTurn_deg * std::numbers::pi / 180), s = std::sin(kTurn_deg * std::numbers::pi / 180);
    return bent(form, {c * p.x() - s * p.y(), s * p.x() + c * p.y(), 0});
  };
  WorldSpec spec;
  spec.body = form == kFace ? reference : body_of(form, v[1]);
  spec.cell_mm = v[2];
  World world(spec, with.workers);

  Row r;
  r.figures = {{"form", v[0]}, {"skin_mm", v[1]}, {"cell_mm", v[2]}, {"at_x_mm", v[3]}, {"at_y_mm", v[4]}};
  double corner = 0, line = 0, stitch = 0, refused = 0;
  std::vector<std::pair<std::string, double>> each;
  for (const Procedure& p : procedures()) {
    if (with.interrupted && with.interrupted()) break;
    const Figure f = fitted(p.figure(p.defaults()), form == kFace ? 16 : kReach_mm);
    OperationPlan plan;
    plan.depth_mm = kDepth_mm, plan.undermine_margin_mm = 0;
    int acts = 0;
    const std::vector<Command> commands = carry_out(f, on, plan);
    for (const Command& c : commands) {
      const bool cut = std::holds_alternative<Incise>(c) || std::holds_alternative<Excise>(c);
      if (!cut && !std::holds_alternative<Suture>(c) && !std::holds_alternative<SutureRow>(c)) continue;
      const Outcome o = world.apply(c);
      refused += !o.done;
      acts += o.done;
    }
    Snapshot shown;
    world.fill(shown);
    const PlaceRim rim(shown.topology->view);
    double own = 0;
    std::vector<Vec3> lines;  // a place every 0.1 mm
    for (const auto* lists : {&f.excisions, &f.incisions})
      for (const auto& drawn : *lists) {
        const bool closed = lists == &f.excisions;
        for (size_t i = 0; i + (closed ? 0 : 1) < drawn.size(); ++i) {
          const Vec2 a = drawn[i], b = drawn[(i + 1) % drawn.size()];
          own = std::max(own, rim.distance_mm(meant(a)));
          const int n = int((b - a).norm());
          for (int k = 1; k <= n; ++k) line = std::max(line, rim.distance_mm(meant(a + (b - a) * (k / (n + 1.0)))));
          const int m = 10 * (n + 1);
          for (int k = 0; k <= m; ++k) lines.push_back(meant(a + (b - a) * (double(k) / m)));
        }
        own = std::max(own, rim.distance_mm(meant(drawn.back())));
      }
    corner = std::max(corner, own);
    each.push_back({p.name + "_mm", own});
    // Nothing has moved: a stitch's ends are at rest. They sit on the edges that they were set beside.
    for (const SutureState& u : shown.sutures)
      for (const Vec3f& end : {u.a_mm, u.b_mm}) {
        double best = 1e300;
        for (const Vec3& x : lines) best = std::min(best, (end.cast<double>() - x).norm());
        stitch = std::max(stitch, best);
      }
    for (; acts > 0; --acts) world.apply(Undo{});
  }
  r.figures.insert(r.figures.end(), {{"corner_mm", corner},
                                     {"line_mm", line},
                                     {"stitch_mm", stitch},
                                     {"refused", refused},
                                     {"procedures", double(each.size())}});
  r.figures.insert(r.figures.end(), each.begin(), each.end());
  return r;
}

std::vector<Bar> place_bars(const std::vector<Row>& rows) {
  double corner = 0, line = 0, stitch = 0, refused = 0;
  for (const Row& r : rows)
    corner = std::max(corner, r.at("corner_mm")), line = std::max(line, r.at("line_mm")),
    stitch = std::max(stitch, r.at("stitch_mm")), refused += r.at("refused");
  const char* source = "the repertoire's own: within 0.5 mm on any skin";
  return {at_most("farthest corner from where it was meant, mm", corner, 0.5, source),
          at_most("farthest place of a drawn line, mm", line, 0.5, source),
          at_most("farthest end of a stitch, mm", stitch, 0.5, source),
          at_most("acts refused", refused, 0, "the same script can be carried out everywhere")};
}

std::vector<NamedChart> place_charts(const std::vector<Row>& rows) {
  NamedChart c;
  c.name = "place", c.title = english("Farthest corner from where it was meant");
  c.chart.description = c.title + ", one line for each skin and mesh";
  c.chart.x.title = english("cells, mm"), c.chart.y.title = english("mm");
  c.chart.y_marks = {{0.5, "bar"}};
  for (const Row& r : rows) {
    constexpr const char* kNames[] = {"plane", "cylinder", "sphere", "face"};
    const std::string name = fmt::format("{}, {:g} mm", kNames[int(r.at("form"))], r.at("skin_mm"));
    auto& all = c.chart.series;
    auto it = std::find_if(all.begin(), all.end(), [&](const ChartSeries& s) { return s.name == name; });
    if (it == all.end()) it = all.insert(it, ChartSeries{name, {}, {}, true});
    it->x.push_back(r.at("cell_mm")), it->y.push_back(r.at("corner_mm"));
  }
  return {c};
}

uint64_t inputs(const Values& v) {
  if (int(v[0]) != kFace) return 0;
  const std::string bytes = read_whole_file(data_folder() + kFaceFile);
  Hash64 h;
  h.bytes(bytes.data(), bytes.size());
  return h.value();
}

}  // namespace

Family place_scripts() {
  return {
      "place",
      english("The same scripts on other meshes, lattices and skins: how far from where they were meant they cut and "
              "stitch"),
      {{"form",
        "0 plane, 1 cylinder and 2 sphere of 60 mm radius, 3 the face in the folder that LIMBERG_DATA names",
        {0, 1, 2},
        0,
        3},
       {"skin_mm", "size of the skin's triangles (the script was laid on 0.8 mm); not of the face's", {1, 1.7}, 0.6, 3},
       {"cell_mm", "size of the lattice's cells", {5, 4, 3.5}, 2.5, 8},
       {"at_x_mm", "where on the face, in its chart", {40}, -60, 60},
       {"at_y_mm", "where on the face, in its chart", {-50}, -120, 60}},
      run_place,
      place_bars,
      place_charts,
      {},
      inputs};
}

}  // namespace limberg::study
