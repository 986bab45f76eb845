// Moving a tissue, and what it does to the face.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/rotation.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {
namespace {

constexpr size_t kGrain = 1024;
constexpr double kReach = 0.25;  // of a spring's length, in one iteration

bool moves(const Tissue& t, size_t v) { return t.role[v] == TissueRole::inside || t.role[v] == TissueRole::side; }

typedef double v4 __attribute__((vector_size(32)));  // one lane per edge
inline v4 all(double a) { return v4{a, a, a, a}; }
inline double total(const v4& a) { return (a[0] + a[1]) + (a[2] + a[3]); }

/// What its four edges do to a vertex, in one pass over them and
/// without branches: they are most of the cost of an iteration.
struct Edges {
  Vec3 force_mN = Vec3::Zero();  // of the springs
  double tangent = 0;            // sum of their tangent stiffnesses, mN/mm
  Vec3 mean_mm = Vec3::Zero();   // sum k_ij (P_j - P_i) / sum k_ij
};
/// The largest elongation of the springs goes to `longest` (never less than it was).
template <bool with_springs, bool with_mean>
inline Edges edges(const Tissue& t, size_t v, const SpringLaw& law, double& longest) {
  Edges out;
  v4 x, y, z, k, l0;
  const Vec3& at = t.x_mm[v];
  for (size_t j = 0; j < 4; ++j) {
    const Vec3& u = t.x_mm[size_t(t.nbr[v][j])];
    x[j] = u.x() - at.x(), y[j] = u.y() - at.y(), z[j] = u.z() - at.z();
  }
  std::memcpy(&k, t.k_mN_per_mm[v].data(), sizeof k);
  if (with_mean)
    if (const double sum = total(k); sum > 0) out.mean_mm = Vec3(total(k * x), total(k * y), total(k * z)) / sum;
  if (!with_springs) return out;
  std::memcpy(&l0, t.rest_mm[v].data(), sizeof l0);
  const v4 l2 = x * x + y * y + z * z;
  v4 l, f, slope;
  for (size_t j = 0; j < 4; ++j) l[j] = std::sqrt(l2[j]);
  if (law.kind == Stiffening::none || law.kind == Stiffening::biphasic) {
    // Two straight pieces: the second adds (ratio - 1) times what is beyond the knee.
    const double more = law.kind == Stiffening::none ? 0 : law.ratio - 1,
                 knee = law.kind == Stiffening::none ? 1 : 1 + law.knee;
    const v4 over = l - knee * l0;
    const auto beyond = (over > 0) & (l0 > 0);
    // What the force is divided by is no less than the tangent and grows into it on the way to the knee. Were it to
    // jump there as the tangent does, so would the pull on the face, and a spring at the knee would never let it rest.
    const v4 stretch = l - l0, way = (knee - 1) * l0;
    const v4 share = stretch > 0 ? (stretch < way ? stretch / (way > 0 ? way : all(1)) : all(1)) : all(0);
    slope = l0 > 0 ? 1 + more * share : all(1);
    f = (l - l0) + more * (beyond ? over : all(0));
    f = l0 > 0 ? f : all(0);
  } else {
    for (size_t j = 0; j < 4; ++j) f[j] = law.force_over_k0(l[j], l0[j]), slope[j] = law.tangent_over_k0(l[j], l0[j]);
  }
  out.tangent = total(k * slope);
  f = k * f / (l > 0 ? l : all(1));
  out.force_mN = Vec3(total(f * x), total(f * y), total(f * z));
  for (size_t j = 0; j < 4; ++j)
    if (l[j] > (1 + longest) * l0[j] && l0[j] > 0) longest = l[j] / l0[j] - 1;
  return out;
}

Vec3 to_mean(const Tissue& t, size_t v) {
  Vec3 p = Vec3::Zero();
  for (size_t k = 0; k < 4; ++k) p += 0.25 * t.x_mm[size_t(t.nbr[v][k])];
  return p - t.x_mm[v];
}

/// The rotation nearest to A (in the sense of polar decomposition), from a guess. A guess that is nearly right is
/// corrected once: the next call goes on from there.
Mat3 nearest_rotation(const Mat3& A, Mat3 R) {
  constexpr int kTurns = 4;
  constexpr double kNearly = 1e-3;
  for (int i = 0; i < kTurns; ++i) {
    const Vec3 axis = R.col(0).cross(A.col(0)) + R.col(1).cross(A.col(1)) + R.col(2).cross(A.col(2));
    const double size = std::abs(R.col(0).dot(A.col(0)) + R.col(1).dot(A.col(1)) + R.col(2).dot(A.col(2)));
    if (!(size > 0)) return R;
    const Vec3 w = axis / size;
    const double angle = w.norm();
    if (angle < 1e-12) return R;
    if (angle < kNearly) {
      // Half the vector as a quaternion: the angle to the third order.
      return Eigen::Quaterniond(1, w.x() / 2, w.y() / 2, w.z() / 2).normalized().toRotationMatrix() * R;
    }
    R = (rotation(angle, w / angle) * R).eval();
  }
  return R;
}

}  // namespace

double SpringLaw::force_over_k0(double l, double l0) const {
  if (!(l0 > 0)) return 0;
  const double e = (l - l0) / l0;
  switch (kind) {
    case Stiffening::none:
      return l - l0;
    case Stiffening::biphasic:
      return e <= knee ? l - l0 : l0 * (knee + ratio * (e - knee));
    case Stiffening::quadratic:
      return (1 + c * e * e) * (l - l0);
    case Stiffening::exponential:
      return l0 / c * elementary::expm1(std::min(c * e, 30.));  // (beyond that the bound has long stopped it)
  }
  return 0;
}

double SpringLaw::tangent_over_k0(double l, double l0) const {
  if (!(l0 > 0)) return 1;
  const double e = (l - l0) / l0;
  switch (kind) {
    case Stiffening::none:
      return 1;
    case Stiffening::biphasic:
      return 1 + std::max(0., ratio - 1) * (knee > 0 ? std::clamp(e / knee, 0., 1.) : e > 0);
    case Stiffening::quadratic:
      return 1 + 3 * c * e * e;
    case Stiffening::exponential:
      return std::max(1., elementary::exp(std::min(c * e, 30.)));
  }
  return 1;
}

void record_rest(Tissue& t) {
  t.x0_mm = t.x_mm;
  t.turn.assign(t.nbr.size(), Mat3::Identity());
  t.bent_mm.assign(t.nbr.size(), Vec3::Zero());
  for (size_t v = 0; v < t.nbr.size(); ++v)
    for (size_t k = 0; k < 4; ++k) t.rest_mm[v][k] = (t.x_mm[size_t(t.nbr[v][k])] - t.x_mm[v]).norm();
}

void turn_shape(Tissue& t, Workers& workers) {
  const size_t n = t.nbr.size();
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      Mat3 A = Mat3::Zero();
      for (size_t k = 0; k < 4; ++k) {
        const size_t u = size_t(t.nbr[v][k]);
        A += t.k_mN_per_mm[v][k] * (t.x_mm[u] - t.x_mm[v]) * (t.x0_mm[u] - t.x0_mm[v]).transpose();
      }
      t.turn[v] = nearest_rotation(A, t.turn[v]);
    }
  });
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      Vec3 bent = Vec3::Zero();
      double sum = 0;
      for (size_t k = 0; k < 4; ++k) {
        const size_t u = size_t(t.nbr[v][k]);
        bent += 0.5 * t.k_mN_per_mm[v][k] * ((t.turn[v] + t.turn[u]) * (t.x0_mm[v] - t.x0_mm[u])),
            sum += t.k_mN_per_mm[v][k];
      }
      t.bent_mm[v] = sum > 0 ? Vec3(bent / sum) : Vec3(Vec3::Zero());
    }
  });
}

TissueStep step(Tissue& t, const TissueLaw& law, Workers& workers) {
  if (law.mode == TissueKind::finite_elements)
    throw InputError("", 0, "a tissue of finite elements does not move vertex by vertex; expected another mode");
  if (!(law.gamma > 0 && law.gamma < 2)) throw InputError("", 0, "gamma of a tissue must lie between 0 and 2");
  if (!std::isfinite(law.alpha) || law.alpha < 0)
    throw InputError("", 0, "alpha of a tissue must be a finite number, 0 or more");
  if (!(law.shape >= 0 && law.shape <= 1))
    throw InputError("", 0, "the share of the shape force must lie between 0 and 1");
  const SpringLaw& s = law.spring;
  if (!(s.knee >= 0) || !(s.ratio >= 1) || !(s.c > 0) || !std::isfinite(s.ratio) || !std::isfinite(s.c))
    throw InputError("", 0, "a spring stiffens: knee 0 or more, ratio 1 or more and c above 0 were expected");
  TissueStep out;
  // Eigenvalues: at most 2 of means, weighted or not, and of springs
  // over the stiffness of their vertex (D^-1 K, Gershgorin).
  const bool springs = law.mode == TissueKind::springs,
             shaped = law.mode == TissueKind::shape || (springs && law.shape > 0);
  constexpr double lambda = 2;
  // (springs that stiffen on the way do it within an iteration, too: a fifth is kept for that)
  out.alpha = std::min(law.alpha, (springs && s.kind != Stiffening::none ? 0.8 : 0.99) * 2 * (2 - law.gamma) / lambda);
  const size_t n = t.nbr.size();
  std::vector<double> far((n + kGrain - 1) / kGrain, 0), longest(far);
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    double most = 0, move2 = 0;
    for (size_t v = b; v < e; ++v) {
      if (!moves(t, v)) {
        t.before_mm[v] = t.x_mm[v];
        continue;
      }
      Vec3 F = Vec3::Zero();
      if (law.mode == TissueKind::smoothing) {
        F = to_mean(t, v);
      } else {
        const Edges of = !springs ? edges<false, true>(t, v, s, most)
                         : shaped ? edges<true, true>(t, v, s, most)
                                  : edges<true, false>(t, v, s, most);
        if (of.tangent > 0) {
          // The stiffness is that of where the vertex is: it goes no farther at once than this holds.
          const Vec3 f = (1 - law.shape) / of.tangent * of.force_mN;
          const double reach = kReach * (t.rest_mm[v][0] + t.rest_mm[v][1] + t.rest_mm[v][2] + t.rest_mm[v][3]) / 4,
                       far_mm2 = f.squaredNorm();
          F += far_mm2 > reach * reach ? Vec3(reach / std::sqrt(far_mm2) * f) : f;
        }
        if (shaped)
          F += (springs ? law.shape : 1) *
               (of.mean_mm + t.bent_mm[v]);  // to where the turned rest shape wants the vertex
      }
      const Vec3 d = (1 - law.gamma) * (t.x_mm[v] - t.before_mm[v]) + out.alpha * F;
      t.before_mm[v] = t.x_mm[v] + d;
      move2 = std::max(move2, d.squaredNorm());
    }
    far[b / kGrain] = move2, longest[b / kGrain] = most;
  });
  std::swap(t.x_mm, t.before_mm);
  for (double d : far) out.max_move_mm = std::max(out.max_move_mm, std::sqrt(d));
  for (double l : longest) out.longest_elongation = std::max(out.longest_elongation, l);
  return out;
}

void pull_face(const Tissue& t, const TissueLaw& law, std::vector<Vec3>& force_mm, std::vector<Vec3>* force_mN) {
  if (law.mode == TissueKind::smoothing) return;
  const double share = law.mode == TissueKind::shape ? 1 : law.shape;
  double longest = 0;
  for (size_t i = 0; i < t.link.size(); ++i) {
    const auto [tv, f] = t.link[i];
    const size_t v = size_t(tv);
    if (size_t(f) >= force_mm.size() || (force_mN && size_t(f) >= force_mN->size()))
      throw InputError("", 0, "one force per vertex of the face was expected");
    const Edges of = edges<true, true>(t, v, law.spring, longest);
    if (share < 1) {
      if (of.tangent > 0) force_mm[size_t(f)] += (1 - share) / of.tangent * of.force_mN;
      if (force_mN) (*force_mN)[size_t(f)] += of.force_mN;
    }
    if (share > 0) force_mm[size_t(f)] += share * (of.mean_mm + t.bent_mm[v]);
  }
}

}  // namespace limberg::simplex
