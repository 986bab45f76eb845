#include "tests/bench/fuzz/world_generator.h"

#include <cmath>
#include <numbers>

namespace limberg::fuzz {

WorldCase WorldGenerator::start() {
  case_ = WorldCase{};
  case_.thickness_mm = random_.one_in(3) ? 6 : 10;
  case_.size_mm = 50;
  case_.fronts = random_.one_in(4);
  case_.steps = !random_.one_in(3);
  case_.seed = random_.next() % 100000;
  return case_;
}

Vec2 WorldGenerator::point() {
  const double r = 0.5 * case_.size_mm - 4;
  if (!drawn_.empty() && random_.one_in(3)) {  // on, beside or at the end of what was drawn
    const auto& path = drawn_[size_t(random_.below(int(drawn_.size())))];
    const Vec2 p = path[size_t(random_.below(int(path.size())))];
    return random_.one_in(2) ? p : near(p, 0.6);
  }
  const Vec2 p(random_.real(-r, r), random_.real(-r, r));
  return random_.one_in(3) ? Vec2(5 * std::round(p.x() / 5), 5 * std::round(p.y() / 5)) : p;
}

double WorldGenerator::depth() {
  if (random_.one_in(6)) return case_.thickness_mm + 2;
  return random_.one_in(2) ? 1 + random_.below(5) : random_.real(0.8, 6);
}

std::vector<Vec2> WorldGenerator::stroke() {
  if (!drawn_.empty() && random_.one_in(4)) {  // again, with a tremor, and some further
    std::vector<Vec2> path = drawn_[size_t(random_.below(int(drawn_.size())))];
    for (Vec2& p : path) p = near(p, 0.2);
    if (random_.one_in(2)) path.back() += (path.back() - path[path.size() - 2]).normalized() * random_.real(-3, 6);
    return path;
  }
  std::vector<Vec2> path{point()};
  if (random_.one_in(2)) {  // a walk, which may cross itself
    double heading = random_.real(0, 2 * std::numbers::pi);
    const double turn = random_.real(-0.5, 0.5);
    for (int i = 4 + random_.below(12); i > 0; --i) {
      heading += turn + random_.real(-0.3, 0.3);
      path.push_back(path.back() + random_.real(1, 4) * Vec2(std::cos(heading), std::sin(heading)));
    }
  } else {
    for (int i = 1 + random_.below(3); i > 0; --i) path.push_back(point());
  }
  if (random_.one_in(6)) path.push_back(path[0]);
  return path;
}

std::vector<Vec2> WorldGenerator::ring() {
  if (!drawn_.empty() && random_.one_in(3)) {  // what an earlier stroke encloses
    const auto& path = drawn_[size_t(random_.below(int(drawn_.size())))];
    if (path.size() > 2) return path;
  }
  std::vector<Vec2> out;
  const Vec2 c = point();
  const int n = 3 + random_.below(6);
  const double r = random_.real(3, 11);
  for (int i = 0; i < n; ++i) {
    const double w = 2 * std::numbers::pi * i / n;
    out.push_back(c + r * random_.real(0.6, 1.2) * Vec2(std::cos(w), std::sin(w)));
  }
  return out;
}

void WorldGenerator::begin_stroke() {
  const std::vector<Vec2> path = stroke();
  const double d = depth(), angle = random_.one_in(3) ? random_.real(45, 135) : 90;
  drawn_.push_back(path);
  if (random_.one_in(2)) {
    queue_.push_back(Incise{path, d, angle, random_.one_in(5)});
    return;
  }
  ++strokes_;
  const double piece = random_.real(2, 12);
  InciseMore more{strokes_, {path[0]}, d, angle, false};
  double left = piece;
  for (size_t i = 1; i < path.size(); ++i) {
    Vec2 at = path[i - 1];
    while ((path[i] - at).norm() > left) {
      at += (path[i] - at).normalized() * left;
      more.path.push_back(at);
      queue_.push_back(more);
      more.path.clear();
      left = piece;
    }
    left -= (path[i] - at).norm();
    more.path.push_back(path[i]);
  }
  more.last = true;
  queue_.push_back(more);
  for (size_t i = 1; i < queue_.size(); ++i)
    if (random_.one_in(12))
      queue_.insert(queue_.begin() + long(i++), MoveHook{1, {random_.real(-15, 15), random_.real(-15, 15), 5}, 0});
}

Command WorldGenerator::other() {
  switch (random_.below(9)) {
    case 0:
      return Suture{point(), point()};
    case 1:
      return SutureRow{{point(), point()}, {point(), point()}, random_.real(2, 6)};
    case 2:
      return SetHook{1 + random_.below(2), point()};
    case 3:
      return MoveHook{1 + random_.below(2), {random_.real(-15, 15), random_.real(-15, 15), random_.real(0, 8)}, 0};
    case 4:
      return ReleaseHook{1 + random_.below(2)};
    case 5:
    case 6:  // and back, half the time, after a look
      if (random_.one_in(2)) queue_.push_front(Redo{});
      if (random_.one_in(3)) queue_.push_front(Undo{}), queue_.push_front(Wait{0.01});
      return Undo{};
    default:
      return Wait{0.01 * (1 + random_.below(3))};
  }
}

Command WorldGenerator::next() {
  if (queue_.empty()) {
    const int kind = random_.below(12);
    if (kind < 5)
      begin_stroke();
    else if (kind < 7)
      queue_.push_back(Undermine{ring(), depth()});
    else if (kind < 9)
      queue_.push_back(Excise{ring(), depth(), !random_.one_in(4)});
    else if (kind < 10 || drawn_.empty())
      queue_.push_back(other());
    else  // second thoughts, and third ones
      for (int k = 1 + random_.below(4); k > 0; --k)
        queue_.push_back(random_.one_in(2) ? Command(Undo{}) : Command(Redo{}));
  }
  const Command c = queue_.front();
  queue_.pop_front();
  return c;
}

}  // namespace limberg::fuzz
