#include "app/design/design_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "app/assembly/operation.h"
#include "app/result/metrics.h"
#include "sim/base/error.h"
#include "sim/commands/plan_numbers.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"

namespace limberg {
namespace {

constexpr double kForce_N = 2.45, kEar_mm = 4, kLandmark_mm = 2, kNear_mm = 2;

/// How a type is sized, and how many turns and mirror images of it differ.
struct Type {
  const char *name, *size;
  bool turns_half;  // the same after half a turn
  bool mirrors;
};
constexpr Type kTypes[] = {{"fusiform", "width_mm", true, false},    {"rhomboid", "side_mm", false, true},
                           {"dufourmentel", "side_mm", false, true}, {"webster", "side_mm", false, true},
                           {"bilobed", "diameter_mm", false, true},  {"o_to_z", "diameter_mm", true, true},
                           {"rotation", "radius_mm", false, true},   {"advancement", "width_mm", false, false},
                           {"v_y", "width_mm", false, false}};

Vec2 to_chart(const Vec2& figure, const PlannedProcedure& p) {
  return Vec2(p.at) + turned(p.mirrored ? Vec2(figure.x(), -figure.y()) : figure, p.turn_deg);
}

Vec2 centre_of(const std::vector<Vec2>& outline) {
  Vec2 sum = Vec2::Zero();
  double area = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const double c = a.x() * b.y() - a.y() * b.x();
    area += c, sum += c * (a + b) / 3;
  }
  return std::abs(area) > 1e-9 ? Vec2(sum / area) : outline[0];
}

bool holds(const std::vector<ChartPoint>& outline, const std::vector<ChartPoint>& defect) {
  return std::all_of(defect.begin(), defect.end(), [&](const ChartPoint& p) { return inside_polygon(outline, p); });
}

/// The procedure with its size set; the plan's place so that its first excision is centred on the defect.
bool place_figure(Design& d, const Type& type, double size, const Vec2& centre) {
  const Procedure& p = find_procedure(type.name);
  std::vector<double> v = p.defaults();
  d.plan.values.clear();
  for (size_t i = 0; i < v.size(); ++i) {
    const ProcedureParameter& q = p.parameters[i];
    const double scale = size / [&] {
      for (const auto& o : p.parameters)
        if (o.name == type.size) return o.value;
      return 1.0;
    }();
    // Other lengths keep their proportion to the size.
    double value = q.name == type.size ? size : q.name.ends_with("_mm") ? q.value * scale : q.value;
    value = std::clamp(value, q.lo, q.hi);
    v[i] = value;
    if (value != q.value) d.plan.values.emplace_back(q.name, value);
  }
  try {
    d.figure = p.figure(v);
  } catch (const InputError&) {
    return false;
  }
  if (d.figure.excisions.empty()) return false;
  d.plan.at = {0, 0};
  d.plan.at = centre - to_chart(centre_of(d.figure.excisions[0]), d.plan);
  return true;
}

void set_cost(Design& d, const Metrics& m, const DesignTask& task) {
  d.force_N = m.suture_force_max_N, d.closure_N = m.closure_force_N, d.dog_ear_mm = m.dog_ear_mm,
  d.landmark_mm = m.landmark_max_mm;
  d.waste_mm2 = m.excised_mm2, d.scar_mm = m.scar_length_mm;
  d.force_cost = task.weight_force * d.force_N / kForce_N, d.ear_cost = task.weight_ear * d.dog_ear_mm / kEar_mm;
  d.landmark_cost = task.weight_landmark * d.landmark_mm / kLandmark_mm;
  d.cost = d.force_cost + d.ear_cost + d.landmark_cost;
  if (!d.fine) d.first_cost = d.cost;
}

}  // namespace

std::string Design::name() const {
  std::string s = plan.procedure;
  std::string t;
  for (const auto& [key, value] : plan.values) {
    t = fmt::format(" {}={:.3g}", key, value);
    s += t;
  }
  t = fmt::format(" turned {:g}{}", plan.turn_deg, plan.mirrored ? " mirrored" : "");
  return s + t;
}

std::string why_first(const Design& a, const Design* b) {
  std::string t = fmt::format(
      "its strongest stitch pulls with {:.2f} N (cost {:.2f}), the skin stands up by {:.1f} mm ({:.2f}), landmarks "
      "move by {:.1f} mm ({:.2f})",
      a.force_N, a.force_cost, a.dog_ear_mm, a.ear_cost, a.landmark_mm, a.landmark_cost);
  std::string why = t;
  if (!b || b->fine != a.fine) return why;
  const std::pair<double, const char*> parts[] = {{b->force_cost - a.force_cost, "its force"},
                                                  {b->ear_cost - a.ear_cost, "its dog-ear"},
                                                  {b->landmark_cost - a.landmark_cost, "what it does to landmarks"}};
  const auto most = std::max_element(std::begin(parts), std::end(parts),
                                     [](const auto& x, const auto& y) { return x.first < y.first; });
  t = fmt::format("; the next costs {:.2f} more, most of it by {} ({:+.2f})", b->cost - a.cost, most->second,
                  most->first);
  return why + t;
}

std::vector<std::pair<std::string, int>> dropped_by_reason(std::span<const Design> all) {
  std::vector<std::pair<std::string, int>> out;
  for (const Design& d : all) {
    if (d.dropped.empty()) continue;
    const auto it = std::find_if(out.begin(), out.end(), [&](const auto& o) { return o.first == d.dropped; });
    if (it == out.end())
      out.emplace_back(d.dropped, 1);
    else
      ++it->second;
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  return out;
}

std::vector<ChartPoint> parse_defect(const std::string& text) {
  std::vector<double> n;
  const bool circle = text.starts_with("circle:");
  const std::string numbers = circle ? text.substr(7) : text;
  for (const char *p = numbers.data(), *end = p + numbers.size(); p < end;) {
    double v = 0;
    const auto r = std::from_chars(p, end, v);
    const char wanted = circle || n.size() % 2 == 0 ? ',' : ';';
    if (r.ec != std::errc() || !std::isfinite(v) || std::abs(v) > 1000 || (r.ptr != end && *r.ptr != wanted))
      throw InputError("--defect", 0,
                       text.substr(0, 60) + " is no outline; expected circle:X,Y,DIAMETER or X,Y;X,Y;X,Y;... in mm");
    n.push_back(v);
    p = r.ptr == end ? end : r.ptr + 1;
  }
  std::vector<ChartPoint> out;
  if (circle) {
    if (n.size() != 3 || !(n[2] >= 2 && n[2] <= 100))
      throw InputError("--defect", 0, text.substr(0, 60) + "; expected circle:X,Y,DIAMETER with 2 to 100 mm");
    for (int i = 0; i < 48; ++i) out.push_back(Vec2(n[0], n[1]) + 0.5 * n[2] * direction(7.5 * i));
  } else {
    if (n.size() < 6 || n.size() % 2)
      throw InputError("--defect", 0, text.substr(0, 60) + " has fewer than three points; expected X,Y;X,Y;X,Y;...");
    for (size_t i = 0; i < n.size(); i += 2) out.emplace_back(n[i], n[i + 1]);
    if (std::abs([&] {
          double a = 0;
          for (size_t i = 0; i < out.size(); ++i)
            a += out[i].x() * out[(i + 1) % out.size()].y() - out[i].y() * out[(i + 1) % out.size()].x();
          return 0.5 * a;
        }()) < 1)
      throw InputError("--defect", 0, "the outline encloses less than 1 mm2; expected the outline of a defect");
  }
  return out;
}

const std::vector<std::string>& covering_types() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> n;
    for (const Type& t : kTypes) n.emplace_back(t.name);
    return n;
  }();
  return names;
}

std::vector<Design> candidates(const Scene& scene, const Skin& skin, const DesignTask& task) {
  (void)scene;
  for (const std::string& t : task.types)
    if (std::find(covering_types().begin(), covering_types().end(), t) == covering_types().end()) {
      std::string list;
      for (const std::string& n : covering_types()) list += (list.empty() ? "" : ", ") + n;
      throw InputError(t, 0, "covers no defect; expected one of: " + list);
    }
  const Vec2 centre = centre_of(task.defect);
  std::vector<Design> out;
  for (const Type& type : kTypes) {
    if (!task.types.empty() && std::find(task.types.begin(), task.types.end(), type.name) == task.types.end()) continue;
    double lo = 0, hi = 0;
    for (const ProcedureParameter& q : find_procedure(type.name).parameters)
      if (q.name == type.size) lo = q.lo, hi = q.hi;
    for (double turn = 0; turn < (type.turns_half ? 180 : 360) - 1e-9; turn += task.turn_step_deg)
      for (int mirrored = 0; mirrored <= int(type.mirrors); ++mirrored) {
        Design d;
        d.plan.procedure = type.name, d.plan.turn_deg = turn, d.plan.mirrored = mirrored != 0;
        const auto covers = [&](double size) {
          if (!place_figure(d, type, size, centre)) return false;
          std::vector<ChartPoint> outline;
          for (const Vec2& p : d.figure.excisions[0]) outline.push_back(to_chart(p, d.plan));
          return holds(outline, task.defect);
        };
        if (!covers(hi)) {
          d.dropped = "too small for the defect at its largest";
          out.push_back(std::move(d));
          continue;
        }
        double small = lo, large = hi;
        for (int i = 0; i < 30 && !covers(lo); ++i) {
          const double mid = 0.5 * (small + large);
          (covers(mid) ? large : small) = mid;
        }
        const double size = covers(lo) ? lo : std::min(hi, std::ceil(20 * large) / 20);  // to 0.05 mm
        covers(size);
        try {
          const OnSkin where(skin, {d.plan.at, d.plan.turn_deg, d.plan.mirrored});
          d.commands = carry_out(d.figure, where, task.plan);
          for (const Landmark& l : task.spare) {
            for (const auto& e : d.figure.excisions) {
              std::vector<ChartPoint> outline;
              for (const Vec2& p : e) outline.push_back(where.chart(p));
              if (inside_polygon(outline, l.at)) d.dropped = "takes " + l.name + " away";
            }
            for (const auto& w : d.figure.wounds)
              for (size_t i = 0; i < w.size() && d.dropped.empty(); ++i)
                if (distance_to_segment(l.at, where.chart(w[i]), where.chart(w[(i + 1) % w.size()])) < kNear_mm)
                  d.dropped = "passes within 2 mm of " + l.name;
          }
        } catch (const InputError& e) {
          d.dropped = e.what();
        }
        out.push_back(std::move(d));
      }
  }
  return out;
}

void carry_out(Design& d, const Scene& scene, const std::shared_ptr<const Body>& body, const DesignTask& task,
               double cell_mm, bool fine, Workers& workers, const std::function<bool()>& interrupted) {
  WorldSpec spec = world_spec(scene, body);
  spec.cell_mm = cell_mm;
  if (!fine) spec.contact = ContactChoice::off, spec.refine_fronts = false;
  World world(spec, workers);
  Script script;
  script.name = d.name();
  std::vector<Command> commands = d.commands;
  if (!fine && task.plan.spacing_mm < cell_mm) {
    // Stitches that stand nearer than cells are large pull against each other where edges bend (study/fusiform.cpp),
    // and what bends would seem dearer than what is straight.
    OperationPlan wider = task.plan;
    wider.spacing_mm = cell_mm;
    const Skin skin(body);
    commands = carry_out(d.figure, OnSkin(skin, {d.plan.at, d.plan.turn_deg, d.plan.mirrored}), wider);
  }
  for (const Command& c : commands) script.lines.push_back({int(script.lines.size()) + 1, c});
  OperationSettings set;
  set.interrupted = interrupted;
  set.rest_residual = 1e-4, set.rest_steps = 40, set.hook_step_mm = 3;
  // A path is followed as roughly as its end allows: the end is what is judged, to the third digit of a force at 1e-4.
  if (!fine)
    set.rest_residual = 1e-3, set.rest_steps = 10, set.final_residual = 1e-4, set.final_steps = 100,
    set.hook_step_mm = 5;
  try {
    const OperationOutcome o = operate(world, scene.tools.max_depth_mm, script, set);
    d.residual = o.last.residual, d.cell_mm = cell_mm, d.fine = fine;
    if (o.interrupted) d.dropped = "interrupted";
  } catch (const InputError& e) {
    d.dropped = e.what();
    return;
  }
  MeasureAlso also;
  also.landmarks = task.spare;
  set_cost(d, measure_world(world, commands, also), task);
}

void rank(std::vector<Design>& designs) {
  std::stable_sort(designs.begin(), designs.end(), [](const Design& a, const Design& b) {
    if (a.dropped.empty() != b.dropped.empty()) return a.dropped.empty();
    if (!a.dropped.empty()) return a.name() < b.name();
    return a.fine != b.fine ? a.fine : a.cost < b.cost;
  });
}

std::vector<Design> search_designs(const Scene& scene, const DesignTask& task, Workers& workers,
                                   const std::function<bool()>& interrupted,
                                   const std::function<void(const SearchProgress&)>& progress) {
  const std::shared_ptr<const Body> body = build_body(scene);
  const Skin skin(body);
  for (const ChartPoint& p : task.defect)
    if (!skin.at(p))
      throw InputError("--defect", 0, "its outline leaves the skin; expected a defect on the skin of " + scene.name);
  std::vector<Design> all = candidates(scene, skin, task);
  const int refine = std::max(0, task.refine);
  int coarse = 0, done = 0;
  for (const Design& d : all) coarse += d.dropped.empty();
  const int best = std::min(refine, coarse);
  // In coarse designs: work goes with the number of cells to 4/3,
  // contact makes it five times as much (measured, 2026-11-21).
  const double fine = task.fine_mm > 0 ? task.fine_mm : scene.cell_mm, weight = 5 * std::pow(task.coarse_mm / fine, 4);
  double work = 0;
  const auto tell = [&](bool refining) {
    if (progress) progress({done, coarse + best, refining, work / (coarse + best * weight)});
    ++done, work += refining ? weight : 1;
  };
  for (Design& d : all) {
    if (!d.dropped.empty()) continue;
    if (interrupted && interrupted()) {
      d.dropped = "not tried: interrupted";
      continue;
    }
    tell(false);
    carry_out(d, scene, body, task, task.coarse_mm, false, workers, interrupted);
  }
  rank(all);
  int refined = 0;
  for (Design& d : all) {
    if (refined == refine || !d.dropped.empty() || (interrupted && interrupted())) break;
    tell(true);
    const Design first_pass = d;
    carry_out(d, scene, body, task, fine, true, workers, interrupted);
    if (interrupted && interrupted() && !d.dropped.empty()) d = first_pass;
    ++refined;
  }
  rank(all);
  return all;
}

}  // namespace limberg
