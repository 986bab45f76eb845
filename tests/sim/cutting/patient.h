#pragma once
// A block of tissue with its arrangement, cut by strokes on its skin.
#include <gtest/gtest.h>

#include <memory>

#include "sim/body/block.h"
#include "sim/body/skin.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "sim/cutting/strokes/stroke.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {

using Chi = std::vector<int>;

struct Patient {
  std::shared_ptr<const Body> body;
  Skin skin;
  Arrangement a;
  uint64_t seed = 1;
  int cuts = 0;  // operations of the last stroke
  explicit Patient(double cell = 1.6)
      : body([&] {
          BlockSpec spec;
          spec.size_mm = {100, 100, 10};
          spec.skin_cell_mm = cell;
          return std::make_shared<const Body>(make_block(spec));
        }()),
        skin(body),
        a(body->surface, body->grid) {}
  BladeContext context() {
    return {body.get(), &a, [this](const ChartPoint& p) { return skin.at(p); }};
  }
  CutResult cut(const BladeResult& b) {
    CutResult r;
    if (!b.blade) {
      r.reason = b.reason;
      return r;
    }
    r = a.cut(*b.blade, seed++);
    EXPECT_EQ(a.check_all(), "");
    return r;
  }
  /// A whole stroke. Whatever comes of it, every invariant holds, and a stroke that was not made has changed nothing.
  CutResult incise(const std::vector<Vec2>& path, double depth = 4, double angle = 90, bool spline = false) {
    const uint64_t hash = a.full_hash();
    const CutResult r = limberg::incise(a, context(), path, depth, angle, 100 * seed++, spline, &cuts);
    EXPECT_EQ(a.check_all(), "");
    if (!r.ok()) {
      EXPECT_EQ(a.full_hash(), hash);
      EXPECT_NE(r.reason, "");
    }
    return r;
  }
  CutResult undermine(const std::vector<Vec2>& outline, double depth = 4) {
    const BladeResult b = build_undermining(context(), outline, depth);
    CutResult r = cut(b);
    if (b.nothing) r.status = CutResult::nothing_to_cut;
    return r;
  }
  double wall_area() const {  // one side
    double sum = 0;
    for (const Face& f : a.faces())
      if (f.live() && f.mat == 3)
        sum += 0.5 * (a.point_mm(f.v[1]) - a.point_mm(f.v[0])).cross(a.point_mm(f.v[2]) - a.point_mm(f.v[0])).norm();
    return sum;
  }
  std::vector<int32_t> live_walls() const {
    std::vector<int32_t> out;
    for (int32_t f = 0; f < int32_t(a.faces().size()); ++f)
      if (a.faces()[f].live() && a.orig_tris()[a.faces()[f].orig].op > 0) out.push_back(f);
    return out;
  }
  /// Edges at which exactly one wall ends: the fronts of all cracks, mm.
  double front_length() const {
    double sum = 0;
    for (int32_t f = 0; f < int32_t(a.faces().size()); ++f)
      for (int k = 0; k < 3; ++k) {
        const Face& t = a.faces()[f];
        if (!t.live() || t.mat != 3) continue;
        const int32_t h = sided_half_edge(sided_face(f, 0), k);
        if (a.mate(h) == sided_half_edge(sided_face(f, 1), k))
          sum += (a.point_mm(t.v[size_t(k)]) - a.point_mm(t.v[size_t(k + 1) % 3])).norm();
      }
    return sum;
  }
};

}  // namespace limberg::test
