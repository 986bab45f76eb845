#include "sim/skull/bone/ring_ways.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/elementary.h"

namespace limberg::bone {
namespace {

using Eigen::Isometry3d;

constexpr int kPlaces = 9;          // of a run
constexpr double kNormals = 0.3;    // weight of a normal against a place
constexpr double kNear_mm = 1.2;    // rings run together while they are no further apart
constexpr double kFan = 0.06;       // and per mm of arc from where they were laid on each other
constexpr double kLongest_mm = 45;  // of the run to either side that is followed
constexpr size_t kShifts = 4;       // of one place of p, kShift_mm apart on q
constexpr double kShift_mm = 8;
constexpr double kChord_mm = 0.5, kRun_mm = 0.4;  // runs that differ by less may be one; and 4, 3 times the noise

/// About its own middle.
struct Run {
  std::array<Vec3, kPlaces> x, n;
  Vec3 middle = Vec3::Zero();
  double chord[3] = {0, 0, 0};
};

std::vector<Run> runs(const Ring& r, bool backwards) {
  const int n = int(r.x_mm.size());
  std::vector<Run> out;
  out.reserve(size_t(n));
  for (int i = 0; i < n; ++i) {
    Run& run = out.emplace_back();
    for (int k = 0; k < kPlaces; ++k) {
      const double arc = kHalf_mm * (2. * k / (kPlaces - 1) - 1) * (backwards ? -1 : 1), at = arc / r.step_mm + i;
      const int low = int(std::floor(at));
      const double w = at - low;
      const size_t a = size_t(((low % n) + n) % n), b = (a + 1) % size_t(n);
      run.x[size_t(k)] = (1 - w) * r.x_mm[a] + w * r.x_mm[b];
      run.n[size_t(k)] = ((1 - w) * r.normal[a] + w * r.normal[b]).normalized();
      run.middle += run.x[size_t(k)] / kPlaces;
    }
    constexpr size_t mid = kPlaces / 2, end = kPlaces - 1;
    run.chord[0] = (run.x[end] - run.x[0]).norm(), run.chord[1] = (run.x[mid] - run.x[0]).norm(),
    run.chord[2] = (run.x[end] - run.x[mid]).norm();
    for (Vec3& x : run.x) x -= run.middle;
  }
  return out;
}

/// The motion of q's run onto p's; false where they are too unlike.
bool lay(const Run& p, const Run& q, double chord_mm, double run_mm, Isometry3d& T) {
  for (size_t k = 0; k < 3; ++k)
    if (std::abs(p.chord[k] - q.chord[k]) > chord_mm) return false;
  Mat3 H = Mat3::Zero();
  for (size_t k = 0; k < kPlaces; ++k)
    H += q.x[k] * p.x[k].transpose() + kNormals * kArm_mm * kArm_mm * q.n[k] * p.n[k].transpose();
  const Eigen::JacobiSVD<Mat3> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 R = svd.matrixV() * svd.matrixU().transpose();
  if (R.determinant() < 0) R = svd.matrixV() * Vec3(1, 1, -1).asDiagonal() * svd.matrixU().transpose();
  double sum = 0, along = 0;
  for (size_t k = 0; k < kPlaces; ++k)
    sum += (R * q.x[k] - p.x[k]).squaredNorm() / kPlaces, along += (R * q.n[k]).dot(p.n[k]) / kPlaces;
  if (sum > run_mm * run_mm || along < 0.9) return false;
  T = Isometry3d::Identity();
  T.linear() = R, T.translation() = p.middle - R * q.middle;
  return true;
}

double follow(const Ring& p, size_t i, const Ring& q, size_t j, const Isometry3d& T, double near) {
  const int np = int(p.x_mm.size()), nq = int(q.x_mm.size());
  double score = 0;
  for (int side : {1, -1})
    for (int k = 2; k * p.step_mm < kLongest_mm && 2 * k < np; k += 2) {
      const Vec3& x = p.x_mm[size_t(((int(i) + side * k) % np + np) % np)];
      const double at = int(j) - side * k * p.step_mm / q.step_mm;
      const int low = int(std::floor(at));
      const double w = at - low;
      const size_t a = size_t((low % nq + nq) % nq), b = (a + 1) % size_t(nq);
      const double d = (T * ((1 - w) * q.x_mm[a] + w * q.x_mm[b]) - x).norm(), most = near + kFan * k * p.step_mm;
      if (d > most) break;
      score += 2 * p.step_mm * (1 - d / most);
    }
  return score;
}

}  // namespace

std::vector<RingWay> ring_ways(const Ring& p, const Ring& q, const Vec3& about, size_t most) {
  std::vector<RingWay> all, out;
  if (p.length_mm() < 2.2 * kHalf_mm || q.length_mm() < 2.2 * kHalf_mm) return out;
  const std::vector<Run> on_p = runs(p, false), on_q = runs(q, true);
  const double noise = elementary::hypot(p.noise_mm, q.noise_mm), chord = kChord_mm + 4 * noise,
               run = kRun_mm + 3 * noise, near = kNear_mm + 3 * noise;
  Isometry3d T;
  for (size_t i = 0; i < on_p.size(); i += 2) {
    // Several for each place: where a ring fits at every angle, all but the best would go unseen.
    std::vector<std::pair<double, size_t>> score;
    std::vector<Isometry3d> motion(on_q.size());
    for (size_t j = 0; j < on_q.size(); ++j)
      if (lay(on_p[i], on_q[j], chord, run, motion[j]))
        if (const double s = follow(p, i, q, j, motion[j], near); s > 0) score.push_back({s, j});
    std::stable_sort(score.begin(), score.end(), [](const auto& s, const auto& t) { return s.first > t.first; });
    std::vector<size_t> taken;
    for (const auto& [s, j] : score) {
      if (taken.size() >= kShifts) break;
      const size_t n = on_q.size(), apart = size_t(kShift_mm / q.step_mm);
      const size_t at = j;
      if (std::any_of(taken.begin(), taken.end(),
                      [&](size_t k) { return std::min((at + n - k) % n, (k + n - at) % n) < apart; }))
        continue;
      taken.push_back(j), all.push_back({s, motion[j]});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const RingWay& s, const RingWay& t) { return s.score > t.score; });
  for (const RingWay& w : all) {
    if (out.size() >= most) break;
    const auto same = [&](const RingWay& d) {
      return (w.T * about - d.T * about).norm() <= 4 && degrees(w.T.inverse() * d.T) <= 8;
    };
    if (std::none_of(out.begin(), out.end(), same)) out.push_back(w);
  }
  return out;
}

}  // namespace limberg::bone
