#include "sim/cutting/arrangement/point_store.h"

#include <algorithm>

namespace limberg {

namespace {

uint64_t mod_inverse(uint64_t a) {  // Fermat: a^(p - 2)
  uint64_t r = 1, e = kPrime - 2;
  for (; e != 0; e >>= 1, a = mod_mul(a, a))
    if (e & 1) r = mod_mul(r, a);
  return r;
}

// value mod 2^61 - 1, in which 2^64 = 8.
uint64_t mod_prime(const Int256& value) {
  const bool negative = value.negative();
  const Int256 m = negative ? -value : value;
  size_t top = 4;
  while (top > 0 && m.limb[top - 1] == 0) --top;
  uint64_t r = 0;
  for (size_t i = top; i-- > 0;) {
    const uint128 t = (uint128(r) << 3) + m.limb[i];
    r = uint64_t(t & kPrime) + uint64_t(t >> 61);
    if (r >= kPrime) r -= kPrime;
  }
  return negative && r != 0 ? kPrime - r : r;
}
uint64_t mod_prime(const int128& value) {  // below 2^122
  const uint128 m = value < 0 ? -uint128(value) : uint128(value);
  uint64_t r = uint64_t(m & kPrime) + uint64_t(m >> 61);
  if (r >= kPrime) r -= kPrime;
  return value < 0 && r != 0 ? kPrime - r : r;
}

}  // namespace

void PointStore::make_room() {
  const auto one_more = [](auto& v) {
    if (v.size() == v.capacity()) v.reserve(2 * v.size() + 64);
  };
  one_more(approx_), one_more(implicit_of_), one_more(implicit_);
}

int32_t PointStore::add_explicit(const Int3& p) {
  make_room();
  approx_.emplace_back(p.x, p.y, p.z);
  implicit_of_.push_back(-1);
  return size() - 1;
}

int32_t PointStore::line_plane(int32_t a, int32_t b, int32_t tri, const Plane& plane) {
  if (a > b) std::swap(a, b);
  const PointKey key{PointKey::line_plane, {a, b, tri}};
  const size_t at = place_for(key);
  if (const int32_t i = table_[at].index; i >= 0) return implicit_[size_t(i)].point;
  make_room();
  line_plane_.push_back(limberg::line_plane(integer(a), integer(b), plane));
  return add_implicit(at, key, approximate(line_plane_.back()), int32_t(line_plane_.size()) - 1);
}

int32_t PointStore::three_planes(std::array<int32_t, 3> tri, const Plane& p0, const Plane& p1, const Plane& p2) {
  std::sort(tri.begin(), tri.end());
  const PointKey key{PointKey::three_planes, tri};
  const size_t at = place_for(key);
  if (const int32_t i = table_[at].index; i >= 0) return implicit_[size_t(i)].point;
  make_room();
  three_planes_.push_back(limberg::three_planes(p0, p1, p2));
  return add_implicit(at, key, approximate(three_planes_.back()), int32_t(three_planes_.size()) - 1);
}

size_t PointStore::place_for(const PointKey& key) {
  if ((implicit_.size() + 1) * 4 > table_.size()) {
    table_.assign(std::max<size_t>(256, table_.size() * 4), {});
    for (size_t i = 0; i < implicit_.size(); ++i) {
      const uint64_t h = hash(implicit_[i].key);
      table_[place(implicit_[i].key, h)] = {uint32_t(h >> 32), int32_t(i)};
    }
  }
  return place(key, hash(key));
}

int32_t PointStore::add_implicit(size_t at, const PointKey& key, const Vec3& approx, int32_t form) {
  const int32_t id = size();
  approx_.push_back(approx);
  implicit_of_.push_back(int32_t(implicit_.size()));
  implicit_.push_back({key, id, form});
  table_[at] = {uint32_t(hash(key) >> 32), int32_t(implicit_.size()) - 1};
  return id;
}

void PointStore::truncate(int32_t n) {
  while (size() > n) {
    if (implicit_of_.back() >= 0) {
      const Implicit& last = implicit_.back();
      table_[place(last.key, hash(last.key))].index = -1;
      if (last.is_line_plane())
        line_plane_.resize(size_t(last.form));
      else
        three_planes_.resize(size_t(last.form));
      implicit_.pop_back();
    }
    implicit_of_.pop_back();
    approx_.pop_back();
  }
  residue_.resize(std::min(residue_.size(), implicit_.size()));
}

void PointStore::settle() {
  // x_i / w_i for all i with one inverse: products of w up to each point, the inverse of the last, and back. The
  // product before a point waits in the place of its first residue, w in that of its second.
  const size_t from = residue_.size();
  if (from == implicit_.size()) return;
  residue_.resize(implicit_.size());
  const auto residues_of = [&](const auto& form, uint64_t own) {  // of x / w, when 1 / w is known
    return Residues{mod_mul(mod_prime(form.x[0]), own), mod_mul(mod_prime(form.x[1]), own),
                    mod_mul(mod_prime(form.x[2]), own)};
  };
  uint64_t product = 1;
  for (size_t i = from; i < implicit_.size(); ++i) {
    const auto form = size_t(implicit_[i].form);
    const uint64_t w = implicit_[i].is_line_plane() ? mod_prime(line_plane_[form].w) : mod_prime(three_planes_[form].w);
    residue_[i] = {product, w, 0};
    if (w != 0) product = mod_mul(product, w);
  }
  uint64_t inverse = mod_inverse(product);
  for (size_t i = implicit_.size(); i-- > from;) {
    const uint64_t before = residue_[i][0], w = residue_[i][1];
    const uint64_t own = w != 0 ? mod_mul(inverse, before) : 0;
    if (w != 0) inverse = mod_mul(inverse, w);
    const auto form = size_t(implicit_[i].form);
    residue_[i] =
        implicit_[i].is_line_plane() ? residues_of(line_plane_[form], own) : residues_of(three_planes_[form], own);
  }
}

}  // namespace limberg
