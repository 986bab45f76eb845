#pragma once
// What several tests of the elasticity need: random displacements, a cut, workers with threads.
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/fem/solver/engine.h"

namespace limberg::test {

/// A small generator of its own (SplitMix64), so that every machine draws the same numbers.
struct Random {
  uint64_t state;
  explicit Random(uint64_t seed) : state(seed) {}
  double uniform() {  // [-1, 1)
    uint64_t z = (state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
    return double(z >> 11) * 0x1p-52 - 1;
  }
  Vec3 vector(double size) { return size * Vec3(uniform(), uniform(), uniform()); }
};

inline std::vector<Vec3> random_displacement(const FemModel& m, double size, uint64_t seed, bool fixed_too = true) {
  Random r(seed);
  std::vector<Vec3> u(m.X_mm.size());
  for (size_t i = 0; i < u.size(); ++i) {
    u[i] = r.vector(size);
    if (m.fixed[i] && !fixed_too) u[i].setZero();
  }
  return u;
}

inline std::vector<Vec3f> to_float(const std::vector<Vec3>& u) {
  std::vector<Vec3f> f;
  for (const Vec3& v : u) f.push_back(v.cast<float>());
  return f;
}

/// Every node where a homogeneous F takes it.
inline NodeArray moved_by(const FemModel& m, const Mat3& F) {
  NodeArray u(m.X_mm.size());
  for (size_t i = 0; i < u.size(); ++i) {
    const Vec3 d = (F - Mat3::Identity()) * m.X_mm[i];
    u[i] = {float(d[0]), float(d[1]), float(d[2]), 0};
  }
  return u;
}

/// The model with the nodes on the plane x = 0 doubled for |y| < half_length: a through cut. Cells keep their order.
inline FemModel cut_at_x0(const FemModel& before, double half_length_mm) {
  FemModel m = before;
  m.parent = ParentList::identity(m.parent.size());
  std::map<int32_t, int32_t> copy;
  for (HexCell& c : m.cells) {
    double x = 0;
    for (int32_t v : c.node) x += before.X_mm[size_t(v)][0];
    if (x < 0) continue;
    for (int32_t& v : c.node) {
      const Vec3 X = before.X_mm[size_t(v)];
      if (std::abs(X[0]) > 1e-9 || std::abs(X[1]) >= half_length_mm || before.fixed[size_t(v)]) continue;
      auto [it, is_new] = copy.try_emplace(v, int32_t(m.X_mm.size()));
      if (is_new) {
        m.X_mm.push_back(X), m.fixed.push_back(0), m.parent.push_back(v);
        m.mass_kg[size_t(v)] /= 2, m.mass_kg.push_back(m.mass_kg[size_t(v)]);
      }
      v = it->second;
    }
  }
  return m;
}

inline std::vector<int32_t> identity_parents(const FemModel& m) {
  std::vector<int32_t> p(m.cells.size());
  for (size_t i = 0; i < p.size(); ++i) p[i] = int32_t(i);
  return p;
}

/// Arithmetic on the calling thread.
inline fem::Engine& engine() {
  static InlineWorkers workers;
  static fem::Engine one(workers);
  return one;
}

/// Workers with real threads, started per call: slow, but every interleaving may happen.
class ThreadWorkers final : public Workers {
 public:
  explicit ThreadWorkers(int count) : count_(count) {}
  int count() const override { return count_; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    std::atomic<size_t> next = 0;
    auto run = [&] {
      for (size_t b; (b = next.fetch_add(grain)) < n;) body(b, std::min(n, b + grain));
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < count_; ++i) threads.emplace_back(run);
    run();
    for (std::thread& t : threads) t.join();
  }
  std::shared_ptr<Job> submit(std::function<void()> f) override {
    struct Background final : Job {
      std::thread thread;
      std::atomic<bool> finished = false;
      ~Background() override {
        if (thread.joinable()) thread.join();
      }
      bool done() const override { return finished.load(std::memory_order_acquire); }
      void wait() override {
        if (thread.joinable()) thread.join();
      }
    };
    auto j = std::make_shared<Background>();
    j->thread =
        std::thread([f = std::move(f), p = j.get()] { f(), p->finished.store(true, std::memory_order_release); });
    return j;
  }

 private:
  int count_;
};

}  // namespace limberg::test
