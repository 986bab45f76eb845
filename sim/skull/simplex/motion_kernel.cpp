#include "sim/skull/simplex/motion_kernel.h"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace limberg::simplex {
namespace {

constexpr int kLanes = 8;
typedef double v8 __attribute__((vector_size(64)));
typedef int64_t m8 __attribute__((vector_size(64)));

inline v8 all(double a) { return v8{a, a, a, a, a, a, a, a}; }
inline v8 absolute(v8 a) { return a < 0 ? -a : a; }
inline v8 larger(v8 a, v8 b) { return a > b ? a : b; }
inline v8 smaller(v8 a, v8 b) { return a < b ? a : b; }
inline v8 root(v8 a) {
#ifdef __AVX512F__
  return (v8)_mm512_maskz_sqrt_pd(0xff, (__m512d)a);
#else
  v8 r;
  for (int l = 0; l < kLanes; ++l) r[l] = __builtin_sqrt(a[l]);
  return r;
#endif
}

struct V3 {
  v8 x, y, z;
};
inline V3 operator-(const V3& a, const V3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline V3 cross(const V3& a, const V3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline v8 dot(const V3& a, const V3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// atan2: the angle is halved three times, tan(a/2) = tan a / (1
/// + sqrt(1 + tan^2 a)), then the series of atan at |t| < 0.2.
inline v8 angle(v8 y, v8 x) {
  v8 t = y / (root(x * x + y * y) + absolute(x) + 1e-300);
  t = t / (1 + root(1 + t * t));
  t = t / (1 + root(1 + t * t));
  const v8 u = t * t;
  v8 s = all(-1. / 23);
  s = 1. / 21 + u * s, s = -1. / 19 + u * s, s = 1. / 17 + u * s, s = -1. / 15 + u * s, s = 1. / 13 + u * s,
  s = -1. / 11 + u * s;
  s = 1. / 9 + u * s, s = -1. / 7 + u * s, s = 1. / 5 + u * s, s = -1. / 3 + u * s, s = 1 + u * s;
  const v8 half_turn = y < 0 ? all(-3.14159265358979323846) : all(3.14159265358979323846);
  const v8 a = 8 * (t * s);
  return x < 0 ? half_turn - a : a;
}

/// sin and cos for |a| <= pi: quarter turns taken out, Taylor series on +-pi/4.
inline void sine_cosine(v8 a, v8& s, v8& c) {
  constexpr double magic = 6755399441055744.;  // 1.5 * 2^52: adding it rounds to a whole number
  const v8 n = (a * 0.63661977236758134308 + magic) - magic;
  const v8 y = (a - n * 1.5707963267948966192) - n * 6.123233995736766e-17, u = y * y;
  v8 p = all(1. / 355687428096000.);
  p = -1. / 1307674368000. + u * p, p = 1. / 6227020800. + u * p, p = -1. / 39916800. + u * p, p = 1. / 362880. + u * p;
  p = -1. / 5040. + u * p, p = 1. / 120. + u * p, p = -1. / 6. + u * p;
  const v8 sy = y + y * (u * p);
  v8 q = all(1. / 20922789888000.);
  q = -1. / 87178291200. + u * q, q = 1. / 479001600. + u * q, q = -1. / 3628800. + u * q, q = 1. / 40320. + u * q;
  q = -1. / 720. + u * q, q = 1. / 24. + u * q;
  const v8 cy = 1 - 0.5 * u + (u * u) * q;
  const m8 odd = absolute(n) == 1, turned = absolute(n) == 2;
  s = odd ? (n > 0 ? cy : -cy) : sy;
  c = odd ? (n > 0 ? -sy : sy) : cy;
  s = turned ? -s : s;
  c = turned ? -c : c;
}

struct Group {  // eight vertices and their geometry (vertex_shape.h)
  size_t v[kLanes];
  V3 b, c, p, N;  // B - A, C - A, P - A; N unit, zero when degenerate
  v8 area2, r, L, l1, l2, l3, e2, e3, k;
  m8 bad;
};

inline V3 load(const double* x, const size_t* v) {
  V3 o;
  for (int l = 0; l < kLanes; ++l) o.x[l] = x[3 * v[l]], o.y[l] = x[3 * v[l] + 1], o.z[l] = x[3 * v[l] + 2];
  return o;
}

/// Neighbours that will be needed a few groups later are fetched
/// into the cache: meshes of 10^5 vertices and more do not fit.
inline void fetch(const KernelView& k, size_t first, size_t end) {
  constexpr size_t kAhead = 6 * kLanes;
  if (first + kAhead + kLanes > end) return;
  const int32_t* n = k.nbr + 3 * (first + kAhead);
  for (int j = 0; j < 3 * kLanes; ++j)
    if (n[j] >= 0) __builtin_prefetch(k.x + 3 * size_t(n[j]));
}

inline void gather(const KernelView& k, size_t first, size_t end, Group& g, V3& A) {
  if (k.large) fetch(k, first, end);
  size_t n[3][kLanes];
  for (int l = 0; l < kLanes; ++l) {
    const size_t v = first + size_t(l) < end ? first + size_t(l) : end - 1;
    g.v[l] = v;
    for (int j = 0; j < 3; ++j) {
      const int32_t u = k.nbr[3 * v + size_t(j)];
      n[j][l] = u < 0 ? v : size_t(u);
    }
  }
  A = load(k.x, n[0]);
  g.b = load(k.x, n[1]) - A, g.c = load(k.x, n[2]) - A, g.p = load(k.x, g.v) - A;
}

inline void measure(Group& g) {
  const V3 n = cross(g.b, g.c);
  const v8 s = dot(n, n);
  const V3 bc = g.c - g.b;
  g.l1 = dot(g.b, g.b), g.l2 = dot(bc, bc), g.l3 = dot(g.c, g.c);
  const v8 most = larger(larger(g.l1, g.l2), g.l3);
  g.bad = s <= (1e-9 * most) * (1e-9 * most);  // kDegenerateTriangle
  const v8 inverse = g.bad ? all(0) : 1 / (g.bad ? all(1) : s), one = root(inverse);
  g.area2 = s * one;
  g.N = {n.x * one, n.y * one, n.z * one};
  g.r = 0.5 * one * root(g.l1 * g.l2 * g.l3);
  g.L = dot(g.p, g.N);
  g.e2 = dot(cross(g.p, g.c), n) * inverse;
  g.e3 = dot(cross(g.b, g.p), n) * inverse;
  const v8 e1 = 1 - g.e2 - g.e3;
  g.k = e1 * g.e2 * g.l1 + g.e2 * g.e3 * g.l2 + g.e3 * e1 * g.l3;
}

/// P~ - A.
inline V3 target(const KernelView& k, const Group& g, const KernelZone* const law[kLanes]) {
  enum { position, tangent, by_angle, by_curvature, by_shape };
  v8 e1 = all(0), e2 = all(0), s = all(0), c = all(1), sigma = all(1), height = all(0), mean = all(0);
  m8 keeps = {0}, scaled = {0}, angles = {0}, curves = {0};
  bool any_angle = false, any_curve = false;
  for (int l = 0; l < kLanes; ++l) {
    const size_t v = g.v[l];
    const int32_t kind = law[l]->constraint;
    if (kind == by_shape) {
      const KernelShape& f = k.shape[v];
      e1[l] = f.e1, e2[l] = f.e2, s[l] = f.sin_phi, c[l] = f.cos_phi, height[l] = f.height;
      if (f.branch == 0)
        scaled[l] = -1;
      else
        sigma[l] = f.branch;
      continue;
    }
    e1[l] = k.metric[2 * v], e2[l] = k.metric[2 * v + 1];
    if (kind == position) {
      keeps[l] = -1;
    } else if (kind == tangent) {
      scaled[l] = -1;
    } else {
      const double* of = kind == by_angle ? k.phi : k.H;
      double sum = 0;
      if (law[l]->rigidity <= 1) {
        const int32_t* u = k.nbr + 3 * v;
        if (u[0] >= 0) sum = 0.25 * ((of[v] + of[size_t(u[0])]) + (of[size_t(u[1])] + of[size_t(u[2])]));
      } else {
        const size_t a = k.near_first[v], b = k.near_first[v + 1];
        for (size_t i = a; i < b; ++i) sum += of[size_t(k.near[i])];
        sum /= double(b > a ? b - a : 1);
      }
      mean[l] = sum;
      if (kind == by_angle)
        angles[l] = -1, any_angle = true;
      else
        curves[l] = -1, any_curve = true;
    }
  }
  if (any_angle) {
    v8 sa, ca;
    sine_cosine(mean, sa, ca);
    s = angles ? sa : s, c = angles ? ca : c;
  }
  if (any_curve) {
    const v8 sa = larger(smaller(g.r * mean, all(1)), all(-1));
    s = curves ? sa : s, c = curves ? root(1 - sa * sa) : c;
  }
  const v8 e3 = 1 - e1 - e2;
  const v8 kk = e1 * e2 * g.l1 + e2 * e3 * g.l2 + e3 * e1 * g.l3;
  // The height from the angle: vertex_shape.h, height_from_angle.
  const v8 rc = g.r * c, q = sigma * root(larger(rc * rc + kk * s * s, all(0)));
  const m8 sum = (rc * q >= 0) & (rc + q != 0);
  const v8 top = sum ? kk * s : q - rc, bottom = sum ? rc + q : s;
  v8 L = top / (bottom == 0 ? all(1) : bottom);
  // No height has that angle, or one out of all proportion: not farther than ten times the size of what is there.
  const v8 far = 10 * (g.r + absolute(g.L));
  L = bottom == 0 ? g.L : larger(smaller(L, far), -far);
  L = scaled ? height * root(g.area2) : L;
  L = keeps ? g.L : L;
  L = g.bad ? all(0) : L;
  return {e2 * g.b.x + e3 * g.c.x + L * g.N.x, e2 * g.b.y + e3 * g.c.y + L * g.N.y,
          e2 * g.b.z + e3 * g.c.z + L * g.N.z};
}

inline void laws(const KernelView& k, const Group& g, const KernelZone* law[kLanes]) {
  for (int l = 0; l < kLanes; ++l) {
    const int32_t z = k.zone[g.v[l]];
    law[l] = k.law + (z < k.zones ? z : k.zones - 1);
  }
}

}  // namespace

void kernel_curvature(const KernelView& k, size_t begin, size_t end, double* phi, double* H) {
  for (size_t i = begin; i < end; i += kLanes) {
    Group g;
    V3 A;
    gather(k, i, end, g, A);
    measure(g);
    const v8 y = 2 * g.r * g.L, x = g.k - g.L * g.L;
    const size_t n = end - i < size_t(kLanes) ? end - i : size_t(kLanes);
    if (phi) {
      const m8 far = (g.k < 0) & (g.L * g.L < -g.k);
      const v8 a = g.bad ? all(0) : angle(y, far ? -x : x);
      for (size_t l = 0; l < n; ++l) phi[i + l] = a[l];
    }
    if (H) {
      // sin(phi) / r = 2 L / |(y, x)|.
      const v8 h = root(x * x + y * y), a = (h > 0) & (g.bad == 0) ? 2 * g.L / (h > 0 ? h : all(1)) : all(0);
      for (size_t l = 0; l < n; ++l) H[i + l] = a[l];
    }
  }
}

KernelSums kernel_step(const KernelView& k, size_t begin, size_t end, double* before) {
  KernelSums sums;
  for (size_t i = begin; i < end; i += kLanes) {
    Group g;
    V3 A;
    gather(k, i, end, g, A);
    measure(g);
    const KernelZone* law[kLanes];
    laws(k, g, law);
    const V3 t = target(k, g, law);
    v8 alpha, keep = all(k.keep);
    for (int l = 0; l < kLanes; ++l) {
      const size_t v = g.v[l];
      // kLocked; alpha < 0: fixed zone
      const bool moves = (k.flags[v] & 1) == 0 && law[l]->alpha >= 0 && k.nbr[3 * v] >= 0;
      alpha[l] = moves ? law[l]->alpha : 0;
      if (!moves) keep[l] = 0;
    }
    const V3 P = load(k.x, g.v), old = load(before, g.v);
    V3 d{keep * (P.x - old.x) + alpha * (t.x - g.p.x), keep * (P.y - old.y) + alpha * (t.y - g.p.y),
         keep * (P.z - old.z) + alpha * (t.z - g.p.z)};
    if (k.ext || k.push) {
      for (int l = 0; l < kLanes; ++l) {
        const size_t v = g.v[l];
        if ((k.flags[v] & 1) != 0 || law[l]->alpha < 0 || k.nbr[3 * v] < 0) continue;
        const double beta = law[l]->beta;
        if (k.ext) d.x[l] += beta * k.ext[3 * v], d.y[l] += beta * k.ext[3 * v + 1], d.z[l] += beta * k.ext[3 * v + 2];
        if (k.push) d.x[l] += k.push[3 * v], d.y[l] += k.push[3 * v + 1], d.z[l] += k.push[3 * v + 2];
      }
    }
    v8 move2 = dot(d, d);
    const v8 limit = all(k.max_step_mm);
    const m8 over = move2 > limit * limit;
    const v8 shorten = over ? limit / root(over ? move2 : all(1)) : all(1);
    d = {d.x * shorten, d.y * shorten, d.z * shorten};
    move2 = move2 * shorten * shorten;
    const V3 next{P.x + d.x, P.y + d.y, P.z + d.z};
    const size_t n = end - i < size_t(kLanes) ? end - i : size_t(kLanes);
    for (size_t l = 0; l < n; ++l) {
      double* to = before + 3 * (i + l);
      to[0] = next.x[l], to[1] = next.y[l], to[2] = next.z[l];
      sums.sum_move2 += move2[l];
      if (!(move2[l] <= sums.max_move2)) sums.max_move2 = move2[l];
    }
  }
  return sums;
}

void kernel_force(const KernelView& k, size_t begin, size_t end, double* force) {
  for (size_t i = begin; i < end; i += kLanes) {
    Group g;
    V3 A;
    gather(k, i, end, g, A);
    measure(g);
    const KernelZone* law[kLanes];
    laws(k, g, law);
    const V3 t = target(k, g, law);
    const size_t n = end - i < size_t(kLanes) ? end - i : size_t(kLanes);
    for (size_t l = 0; l < n; ++l) {
      double* to = force + 3 * (i + l);
      to[0] = t.x[l] - g.p.x[l], to[1] = t.y[l] - g.p.y[l], to[2] = t.z[l] - g.p.z[l];
    }
  }
}

}  // namespace limberg::simplex
