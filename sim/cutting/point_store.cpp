#include "sim/cutting/point_store.h"

#include <algorithm>

namespace limberg {

namespace {

uint64_t mod_inverse(uint64_t a) {  // Fermat: a^(p - 2)
  uint64_t r = 1, e = kPrime - 2;
  for (; e != 0; e >>= 1, a = mod_mul(a, a))
    if (e & 1) r = mod_mul(r, a);
  return r;
}

}  // namespace

int32_t PointStore::add_explicit(const Int3& p) {
  approx_.emplace_back(p.x, p.y, p.z);
  implicit_of_.push_back(-1);
  return size() - 1;
}

int32_t PointStore::line_plane(int32_t a, int32_t b, int32_t tri, const Plane& plane) {
  if (a > b) std::swap(a, b);
  const PointKey key{PointKey::line_plane, {a, b, tri}};
  const auto it = find_.find(key);
  return it != find_.end() ? it->second : add_implicit(key, limberg::line_plane(integer(a), integer(b), plane));
}

int32_t PointStore::three_planes(std::array<int32_t, 3> tri, const Plane& p0, const Plane& p1, const Plane& p2) {
  std::sort(tri.begin(), tri.end());
  const PointKey key{PointKey::three_planes, tri};
  const auto it = find_.find(key);
  return it != find_.end() ? it->second : add_implicit(key, limberg::three_planes(p0, p1, p2));
}

int32_t PointStore::add_implicit(const PointKey& key, const Homogeneous& h) {
  const int32_t id = size();
  Implicit made{h, key, {}};
  const uint64_t w = mod_inverse(h.w.mod(kPrime));
  for (size_t i = 0; i < 3; ++i) made.residue[i] = mod_mul(h.x[i].mod(kPrime), w);
  approx_.push_back(approximate(h));
  implicit_of_.push_back(int32_t(implicit_.size()));
  implicit_.push_back(made);
  find_.emplace(key, id);
  return id;
}

void PointStore::truncate(int32_t n) {
  while (size() > n) {
    if (implicit_of_.back() >= 0) {
      find_.erase(implicit_.back().key);
      implicit_.pop_back();
    }
    implicit_of_.pop_back();
    approx_.pop_back();
  }
}

Residues PointStore::residues(int32_t i) const {
  if (!is_explicit(i)) return implicit_[implicit_of_[i]].residue;
  const Vec3& p = approx_[i];
  Residues r;
  for (int k = 0; k < 3; ++k) r[size_t(k)] = p[k] < 0 ? kPrime - uint64_t(-p[k]) : uint64_t(p[k]);
  return r;
}

}  // namespace limberg
