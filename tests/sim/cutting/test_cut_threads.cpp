// Who computes does not matter: a history of cuts, excisions and undos gives the same
// bits with any number of workers, and when several bodies are cut on several threads
// at the same time. (Section 8 of the design's list of what was to be proved.)
#include <gtest/gtest.h>

#include <thread>

#include "app/session/workers_pool.h"
#include "sim/base/hash.h"
#include "sim/cutting/arrangement/store.h"
#include "tests/bench/fuzz/generator.h"
#include "tests/sim/cutting/case_scene.h"

namespace limberg::test {
namespace test_cut_threads {

/// Every number of a version of the lattice that anything else is made from.
uint64_t bits_of(const LatticeTopology& t) {
  Hash64 h;
  h.add(t.hash());
  for (const CellCopy& c : t.cells) h.add(c.cell), h.add(c.piece), h.add(c.fraction);
  for (size_t i = 0; i < t.cells.size(); ++i) h.add(t.cell_parent[i]);
  for (size_t i = 0; i < t.nodes.size(); ++i) h.add(t.node_parent[i]);
  for (const NodeCopy& n : t.nodes) h.add(n.at.x), h.add(n.at.y), h.add(n.at.z);
  for (const auto& x : t.hanging) h.add(x.node), h.add(x.master[0]), h.add(x.count);
  for (const auto& b : t.born)
    for (const auto& [from, weight] : b.from) h.add(b.node), h.add(from), h.add(weight);
  for (const double v : t.piece_volume_mm3) h.add(v);
  for (const auto& c : t.components) {
    h.add(bool(c));
    if (!c) continue;
    for (size_t f = 0; f < c->face.size(); ++f)
      h.add(c->face[f]), h.add(c->of_side[f][0]), h.add(c->of_side[f][1]), h.add(c->relation[f]);
    for (const CellClass& k : c->classes) h.add(k.fraction), h.add(k.old_class), h.add(k.corners);
  }
  return h.value();
}

struct History {
  std::vector<uint64_t> bits;  // after every operation
  int touched = 0;             // most cells in one update
};

/// Incisions across each other, one through, undermining, a plug that is taken away, undo.
History history(Workers* workers, int front_levels) {
  const LatticeGrid g = [&] {
    LatticeGrid made = lattice_over(wavy_slab(60, 12, 24, 0.8), 4.3);
    if (front_levels)
      for (int32_t* p : {&made.pitch.x, &made.pitch.y, &made.pitch.z}) *p = *p / 16 * 16 + 16;
    return made;
  }();
  Arrangement a(wavy_slab(60, 12, 24, 0.8), grid());
  std::vector<std::shared_ptr<const LatticeTopology>> version{build_topology(g, material_surface(a), front_levels)};
  History out;
  const auto note = [&] {
    version.push_back(update_topology(*version.back(), material_surface(a), workers));
    out.bits.push_back(a.full_hash());
    out.bits.push_back(bits_of(*version.back()));
    out.touched = std::max(out.touched, version.back()->touched_cells);
  };
  uint64_t seed = 1;
  for (const Blade& b : {strip({{-23.117, 0.331}, {21.243, 1.171}}, 3.01, -6.037, false, 4),
                         strip({{1.031, -21.13}, {2.071, 22.37}}, 3.03, -4.091, false, 4),
                         sheet({-9.03, 0.113, -3.071}, {18.01, 0.1, 0.05}, {0.07, 9.13, 0.11}, 5, 3),
                         open_box({{9.03, -9.1}, {5.07, -5.013}, {1.11, -9.17}, {5.013, -13.07}}, 3.07, -5.03),
                         strip({{-50.07, -14.13}, {51.11, -15.07}}, 4.03, -16.01, false, 200)}) {
    EXPECT_TRUE(a.cut(b, seed++).ok());
    note();
  }
  int32_t smallest = 0;
  for (size_t i = 0; i < a.components().size(); ++i)
    if (a.components()[i].volume_mm3 > 0 && a.components()[i].volume_mm3 < a.components()[size_t(smallest)].volume_mm3)
      smallest = int32_t(i);
  EXPECT_TRUE(a.excise(smallest).done);
  note();
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(a.undo());
    version.pop_back();
    out.bits.push_back(a.full_hash());
  }
  EXPECT_TRUE(a.cut(strip({{-22, -6.1}, {23, 9.2}}, 3.05, -7.3), 9).ok());
  note();
  EXPECT_EQ(a.check_all(), "");
  return out;
}

TEST(CutThreads, AnyNumberOfWorkersGivesTheSameBits) {
  for (const int levels : {0, 3}) {
    const History alone = history(nullptr, levels);
    EXPECT_GT(alone.touched, 48);  // more than three groups of cells: there is something to divide
    for (const int n : {1, 2, 4, 8}) {
      WorkersPool pool(n);
      EXPECT_EQ(history(&pool, levels).bits, alone.bits) << n << " workers, fronts divided " << levels << " times";
    }
  }
}

/// A fuzz history: cuts of every kind, excisions, undo and redo, faults, and the lattice after each of them.
std::vector<uint64_t> fuzzed(uint64_t seed, int operations) {
  fuzz::Generator g(seed, seed % 2 == 1);
  const fuzz::Case c = g.start(seed % 3 == 0 ? 3 : 0);
  fuzz::Runner r(c, {0, true, false});
  std::vector<uint64_t> bits;
  for (int32_t i = 0; i < operations; ++i) {
    EXPECT_EQ(r.apply(g.next(r, i)), "") << "seed " << seed << " operation " << i;
    bits.push_back(r.arrangement().full_hash());
    bits.push_back(bits_of(*r.lattice()));
  }
  return bits;
}

TEST(CutThreads, BodiesCutAtTheSameTimeDoNotSeeEachOther) {
  constexpr int kThreads = 4, kEach = 3, kOperations = 14;
  std::vector<std::vector<uint64_t>> alone;
  for (int i = 0; i < kThreads * kEach; ++i) alone.push_back(fuzzed(uint64_t(20 + i), kOperations));
  std::vector<std::vector<uint64_t>> together(alone.size());
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i)
        together[size_t(kEach * t + i)] = fuzzed(uint64_t(20 + kEach * t + i), kOperations);
    });
  for (std::thread& t : threads) t.join();
  for (size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(together[i], alone[i]) << "seed " << 20 + i;
}

}  // namespace test_cut_threads
}  // namespace limberg::test
