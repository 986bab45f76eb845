#pragma once
// What is known at places, between them: the mean of the nearest eight, by the weights of Franke and Nielson (1980):
// that of a place at distance d is ((R - d) / (R d))^2, where R is the distance of the ninth. At a place it is that
// of the place.
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

class BetweenPlaces {
 public:
  explicit BetweenPlaces(std::span<const Vec3> at_mm);  // at least one
  ~BetweenPlaces();

  /// Places and their weights, which add up to more than 0; nearest first.
  std::vector<std::pair<size_t, double>> weights(const Vec3& X_mm) const;

 private:
  struct Tree;
  std::vector<Vec3> at_;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace limberg
