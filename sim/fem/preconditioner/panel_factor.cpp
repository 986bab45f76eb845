#include "sim/fem/preconditioner/panel_factor.h"

#include <algorithm>

namespace limberg::fem {
namespace {

// Numbers in the panels below which one thread is done before another is awake.
constexpr size_t least_to_share = 100000;
// A subtree with more than this part of the work is not left whole. A dissection's tree halves at every level, so a
// quarter leaves four subtrees and three separators on top.
constexpr size_t pieces = 4;

}  // namespace

PanelFactor::PanelFactor(const SupernodalView& L) : n_(L.n) {
  size_t total = 0, tails = 0;
  for (int32_t s = 0; s < L.supernodes; ++s) {
    const size_t nc = size_t(L.super[s + 1] - L.super[s]), nr = size_t(L.rows_begin[s + 1] - L.rows_begin[s]);
    total += (nr + 15) / 16 * 16 * nc;
    tails += nr - nc;
  }
  values_.resize(total);
  rows_.reserve(tails);
  panels_.reserve(size_t(L.supernodes));
  size_t at = 0;
  std::vector<double> M;
  for (int32_t s = 0; s < L.supernodes; ++s) {
    Panel p;
    p.first = L.super[s];
    p.columns = L.super[s + 1] - p.first;
    p.rows = L.rows_begin[s + 1] - L.rows_begin[s];
    p.rows_begin = int32_t(rows_.size());
    p.values = at;
    const int32_t* rows = L.rows + L.rows_begin[s];
    rows_.insert(rows_.end(), rows + p.columns, rows + p.rows);
    max_columns_ = std::max(max_columns_, p.columns), max_rows_ = std::max(max_rows_, p.rows);
    const size_t nc = size_t(p.columns), nr = size_t(p.rows);
    const double* l = L.values + L.values_begin[s];  // l(i, j) = l[i + j ld]
    const size_t ld = SupernodalView::leading(nr);

    // M is the solution of M D = [I ; -L21]: columns from the last to the first.
    M.assign(nr * nc, 0);
    for (size_t j = 0; j < nc; ++j) {
      M[j + j * nr] = 1;
      for (size_t i = nc; i < nr; ++i) M[i + j * nr] = -l[i + j * ld];
    }
    for (size_t j = nc; j-- > 0;) {
      double* mj = &M[j * nr];
      for (size_t k = j + 1; k < nc; ++k) {
        const double f = l[k + j * ld];
        if (f == 0) continue;
        const double* mk = &M[k * nr];
        for (size_t i = k; i < nr; ++i) mj[i] -= f * mk[i];
      }
      const double inv = 1 / l[j + j * ld];
      for (size_t i = j; i < nr; ++i) mj[i] *= inv;
    }
    for (size_t i = 0; i < nr; ++i)
      for (size_t j = 0; j < nc; ++j) values_[at + (i / 16 * nc + j) * 16 + i % 16] = float(M[i + j * nr]);
    at += (nr + 15) / 16 * 16 * nc;
    panels_.push_back(p);
  }
  find_subtrees();
}

void PanelFactor::find_subtrees() {
  const size_t n = panels_.size();
  for (Panel& p : panels_) p.inside = p.rows;
  stretches_ = {{0, int32_t(n), false, 0, 0}};
  if (values_.size() < least_to_share) return;
  std::vector<int32_t> panel_of(size_t(n_), 0), parent(n, -1), first(n);
  std::vector<size_t> work(n, 0);
  for (size_t k = 0; k < n; ++k) {
    first[k] = int32_t(k);
    for (int32_t j = 0; j < panels_[k].columns; ++j) panel_of[size_t(panels_[k].first + j)] = int32_t(k);
  }
  size_t total = 0;
  for (size_t k = 0; k < n; ++k) {  // children come before their parents, a subtree is one stretch
    const Panel& p = panels_[k];
    work[k] += size_t(p.rows) * size_t(p.columns + 8);
    if (p.rows == p.columns) {
      total += work[k];
      continue;
    }
    const size_t up = size_t(parent[k] = panel_of[size_t(rows_[size_t(p.rows_begin)])]);
    work[up] += work[k];
    first[up] = std::min(first[up], first[k]);
  }
  // From the last panel down: what is small enough is a subtree,
  // what is not is top. Small neighbours are taken together.
  std::vector<Stretch> found;
  size_t taken = 0;  // work of the latest stretch of subtrees
  for (int32_t k = int32_t(n) - 1; k >= 0;) {
    const size_t own = work[size_t(k)];
    const bool subtree = own <= total / pieces, joins = !found.empty() && found.back().subtree == subtree;
    if (subtree) {
      if (joins && taken + own <= total / pieces)
        found.back().first = first[size_t(k)], taken += own;
      else
        found.push_back({first[size_t(k)], k + 1, true, 0, 0}), taken = own;
      k = first[size_t(k)] - 1;
    } else {
      if (joins)
        found.back().first = k;
      else
        found.push_back({k, k + 1, false, 0, 0});
      --k;
    }
  }
  std::reverse(found.begin(), found.end());
  stretches_ = std::move(found);
  for (size_t s = 0; s < stretches_.size(); ++s) {
    Stretch& t = stretches_[s];
    if (!t.subtree) continue;
    subtrees_.push_back(int32_t(s));
    const Panel& top = panels_[size_t(t.last) - 1];
    t.log = log_length_;
    for (int32_t k = t.first; k < t.last; ++k) {
      Panel& p = panels_[size_t(k)];
      while (p.inside > p.columns && rows_[size_t(p.rows_begin + p.inside - p.columns) - 1] >= top.first + top.columns)
        --p.inside;
      t.log_length += size_t(p.rows - p.inside);
    }
    log_length_ += t.log_length;
  }
  const auto size = [&](int32_t s) {
    const Stretch& t = stretches_[size_t(s)];
    return (size_t(t.last) < n ? panels_[size_t(t.last)].values : values_.size()) - panels_[size_t(t.first)].values;
  };
  std::stable_sort(subtrees_.begin(), subtrees_.end(), [&](int32_t a, int32_t b) { return size(a) > size(b); });
}

void PanelFactor::replay(const Stretch& s, Node4* y, const Node4* log) const {
  for (int32_t k = s.first; k < s.last; ++k) {
    const Panel& p = panels_[size_t(k)];
    const int32_t* rows = rows_.data() + p.rows_begin - p.columns;
    for (int32_t i = p.inside; i < p.rows; ++i, ++log) store(y[rows[i]], load(y[rows[i]]) + load(*log));
  }
}

void PanelFactor::solve(Node4* y, const Engine& engine) const {
  struct Scratch {
    NodeArray columns, rows;
    AlignedArray<float> x;
  };
  const size_t blocks = size_t(max_rows_ + 15) / 16;
  const auto scratch = [&] {
    static thread_local Scratch s;
    if (s.columns.size() < size_t(max_columns_)) s.columns.resize(size_t(max_columns_));
    if (s.rows.size() < 16 * blocks) s.rows.resize(16 * blocks);
    if (s.x.size() < 48 * blocks) s.x.resize(48 * blocks);
    return PanelScratch{s.columns.data(), s.rows.data(), s.x.data()};
  };
  const Kernels& k = engine.kernels();
  const PanelView view{panels_.data(), rows_.data(), values_.data()};
  const PanelScratch own = scratch();
  static thread_local NodeArray log_store;
  if (log_store.size() < log_length_) log_store.resize(log_length_);
  Node4* log = log_store.data();
  const bool shared = engine.workers().count() > 1 && subtrees_.size() > 1;
  const auto forward = [&](const Stretch& s, const PanelScratch& with) {
    k.panels_forward(view, size_t(s.first), size_t(s.last), y, log + s.log, with);
  };
  if (shared)
    engine.run(subtrees_.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) forward(stretches_[size_t(subtrees_[i])], scratch());
    });
  for (const Stretch& s : stretches_) {
    if (!s.subtree || !shared) forward(s, own);
    if (s.subtree) replay(s, y, log + s.log);
  }
  const auto backward = [&](const Stretch& s, const PanelScratch& with) {
    k.panels_backward(view, size_t(s.first), size_t(s.last), y, with);
  };
  for (size_t i = stretches_.size(); i-- > 0;)
    if (!stretches_[i].subtree || !shared) backward(stretches_[i], own);
  if (shared)
    engine.run(subtrees_.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) backward(stretches_[size_t(subtrees_[i])], scratch());
    });
}

}  // namespace limberg::fem
