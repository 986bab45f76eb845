#include "sim/imaging/fit/thinning.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

namespace limberg {
namespace {

constexpr double kOff = 0.12;

class Thinning {
 public:
  Thinning(std::vector<Vec3>& X_mm, std::vector<Tri>& tri, const LevelSet& set)
      : X_(X_mm), tri_(tri), set_(set), of_(X_mm.size()) {
    for (size_t t = 0; t < tri.size(); ++t)
      for (const int32_t v : tri[t]) of_[size_t(v)].push_back(int32_t(t));
  }
  void run(const std::function<double(const Vec3&)>& edge_mm) {
    std::set<std::tuple<double, int32_t, int32_t>> todo;
    const auto add = [&](int32_t a, int32_t b) {
      const double length = (X_[size_t(a)] - X_[size_t(b)]).norm();
      if (length < edge_mm((X_[size_t(a)] + X_[size_t(b)]) / 2)) todo.emplace(length, std::min(a, b), std::max(a, b));
    };
    for (const Tri& t : tri_)
      for (size_t k = 0; k < 3; ++k)
        if (t[k] < t[(k + 1) % 3]) add(t[k], t[(k + 1) % 3]);
    while (!todo.empty()) {
      const auto [length, a, b] = *todo.begin();
      todo.erase(todo.begin());
      if (of_[size_t(a)].empty() || of_[size_t(b)].empty() || (X_[size_t(a)] - X_[size_t(b)]).norm() != length)
        continue;
      if (!collapse(a, b, edge_mm)) continue;
      for (const int32_t n : neighbours(a)) add(a, n);
    }
    std::vector<int32_t> number(X_.size(), -1);
    std::vector<Vec3> X;
    std::vector<Tri> tri;
    for (const Tri& t : tri_) {
      if (t[0] < 0) continue;
      Tri u = t;
      for (int32_t& v : u) {
        if (number[size_t(v)] < 0) number[size_t(v)] = int32_t(X.size()), X.push_back(X_[size_t(v)]);
        v = number[size_t(v)];
      }
      tri.push_back(u);
    }
    X_ = std::move(X), tri_ = std::move(tri);
  }

 private:
  std::set<int32_t> neighbours(int32_t v) const {
    std::set<int32_t> out;
    for (const int32_t t : of_[size_t(v)])
      for (const int32_t w : tri_[size_t(t)])
        if (w != v) out.insert(w);
    return out;
  }
  Vec3 normal(const Tri& t, int32_t moved, int32_t also, const Vec3& to) const {
    const auto at = [&](int32_t v) { return v == moved || v == also ? to : X_[size_t(v)]; };
    return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
  }
  bool collapse(int32_t a, int32_t b, const std::function<double(const Vec3&)>& edge_mm) {
    const std::set<int32_t> na = neighbours(a), nb = neighbours(b);
    std::vector<int32_t> both;
    std::set_intersection(na.begin(), na.end(), nb.begin(), nb.end(), std::back_inserter(both));
    if (both.size() != 2 || !na.contains(b)) return false;
    for (const int32_t v : both)
      if (of_[size_t(v)].size() < 4) return false;
    Vec3 to = (X_[size_t(a)] + X_[size_t(b)]) / 2;
    if (!put_on_surface(set_, to, 1)) return false;
    for (const int32_t v : {a, b})
      for (const int32_t t : of_[size_t(v)]) {
        const Tri& c = tri_[size_t(t)];
        if (std::count(c.begin(), c.end(), a) && std::count(c.begin(), c.end(), b)) continue;
        const Vec3 was = normal(c, -1, -1, to), is = normal(c, a, b, to);
        if (!(was.dot(is) > 0.5 * was.norm() * is.norm())) return false;
        Vec3 middle = Vec3::Zero();
        for (const int32_t w : c) middle += (w == v ? to : X_[size_t(w)]) / 3;
        if (!(std::abs(level_at(set_, middle).distance_mm) < kOff * edge_mm(to))) return false;
        for (const int32_t w : c)
          if (w != v && (X_[size_t(w)] - to).norm() > 2 * edge_mm(to)) return false;
      }
    X_[size_t(a)] = to;
    for (const int32_t t : of_[size_t(b)]) {
      Tri& c = tri_[size_t(t)];
      if (std::count(c.begin(), c.end(), a)) {
        for (const int32_t w : c)
          if (w != b) std::erase(of_[size_t(w)], t);
        c = {-1, -1, -1};
        continue;
      }
      std::replace(c.begin(), c.end(), b, a);
      of_[size_t(a)].push_back(t);
    }
    of_[size_t(b)].clear();
    return true;
  }
  std::vector<Vec3>& X_;
  std::vector<Tri>& tri_;
  const LevelSet& set_;
  std::vector<std::vector<int32_t>> of_;
};

}  // namespace

void thin_edges(std::vector<Vec3>& X_mm, std::vector<Tri>& tri, const LevelSet& set,
                const std::function<double(const Vec3&)>& edge_mm) {
  Thinning(X_mm, tri, set).run(edge_mm);
}

void keep_largest(std::vector<Vec3>& X_mm, std::vector<Tri>& triangles) {
  std::vector<int32_t> root(X_mm.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int32_t v) {
    while (root[size_t(v)] != v) v = root[size_t(v)] = root[size_t(root[size_t(v)])];
    return v;
  };
  for (const Tri& t : triangles)
    for (size_t k = 1; k < 3; ++k) {
      const int32_t a = find(t[0]), b = find(t[k]);
      root[size_t(std::max(a, b))] = std::min(a, b);
    }
  std::map<int32_t, size_t> count;
  for (const Tri& t : triangles) ++count[find(t[0])];
  int32_t most = -1;
  for (const auto& [r, n] : count)
    if (most < 0 || n > count[most]) most = r;
  std::vector<int32_t> number(X_mm.size(), -1);
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  for (const Tri& t : triangles) {
    if (find(t[0]) != most) continue;
    Tri u = t;
    for (int32_t& v : u) {
      if (number[size_t(v)] < 0) number[size_t(v)] = int32_t(X.size()), X.push_back(X_mm[size_t(v)]);
      v = number[size_t(v)];
    }
    tri.push_back(u);
  }
  X_mm = std::move(X), triangles = std::move(tri);
}

}  // namespace limberg
