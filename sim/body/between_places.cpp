#include "sim/body/between_places.h"

#include <algorithm>
#define BOOST_ALLOW_DEPRECATED_HEADERS  // Boost 1.74 includes its own, and says so
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <iterator>

namespace limberg {
namespace {

constexpr size_t kNearest = 8;
constexpr double kThere_mm = 1e-6;

namespace bg = boost::geometry;
using Place = bg::model::point<double, 3, bg::cs::cartesian>;
using Numbered = std::pair<Place, size_t>;

Place place_of(const Vec3& X) { return {X.x(), X.y(), X.z()}; }

}  // namespace

struct BetweenPlaces::Tree {
  bg::index::rtree<Numbered, bg::index::rstar<16>> of;
};

BetweenPlaces::BetweenPlaces(std::span<const Vec3> at_mm) : at_(at_mm.begin(), at_mm.end()) {
  std::vector<Numbered> all;
  for (size_t i = 0; i < at_.size(); ++i) all.emplace_back(place_of(at_[i]), i);
  tree_ = std::make_unique<Tree>(Tree{bg::index::rtree<Numbered, bg::index::rstar<16>>(all)});
}

BetweenPlaces::~BetweenPlaces() = default;

std::vector<std::pair<size_t, double>> BetweenPlaces::weights(const Vec3& X) const {
  std::vector<Numbered> found;
  tree_->of.query(bg::index::nearest(place_of(X), unsigned(kNearest + 1)), std::back_inserter(found));
  std::vector<std::pair<double, size_t>> near;  // distances
  for (const auto& [at, i] : found) near.emplace_back((at_[i] - X).norm(), i);
  std::sort(near.begin(), near.end());
  if (near[0].first < kThere_mm) return {{near[0].second, 1}};
  const double R = near.size() > kNearest ? near.back().first : INFINITY;
  std::vector<std::pair<size_t, double>> out;
  double sum = 0;
  for (const auto& [d, i] : near) {
    const double root = std::isfinite(R) ? (R - d) / (R * d) : 1 / d;
    out.emplace_back(i, root * root), sum += root * root;
  }
  if (!(sum > 0)) return {{near[0].second, 1}};
  return out;
}

}  // namespace limberg
