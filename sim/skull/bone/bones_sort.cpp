// Fragments put together by their cut rings: what the sorting found becomes poses and words.
#include <algorithm>
#include <cmath>

#include "sim/base/union_find.h"
#include "sim/geometry/rotation.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/sorting.h"
#include "sim/skull/bone/words.h"

namespace limberg::bone {
namespace {

/// How far a place and the directions there are from each other under two poses.
struct Apart {
  double mm = 0, deg = 0;
  /// A fifth of the nearest that a fit of rings looks (sorting.cpp).
  bool nothing() const { return mm <= 0.01 && deg <= 0.01; }
};

Apart apart(const Eigen::Isometry3d& was, const Eigen::Isometry3d& is, const Vec3& at_mm) {
  return {(is * at_mm - was * at_mm).norm(), axis_angle(is.linear() * was.linear().transpose()).angle * 180 / M_PI};
}

bool has(const Match& m, size_t piece) { return size_t(m.a) == piece || size_t(m.b) == piece; }

/// What verified pairs join, two or more, each by number. (A group of
/// the sorting may hold a pair that lies together and does not stand.)
std::vector<std::vector<size_t>> joined(const std::vector<Match>& matches, size_t pieces) {
  UnionFind group(pieces);
  for (const Match& m : matches) group.unite(m.a, m.b);
  std::vector<std::vector<size_t>> members(pieces);
  for (size_t i = 0; i < pieces; ++i) members[size_t(group.find(int32_t(i)))].push_back(i);
  std::erase_if(members, [](const std::vector<size_t>& m) { return m.size() < 2; });
  return members;
}

/// Of its longest pair.
std::string moved_words(const std::string& name, const Apart& by, const std::vector<Match>& matches, size_t piece) {
  const Match& best = *std::find_if(matches.begin(), matches.end(), [&](const Match& m) { return has(m, piece); });
  return name + text(" put where it fits: by %.1f mm and %.1f degrees (rings together for %.0f mm, %.2f mm apart)",
                     by.mm, by.deg, best.length_mm, best.residual_mm);
}

std::string alone_words(const std::vector<Fragment>& fragments, const Sorting& found, size_t piece) {
  for (const Unmatched& u : found.refused)  // pairs that fitted by themselves come first
    if (size_t(u.a) == piece || size_t(u.b) == piece)
      return fragments[piece].name + " fits nothing: with " +
             fragments[size_t(u.a) == piece ? size_t(u.b) : size_t(u.a)].name + ", " + u.reason;
  return fragments[piece].name + " fits nothing";
}

}  // namespace

ActedOnBone Bones::sort() {
  if (hold_) return refused(kHeld);
  const Sorting found = sort_fragments(pieces_of(*this));  // its pieces in the order of the fragments
  BonesState to = now_;
  std::string words;
  const auto say = [&](const std::string& s) { words += (words.empty() ? "" : "; ") + s; };
  const auto fixed = [&](size_t i) { return now_.fragments[i].fixed; };
  bool moves = false;
  for (const std::vector<size_t>& group : joined(found.matches, now_.fragments.size())) {
    const auto held = std::find_if(group.begin(), group.end(), fixed);
    if (held != group.end())
      if (const auto other = std::find_if(held + 1, group.end(), fixed); other != group.end())
        return refused(now_.fragments[*held].name + " and " + now_.fragments[*other].name +
                       " fit each other and are fixed, both; expected one of them at most");
    const size_t stays = held != group.end() ? *held : group.front();
    for (const size_t i : group) {
      Fragment& f = to.fragments[i];
      const Eigen::Isometry3d pose = found.pose[stays].inverse() * found.pose[i] * f.pose;
      const Apart by = apart(f.pose, pose, f.centre_mm);
      if (i == stays || by.nothing()) continue;
      f.pose = pose, moves = true;
      say(moved_words(f.name, by, found.matches, i));
    }
  }
  for (size_t i = 0; i < now_.fragments.size(); ++i)
    if (std::none_of(found.matches.begin(), found.matches.end(), [&](const Match& m) { return has(m, i); }))
      say(alone_words(now_.fragments, found, i));
  if (found.matches.empty())
    return refused("no fragment fits another by its cut rings (" + words +
                   "); expected fragments that were cut from each other");
  if (!moves)
    return refused("the fragments that fit each other lie so already" + (words.empty() ? "" : " (" + words + ")"));
  for (const Plate& p : now_.plates) {
    const auto b_in_a = [&](const BonesState& s) {
      return Eigen::Isometry3d(s.fragments[size_t(index(p.a))].pose.inverse() * s.fragments[size_t(index(p.b))].pose);
    };
    const Apart bent = apart(b_in_a(now_), b_in_a(to), p.b_mm);
    if (bent.nothing()) continue;
    return refused(
        fragment(p.a)->name + " and " + fragment(p.b)->name +
        text(" would go %.2f mm and %.2f degrees from each other, and a plate holds them; expected it taken off",
             bent.mm, bent.deg));
  }
  BoneChange change;
  change.before = std::move(now_);
  now_ = std::move(to);
  return finish(std::move(change), std::move(words));
}

}  // namespace limberg::bone
