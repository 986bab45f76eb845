// The hash of the soft tissue's state sees every field of it: that a field is listed the compiler checks, that it is
// hashed is checked here.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "sim/patient/tissue_state.h"

namespace limberg {
namespace test_tissue_state {

template <class T>
uint64_t hash(const T& t) {
  FieldHash h;
  h(t);
  return h.value();
}

/// Each change of one field gives a hash that no other has.
template <class T>
void expect_all_seen(const T& start, const std::vector<std::function<void(T&)>>& changes) {
  std::vector<uint64_t> seen{hash(start)};
  for (size_t i = 0; i < changes.size(); ++i) {
    T t = start;
    changes[i](t);
    seen.push_back(hash(t));
    for (size_t k = 0; k + 1 < seen.size(); ++k) EXPECT_NE(seen[k], seen.back()) << "changes " << k << " and " << i;
  }
}

TEST(TissueState, EveryFieldOfWhatHoldsTheTissueIsHashed) {
  expect_all_seen<Anchor>(
      {}, {[](Anchor& a) { a.X_mm.x() = 1; }, [](Anchor& a) { a.hint_mm.y() = 1; }, [](Anchor& a) { a.origin = 3; },
           [](Anchor& a) { a.at.triangle = 4; }, [](Anchor& a) { a.at.bary.z() = 1; },
           [](Anchor& a) { a.embedded.node[7] = 5; }, [](Anchor& a) { a.embedded.w[7] = 5; },
           [](Anchor& a) { a.bite_mm = 1; }, [](Anchor& a) { a.wide.push_back({}); },
           [](Anchor& a) { a.wide.push_back({}), a.wide[0].share = -1; }, [](Anchor& a) { a.wall_normal.x() = 1; }});
  expect_all_seen<Hook>({}, {[](Hook& h) { h.id = 1; }, [](Hook& h) { h.spring = 1; },
                             [](Hook& h) { h.anchor.origin = 7; }, [](Hook& h) { h.handle_mm.z() = 1; }});
  expect_all_seen<Stitch>(
      {}, {[](Stitch& s) { s.id = 1; }, [](Stitch& s) { s.spring = 1; }, [](Stitch& s) { s.a.origin = 7; },
           [](Stitch& s) { s.b.origin = 7; }, [](Stitch& s) { s.slack_mm.x() = 1; }, [](Stitch& s) { s.thread = 1; },
           [](Stitch& s) { s.tied_N = 1; }, [](Stitch& s) { s.peak_N = 1; }});
  expect_all_seen<Thread>(
      {}, {[](Thread& t) { t.id = 1; }, [](Thread& t) { t.length_mm = 1; }, [](Thread& t) { t.slack_mm = 1; },
           [](Thread& t) { t.corner = true; }, [](Thread& t) { t.closing = false; }});
  expect_all_seen<PlacedLoad>({}, {[](PlacedLoad& l) { l.anchor.origin = 7; }, [](PlacedLoad& l) { l.force_N.y() = 1; },
                                   [](PlacedLoad& l) { l.radius_mm = 1; }});
  expect_all_seen<Holding>({}, {[](Holding& k) { k.hooks.push_back({}); }, [](Holding& k) { k.stitches.push_back({}); },
                                [](Holding& k) { k.threads.push_back({}); }, [](Holding& k) { k.next_spring = 2; },
                                [](Holding& k) { k.next_stitch = 2; }, [](Holding& k) { k.next_thread = 2; },
                                [](Holding& k) { k.loads.push_back({}); }});
  using Figures = TissueFigures;
  expect_all_seen<Figures>({}, {[](Figures& f) { f.volume_mm3 = 1; }, [](Figures& f) { f.removed_volume_mm3 = 1; },
                                [](Figures& f) { f.cuts = 1; }, [](Figures& f) { f.open_energy_uJ = 0; },
                                [](Figures& f) { f.open_energy_uJ = 1; }, [](Figures& f) { f.last.energy_uJ = 1; },
                                [](Figures& f) { f.last.residual = 1; }, [](Figures& f) { f.last.distance_mm = 1; }});
}

TEST(TissueState, EveryFieldOfSolverAndContactsIsHashed) {
  SolverState start;
  start.before_s = 0.5;
  expect_all_seen<SolverState>(
      start,
      {[](SolverState& s) { s.displacement_mm = {1}; }, [](SolverState& s) { s.velocity_mm_s = {1}; },
       [](SolverState& s) { s.pressure = {1}; }, [](SolverState& s) { s.memory = {1}; },
       [](SolverState& s) { s.since_update = 1; }, [](SolverState& s) { s.before_s = 1; },
       [](SolverState& s) { s.displacement_before_mm = {1}; }, [](SolverState& s) { s.velocity_before_mm_s = {1}; }});
  using Contact = HeldContact;
  expect_all_seen<Contact>(
      {}, {[](Contact& c) { c.place = 9; }, [](Contact& c) { c.sheet = 9; }, [](Contact& c) { c.triangle = 9; },
           [](Contact& c) { c.bary[2] = 9; }, [](Contact& c) { c.normal.x() = 9; }, [](Contact& c) { c.facet.x() = 9; },
           [](Contact& c) { c.apart_mm.x() = 9; }, [](Contact& c) { c.gap_mm = 9; }, [](Contact& c) { c.weight = 9; },
           [](Contact& c) { c.depth_tested = true; }, [](Contact& c) { c.grip.push_mN = 9; },
           [](Contact& c) { c.grip.stick_mm.x() = 9; }});
  expect_all_seen<HeldByCollider>({}, {[](HeldByCollider& c) { c.grip.push_mN = 9; }});
  using Damping = ContactMemory::Damping;
  expect_all_seen<Damping>({}, {[](Damping& d) { d.place = 9; }, [](Damping& d) { d.projections = 9; },
                                [](Damping& d) { d.slid_mm.x() = 9; }});
  expect_all_seen<ContactMemory>(
      {}, {[](ContactMemory& m) { m.pairs.push_back({}); }, [](ContactMemory& m) { m.damping.push_back({}); }});
}

}  // namespace test_tissue_state
}  // namespace limberg
