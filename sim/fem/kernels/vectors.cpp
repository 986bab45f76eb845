// Vectors of nodes. Arrays are padded to 64 bytes and the padding is zero, so every loop runs over whole vectors.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

constexpr size_t block = 32;  // vectors of four nodes whose sums stay in float

inline size_t end_of(size_t nodes, size_t last_block) {
  const size_t n = (nodes + 3) / 4;
  return last_block * block < n ? last_block * block : n;
}
inline v16* wide(Node4* a) { return reinterpret_cast<v16*>(a); }
inline const v16* wide(const Node4* a) { return reinterpret_cast<const v16*>(a); }

}  // namespace

void dot(const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last, double* sums) {
  const v16 *p = wide(a), *q = wide(b);
  for (size_t k = first; k < last; ++k) {
    size_t i = k * block;
    const size_t end = end_of(nodes, k + 1);
    v16 s0 = {}, s1 = {};
    for (; i + 1 < end; i += 2) s0 += p[i] * q[i], s1 += p[i + 1] * q[i + 1];
    if (i < end) s0 += p[i] * q[i];
    sums[k] = sum(s0 + s1);
  }
}

void add_scaled(Node4* y, float s, const Node4* x, size_t nodes, size_t first, size_t last) {
  v16* p = wide(y);
  const v16* q = wide(x);
  const size_t n = end_of(nodes, last);
  for (size_t i = first * block; i < n; ++i) p[i] += s * q[i];
}

void add_scaled_dot(Node4* y, float s, const Node4* x, const Node4* z, size_t nodes, size_t first, size_t last,
                    double* sums) {
  v16* p = wide(y);
  const v16 *q = wide(x), *r = wide(z);
  for (size_t k = first; k < last; ++k) {
    size_t i = k * block;
    const size_t end = end_of(nodes, k + 1);
    v16 s0 = {}, s1 = {};
    for (; i + 1 < end; i += 2) {
      const v16 a = p[i] + s * q[i], b = p[i + 1] + s * q[i + 1];
      p[i] = a, p[i + 1] = b;
      s0 += a * r[i], s1 += b * r[i + 1];
    }
    if (i < end) {
      const v16 a = p[i] + s * q[i];
      p[i] = a, s0 += a * r[i];
    }
    sums[k] = sum(s0 + s1);
  }
}

void combine(Node4* out, const Node4* a, float s, const Node4* b, size_t nodes, size_t first, size_t last) {
  v16* o = wide(out);
  const v16 *p = wide(a), *q = wide(b);
  const size_t n = end_of(nodes, last);
  for (size_t i = first * block; i < n; ++i) o[i] = p[i] + s * q[i];
}

void subtract(Node4* out, const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last) {
  v16* o = wide(out);
  const v16 *p = wide(a), *q = wide(b);
  const size_t n = end_of(nodes, last);
  for (size_t i = first * block; i < n; ++i) o[i] = p[i] - q[i];
}

// Four nodes at a time: the column's four numbers are each spread over a lane.
void subtract_outer(Node4* y, const float* const* columns, const Node4* s, int count, size_t nodes, size_t first,
                    size_t last) {
  v16* p = wide(y);
  const size_t n = end_of(nodes, last);
  for (size_t i = first * block; i < n; ++i) {
    v16 a = p[i], b = {};
    int j = 0;
    for (; j + 1 < count; j += 2) {
      a -= spread(columns[j] + 4 * i) * in_every_lane(s + j);
      b += spread(columns[j + 1] + 4 * i) * in_every_lane(s + j + 1);
    }
    if (j < count) a -= spread(columns[j] + 4 * i) * in_every_lane(s + j);
    p[i] = a - b;
  }
}

void max_square(const Node4* a, size_t nodes, size_t first, size_t last, double* sums) {
  for (size_t k = first; k < last; ++k) {
    const size_t end = 4 * (k + 1) * block < nodes ? 4 * (k + 1) * block : nodes;
    double m = 0;
    for (size_t i = 4 * k * block; i < end; ++i) {
      const double s =
          double(a[i].x) * double(a[i].x) + double(a[i].y) * double(a[i].y) + double(a[i].z) * double(a[i].z);
      if (s > m) m = s;
      if (s != s) {
        m = s;
        break;
      }
    }
    sums[k] = m;
  }
}

bool all_finite(const Node4* a, size_t nodes, size_t first, size_t last) {
  const v16* p = wide(a);
  const size_t n = end_of(nodes, last);
  v16 s = {};
  for (size_t i = first * block; i < n; ++i) s += p[i] * 0.0f;  // 0 for a finite number, NaN for any other
  return sum(s) == 0;
}

}  // namespace limberg::fem::LIMBERG_SET
