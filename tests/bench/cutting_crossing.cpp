// What it costs a cut to go across earlier ones. Every cut is made, taken back
// and made again, and the second time counts: so each finds in the caches what it
// needs, as the first one does, whose undo was the last act of the round before.
#include <algorithm>
#include <array>

#include "sim/cutting/arrangement/cut_scratch.h"
#include "sim/cutting/arrangement/store.h"
#include "tests/bench/cutting_parts.h"
#include "tests/bench/cutting_scene.h"

namespace limberg::bench {
namespace {

CutResult timed(Arrangement& a, const Blade& blade, uint64_t seed, Times& times) {
  Times untimed;
  cut(a, blade, seed, untimed);
  a.undo();
  return cut(a, blade, seed, times);
}

size_t faces_of_last(const Arrangement& a) {
  return a.last_operation().added.size() + a.last_operation().removed.size();
}

struct Work {  // what one cut had to look at and to make
  size_t boxes = 0, pairs = 0, faces = 0, triangles = 0, walls = 0, three_planes = 0;
};
Work work_of_last(Arrangement& a, int wall_faces) {
  Work w;
  w.walls = size_t(wall_faces);
  w.boxes = a.store().scratch->hit.size();
  w.pairs = a.store().scratch->segment.size();
  const PointStore& points = a.store().points;
  for (int32_t p = a.store().history.back().points; p < points.size(); ++p)
    w.three_planes += points.key(p).kind == PointKey::three_planes;
  w.faces = faces_of_last(a);
  std::vector<int32_t> divided;
  for (int32_t f : a.last_operation().removed) divided.push_back(a.faces()[size_t(f)].orig);
  std::sort(divided.begin(), divided.end());
  w.triangles = size_t(std::unique(divided.begin(), divided.end()) - divided.begin());
  return w;
}

/// The cuts one after the other, each timed, over the first one's time, and what it did.
struct InOrder {
  std::array<Times, 4> t, ratio;
  std::array<Work, 4> work;
  void cut_all(Arrangement& a, const std::vector<Blade>& blade) {
    for (size_t k = 0; k < 4; ++k) {
      const CutResult made = timed(a, blade[k], k, t[k]);
      work[k] = work_of_last(a, made.wall_faces);
      ratio[k].add(t[k].ms.back() / t[0].ms.back());
    }
  }
};

std::string over_first(const char* format, size_t value, size_t first) {
  return text(format, value, double(value) / double(first));
}

void add_cut_row(Result& out, const char* name, const std::string& method, size_t triangles, const Work& w,
                 const Work& one, const Times& t) {
  add_row(out, name, method,
          text("%zu triangles, 120 mm; ", triangles) + over_first("near %zu (%.3f of cut 1)", w.boxes, one.boxes) +
              over_first(", meeting %zu (%.3f)", w.pairs, one.pairs) +
              over_first(", divided %zu (%.3f)", w.triangles, one.triangles) +
              text(", points of three planes %zu", w.three_planes) +
              over_first(", faces made or replaced %zu (%.3f)", w.faces, one.faces) +
              text(", of them wall %zu; %.0f ns a face", w.walls, 1e6 * t.median() / double(w.faces)),
          t);
}

/// The cuts of which the bars come: all as deep, the second
/// across the first, the third across both, the fourth
/// beside the first, 1 mm off, across the two others.
void cuts_of_the_prototype(Result& out, const CuttingSettings& settings, const Body& body, int repeats) {
  Arrangement a(body.surface, body.grid);
  constexpr std::array<const char*, 4> names{"cut 1", "cut 2, an X", "cut 3, a star", "cut 4, 1 mm beside cut 1"};
  std::vector<Blade> blade;
  for (const auto& [angle_deg, beside_mm] :
       {std::pair(0., 0.), std::pair(90., 0.), std::pair(45., 0.), std::pair(0., 1.)}) {
    BladePlace p;
    p.angle_deg = angle_deg, p.middle.y() += beside_mm;
    blade.push_back(curved_blade(body, p));
  }
  InOrder cuts;
  const auto& [t, ratio, work] = cuts;
  for (int i = 0; i < repeats; ++i) {
    cuts.cut_all(a, blade);
    for (int k = 0; k < 4; ++k) a.undo();
  }
  for (size_t k = 0; k < 4; ++k)
    add_cut_row(out, "crossing", names[k], body.surface.tri.size(), work[k], work[0], t[k]);
  if (settings.quick) return;
  for (size_t k = 1; k < 4; ++k)
    add_bar(out,
            text("crossing: %s, over cut 1; faces made or replaced %.2f", names[k],
                 double(work[k].faces) / double(work[0].faces)),
            ratio[k].median(), 1.1, false, kTargets);
}

/// Harder: all four through one place, so that the fourth crosses three, each at another angle and depth. "Alone": the
/// same blade into the uncut body, which tells what its own direction and depth cost from what crossing costs. "In
/// turns": the four orders in which every blade is once first, once second and so on, so that both sides of the ratio
/// are means over the same four.
void star_of_four(Result& out, const CuttingSettings& settings, const Body& body, int repeats) {
  Arrangement a(body.surface, body.grid);
  std::vector<Blade> blade;
  for (double angle : {0.0, 90.0, 45.0, 135.0}) {
    BladePlace p;
    p.angle_deg = angle, p.depth_mm = 9 - angle / 90;
    p.middle += Vec2(angle / 90, angle / 60);
    blade.push_back(curved_blade(body, p));
  }
  InOrder cuts;
  const auto& [t, ratio, work] = cuts;
  std::array<Times, 4> alone, to_alone, in_turns, in_turns_work;
  std::array<size_t, 4> alone_faces{};
  for (int i = 0; i < repeats; ++i) {
    for (size_t k = 0; k < 4; ++k) {
      timed(a, blade[k], k, alone[k]);
      alone_faces[k] = faces_of_last(a);
      a.undo();
    }
    cuts.cut_all(a, blade);
    for (size_t k = 0; k < 4; ++k) to_alone[k].add(t[k].ms.back() / alone[k].ms.back());
    for (int k = 0; k < 4; ++k) a.undo();
    std::array<double, 4> by_place{}, faces_by_place{};
    for (size_t turn = 0; turn < 4; ++turn) {
      for (size_t place = 0; place < 4; ++place) {
        const size_t k = (turn + place) % 4;
        Times one;
        timed(a, blade[k], k, one);
        by_place[place] += one.ms.back();
        faces_by_place[place] += double(faces_of_last(a));
      }
      for (int k = 0; k < 4; ++k) a.undo();
    }
    for (size_t k = 0; k < 4; ++k)
      in_turns[k].add(by_place[k] / by_place[0]), in_turns_work[k].add(faces_by_place[k] / faces_by_place[0]);
  }
  for (size_t k = 0; k < 4; ++k) {
    add_cut_row(out, "star of four", text("cut %zu", k + 1), body.surface.tri.size(), work[k], work[0], t[k]);
    add_row(out, "star of four", text("cut %zu's blade alone, into the uncut body", k + 1),
            text("%.3f of cut 1's", alone[k].median() / alone[0].median()), alone[k]);
  }
  if (settings.quick) return;
  const auto bar = [&](size_t k, const char* against, double faces, double value, const char* source) {
    add_bar(out, text("star of four: cut %zu over %s; faces made or replaced %.2f", k + 1, against, faces), value, 1.1,
            false, source);
  };
  for (size_t k = 1; k < 4; ++k)
    bar(k, "cut 1, each of the four blades in each place once", in_turns_work[k].median(), in_turns[k].median(),
        "as for the cuts of the prototype: the same blades on both sides");
  for (size_t k = 1; k < 4; ++k)
    bar(k, "the same blade alone in the uncut body", double(work[k].faces) / double(alone_faces[k]),
        to_alone[k].median(), "as for the cuts of the prototype: what crossing itself costs");
  for (size_t k = 1; k < 4; ++k)
    bar(k, "cut 1 (other blades: direction and depth count too)", double(work[k].faces) / double(work[0].faces),
        ratio[k].median(), "as for the cuts of the prototype");
}

}  // namespace

void crossing_cuts(Result& out, const CuttingSettings& settings, int slab_cells, int repeats) {
  say(settings, "crossing");
  const Body body = wavy_slab(slab_cells);
  cuts_of_the_prototype(out, settings, body, repeats);
  say(settings, "crossing: star of four");
  star_of_four(out, settings, body, repeats);
}

}  // namespace limberg::bench
