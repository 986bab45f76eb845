#pragma once
// A patient of a few lines: a flat square of skin whose hooks pull their surroundings along, and which comes to rest at
// a rate of its own. Enough for every lane; its hash is over all it does, so that a difference of order shows.
#include <time.h>

#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>

#include "app/session/patient.h"
#include "sim/base/hash.h"
#include "sim/base/workers.h"

namespace limberg {

class FakePatient final : public Patient {
 public:
  explicit FakePatient(Workers* workers = nullptr, int n = 40, double spacing_mm = 1) : workers_(workers), n_(n) {
    auto body = std::make_shared<Body>();
    body->name = "flat";
    auto t = std::make_shared<SurfaceTopology>();
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        body->surface.X_mm.push_back(Vec3((i - n / 2) * spacing_mm, (j - n / 2) * spacing_mm, 0));
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        body->surface.tri.push_back({a, b, d});
        body->surface.tri.push_back({a, d, c});
      }
    body->surface.tag.assign(body->surface.tri.size(), SurfaceTag::skin);
    body_ = body;
    make_topology(1);
    x_ = t_->view.X_mm;
  }

  Outcome apply(const Command& c) override {
    log_.add(int(c.index()));
    if (const auto* i = std::get_if<Incise>(&c)) {
      if (i->depth_mm > 9) return {false, "depth 10 mm is too deep; expected at most 9 mm"};
      make_topology(t_->version + 1);
      for (const ChartPoint& p : i->path) log_.add(p.x()), log_.add(p.y());
    } else if (const auto* h = std::get_if<SetHook>(&c)) {
      hooks_[h->id] = {Vec3(h->at.x(), h->at.y(), 0), Vec3(h->at.x(), h->at.y(), 0)};
    } else if (const auto* m = std::get_if<MoveHook>(&c)) {
      if (!hooks_.contains(m->id)) return {false, "no such hook"};
      hooks_[m->id].second = m->to_mm;
    } else if (const auto* r = std::get_if<ReleaseHook>(&c)) {
      hooks_.erase(r->id);
    }
    return {true, {}};
  }

  StepReport step(const StepSettings& s) override {
    StepReport out;
    for (int it = 0; it < s.max_iterations && !(s.should_stop && s.should_stop()); ++it) {
      std::vector<double> part((x_.size() + kGrain - 1) / kGrain);
      const auto chunk = [&](size_t b, size_t e) {
        double move = 0;
        for (size_t i = b; i < e; ++i) {
          Vec3 target = t_->view.X_mm[i];
          for (const auto& [id, h] : hooks_) {
            const double w = std::exp(-(t_->view.X_mm[i] - h.first).squaredNorm() / 20);
            target += w * (h.second - h.first);
          }
          const Vec3 d = 0.3 * (target - x_[i]);
          x_[i] += d;
          move += d.squaredNorm();
        }
        part[b / kGrain] = move;
      };
      if (workers_)
        workers_->parallel_for(x_.size(), kGrain, chunk);
      else
        for (size_t b = 0; b < x_.size(); b += kGrain) chunk(b, std::min(x_.size(), b + kGrain));
      double move = 0;
      for (const double p : part) move += p;  // in order: the same bits with any number of workers
      out.residual = std::sqrt(move);
      residual_ = out.residual;
      ++out.iterations;
      if (out.residual <= s.tolerance) break;
    }
    if (takes_ns_ > 0) {
      const timespec pause{takes_ns_ / 1'000'000'000, takes_ns_ % 1'000'000'000};
      nanosleep(&pause, nullptr);
      out_of_time_ += s.should_stop && s.should_stop();
    }
    if (++steps_ == fails_at_) throw std::runtime_error("broken patient");
    return out;
  }

  bool press(const PressQuestion& q, PressAnswer& a) override {
    a = {q.topology_version, q.triangle, 0.3, q.depth_mm, 0, 1};
    return q.topology_version == t_->version;
  }
  void fill(Snapshot& s) const override {
    s.step = steps_;
    s.topology = t_;
    s.topology_version = t_->version;
    s.x_mm.resize(x_.size());
    for (size_t i = 0; i < x_.size(); ++i) s.x_mm[i] = x_[i].cast<float>();
    s.hooks.clear();
    for (const auto& [id, h] : hooks_)
      s.hooks.push_back({id, h.first.cast<float>(), h.second.cast<float>(), Vec3f::Zero()});
    s.residual = float(residual_);
  }
  std::shared_ptr<const SurfaceTopology> topology() const override { return t_; }
  uint64_t topology_hash() const override { return t_->version; }
  uint64_t state_hash() const override {
    Hash64 h = log_;
    for (const Vec3& x : x_) h.bytes(x.data(), 3 * sizeof(double));
    h.add(residual_);
    return h.value();
  }
  void fail_at_step(uint64_t step) { fails_at_ = step; }
  /// Each step takes so much longer.
  void take_time(int64_t ns) { takes_ns_ = ns; }
  /// So many steps that took time were told then to stop.
  int out_of_time() const { return out_of_time_; }
  /// Something is going on for ever.
  void keep_busy() { busy_ = true; }
  bool settled() const override { return !busy_; }
  const std::vector<Vec3>& x_mm() const { return x_; }
  size_t hooks() const { return hooks_.size(); }

 private:
  static constexpr size_t kGrain = 100;

  void make_topology(uint64_t version) {
    auto t = std::make_shared<SurfaceTopology>();
    t->version = version;
    t->body = body_;
    SurfaceView& v = t->view;
    v.X_mm = body_->surface.X_mm;
    v.cell_copy.assign(v.X_mm.size(), 0);
    for (size_t i = 0; i < v.X_mm.size(); ++i) v.point.push_back(int32_t(i));
    v.tri = body_->surface.tri;
    v.uv.resize(v.tri.size());
    v.kind.assign(v.tri.size(), FaceKind::skin);
    for (size_t i = 0; i < v.tri.size(); ++i) v.sided_face.push_back(int32_t(2 * i)), v.origin.push_back(int32_t(i));
    t->embedding.resize(v.X_mm.size());
    t->depth_mm = Lazy<SharedArray<float>>(SharedArray<float>(v.X_mm.size(), 0));
    t_ = t;
  }

  Workers* workers_;
  int n_;
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const SurfaceTopology> t_;
  std::vector<Vec3> x_;
  std::map<int, std::pair<Vec3, Vec3>> hooks_;
  Hash64 log_;
  double residual_ = 0;
  uint64_t steps_ = 0;
  bool busy_ = false;
  uint64_t fails_at_ = 0;
  int out_of_time_ = 0;
  int64_t takes_ns_ = 0;
};

}  // namespace limberg
