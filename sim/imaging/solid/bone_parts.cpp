#include "sim/imaging/solid/bone_parts.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/imaging/fit/prepare.h"
#include "sim/imaging/solid/even_grid.h"
#include "sim/imaging/solid/least_cut.h"

namespace limberg {

namespace {

using namespace imaging;

constexpr double kBrainBall_mm = 18;    // wider than the foramen magnum (about 35 mm)
constexpr double kLeastBrain_cm3 = 80;  // of a head that is cut off above the brows
constexpr double kAroundBrain_mm = 5;   // bone so near the hollow is skull
constexpr double kCore_mm = 12;         // the hollow less what is so near bone: canals are gone
constexpr double kFront_mm = 55;        // the chin is no farther behind the foremost bone
constexpr double kChinSeed_mm = 10;
constexpr double kSpineBehind_mm = 75, kSpineBelow_mm = 25;  // of the foremost bone; of the brain's hollow
constexpr double kLeastChin_mm = 45;                         // below the middle of the brain's hollow
constexpr double kLeastMandible_cm3 = 8;                     // a child's; less is a piece of something else
constexpr int kRungs = 24;                                   // densities that are tried
constexpr double kNearest_mm = 4;                            // loose pieces (teeth) belong to the part that is so near

struct Parter {
  Parter(const BoneSolid& from, double above, Workers& w) : s(from), iso(above), workers(w) {}
  const BoneSolid& s;
  double iso;
  Workers& workers;
  BoneParts out;
  const GridSize& n = s.distance.size;
  double h = s.step_mm;
  std::vector<uint8_t> solid;
  double front = 1e300;  // y of the foremost bone

  Vec3 place(size_t i) const {
    const auto at = node_at(n, i);
    return s.distance.place(Vec3(at[0], at[1], at[2]));
  }
  double cm3(int64_t count) const { return double(count) * h * h * h * 1e-3; }

  BoneParts run() {
    solid.resize(s.value.size());
    for (size_t i = 0; i < solid.size(); ++i) solid[i] = s.distance.value[i] < 0;
    out.of.assign(solid.size(), BonePart::none);
    const std::vector<uint8_t> skull = around_brain();
    const std::vector<uint8_t> chin = chin_seed();
    std::vector<uint8_t> back = spine_seed();
    std::vector<uint8_t> rest = solid;
    if (any(chin)) take(BonePart::mandible, chin, skull, rest, out.mandible, "the mandible");
    for (size_t i = 0; i < back.size(); ++i) back[i] = back[i] && rest[i];
    if (any(back)) take(BonePart::spine, back, skull, rest, out.spine, "the spine");
    label_rest(rest, skull);
    for (const BonePart p : out.of)
      (p == BonePart::skull      ? out.skull_cm3
       : p == BonePart::mandible ? out.mandible_cm3
       : p == BonePart::spine    ? out.spine_cm3
                                 : out.other_cm3) += p == BonePart::none ? 0 : cm3(1);
    return std::move(out);
  }

  static bool any(const std::vector<uint8_t>& set) {
    return std::any_of(set.begin(), set.end(), [](uint8_t x) { return x != 0; });
  }

  /// Bone around the largest hollow that the ball does not enter; where the volume ends it is closed above and below.
  std::vector<uint8_t> around_brain() {
    std::vector<uint8_t> closed = solid;
    // The nodes beyond the volume's ends along z stand for what is not in the picture.
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (size_t i = 0; i < solid.size(); ++i)
      if (solid[i]) low = low.cwiseMin(place(i)), high = high.cwiseMax(place(i));
    front = low.y();
    for (size_t i = 0; i < solid.size(); ++i) {
      const double z = place(i).z();
      if (z < low.z() - 0.5 * h || z > high.z() + 0.5 * h) closed[i] = 1;
    }
    closed[0] = 0;
    const Reach r = outside_reach(closed);
    // Its core, which keeps away from bone: canals and the throat hang on the hollow, but not on that.
    std::vector<uint8_t> core(solid.size());
    for (size_t i = 0; i < core.size(); ++i)
      core[i] = !closed[i] && !r.air(i) && h * std::sqrt(double(r.to_set[i])) >= kCore_mm;
    const GridParts parts = parts_of(n, core);
    int64_t most = 0;
    int32_t brain = -1;
    for (size_t p = 0; p < parts.nodes.size(); ++p)
      if (parts.nodes[p] > most) most = parts.nodes[p], brain = int32_t(p);
    for (size_t i = 0; i < core.size(); ++i) core[i] = parts.of[i] >= 0 && parts.of[i] == brain;
    const std::vector<float> to_core = squared_distance(n, core, workers);
    std::vector<uint8_t> in(solid.size());
    int64_t count = 0;
    for (size_t i = 0; i < in.size(); ++i) {
      in[i] = !closed[i] && h * std::sqrt(double(to_core[i])) <= kCore_mm;
      if (in[i]) out.brain_mm += place(i), low_brain = std::min(low_brain, place(i).z()), ++count;
    }
    out.brain_cm3 = cm3(count);
    if (!(out.brain_cm3 >= kLeastBrain_cm3))
      throw InputError("", 0,
                       "bone has no hollow for a brain: the largest is " + std::to_string(int(out.brain_cm3)) +
                           " cm3; expected a head with its vault, at least 80");
    out.brain_mm /= double(count);
    const std::vector<float> far = squared_distance(n, in, workers);
    std::vector<uint8_t> seed(solid.size());
    // Not below the middle: canals of nerves and the spine's go on from the hollow.
    for (size_t i = 0; i < seed.size(); ++i)
      seed[i] = solid[i] && h * std::sqrt(double(far[i])) < kAroundBrain_mm && place(i).z() > out.brain_mm.z() - 10;
    return seed;
  }
  double low_brain = 1e300;  // the lowest place of the hollow

  /// The ball begins at the side of the grid, where nothing is closed.
  Reach outside_reach(const std::vector<uint8_t>& closed) const {
    Reach r;
    r.radius = kBrainBall_mm / h;
    r.to_set = squared_distance(n, closed, workers);
    const double least = (r.radius + 0.5) * (r.radius + 0.5);
    r.centre.assign(closed.size(), 0);
    std::vector<size_t> stack;
    const auto begin = [&](size_t i) {
      if (!closed[i] && !r.centre[i]) r.centre[i] = 1, stack.push_back(i);
    };
    for (size_t i = 0; i < closed.size(); ++i) {
      const auto at = node_at(n, i);
      if (at[0] == 0 || at[1] == 0 || at[0] + 1 == n[0] || at[1] + 1 == n[1]) begin(i);
    }
    // At the border the ball may stand half outside the grid.
    while (!stack.empty()) {
      const size_t i = stack.back();
      stack.pop_back();
      neighbours(n, i, [&](size_t j) {
        if (!r.centre[j] && double(r.to_set[j]) >= least) r.centre[j] = 1, stack.push_back(j);
      });
    }
    r.to_centres = squared_distance(n, r.centre, workers);
    return r;
  }

  std::vector<uint8_t> chin_seed() {
    const Vec3 down_and_forwards = Vec3(0, -0.5, -0.866).normalized();
    double best = -1e300;
    for (size_t i = 0; i < solid.size(); ++i) {
      if (!solid[i]) continue;
      const Vec3 x = place(i);
      if (x.y() > front + kFront_mm || std::abs(x.x() - out.brain_mm.x()) > 30) continue;
      if (const double d = down_and_forwards.dot(x); d > best) best = d, out.chin_mm = x;
    }
    std::vector<uint8_t> seed(solid.size(), 0);
    if (best == -1e300 || out.chin_mm.z() > out.brain_mm.z() - kLeastChin_mm) {
      out.notes.push_back("there is no chin in the picture; the bone stays in one piece");
      return seed;
    }
    for (size_t i = 0; i < seed.size(); ++i) seed[i] = solid[i] && (place(i) - out.chin_mm).norm() < kChinSeed_mm;
    return seed;
  }

  std::vector<uint8_t> spine_seed() const {
    std::vector<uint8_t> seed(solid.size(), 0);
    double lowest = 1e300;
    const auto may = [&](const Vec3& x) {
      return x.y() > front + kSpineBehind_mm && std::abs(x.x() - out.brain_mm.x()) < 40 &&
             x.z() < low_brain - kSpineBelow_mm;
    };
    for (size_t i = 0; i < solid.size(); ++i)
      if (solid[i] && may(place(i))) lowest = std::min(lowest, place(i).z());
    if (lowest > 1e299) return seed;
    for (size_t i = 0; i < solid.size(); ++i) {
      const Vec3 x = place(i);
      seed[i] = solid[i] && may(x) && x.z() < lowest + 10;
    }
    return seed;
  }

  /// Parts `seed` with all that goes on from it from what goes on from `other`, and takes it out of `rest`.
  void take(BonePart part, const std::vector<uint8_t>& seed, const std::vector<uint8_t>& other,
            std::vector<uint8_t>& rest, BoneCut& cut, const char* name) {
    // The least density at which they are apart, and the core that goes on from the seed there.
    std::vector<uint8_t> core, dense(rest.size());
    for (int rung = 0; rung <= kRungs && core.empty(); ++rung) {
      const double level = rung == 0 ? -1e300 : iso + (s.cortical - iso) * rung / kRungs;
      for (size_t i = 0; i < dense.size(); ++i) dense[i] = rest[i] && double(s.value[i]) >= level;
      const GridParts parts = parts_of(n, dense);
      std::vector<uint8_t> mine(parts.nodes.size(), 0);
      bool meets = false, there = false;
      for (size_t i = 0; i < seed.size(); ++i)
        if (seed[i] && parts.of[i] >= 0) mine[size_t(parts.of[i])] = 1, there = true;
      for (size_t i = 0; i < other.size() && !meets; ++i)
        meets = other[i] && parts.of[i] >= 0 && mine[size_t(parts.of[i])];
      if (!there) break;
      if (meets) continue;
      core.assign(rest.size(), 0);
      for (size_t i = 0; i < core.size(); ++i) core[i] = parts.of[i] >= 0 && mine[size_t(parts.of[i])];
      cut.apart_at = std::max(iso, level);
    }
    if (core.empty()) core = seed, cut.apart_at = s.cortical;
    const LeastCut c = least_cut(n, rest, core, other, [&](size_t a, size_t b) {
      // The least of the two: a gap of one node is a gap. What a wall was drawn of counts little.
      return std::max(0.02, (std::min(double(s.value[a]), double(s.value[b])) - iso) / (s.cortical - iso));
    });
    int64_t mine = 0, through = 0;
    double density = 0;
    for (size_t i = 0; i < rest.size(); ++i) mine += rest[i] && c.first[i];
    if (part == BonePart::mandible && cm3(mine) < kLeastMandible_cm3) {
      out.notes.push_back(std::string(name) +
                          " could not be parted from the skull: the cut that goes through the least bone leaves " +
                          std::to_string(cm3(mine)).substr(0, 4) + " cm3");
      return;
    }
    for (const auto& [a, b] : c.through) density += 0.5 * double(s.value[a] + s.value[b]), ++through;
    cut.made = true, cut.area_mm2 = double(through) * h * h, cut.density = through ? density / double(through) : 0;
    for (size_t i = 0; i < rest.size(); ++i)
      if (rest[i] && c.first[i]) out.of[i] = part, rest[i] = 0;
  }

  /// What is left is skull where it goes on from its seed; loose pieces belong to what is nearest, if that is near.
  void label_rest(const std::vector<uint8_t>& rest, const std::vector<uint8_t>& skull) {
    const GridParts parts = parts_of(n, rest);
    std::vector<uint8_t> is_skull(parts.nodes.size(), 0);
    for (size_t i = 0; i < rest.size(); ++i)
      if (skull[i] && parts.of[i] >= 0) is_skull[size_t(parts.of[i])] = 1;
    for (size_t i = 0; i < rest.size(); ++i)
      if (parts.of[i] >= 0 && is_skull[size_t(parts.of[i])]) out.of[i] = BonePart::skull;
    std::vector<std::array<double, 4>> near(parts.nodes.size(), {1e300, 1e300, 1e300, 1e300});
    for (const BonePart p : {BonePart::skull, BonePart::mandible, BonePart::spine}) {
      std::vector<uint8_t> set(rest.size());
      for (size_t i = 0; i < set.size(); ++i) set[i] = out.of[i] == p;
      if (!any(set)) continue;
      const std::vector<float> far = squared_distance(n, set, workers);
      for (size_t i = 0; i < rest.size(); ++i)
        if (parts.of[i] >= 0 && !is_skull[size_t(parts.of[i])]) {
          double& d = near[size_t(parts.of[i])][size_t(p)];
          d = std::min(d, h * std::sqrt(double(far[i])));
        }
    }
    int64_t loose = 0;
    for (size_t i = 0; i < rest.size(); ++i) {
      if (parts.of[i] < 0 || is_skull[size_t(parts.of[i])]) continue;
      const auto& d = near[size_t(parts.of[i])];
      const size_t p = size_t(std::min_element(d.begin() + 1, d.end()) - d.begin());
      if (d[p] <= kNearest_mm)
        out.of[i] = BonePart(p);
      else
        ++loose;
    }
    out.other_cm3 = cm3(loose);
  }
};

}  // namespace

BoneParts part_bones(const BoneSolid& solid, double iso, Workers& workers) { return Parter(solid, iso, workers).run(); }

BoneSolid only(const BoneSolid& solid, const BoneParts& parts, BonePart part, Workers& workers) {
  BoneSolid out = solid;
  const double h = solid.step_mm;
  std::vector<uint8_t> mine(parts.of.size()), others(parts.of.size());
  int64_t count = 0;
  for (size_t i = 0; i < mine.size(); ++i) {
    mine[i] = parts.of[i] == part, others[i] = solid.distance.value[i] < 0 && !mine[i];
    count += mine[i];
  }
  // Half a step outside where another part begins; what is near no bone of this part is far away.
  const std::vector<float> far = squared_distance(solid.distance.size, mine, workers);
  for (size_t i = 0; i < mine.size(); ++i) {
    float& d = out.distance.value[i];
    const double to_mine = h * (std::sqrt(double(far[i])) - 0.5);
    if (others[i])
      d = float(std::max(0.25 * h, to_mine));
    else if (!mine[i])
      d = float(std::max(double(d), to_mine - h));
  }
  out.volume_cm3 = double(count) * h * h * h * 1e-3;
  out.cavity.clear(), out.value.clear();
  return out;
}

}  // namespace limberg
