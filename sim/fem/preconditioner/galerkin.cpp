#include "sim/fem/preconditioner/galerkin.h"

#include <algorithm>

namespace limberg::fem {
namespace {

class CoarseRows {
 public:
  CoarseRows(const NodeMatrix& A, const Coarsening& c)
      : A_(A), c_(c), product_(size_t(A.rows()), {-1, -1}), place_(c.place.size(), -1) {}

  void make(int32_t I, NodeMatrix& out) {
    const Interpolation& R = c_.restrict_;
    for (int32_t e = R.begin[size_t(I)]; e < R.begin[size_t(I) + 1]; ++e) multiply(R.column[size_t(e)]);
    found_.clear();
    for (int32_t e = R.begin[size_t(I)]; e < R.begin[size_t(I) + 1]; ++e) {
      const double w = double(R.weight[size_t(e)]);
      const auto [from, to] = product_[size_t(R.column[size_t(e)])];
      for (int32_t k = from; k < to; ++k) add(entry_[size_t(k)].first, w * entry_[size_t(k)].second);
    }
    sort_and_reset();
    for (auto& [J, value] : found_) out.column.push_back(J), out.value.push_back(float(value));
  }

 private:
  /// Row i of A P, once.
  void multiply(int32_t i) {
    auto& [from, to] = product_[size_t(i)];
    if (from >= 0) return;
    found_.clear();
    const Interpolation& P = c_.prolong;
    for (int32_t e = A_.begin[size_t(i)]; e < A_.begin[size_t(i) + 1]; ++e) {
      const size_t j = size_t(A_.column[size_t(e)]);
      const double a = double(A_.value[size_t(e)]);
      for (int32_t p = P.begin[j]; p < P.begin[j + 1]; ++p) add(P.column[size_t(p)], a * double(P.weight[size_t(p)]));
    }
    for (auto& e : found_) place_[size_t(e.first)] = -1;
    from = int32_t(entry_.size());
    entry_.insert(entry_.end(), found_.begin(), found_.end());
    to = int32_t(entry_.size());
  }
  void add(int32_t J, double value) {
    int32_t& p = place_[size_t(J)];
    if (p < 0) p = int32_t(found_.size()), found_.push_back({J, 0});
    found_[size_t(p)].second += value;
  }
  void sort_and_reset() {
    for (auto& e : found_) place_[size_t(e.first)] = -1;
    std::sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  const NodeMatrix& A_;
  const Coarsening& c_;
  std::vector<std::pair<int32_t, int32_t>> product_;  // per fine node: its row of A P in entry_, or -1
  std::vector<std::pair<int32_t, double>> entry_, found_;
  std::vector<int32_t> place_;
};

}  // namespace

NodeMatrix galerkin(const NodeMatrix& A, const Coarsening& c) {
  CoarseRows rows(A, c);
  NodeMatrix out;
  for (size_t I = 0; I < c.place.size(); ++I) {
    rows.make(int32_t(I), out);
    out.begin.push_back(int32_t(out.column.size()));
  }
  return out;
}

NodeMatrix galerkin(const NodeMatrix& A, const Coarsening& c, const NodeMatrix& before, const NodeChange& coarse) {
  CoarseRows rows(A, c);
  NodeMatrix out;
  out.column.reserve(before.column.size() + before.column.size() / 8), out.value.reserve(out.column.capacity());
  for (size_t I = 0; I < c.place.size(); ++I) {
    if (coarse.dirty[I])
      rows.make(int32_t(I), out);
    else
      copy_row(before, coarse.parent[I], coarse.child, out);
    out.begin.push_back(int32_t(out.column.size()));
  }
  return out;
}

bool compare_coarse(const Coarsening& before, const Coarsening& now, const NodeMatrix& A, const NodeChange& fine,
                    NodeChange& coarse) {
  if (!(before.rule == now.rule)) return false;
  const Interpolation &P = now.prolong, &P0 = before.prolong, &R = now.restrict_;
  const size_t n = now.place.size();
  coarse.parent.assign(n, -1), coarse.child.assign(before.place.size(), -1), coarse.dirty.assign(n, 0);
  // A coarse node comes from the one of its place that interpolated the parent of a fine node of its own.
  std::vector<uint8_t> children(before.place.size(), 0);
  for (size_t I = 0; I < n; ++I) {
    for (int32_t e = R.begin[I]; e < R.begin[I + 1] && coarse.parent[I] < 0; ++e) {
      const int32_t p = fine.parent[size_t(R.column[size_t(e)])];
      if (p < 0) continue;
      for (int32_t k = P0.begin[size_t(p)]; k < P0.begin[size_t(p) + 1]; ++k)
        if (before.place[size_t(P0.column[size_t(k)])] == now.place[I]) coarse.parent[I] = P0.column[size_t(k)];
    }
    const int32_t p = coarse.parent[I];
    if (p < 0) continue;
    children[size_t(p)] = uint8_t(std::min(2, children[size_t(p)] + 1));
    coarse.child[size_t(p)] = children[size_t(p)] == 1 ? int32_t(I) : -1;
  }
  keep_rising(coarse.child);
  for (size_t I = 0; I < n; ++I) coarse.dirty[I] = coarse.parent[I] < 0 || coarse.child[size_t(coarse.parent[I])] < 0;

  const auto touch_before = [&](int32_t p) {
    for (int32_t k = P0.begin[size_t(p)]; k < P0.begin[size_t(p) + 1]; ++k)
      if (const int32_t I = coarse.child[size_t(P0.column[size_t(k)])]; I >= 0) coarse.dirty[size_t(I)] = 1;
  };
  const auto touch = [&](int32_t v) {
    for (int32_t e = P.begin[size_t(v)]; e < P.begin[size_t(v) + 1]; ++e) coarse.dirty[size_t(P.column[size_t(e)])] = 1;
  };
  for (size_t p = 0; p < fine.child.size(); ++p)
    if (fine.child[p] < 0) touch_before(int32_t(p));
  for (size_t v = 0; v < fine.parent.size(); ++v) {
    const int32_t p = fine.parent[v];
    bool same = p >= 0 && fine.child[size_t(p)] >= 0;
    if (same) {
      const int32_t a = P.begin[v], b = P0.begin[size_t(p)], count = P.begin[v + 1] - a;
      same = count == P0.begin[size_t(p) + 1] - b;
      for (int32_t k = 0; k < count && same; ++k)
        same = P.column[size_t(a + k)] == coarse.child[size_t(P0.column[size_t(b + k)])] &&
               P.weight[size_t(a + k)] == P0.weight[size_t(b + k)];
      if (!same) touch_before(p);
    }
    if (fine.dirty[v]) touch(int32_t(v));
    if (same) continue;
    // Its weights are others: so are all rows of A P that meet it (A is symmetric).
    touch(int32_t(v));
    for (int32_t e = A.begin[v]; e < A.begin[v + 1]; ++e) touch(A.column[size_t(e)]);
  }
  return true;
}

}  // namespace limberg::fem
