// Landmarks of the analytic head: extremal places of its surfaces.
#include <cmath>
#include <optional>

#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {
namespace {

using Surface = LandmarkRule::Surface;

constexpr double kPast_mm = 25;  // how far beyond the stated place a ray goes on

double distance(const LandmarkGround& h, Surface s, const Vec3& p) {
  return s == Surface::skull ? h.skull(p) : s == Surface::mandible ? h.mandible(p) : h.skin(p);
}

/// The first place of the surface along a ray; nothing when it begins inside or meets none.
std::optional<Vec3> meet(const LandmarkGround& h, Surface s, const Vec3& from, const Vec3& look, double length) {
  double before = 0;
  for (double t = 0; t < length;) {
    const double d = distance(h, s, from + t * look);
    if (t == 0 && d < 0) return std::nullopt;
    if (d < 1e-7) {
      double lo = before, hi = t;  // bisection to rounding
      for (int i = 0; i < 50 && hi - lo > 1e-9; ++i) {
        const double m = 0.5 * (lo + hi);
        (distance(h, s, from + m * look) < 0 ? hi : lo) = m;
      }
      return from + hi * look;
    }
    before = t;
    t += std::max(d / h.lipschitz, 1e-4);
  }
  return std::nullopt;
}

std::optional<Vec3> find(const LandmarkGround& h, const LandmarkRule& r, double side) {
  const auto mirrored = [&](Vec3 v) { return Vec3(side * v.x(), v.y(), v.z()); };
  Vec3 place = mirrored(r.place);
  if (r.carried && h.place) place = h.place(place);
  const Vec3 look = mirrored(r.look).normalized(), score = mirrored(r.score);
  const Vec3 helper = std::abs(look.x()) > 0.9 ? Vec3::UnitY() : Vec3::UnitX();
  const Vec3 u = (helper - helper.dot(look) * look).normalized(), v = look.cross(u);
  double a0 = 0, b0 = 0, ra = r.reach_mm[0], rb = r.reach_mm[1];
  std::optional<Vec3> best;
  for (int round = 0; round < 12; ++round) {
    double best_a = a0, best_b = b0;
    const int na = ra > 0 ? 4 : 0, nb = rb > 0 ? 6 : 0;
    for (int i = -na; i <= na; ++i)
      for (int j = -nb; j <= nb; ++j) {
        const double a = na ? std::clamp(a0 + ra * i / na, -r.reach_mm[0], r.reach_mm[0]) : 0,
                     b = nb ? std::clamp(b0 + rb * j / nb, -r.reach_mm[1], r.reach_mm[1]) : 0;
        const auto p = meet(h, r.surface, place + a * u + b * v - r.back_mm * look, look, r.back_mm + kPast_mm);
        if (p && (!best || p->dot(score) > best->dot(score))) best = p, best_a = a, best_b = b;
      }
    a0 = best_a, b0 = best_b, ra *= 0.4, rb *= 0.3;
    if (na + nb == 0) break;
  }
  return best;
}

}  // namespace

const std::vector<LandmarkRule>& landmark_rules() {
  using enum LandmarkRule::Surface;
  static const Vec3 in(0, -1, 0), out(0, 1, 0), up(0, 0, 1), down(0, 0, -1), left(-1, 0, 0), right(1, 0, 0);
  static const std::vector<LandmarkRule> rules = {
      {"G", skull, {0, 96, 40}, in, out, {0, 12}},
      {"N", skull, {0, 94, 25}, in, in, {0, 8}},
      {"Rhi", skull, {0, 106, -6}, {0, -1, 0.5}, {0, 1, -0.5}, {0, 5}},
      {"ANS", skull, {0, 97, -34.5}, in, out, {0, 3}},
      {"A", skull, {0, 93, -40}, in, in, {0, 4}},
      {"Is", skull, {0, 96, -54}, {0, -0.5, 1}, {0, 0.5, -1}, {0, 6}},
      {"PNS", skull, {0, 42, -38}, out, in, {0, 4}, 6},
      {"Ba", skull, {0, -6, -17}, {0, 0.6, 1}, {0, -0.6, -1}, {0, 8}},
      {"Op", skull, {0, -38, -14}, {0, -0.6, 1}, {0, 0.6, -1}, {0, 8}},
      {"V", skull, {0, 2, 118}, down, up, {0, 20}},
      {"Ii", mandible, {0, 88, -59}, {0, -0.5, -1}, {0, 0.5, 1}, {0, 6}, 12, false, true},
      {"B", mandible, {0, 88, -76}, in, in, {0, 8}, 25, false, true},
      {"Pog", mandible, {0, 90, -91}, in, out, {0, 6}, 25, false, true},
      {"Gn", mandible, {0, 88, -95}, {0, -1, 1}, {0, 1, -1}, {0, 8}, 25, false, true},
      {"Me", mandible, {0, 82, -97}, up, down, {0, 8}, 25, false, true},
      {"Or", skull, {31, 87, -1}, {0, -0.7, -1}, {0, 0.7, 1}, {0, 6}, 8, true},
      {"Po", skull, {62, 0, 0}, left, right, {0, 0}, 25, true},
      {"Zy", skull, {66, 24, -2}, left, right, {12, 6}, 25, true},
      {"Eu", skull, {71, 0, 54}, left, right, {25, 20}, 25, true},
      {"Co", mandible, {51, 10, -13}, down, up, {6, 6}, 4, true, true},
      {"Go", mandible, {48, 4, -64}, {-0.2, 1, 1}, {0.2, -1, -1}, {10, 10}, 25, true, true},
      {"g'", skin, {0, 102, 40}, in, out, {0, 12}},
      {"n'", skin, {0, 100, 22}, in, in, {0, 10}},
      {"prn", skin, {0, 123, -26}, in, out, {0, 8}},
      {"sn", skin, {0, 108, -40}, {0, -1, 1}, {0, -1, 1}, {0, 6}},
      {"ls", skin, {0, 106, -51}, in, out, {0, 4}},
      {"sto", skin, {0, 102, -57}, in, in, {0, 3}},
      {"li", skin, {0, 103, -62}, in, out, {0, 4}, 25, false, true},
      {"sl", skin, {0, 98, -76}, in, in, {0, 8}, 25, false, true},
      {"pog'", skin, {0, 100, -90}, in, out, {0, 8}, 25, false, true},
      {"gn'", skin, {0, 96, -100}, {0, -1, 1}, {0, 1, -1}, {0, 8}, 25, false, true},
      {"me'", skin, {0, 84, -105}, up, down, {0, 8}, 25, false, true},
      {"v'", skin, {0, 2, 124}, down, up, {0, 20}},
      {"en", skin, {16, 92, 13}, in, out, {0, 0}, 25, true},
      {"ex", skin, {46, 84, 14}, in, out, {0, 0}, 25, true},
      {"al", skin, {18, 104, -29}, left, right, {5, 5}, 12, true},
      {"ch", skin, {26.5, 90, -56}, in, out, {0, 0}, 25, true},
      {"zy'", skin, {70, 24, -2}, left, right, {14, 8}, 25, true},
      {"go'", skin, {52, 4, -64}, {-1, 0.4, 0.4}, {1, -0.4, -0.4}, {0, 0}, 25, true, true},
      {"t", skin, {72, 0, 3}, left, right, {0, 0}, 25, true},
  };
  return rules;
}

std::vector<std::pair<std::string, Vec3>> landmarks_by(const std::vector<LandmarkRule>& rules,
                                                       const LandmarkGround& ground) {
  std::vector<std::pair<std::string, Vec3>> out;
  for (const LandmarkRule& r : rules) {
    for (double side : {1., -1.}) {
      if (!r.pair && side < 0) continue;
      if (const auto p = find(ground, r, side))
        out.emplace_back(r.pair ? std::string(r.name) + (side > 0 ? "_R" : "_L") : r.name, *p);
    }
  }
  return out;
}

std::vector<std::pair<std::string, Vec3>> head_landmarks(const HeadShape& h) {
  std::vector<std::pair<std::string, Vec3>> out = landmarks_by(
      landmark_rules(), {[&](const Vec3& p) { return h.skull(p); }, [&](const Vec3& p) { return h.mandible(p); },
                         [&](const Vec3& p) { return h.skin(p); }, HeadShape::kLipschitz,
                         [&](const Vec3& p) { return h.mandible_place(p); }});
  out.insert(out.begin(), {"S", Vec3(0, 20, 15)});
  return out;
}

}  // namespace limberg
