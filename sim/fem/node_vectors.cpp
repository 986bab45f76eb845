#include "sim/fem/node_vectors.h"

#include <cmath>

namespace limberg::fem {
namespace {

// Arrays are padded to 64 bytes and the padding is zero, so every loop runs over whole vectors.
size_t vectors(const NodeArray& a) { return (a.size() + 3) / 4; }
v16* wide(NodeArray& a) { return reinterpret_cast<v16*>(a.data()); }
const v16* wide(const NodeArray& a) { return reinterpret_cast<const v16*>(a.data()); }

constexpr size_t block = 32;  // vectors summed in float before they go to double

double sum(v16 v) {
  double s = 0;
  for (int i = 0; i < 16; ++i) s += double(v[i]);
  return s;
}

}  // namespace

double dot(const NodeArray& a, const NodeArray& b) {
  const v16 *p = wide(a), *q = wide(b);
  const size_t n = vectors(a);
  double total = 0;
  for (size_t i = 0; i < n;) {
    const size_t end = i + block < n ? i + block : n;
    v16 s0 = {}, s1 = {};
    for (; i + 1 < end; i += 2) s0 += p[i] * q[i], s1 += p[i + 1] * q[i + 1];
    if (i < end) s0 += p[i] * q[i], ++i;
    total += sum(s0 + s1);
  }
  return total;
}

void add_scaled(NodeArray& y, double s, const NodeArray& x) {
  v16* p = wide(y);
  const v16* q = wide(x);
  const float f = float(s);
  const size_t n = vectors(y);
  for (size_t i = 0; i < n; ++i) p[i] += f * q[i];
}

double add_scaled_dot(NodeArray& y, double s, const NodeArray& x, const NodeArray& z) {
  v16* p = wide(y);
  const v16 *q = wide(x), *r = wide(z);
  const float f = float(s);
  const size_t n = vectors(y);
  double total = 0;
  for (size_t i = 0; i < n;) {
    const size_t end = i + block < n ? i + block : n;
    v16 s0 = {}, s1 = {};
    for (; i + 1 < end; i += 2) {
      const v16 a = p[i] + f * q[i], b = p[i + 1] + f * q[i + 1];
      p[i] = a, p[i + 1] = b;
      s0 += a * r[i], s1 += b * r[i + 1];
    }
    if (i < end) {
      const v16 a = p[i] + f * q[i];
      p[i] = a, s0 += a * r[i], ++i;
    }
    total += sum(s0 + s1);
  }
  return total;
}

void combine(NodeArray& out, const NodeArray& a, double s, const NodeArray& b) {
  v16* o = wide(out);
  const v16 *p = wide(a), *q = wide(b);
  const float f = float(s);
  const size_t n = vectors(out);
  for (size_t i = 0; i < n; ++i) o[i] = p[i] + f * q[i];
}

void subtract(NodeArray& out, const NodeArray& a, const NodeArray& b) {
  v16* o = wide(out);
  const v16 *p = wide(a), *q = wide(b);
  const size_t n = vectors(out);
  for (size_t i = 0; i < n; ++i) o[i] = p[i] - q[i];
}

void subtract_outer(NodeArray& y, const float* const* columns, const Node4* s, int count) {
#ifdef __AVX512F__
  // Four nodes at a time: the column's four numbers are each spread over a lane.
  const v16i spread = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
  v16* p = wide(y);
  const size_t n = vectors(y);
  for (size_t i = 0; i < n; ++i) {
    v16 a = p[i], b = {};
    int j = 0;
    for (; j + 1 < count; j += 2) {
      a -= __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_load_ps(columns[j] + 4 * i)), spread) * in_every_lane(s + j);
      b += __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_load_ps(columns[j + 1] + 4 * i)), spread) * in_every_lane(s + j + 1);
    }
    if (j < count)
      a -= __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_load_ps(columns[j] + 4 * i)), spread) * in_every_lane(s + j);
    p[i] = a - b;
  }
#else
  for (size_t i = 0; i < y.size(); ++i) {
    v4 a = load(y[i]);
    for (int j = 0; j < count; ++j) a -= columns[j][i] * load(s[j]);
    store(y[i], a);
  }
#endif
}

double max_node(const NodeArray& a) {
  double m = 0;
  for (const Node4& v : a) {
    const double s = double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z;
    if (s != s) return s;
    if (s > m) m = s;
  }
  return std::sqrt(m);
}

bool all_finite(const NodeArray& a) {
  const v16* p = wide(a);
  const size_t n = vectors(a);
  v16 s = {};
  for (size_t i = 0; i < n; ++i) s += p[i] * 0.0f;  // 0 for a finite number, NaN for any other
  for (int i = 0; i < 16; ++i)
    if (!(s[i] == 0.0f)) return false;
  return true;
}

}  // namespace limberg::fem
