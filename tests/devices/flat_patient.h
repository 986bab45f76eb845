#pragma once
// A flat square of skin, 120 mm wide, with its chart at the centre: what gestures and the surgeon look at in tests.
// Hooks follow the hand and sutures do nothing; there is no elasticity.
#include <cmath>
#include <functional>
#include <memory>

#include "devices/front_end.h"
#include "sim/patient/snapshot.h"

namespace limberg::test {

/// n x n cells. `removed(x, y)`: cells with their middle there are not skin (a hole).
inline std::shared_ptr<SurfaceTopology> flat_topology(int n, uint64_t version,
                                                      const std::function<bool(double, double)>& removed = {}) {
  auto t = std::make_shared<SurfaceTopology>();
  t->version = version;
  auto body = std::make_shared<Body>();
  body->name = "flat";
  t->body = body;
  const double h = 120.0 / n;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) t->view.X_mm.push_back(Vec3(-60 + h * i, -60 + h * j, 0));
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      const bool gone = removed && removed(-60 + h * (i + 0.5), -60 + h * (j + 0.5));
      for (const Tri& k : {Tri{a, b, c}, Tri{a, c, d}}) {
        t->view.tri.push_back(k);
        t->view.kind.push_back(gone ? FaceKind::wall : FaceKind::skin);
      }
    }
  }
  return t;
}

/// Positions from rest by a map.
inline Snapshot snapshot_of(std::shared_ptr<const SurfaceTopology> t,
                            const std::function<Vec3(const Vec3&)>& map = {}) {
  Snapshot s;
  s.topology_version = t->version;
  for (const Vec3& X : t->view.X_mm) s.x_mm.push_back((map ? map(X) : X).cast<float>());
  s.topology = std::move(t);
  return s;
}

struct Events final : EventSink {
  bool push(const ToolEvent& e) override {
    all.push_back(e);
    return room;
  }
  std::vector<ToolEvent> all;
  bool room = true;
  int count(int kind) const {
    int n = 0;
    for (const ToolEvent& e : all) n += e.kind == kind;
    return n;
  }
};

struct Samples final : SampleSink {
  void on_sample(const Sample& s) override { all.push_back(s); }
  std::vector<Sample> all;
};

/// What the world would do with hooks: they stand at their handles.
inline void move_hooks(Snapshot& s, const std::vector<ToolEvent>& events, size_t& next, const ToolState& hand) {
  for (; next < events.size(); ++next) {
    const ToolEvent& e = events[next];
    if (e.kind == ToolEvent::hook_set) {
      HookState h;
      h.id = e.id;
      h.at_mm = h.handle_mm = Vec3f(float(e.world_mm[0]), float(e.world_mm[1]), float(e.world_mm[2]));
      h.force_N = Vec3f::Zero();
      s.hooks.push_back(h);
    }
    if (e.kind == ToolEvent::hook_release) std::erase_if(s.hooks, [&](const HookState& h) { return h.id == e.id; });
  }
  for (HookState& h : s.hooks)
    if (h.id == hand.held_hook) h.handle_mm = Vec3(hand.tip_mm[0], hand.tip_mm[1], hand.tip_mm[2]).cast<float>();
}

}  // namespace limberg::test
