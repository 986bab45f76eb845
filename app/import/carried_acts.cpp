#include "app/import/carried_acts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "app/import/cut_lines.h"
#include "app/words/words.h"
#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

namespace pm = peer_material;
using Kind = PeerAct::Kind;
using Fate = CarriedAct::Fate;

constexpr double kAbovePeriosteum_mm = 0.5;
constexpr double kNearCut_mm = 12;  // a T-in or a joint reaches so far for a cut
constexpr double kOwnReach_mm = 4;  // a stitch looks so far for its edge
constexpr double kDeeper = 1.1;     // an incision passes the depth at which it is undermined by so much of it
constexpr double kLeastDepth_mm = 0.5;
constexpr double kThickest_mm = 25;  // of tissue over periosteum
constexpr double kHookBeside_mm = 0.8;
constexpr int kStitchesToStage = 5;
constexpr double kTurnedAway = 0.34;  // cosine; the program's own limit is some 78 degrees

std::string place_text(const Vec3& p) { return fmt::format("[{:.3f},{:.3f},{:.3f}]", p.x(), p.y(), p.z()); }
std::string places_text(const std::vector<Vec3>& all) {
  std::string s = "[";
  for (const Vec3& p : all) s += (s.size() > 1 ? "," : "") + place_text(p);
  return s + "]";
}

const char* side_of(int material) {
  return material == pm::underside                                      ? "under"
         : material == pm::bed || material == pm::undermined_periosteum ? "bed"
         : material == pm::cut_side || material == pm::muscle           ? "wall"
                                                                        : "skin";
}

double median_of(std::vector<double> v, double share = 0.5) {
  if (v.empty()) return 0;
  const size_t k = std::min(v.size() - 1, size_t(share * double(v.size())));
  std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(k), v.end());
  return v[k];
}

class Carrier {
 public:
  Carrier(const PeerHistory& history, const PeerModel& model, const CarrySettings& settings)
      : history_(history), m_(model), settings_(settings), cuts_(model), usual_depth_mm_(model.median_depth_mm()) {
    if (!(usual_depth_mm_ > 0)) usual_depth_mm_ = 2;
  }

  CarriedOperation run() {
    find_undermining_depths();
    for (const PeerAct& a : history_.act) {
      stage_before(a.kind);
      now_ = {};
      now_.line = a.line, now_.name = a.name, now_.words = words_of(a.kind);
      const size_t before = out_.script.size();
      if (!a.wrong.empty())
        refuse(a.wrong);
      else
        act(a);
      if (now_.fate == Fate::refused) out_.script.resize(before);
      if (out_.script.size() > before) now_.first = int(before) + 2, now_.last = int(out_.script.size()) + 1;
      out_.act.push_back(now_);
    }
    stage();
    if (out_.script.empty()) say(R"({"action":"stage","name":"nothing was carried"})");
    measure();
    return std::move(out_);
  }

 private:
  // The account.
  void refuse(std::string why) {
    now_.fate = Fate::refused;
    now_.notes.push_back(std::move(why));
  }
  void change(std::string what) {
    if (now_.fate == Fate::carried) now_.fate = Fate::changed;
    now_.notes.push_back(std::move(what));
  }
  void say(std::string line) { out_.script.push_back(std::move(line)); }
  void moved(double mm) { now_.moved_mm = std::max(now_.moved_mm, mm); }

  std::optional<FoundPlace> find(const PeerPlace& place) {
    std::string reason;
    auto f = find_place(m_, place, reason);
    ++now_.places;
    if (!f) {
      refuse(fmt::format(english("line {}: {}"), place.line, reason));
      return f;
    }
    moved(f->moved_mm);
    return f;
  }
  std::optional<std::vector<FoundPlace>> find_all(const PeerAct& a) {
    std::vector<FoundPlace> out;
    for (const PeerAct::Post& p : a.post) {
      const auto f = find(p.place);
      if (!f) return std::nullopt;
      out.push_back(*f);
    }
    return out;
  }
  void worked_at(const SurfaceSpot& s) { out_.worked.push_back(s); }

  // Stages: a picture when one kind of act gives way to another.
  static int group_of(Kind k) {
    switch (k) {
      case Kind::incision:
      case Kind::deep_cut:
        return 1;
      case Kind::excise:
        return 2;
      case Kind::undermine:
      case Kind::undermine_periosteum:
        return 3;
      case Kind::add_hook:
      case Kind::move_hook:
      case Kind::delete_hook:
        return 4;
      case Kind::add_suture:
      case Kind::delete_suture:
        return 5;
      default:
        return 0;
    }
  }
  void stage_before(Kind k) {
    const int group = group_of(k);
    if (group == 0) return;
    // While it is closed hooks and stitches take turns: one stage for several of them.
    const bool closing = group_ >= 4 && group >= 4 && stitches_ > 0;
    if (group_ != 0 && group != group_ && !closing) stage();
    if (closing && stitches_ >= kStitchesToStage) stage();
    group_ = group;
    if (k == Kind::add_suture) ++stitches_;
  }
  void stage() {
    constexpr const char* kNames[] = {"", "cut", "excised", "undermined", "hooks", "sewn"};
    if (out_.script.size() == staged_) return;
    const int named = stitches_ > 0 ? 5 : group_;
    say(fmt::format(R"({{"action":"stage","name":"{} {}"}})", ++stages_, kNames[named]));
    staged_ = out_.script.size(), stitches_ = 0;
  }

  // Depths.
  double depth_at(const SurfaceSpot& s) const {
    return std::max(kLeastDepth_mm, m_.depth_mm(s.triangle, s.bary).value_or(usual_depth_mm_));
  }
  struct UndermineDepth {
    double depth_mm;
    std::vector<Vec3> at_mm;
  };
  void find_undermining_depths() {
    for (const PeerAct& a : history_.act) {
      if (a.kind != Kind::undermine || !a.wrong.empty()) continue;
      UndermineDepth u{0, {}};
      std::vector<double> depth;
      std::string reason;
      for (const PeerAct::Post& p : a.post)
        if (const auto f = find_place(m_, p.place, reason))
          depth.push_back(depth_at(f->spot)), u.at_mm.push_back(f->spot.at_mm);
      u.depth_mm = median_of(depth);
      if (!depth.empty()) undermined_.push_back(std::move(u));
    }
  }
  /// Of an incision: to where the skin ends along it, and through what is undermined beside it.
  double incision_depth(const SurfaceLine& line) const {
    std::vector<double> depth;
    for (const SurfaceSpot& s : line) depth.push_back(depth_at(s));
    double d = median_of(depth, 0.75);
    for (const UndermineDepth& u : undermined_)
      if (near_to(u, line)) d = std::max(d, u.depth_mm);
    return kDeeper * d;
  }
  static bool near_to(const UndermineDepth& u, const SurfaceLine& line) {
    for (const Vec3& p : u.at_mm)
      for (const SurfaceSpot& s : line)
        if ((s.at_mm - p).norm() < 20) return true;
    return false;
  }

  void act(const PeerAct& a) {
    switch (a.kind) {
      case Kind::load_scene:
      case Kind::nothing:
        now_.fate = Fate::passed;
        break;
      case Kind::incision:
        incise(a);
        break;
      case Kind::deep_cut:
        cut_through(a);
        break;
      case Kind::undermine:
        undermine(a);
        break;
      case Kind::undermine_periosteum:
        undermine_periosteum(a);
        break;
      case Kind::excise:
        excise(a);
        break;
      case Kind::add_hook:
        hook(a);
        break;
      case Kind::move_hook:
        if (!hooks_.contains(a.number)) return refuse(fmt::format(english("hook {} was not set"), a.number));
        say(fmt::format(R"({{"action":"move","id":{},"to":{},"seconds":2}})", a.number + 1,
                        place_text(m_.unit_mm * a.to)));
        hooked_.push_back(m_.unit_mm * a.to);
        break;
      case Kind::delete_hook:
        if (hooks_.erase(a.number) == 0) return refuse(fmt::format(english("hook {} was not set"), a.number));
        say(fmt::format(R"({{"action":"release","id":{}}})", a.number + 1));
        break;
      case Kind::add_suture:
        suture(a);
        break;
      case Kind::delete_suture:
        if (!stitched_.contains(a.number)) return refuse(fmt::format(english("stitch {} was not tied"), a.number));
        say(fmt::format(R"({{"action":"cut_suture","at":{}}})", place_text(stitched_.at(a.number))));
        stitched_.erase(a.number);
        break;
      case Kind::unknown:
        break;
    }
  }

  bool only_of_skin(const PeerAct& a, const char* what) {
    for (const PeerAct::Post& p : a.post)
      if (p.place.material != pm::skin) {
        refuse(fmt::format(english("line {}: {} on material {}; ours begins on skin"), p.place.line, what,
                           p.place.material));
        return false;
      }
    return true;
  }

  void incise(const PeerAct& a) {
    if (!only_of_skin(a, "an incision")) return;
    const auto found = find_all(a);
    if (!found) return;
    std::vector<SurfaceSpot> posts;
    for (const FoundPlace& f : *found) posts.push_back(f.spot), worked_at(f.spot);
    const SurfaceSpot first = posts.front();
    bool closed = false;
    if (a.in) join_cut(posts, true);
    if (a.out) {
      const auto near = cuts_.nearest(posts.back().at_mm, kNearCut_mm);
      const double own = (first.at_mm - posts.back().at_mm).norm();
      if (posts.size() > 2 && own < kNearCut_mm && (!near || own <= near->distance_mm)) {
        if (own > cuts_.step_mm())
          posts.push_back(first);
        else
          posts.back() = first;
        closed = !a.in;
      } else {
        join_cut(posts, false);
      }
    }
    const SurfaceLine line = cuts_.through(posts);
    std::vector<Vec3> path;
    for (const SurfaceSpot& s : posts) path.push_back(s.at_mm);
    say(fmt::format(R"({{"action":"incise","path":{},"depth_mm":{:.2f}}})", places_text(path), incision_depth(line)));
    cuts_.add(line, false);
    if (closed) rings_.push_back({{path.begin(), path.end() - 1}, line});
  }

  /// The first post, or the last one, goes on to the nearest cut.
  void join_cut(std::vector<SurfaceSpot>& posts, bool at_start) {
    SurfaceSpot& end = at_start ? posts.front() : posts.back();
    const auto near = cuts_.nearest(end.at_mm, kNearCut_mm);
    if (!near)
      return change(fmt::format(english("its {} was to join a cut, and none is near"), at_start ? "start" : "end"));
    moved(near->distance_mm);
    const SurfaceSpot joint = walk_to(m_, end, near->at_mm, 1.5 * near->distance_mm + 1);
    if ((joint.at_mm - end.at_mm).norm() < 2 * cuts_.step_mm())
      end = joint;
    else
      posts.insert(at_start ? posts.begin() : posts.end(), joint);
  }

  void cut_through(const PeerAct& a) {
    const auto on_bed =
        std::count_if(a.post.begin(), a.post.end(), [](const PeerAct::Post& p) { return p.place.material == pm::bed; });
    for (const PeerAct::Post& p : a.post)
      if (p.place.material != (on_bed > 0 ? pm::bed : pm::skin) && (on_bed > 0 || p.place.material != pm::periphery))
        return refuse(
            fmt::format(english("line {}: a cut that begins on material {}; ours begins on the outer surface, or "
                                "all of it on the bed below a raised flap"),
                        p.place.line, p.place.material));
    const auto found = find_all(a);
    if (!found) return;
    std::vector<SurfaceSpot> posts;
    std::vector<Vec3> path, normals;
    for (size_t i = 0; i < found->size(); ++i) {
      posts.push_back((*found)[i].spot), worked_at(posts.back());
      path.push_back((*found)[i].inner ? (*found)[i].inner_mm : posts.back().at_mm);
      normals.push_back(a.post[i].normal.normalized());
    }
    if (posts.size() < 2) return refuse(english("one post; two or more make a cut"));
    say(fmt::format(R"({{"action":"cut_through","path":{},"normals":{},"open_start":{},"open_end":{}{}}})",
                    places_text(path), places_text(normals), a.in, a.out, on_bed > 0 ? R"(,"from_bed":true)" : ""));
    if (on_bed > 0) return;  // it shows nowhere on the skin
    for (size_t i = 0; i + 1 < posts.size(); ++i) {
      const SurfaceLine part = cuts_.between(posts[i], posts[i + 1]);
      cuts_.add(part, true);
      add_exit(part, normals[i], normals[i + 1]);
    }
    const size_t n = posts.size();
    if (a.in) add_margin(posts[0], path[1], normals[0]);
    if (a.out) add_margin(posts[n - 1], path[n - 2], normals[n - 1]);
  }

  /// From an open end of a cut on the skin over the free margin to where the blade comes out: round in the blade's
  /// plane.
  void add_margin(const SurfaceSpot& last, const Vec3& before_mm, const Vec3& out) {
    std::array<Bvh::LineHit, 8> hits;
    const int n = std::min<int>(m_.all.line(last.at_mm, -out, 0.1, 100, hits), int(hits.size()));
    const Bvh::LineHit* exit = nullptr;
    for (int k = 0; k < n && !exit; ++k)
      if (!hits[size_t(k)].from_outside) exit = &hits[size_t(k)];
    Vec3 way = last.at_mm - before_mm;
    way -= way.dot(out) * out;
    if (!exit || way.norm() < 1e-6) return;
    const Vec3 goal = m_.at(exit->triangle, exit->bary), across = way.normalized().cross(out);
    const double step = cuts_.step_mm();
    SurfaceLine line{last};
    for (double left = 60; left > 0; left -= step) {
      const SurfaceSpot& here = line.back();
      const Vec3 along = across.cross(m_.normal_at(here.triangle, here.bary));
      Vec3 to = here.at_mm - step * along.normalized();
      to -= across.dot(to - last.at_mm) * across;
      const SurfaceSpot next = walk_to(m_, here, to, 6 * step);
      if ((next.at_mm - here.at_mm).norm() < 0.1 * step) return;
      line.push_back(next);
      if ((next.at_mm - goal).norm() < 2 * step) return cuts_.add(line, true);
    }
  }

  /// The other side of a cut through the body, as far as it is there.
  void add_exit(const SurfaceLine& line, const Vec3& n0, const Vec3& n1) {
    SurfaceLine exit;
    const auto flush = [&] {
      if (exit.size() > 1) cuts_.add(cuts_.through(exit), true);
      exit.clear();
    };
    for (size_t i = 0; i < line.size(); ++i) {
      const double s = line.size() > 1 ? double(i) / double(line.size() - 1) : 0;
      const Vec3 down = -((1 - s) * n0 + s * n1).normalized();
      std::array<Bvh::LineHit, 8> hits;
      const int n = std::min<int>(m_.all.line(line[i].at_mm, down, 0.1, 100, hits), int(hits.size()));
      const Bvh::LineHit* out = nullptr;
      for (int k = 0; k < n && !out; ++k)
        if (!hits[size_t(k)].from_outside) out = &hits[size_t(k)];
      if (!out || m_.material[size_t(out->triangle)] != pm::skin) {
        flush();
        continue;
      }
      const SurfaceSpot spot{out->triangle, out->bary, m_.at(out->triangle, out->bary)};
      if (!exit.empty() && (exit.back().at_mm - spot.at_mm).norm() > 5) flush();
      exit.push_back(spot);
    }
    flush();
  }

  void undermine(const PeerAct& a) {
    for (const PeerAct::Post& p : a.post)
      if (p.place.material != pm::skin)
        return refuse(fmt::format(english("line {}: undermining from material {}; ours goes below skin"), p.place.line,
                                  p.place.material));
    const auto found = find_all(a);
    if (!found) return;
    std::vector<SurfaceSpot> posts;
    std::vector<double> depth;
    for (const FoundPlace& f : *found) posts.push_back(f.spot), depth.push_back(depth_at(f.spot)), worked_at(f.spot);
    leave_out_what_turns_away(posts, false);
    const auto outline = enclosed(a, posts);
    if (!outline) return refuse(english("encloses nothing: two points, and no way along cuts between them"));
    const double d = median_of(depth);
    const auto [least, most] = std::minmax_element(depth.begin(), depth.end());
    say(fmt::format(R"({{"action":"undermine","outline":{},"depth_mm":{:.2f}}})", places_text(*outline), d));
    if (*most > 1.5 * *least)
      change(fmt::format(english("at one depth, {:.1f} mm; the skin is {:.1f} to {:.1f} mm deep there"), d, *least,
                         *most));
  }

  /// An act of ours looks at the skin from one side; a point on skin that turns away from there is left out. `ends`:
  /// the first and the last may be.
  void leave_out_what_turns_away(std::vector<SurfaceSpot>& posts, bool ends) {
    int left_out = 0;
    for (bool again = true; again && posts.size() > 4;) {
      Vec3 mean = Vec3::Zero();
      for (const SurfaceSpot& s : posts) mean += m_.normal_at(s.triangle, s.bary);
      mean.normalize();
      const std::ptrdiff_t kept = ends ? 0 : 1;
      const auto worst = std::min_element(posts.begin() + kept, posts.end() - kept, [&](const auto& x, const auto& y) {
        return m_.normal_at(x.triangle, x.bary).dot(mean) < m_.normal_at(y.triangle, y.bary).dot(mean);
      });
      again = m_.normal_at(worst->triangle, worst->bary).dot(mean) < kTurnedAway;
      if (again) posts.erase(worst), ++left_out;
    }
    if (left_out > 0)
      change(fmt::format(
          english("{} of its points left out, where the skin turns away from the others by more than 70 degrees"),
          left_out));
  }

  /// The places of an outline as who looks along -n sees them: a cut within a fold lies below skin, and the pocket that
  /// joins it ends below that skin.
  std::vector<Vec3> seen_along(const std::vector<Vec3>& outline, const Vec3& n) const {
    std::vector<Vec3> out;
    for (const Vec3& p : outline) {
      std::array<Bvh::LineHit, 8> hits;
      const int count =
          std::min<int>(m_.all.line(p + kThickest_mm * n, -n, 0, kThickest_mm + 0.5, hits), int(hits.size()));
      for (int k = 0; k < count; ++k) {
        const Bvh::LineHit& h = hits[size_t(k)];
        if (!h.from_outside || m_.material[size_t(h.triangle)] != pm::skin ||
            m_.normal_at(h.triangle, h.bary).dot(n) < kTurnedAway)
          continue;
        out.push_back(m_.at(h.triangle, h.bary));
        break;
      }
    }
    return out;
  }

  /// Points joined in their order, closed along the cuts where both ends are joined to one.
  std::optional<std::vector<Vec3>> enclosed(const PeerAct& a, const std::vector<SurfaceSpot>& posts) {
    std::vector<Vec3> outline;
    for (const SurfaceSpot& s : posts) outline.push_back(s.at_mm);
    // Cuts that the points between the ends are joined to lie within the outline or on it already.
    const auto start = a.post.front().connect ? cuts_.nearest(posts.front().at_mm, kNearCut_mm) : std::nullopt;
    const auto end = a.post.back().connect ? cuts_.nearest(posts.back().at_mm, kNearCut_mm) : std::nullopt;
    for (const auto& [post, near] : {std::pair{&a.post.front(), &start}, std::pair{&a.post.back(), &end}})
      if (post->connect && !*near) change(english("a point was to be joined to a cut, and none is near"));
    std::vector<Vec3> back;
    if (start && end) back = cuts_.way(*end, *start);
    if (start && end && back.empty()) {
      change(english("its two joints lie on cuts that do not meet; closed straight between them"));
      back = {end->at_mm, start->at_mm};
    } else if (start && !end) {
      back = {start->at_mm};
    } else if (end && !start) {
      back = {end->at_mm};
    }
    back = simplify(back, cuts_.step_mm());
    outline.insert(outline.end(), back.begin(), back.end());
    std::vector<Vec3> out;
    for (const Vec3& p : outline)
      if (out.empty() || (out.back() - p).norm() > 0.5 * cuts_.step_mm()) out.push_back(p);
    while (out.size() > 1 && (out.back() - out.front()).norm() <= 0.5 * cuts_.step_mm()) out.pop_back();
    if (out.size() < 3) return std::nullopt;
    return out;
  }

  void undermine_periosteum(const PeerAct& a) {
    const auto found = find_all(a);
    if (!found) return;
    std::vector<SurfaceSpot> above;
    std::vector<double> thickness;
    for (const FoundPlace& f : *found) {
      const Vec3 down = m_.normal_at(f.spot.triangle, f.spot.bary);  // out of the body: towards the bone
      std::array<Bvh::LineHit, 8> hits;
      const int n = std::min<int>(m_.all.line(f.spot.at_mm, -down, 0.05, 2 * kThickest_mm, hits), int(hits.size()));
      const Bvh::LineHit* out = nullptr;
      for (int k = 0; k < n && !out; ++k)
        if (!hits[size_t(k)].from_outside) out = &hits[size_t(k)];
      if (!out || m_.material[size_t(out->triangle)] != pm::skin || out->t > kThickest_mm)
        return refuse(
            english("there is no skin within 25 mm over a point of the periosteum; ours undermines from the skin"));
      above.push_back({out->triangle, out->bary, m_.at(out->triangle, out->bary)});
      thickness.push_back(out->t);
    }
    Vec3 outwards = Vec3::Zero();
    for (const SurfaceSpot& s : above) outwards += m_.normal_at(s.triangle, s.bary);
    leave_out_what_turns_away(above, true);  // over a bone's edge the skin may be a fold's other side
    auto outline = enclosed(a, above);
    if (outline) outline = seen_along(*outline, outwards.normalized());
    if (!outline || outline->size() < 3) return refuse(english("encloses nothing"));
    for (const SurfaceSpot& s : above) worked_at(s);
    // Deep enough for what lies between the points too; where nothing is held the pocket is not deeper than beside it.
    const double most = *std::max_element(thickness.begin(), thickness.end());
    say(fmt::format(R"({{"action":"undermine","outline":{},"depth_mm":{:.2f},"above_held_mm":{:g}}})",
                    places_text(*outline), std::min(1.25 * most + 1, kThickest_mm), kAbovePeriosteum_mm));
    change(fmt::format(english("undermined from the skin, {:.1f} mm above the periosteum, which stays on the bone"),
                       kAbovePeriosteum_mm));
  }

  void excise(const PeerAct& a) {
    const auto f = find(a.post[0].place);
    if (!f) return;
    worked_at(f->spot);
    const auto region = cuts_.region(f->spot);
    const auto near = cuts_.nearest(f->spot.at_mm, 40);
    const bool through = region ? region->blade_through : near && near->blade_through;
    if (f->inner || through) {
      say(fmt::format(R"({{"action":"excise","at":{}}})", place_text(f->spot.at_mm)));
      return;
    }
    if (!region) return refuse(english("no cut encloses the place: it would take the patient"));
    // Where a closed incision is all of its border, along the same straight pieces.
    const std::vector<Vec3>* outline = &region->outline;
    double depth = depth_at(f->spot);
    for (const Ring& r : rings_) {
      const bool all = std::all_of(region->outline.begin(), region->outline.end(), [&](const Vec3& p) {
        return std::any_of(r.line.begin(), r.line.end(),
                           [&](const SurfaceSpot& s) { return (s.at_mm - p).norm() < 2 * cuts_.step_mm(); });
      });
      if (all) outline = &r.posts;
    }
    for (const UndermineDepth& u : undermined_) depth = std::max(depth, near_to(u, {f->spot}) ? u.depth_mm : 0);
    say(fmt::format(R"({{"action":"excise","outline":{},"depth_mm":{:.2f}}})", places_text(*outline), depth));
  }
  struct Ring {
    std::vector<Vec3> posts;
    SurfaceLine line;
  };

  /// Where a place on skin lies when it stays on the bank that it was recorded from: walked from where the texture has
  /// it, not over a cut.
  Vec3 on_bank(const FoundPlace& f, double beside_mm) {
    const SurfaceLine way = cuts_.between(f.start, f.spot);
    for (size_t i = 0; i + 1 < way.size(); ++i) {
      const Vec3 n = m_.normal_at(way[i].triangle, way[i].bary);
      const auto met = cuts_.crossing(way[i].at_mm, way[i + 1].at_mm, n);
      if (!met) continue;
      return back_along(way, i, met->at_mm, beside_mm);
    }
    return f.spot.at_mm;
  }
  /// So far back from a point between spots i and i + 1 of a way.
  static Vec3 back_along(const SurfaceLine& way, size_t i, Vec3 from, double mm) {
    for (size_t k = i + 1; k-- > 0;) {
      const double step = (way[k].at_mm - from).norm();
      if (step >= mm) return from + (way[k].at_mm - from) * (mm / step);
      mm -= step, from = way[k].at_mm;
    }
    return from;
  }

  /// A stitch's end: laid just beside the edge of its bank.
  Vec3 bite(const FoundPlace& f) {
    Vec3 at = on_bank(f, settings_.beside_mm);
    auto near = cuts_.nearest(at, kOwnReach_mm);
    // Not one of the other lip, which is near through the air.
    if (near && (walk_to(m_, f.spot, near->at_mm, 2 * kOwnReach_mm).at_mm - near->at_mm).norm() > cuts_.step_mm())
      near.reset();
    if (!near) {
      change(english("no cut lies within 4 mm of an end"));
      return at;
    }
    if (near->distance_mm > 1.5 * settings_.beside_mm || near->distance_mm < 0.5 * settings_.beside_mm) {
      Vec3 away = at - near->at_mm;
      if (away.norm() < 0.05) away = f.start.at_mm - near->at_mm;
      const Vec3 n = m_.normal_at(f.spot.triangle, f.spot.bary);
      away -= away.dot(n) * n;
      if (away.norm() > 1e-3) at = near->at_mm + settings_.beside_mm * away.normalized();
    }
    moved((at - f.spot.at_mm).norm());
    return at;
  }

  /// A place on a cut face, a little to the side that is meant: both faces lie in one place at rest.
  Vec3 on_cut_face(const FoundPlace& f, int material) {
    const Vec3 up = m_.normal_at(f.spot.triangle, f.spot.bary);
    const double off = material == pm::underside ? 0.2 : material == pm::bed ? -0.2 : 0;
    return f.inner_mm + off * up;
  }

  std::optional<Vec3> held_at(const PeerPlace& place, const FoundPlace& f, double beside_mm, bool stitch) {
    if (place.material == pm::periosteum) {
      refuse(
          fmt::format(english("line {}: on periosteum that lies on the bone; ours holds nothing there"), place.line));
      return std::nullopt;
    }
    if (place.material == pm::undermined_periosteum) return f.spot.at_mm;
    if (f.inner) return on_cut_face(f, place.material);
    return stitch ? bite(f) : on_bank(f, beside_mm);
  }

  void hook(const PeerAct& a) {
    if (hooks_.contains(a.number)) return refuse(fmt::format(english("hook {} is set already"), a.number));
    if (a.number < 0) return refuse(english("a hook's number below 0"));
    const auto f = find(a.post[0].place);
    if (!f) return;
    const int material = a.post[0].place.material;
    const auto at = held_at(a.post[0].place, *f, kHookBeside_mm, false);
    if (!at) return;
    worked_at(f->spot);
    const std::string side = side_of(material);
    say(fmt::format(R"({{"action":"hook","id":{},"at":{}{}}})", a.number + 1, place_text(*at),
                    side == "skin" ? "" : R"(,"surface":")" + side + "\""));
    hooks_[a.number] = *at;
    if (a.strong) now_.notes.push_back(english("the peer's strong hook; ours pulls as every hook of the scene"));
  }

  void suture(const PeerAct& a) {
    const auto found = find_all(a);
    if (!found) return;
    Vec3 at[2];
    std::string side[2];
    for (size_t i = 0; i < 2; ++i) {
      const auto p = held_at(a.post[i].place, (*found)[i], settings_.beside_mm, true);
      if (!p) return;
      at[i] = *p, side[i] = side_of(a.post[i].place.material);
      worked_at((*found)[i].spot);
    }
    std::string line = fmt::format(R"({{"action":"suture","a":{},"b":{})", place_text(at[0]), place_text(at[1]));
    for (size_t i = 0; i < 2; ++i)
      if (side[i] != "skin") line += fmt::format(R"(,"surface_{}":"{}")", i == 0 ? 'a' : 'b', side[i]);
    say(line + "}");
    stitched_[a.number] = at[0];
    const Tied tied{at[0], at[1], side[0] == "skin" && side[1] == "skin"};
    ends_.insert(ends_.end(), {tied.a, tied.b});
    if (a.linked) row(tied);
    last_ = tied;
  }

  struct Tied {
    Vec3 a, b;
    bool through_skin;
  };
  void row(const Tied& tied) {
    if (!last_) return change(english("linked to no earlier stitch"));
    if (!tied.through_skin || !last_->through_skin)
      return change(english("linked to a stitch in a cut face; ours sews rows along edges of skin only"));
    const double length = std::min(bank_length(last_->a, tied.a), bank_length(last_->b, tied.b));
    if (length < 1.6 * settings_.spacing_mm) {
      now_.notes.push_back(
          fmt::format(english("its row to the stitch before is {:.1f} mm long: no room for one more"), length));
      return;
    }
    say(fmt::format(R"({{"action":"suture_between","from":{},"to":{},"spacing_mm":{:g}}})", place_text(told_by(*last_)),
                    place_text(told_by(tied)), settings_.spacing_mm));
  }
  /// The end of a stitch by which it is told from the others: the farther from theirs.
  Vec3 told_by(const Tied& tied) const {
    const auto apart = [&](const Vec3& p) {
      double least = 1e300;
      for (const Vec3& q : ends_)
        if (q != tied.a && q != tied.b) least = std::min(least, (p - q).norm());
      return least;
    };
    return apart(tied.a) >= apart(tied.b) ? tied.a : tied.b;
  }
  double bank_length(const Vec3& a, const Vec3& b) const {
    double length = (a - b).norm();
    const auto from = cuts_.nearest(a, kOwnReach_mm), to = cuts_.nearest(b, kOwnReach_mm);
    if (!from || !to) return length;
    const std::vector<Vec3> way = cuts_.way(*from, *to);
    double along = 0;
    for (size_t i = 0; i + 1 < way.size(); ++i) along += (way[i + 1] - way[i]).norm();
    return std::max(length, along);
  }

  void measure() {
    if (out_.worked.empty()) {
      out_.middle_mm = 0.5 * (m_.low_mm + m_.high_mm);
      out_.reach_mm = 0.5 * (m_.high_mm - m_.low_mm).norm();
      return;
    }
    Vec3 low = out_.worked[0].at_mm, high = low, n = Vec3::Zero();
    for (const SurfaceSpot& s : out_.worked) {
      low = low.cwiseMin(s.at_mm), high = high.cwiseMax(s.at_mm);
      n += m_.normal_at(s.triangle, s.bary);
    }
    out_.middle_mm = m_.all.closest(0.5 * (low + high)).point_mm;
    out_.outwards = n.norm() > 1e-3 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
    for (const SurfaceSpot& s : out_.worked) out_.reach_mm = std::max(out_.reach_mm, (s.at_mm - out_.middle_mm).norm());
  }

  const PeerHistory& history_;
  const PeerModel& m_;
  const CarrySettings& settings_;
  CutLines cuts_;
  double usual_depth_mm_;
  CarriedOperation out_;
  CarriedAct now_;
  std::vector<UndermineDepth> undermined_;
  std::vector<Ring> rings_;
  std::map<int, Vec3> hooks_, stitched_;
  std::vector<Vec3> hooked_;
  std::optional<Tied> last_;
  std::vector<Vec3> ends_;  // of all stitches
  int group_ = 0, stitches_ = 0, stages_ = 0;
  size_t staged_ = 0;
};

}  // namespace

const char* words_of(CarriedAct::Fate fate) {
  switch (fate) {
    case Fate::carried:
      return english("carried");
    case Fate::changed:
      return english("changed");
    case Fate::refused:
      return english("refused");
    case Fate::passed:
      return english("nothing to do");
  }
  return "";
}

int CarriedOperation::count(CarriedAct::Fate fate) const {
  return int(std::count_if(act.begin(), act.end(), [&](const CarriedAct& a) { return a.fate == fate; }));
}

CarriedOperation carry(const PeerHistory& history, const PeerModel& model, const CarrySettings& settings) {
  return Carrier(history, model, settings).run();
}

}  // namespace limberg
