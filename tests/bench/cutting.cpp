#include "tests/bench/cutting.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "app/operating_point/cpu_clock.h"
#include "sim/base/text.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "tests/bench/cgal_child.h"
#include "tests/bench/cutting_parts.h"
#include "tests/bench/cutting_scene.h"
#include "tests/bench/fronts.h"

namespace limberg::bench {
namespace {

struct CuttingSize {
  const char* name;
  int cells, repeats;
  bool exact;         // CGAL with exact points too
  double times_cgal;  // the bar; 0: none
};
constexpr CuttingSize full_sizes[] = {{"26 k", 112, 15, true, 0},
                                      {"103 k", 224, 15, true, 50},
                                      {"407 k", 448, 9, true, 150},
                                      {"1.6 M", 896, 7, false, 0}};
constexpr CuttingSize quick_sizes[] = {{"2 k", 28, 3, true, 0}, {"7 k", 56, 3, true, 0}};

size_t heap_bytes() {
  const struct mallinfo2 m = mallinfo2();
  return m.uordblks + m.hblkhd;
}

/// Returns the median time of ours.
double arrangement(Result& out, const CuttingSettings& settings, const CuttingSize& size, CgalChild& cgal) {
  const std::string label = std::string("arrangement, ") + size.name;
  say(settings, label);
  const Body body = wavy_slab(size.cells);
  const Blade blade = curved_blade(body, {});
  const size_t heap = heap_bytes();
  const double start = cpu_ms();
  Arrangement a(body.surface, body.grid);
  Times built;
  built.add(cpu_ms() - start);
  const size_t bytes = heap_bytes() - heap, triangles = body.surface.tri.size();
  std::vector<Int3> x;
  for (const Vec3& p : body.surface.X_mm) x.push_back(body.grid.to_grid(p));
  cgal.set_input(x, body.surface.tri, blade);

  Times ours, undo, epick, epeck;
  CutResult made;
  int32_t points = 0;
  std::string version;
  const int turns = std::min(size.repeats, 3);
  for (int turn = 0; turn < turns; ++turn) {
    for (int i = 0; i < size.repeats / turns; ++i) {
      const int32_t before = a.point_count() + int32_t(blade.vertex.size());
      made = cut(a, blade, 1, ours);
      points = a.point_count() - before;
      const double t = cpu_ms();
      a.undo();
      undo.add(cpu_ms() - t);
    }
    for (bool exact : {false, true}) {
      if (exact && !size.exact) continue;
      say(settings, label + (exact ? ": CGAL, exact points" : ": CGAL"));
      const auto answer = cgal.corefine(exact);
      if (!answer) continue;
      (exact ? epeck : epick).add(answer->ms);
      version = answer->version;
      if (answer->new_vertices != points)  // both know the same intersection
        throw std::runtime_error(
            text("bench cutting: CGAL finds %ld intersection points, ours %d", answer->new_vertices, points));
    }
  }
  const std::string count = text("%zu triangles", triangles);
  add_row(out, label, "ours",
          count + text(", %d intersection points, %d wall faces", points, made.wall_faces) +
              (made.tries > 1 ? text(", %d tries", made.tries) : ""),
          ours);
  add_row(out, label, "ours: undo", count, undo);
  add_row(out, label, "ours: made once (tree, gluing)", count, built);
  if (!epick.empty()) add_row(out, label, "CGAL " + version + " corefine, EPICK", count, epick);
  if (!epeck.empty()) add_row(out, label, "CGAL " + version + " corefine, EPECK", count, epeck);
  Row memory;
  memory.name = label;
  memory.method = "ours: memory";
  memory.settings = count;
  memory.error = double(bytes) / double(triangles);
  memory.error_unit = "B/triangle";
  out.rows.push_back(memory);
  if (!epick.empty()) {
    const double ratio = epick.median() / ours.median();
    if (size.times_cgal > 0)
      add_bar(out, label + ": times faster than CGAL corefine, EPICK", ratio, size.times_cgal, true, kTargets);
    else
      out.rows.back().settings += text("; %.0f times faster than CGAL corefine, EPICK", ratio);
  }
  return ours.median();
}

void history(Result& out, const CuttingSettings& settings, int cells, int cuts) {
  say(settings, "history");
  const Body body = wavy_slab(cells);
  Arrangement a(body.surface, body.grid);
  BladePlace small;
  small.length_mm = 20, small.columns = 14, small.bend_mm = 1;
  const Blade probe = curved_blade(body, small);
  Times first, last, early, late;
  const auto try_probe = [&](Times& t) {
    for (int i = 0; i < 9; ++i) cut(a, probe, 5, t), a.undo();
  };
  try_probe(first);
  // The others lie wherever they fall, over and across each other, but leave the probe's own place free.
  uint64_t state = 0x9e3779b97f4a7c15ull;
  const auto random = [&state](double from, double to) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return from + (to - from) * double(state >> 11) * 0x1p-53;
  };
  for (int done = 0; done < cuts - 1;) {
    BladePlace p = small;
    p.middle = Vec2(random(-85, 85), random(-85, 85));
    p.angle_deg = random(0, 180);
    if (p.middle.norm() < 24) continue;
    Times t;
    const double start = cpu_ms();
    const CutResult r = a.cut(curved_blade(body, p), uint64_t(done));
    t.add(cpu_ms() - start);
    if (!r.ok()) continue;  // it ran along an older one
    if (done < 20) early.add(t.ms[0]);
    if (done >= cuts - 21) late.add(t.ms[0]);
    ++done;
  }
  try_probe(last);
  const std::string count = text("%zu triangles, 20 mm", body.surface.tri.size());
  add_row(out, "history", "the same cut, first", count, first);
  add_row(out, "history", text("the same cut, number %d", cuts), count, last);
  add_row(out, "history", "first 20 cuts", count, early);
  add_row(out, "history", "last 20 cuts, many across older ones", count, late);
  if (settings.quick) return;
  add_bar(out, text("history: cut %d over cut 1", cuts), last.median() / first.median(), 1.5, false, kTargets);
  add_bar(out, "history: last 20 cuts over first 20", late.median() / early.median(), 1.5, false, kTargets);
}

}  // namespace

Result cutting(const CuttingSettings& settings) {
  Result out;
  const auto wanted = [&](const char* part) { return std::string(part).find(settings.only) != std::string::npos; };
  if (wanted("arrangement")) {
    CgalChild cgal(settings.cgal_program.empty() ? cgal_program() : settings.cgal_program);
    double at_103k = 0, at_1600k = 0;
    const auto sizes =
        settings.quick ? std::span<const CuttingSize>(quick_sizes) : std::span<const CuttingSize>(full_sizes);
    for (const CuttingSize& size : sizes) {
      const double ms = arrangement(out, settings, size, cgal);
      if (size.cells == 224) at_103k = ms;
      if (size.cells == 896) at_1600k = ms;
    }
    if (at_103k > 0 && at_1600k > 0)
      add_bar(out, "growth: 1.6 M over 103 k triangles", at_1600k / at_103k, 4.5, false, kTargets);
    out.notes.push_back(
        "Ours keeps a tree over the body's triangles (row 'made once'); CGAL makes its own in every call.");
    out.notes.push_back(
        "Ours also glues the banks, keeps what undo needs and checks volume and closure; CGAL adds the curve to both "
        "meshes.");
    if (!cgal.available()) out.notes.push_back("No comparison with CGAL: " + cgal.why() + ".");
  }
  if (wanted("history")) history(out, settings, settings.quick ? 56 : 224, settings.quick ? 30 : 200);
  if (wanted("crossing")) crossing_cuts(out, settings, settings.quick ? 56 : 224, settings.quick ? 3 : 11);
  if (wanted("whole cut"))
    whole_cut(out, settings, settings.quick ? 56 : 224, settings.quick ? 6 : 3, settings.quick ? 2 : 9);
  if (wanted("drawn")) drawn_incision(out, settings);
  if (wanted("fronts")) fronts(out, settings);
  return out;
}

}  // namespace limberg::bench
