#include "sim/commands/in_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/commands/table.h"

namespace limberg {
namespace {

/// Shows every place of an act.
template <class F>
struct EachPlace {
  F f;
  void operator()(const Field&, auto& v) {
    using T = std::remove_cvref_t<decltype(v)>;
    if constexpr (std::is_same_v<T, ChartPoint>) {
      f(v);
    } else if constexpr (std::is_same_v<T, std::vector<ChartPoint>>) {
      for (auto& p : v) f(p);
    } else if constexpr (std::is_same_v<T, StitchPick>) {
      if (v.id == 0) f(v.at);
    }
  }
  bool form(const char*, bool chosen, const char*, const char*) { return chosen; }
  void same_unless_given(const auto&, const auto&) {}
};

template <class A, class F>
void each_place(A& act, F f) {
  EachPlace<F> each{f};
  std::visit([&]<class C>(C& c) { Act<std::remove_cv_t<C>>::fields(each, c); }, act);
}

}  // namespace

std::vector<Vec3> places_of(const InSpace& c) {
  std::vector<Vec3> out;
  each_place(c.act, [&](const ChartPoint& p) { out.emplace_back(p.x(), p.y(), c.z_mm.at(out.size())); });
  return out;
}

bool has_texture_places(const InSpace& c) {
  return std::any_of(c.z_mm.begin(), c.z_mm.end(), [](double z) { return std::isnan(z); });
}

SkinAct with_points(const InSpace& c, std::span<const ChartPoint> points) {
  SkinAct act = c.act;
  size_t i = 0;
  each_place(act, [&](ChartPoint& p) { p = points[i++]; });
  return act;
}

SkinAct flattened(const InSpace& c) {
  const std::vector<Vec3> places = places_of(c);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& X : places) middle += X / double(places.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& X : places) spread += (X - middle) * (X - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);  // ascending
  std::vector<ChartPoint> flat;
  for (const Vec3& X : places)
    flat.emplace_back(axes.eigenvectors().col(2).dot(X - middle), axes.eigenvectors().col(1).dot(X - middle));
  return with_points(c, flat);
}

}  // namespace limberg
