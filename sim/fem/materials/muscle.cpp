#include "sim/fem/materials/muscle.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"

namespace limberg {
namespace {

constexpr double kWidth = 0.56;

class ActiveFibres final : public MaterialLaw {
 public:
  ActiveFibres(double pull_kPa, const Vec3& fibre) : pull_kPa_(pull_kPa), fibre_(fibre) {}

  Response at(const Mat3& F) const override {
    const Vec3 Fa = F * fibre_;
    const Pull w = pull(Fa.norm());
    return {w.energy, w.over_length * Fa * fibre_.transpose()};
  }

  // (W' / l) (1 - e e^T) + W'' e e^T, e the fibre as it runs now: only W'' may be below zero.
  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    const Vec3 Fa = F * fibre_;
    const double l = Fa.norm();
    const Pull w = pull(l);
    Mat9 H = Mat9::Zero();
    if (!(w.over_length > 0)) return H;
    const double second = project ? std::max(0.0, w.second) : w.second;
    const Mat3 along = w.over_length * Mat3::Identity() + (second - w.over_length) / (l * l) * Fa * Fa.transpose();
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) H.block<3, 3>(3 * j, 3 * k) = fibre_[j] * fibre_[k] * along;
    return H;
  }

  std::string describe() const override { return "active fibres, " + std::to_string(pull_kPa_) + " kPa"; }

 private:
  struct Pull {
    double energy, over_length, second;  // W, W' / l, W''
  };
  Pull pull(double l) const {
    const double x = std::clamp((l - 1) / kWidth, -1.0, 1.0);
    const double energy = pull_kPa_ * kWidth * (x - x * x * x / 3), slope = pull_kPa_ * (1 - x * x);
    return {energy, slope > 0 ? slope / l : 0, slope > 0 ? -2 * x / kWidth * pull_kPa_ : 0};
  }

  double pull_kPa_;
  Vec3 fibre_;
};

}  // namespace

LawPtr active_fibres(double tension_kPa, double activation, const Vec3& fibre) {
  if (!(tension_kPa >= 0) || !std::isfinite(tension_kPa))
    throw InputError("", 0, "a muscle's tension of 0 kPa or more was expected");
  if (!(activation >= 0 && activation <= 1)) throw InputError("", 0, "an activation from 0 to 1 was expected");
  if (!(fibre.norm() > 1e-12)) throw InputError("", 0, "a fibre direction other than zero was expected");
  return std::make_shared<ActiveFibres>(activation * tension_kPa, fibre.normalized());
}

}  // namespace limberg
