#include "sim/skull/bone/osteotomy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "sim/geometry/polyline.h"
#include "sim/skull/bone/aim.h"
#include "sim/skull/bone/corner_blade.h"
#include "sim/skull/bone/drawn_path.h"
#include "sim/skull/bone/section.h"
#include "sim/skull/bone/surface.h"
#include "sim/skull/bone/wall.h"

namespace limberg::bone {
namespace {

using simplex::Crossing;
using simplex::Mesh;

/// The curves that bound one piece of cut surface: an outer one,
/// and what lies within it. Indices into the list of curves.
struct Piece {
  std::vector<size_t> curve;
};

struct Plan {
  std::string reason;
  std::vector<std::vector<Crossing>> curve;
  std::vector<Piece> piece;
  std::function<Vec2(const Vec3&)> flat;  // of a plane, of a fan of planes
  std::optional<CornerBlade> blade;
};

std::vector<Vec3> places(const Mesh& m, const std::vector<Crossing>& c) {
  std::vector<Vec3> x;
  for (const Crossing& k : c) x.push_back((1 - k.t) * m.x_mm[size_t(k.left)] + k.t * m.x_mm[size_t(k.right)]);
  return x;
}

struct Axes {
  Vec3 u, v;
  explicit Axes(const Vec3& n) : u(n.unitOrthogonal()), v(n.cross(u)) {}
  Vec2 operator()(const Vec3& x) const { return {u.dot(x), v.dot(x)}; }
};

/// Curves on a surface that lies flat, in sets: an outer one and what lies within it.
void into_pieces(const Mesh& m, const Osteotomy& o, Section::Curves&& found, Plan& plan) {
  const bool all = o.kind == Osteotomy::Kind::fan || o.radius_mm <= 0;
  std::vector<std::vector<Vec2>> polygon;
  std::vector<double> twice;
  std::vector<uint8_t> wanted;
  for (const auto& c : found.closed) {
    polygon.emplace_back();
    double near = 1e300;
    for (const Vec3& x : places(m, c))
      polygon.back().push_back(plan.flat(x)), near = std::min(near, (x - o.point_mm).norm());
    twice.push_back(2 * signed_area(polygon.back()));
    wanted.push_back(all || near <= o.radius_mm);
  }
  // Seen against the normal, outer curves run counter-clockwise and the ones around cavities clockwise.
  std::vector<int32_t> outer_of(polygon.size(), -1);
  for (size_t i = 0; i < polygon.size(); ++i) {
    if (twice[i] >= 0) continue;
    for (size_t j = 0; j < polygon.size(); ++j)
      if (twice[j] > 0 && inside_polygon(polygon[j], polygon[i][0]) &&
          (outer_of[i] < 0 || twice[j] < twice[size_t(outer_of[i])]))
        outer_of[i] = int32_t(j);
  }
  std::vector<Piece> pieces;
  const bool fan = o.kind == Osteotomy::Kind::fan;
  bool over_ends = all && found.over_ends > 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    if (twice[i] < 0) {
      if (outer_of[i] < 0 && wanted[i]) over_ends = true;  // its outer curve is not closed
      continue;
    }
    Piece p{{i}};
    bool any = wanted[i];
    for (size_t j = 0; j < polygon.size(); ++j)
      if (outer_of[j] == int32_t(i)) p.curve.push_back(j), any |= bool(wanted[j]);
    if (any) pieces.push_back(std::move(p));
  }
  if (over_ends)
    plan.reason = std::string(fan ? "the blade" : "the plane") + " runs over the ring of a hole";
  else if (all && found.open > 0)
    plan.reason = fan ? "the blade ends within the bone" : "the plane meets the bone in an open curve";
  else if (pieces.empty())
    plan.reason = "the plane does not meet the bone within " + std::to_string(int(o.radius_mm)) + " mm of its point";
  plan.curve = std::move(found.closed), plan.piece = std::move(pieces);
}

Plan plan_plane(const Mesh& m, std::span<const uint8_t> in, const Osteotomy& o) {
  Plan plan;
  if (!o.point_mm.allFinite() || !o.normal.allFinite() || !(o.normal.norm() > 1e-9)) {
    plan.reason = "a plane needs a finite point and a normal that is not zero";
    return plan;
  }
  const Vec3 n = o.normal.normalized();
  Section section = section_of_plane(m, in, o.point_mm, n);
  section.mend();
  Section::Curves found = section.curves();
  if (found.closed.empty() && found.open + found.over_ends == 0) {
    plan.reason = "the plane does not meet the bone";
    return plan;
  }
  plan.flat = Axes(n);
  into_pieces(m, o, std::move(found), plan);
  return plan;
}

Plan plan_fan(const Mesh& m, std::span<const uint8_t> in, const Osteotomy& o) {
  Plan plan;
  plan.blade.emplace(o.point_mm, o.ray, o.radius_mm);
  plan.reason = plan.blade->fault();
  if (!plan.reason.empty()) return plan;
  Section section = section_of_ribbon(m, in, plan.blade->places_mm(), plan.blade->triangles());
  section.mend();
  Section::Curves found = section.curves();
  if (found.closed.empty() && found.open + found.over_ends == 0) {
    plan.reason = "the blade does not meet the bone";
    return plan;
  }
  plan.flat = [blade = *plan.blade](const Vec3& x) { return blade.unrolled(x); };
  into_pieces(m, o, std::move(found), plan);
  return plan;
}

Plan plan_contour(const Mesh& m, std::span<const uint8_t> in, const Osteotomy& o) {
  Plan plan;
  const BoneSurface bone = bone_surface(m, in);
  const DrawnPath path = lay_path(bone, o.path_mm);
  plan.reason = path.reason;
  if (!plan.reason.empty()) return plan;
  constexpr double kAbove_mm = 1;  // the blade starts so far over the surface
  const bool solid = is_solid(path, o.deepest_mm);
  // As deep as the bone is nearby along the path, and some more;
  // where the other table falls away steeply, more of both.
  struct Try {
    int reach;  // places to either side
    double factor;
  };
  Section::Curves found;
  const auto good = [&] { return !solid && found.over_ends == 0 && found.open == 0 && found.closed.size() == 2; };
  const auto depths = [&](const std::vector<double>& bone_mm, double deepest, const Try& attempt) {
    std::vector<double> depth(bone_mm.size(), kAbove_mm);
    const int n = int(depth.size());
    for (int i = 0; i < n && !solid; ++i) {
      double most = 0;
      for (int k = -attempt.reach; k <= attempt.reach; ++k)
        if (const double d = bone_mm[size_t(((i + k) % n + n) % n)]; d <= deepest) most = std::max(most, d);
      depth[size_t(i)] = attempt.factor * most + kAbove_mm;
    }
    return depth;
  };
  const auto saw = [&](const Ribbon& ribbon) {
    Section section = section_of_ribbon(m, in, ribbon.X_mm, ribbon.tri);
    section.mend();
    found = section.curves();
  };
  for (const Try& attempt : {Try{3, 1.3}, Try{8, 1.5}, Try{16, 1.8}}) {
    saw(sweep(path, kAbove_mm, depths(path.depth_mm, o.deepest_mm, attempt)));
    if (solid || found.over_ends > 0 || good()) break;
  }
  if (!solid && found.over_ends == 0 && !good()) {
    // Straight in it does not do: tilted to where the other table is (aim.h).
    const Section::Curves straight = found;
    if (const Aim aim = aim_blade(m, bone, path, o.deepest_mm); aim.reason.empty())
      for (const Try& attempt : {Try{0, 1.2}, Try{2, 1.3}, Try{5, 1.4}}) {
        saw(sweep_tilted(path, aim.inward, 2 * kAbove_mm, depths(aim.depth_mm, kLonger * o.deepest_mm, attempt)));
        if (good()) break;
      }
    if (!good()) found = straight;
  }
  if (found.over_ends > 0)
    plan.reason = "the contour runs over the ring of a hole";
  else if (found.closed.empty() && found.open == 0)
    plan.reason = "the contour is too small: it crosses no edge of the bone's mesh";
  else if (found.open > 0)
    plan.reason =
        solid ? "the contour meets the bone in open curves" : "the swept surface meets the other table in open curves";
  else if (solid && found.closed.size() > 1)
    plan.reason = "the contour meets the bone in " + std::to_string(found.closed.size()) + " curves; one was expected";
  else if (!solid && found.closed.size() != 2)
    plan.reason = found.closed.size() < 2 ? "the swept surface does not reach the other table"
                                          : "the swept surface meets the other table in several curves";
  if (!plan.reason.empty()) return plan;
  plan.curve = std::move(found.closed);
  Piece p{{0}};
  if (plan.curve.size() == 2) {
    // The outer one is the one on the path.
    const auto far = [&](const std::vector<Crossing>& c) {
      double sum = 0;
      for (const Vec3& x : places(m, c)) {
        double near = 1e300;
        for (const Vec3& y : path.x_mm) near = std::min(near, (x - y).squaredNorm());
        sum += std::sqrt(near) / double(c.size());
      }
      return sum;
    };
    const bool first = far(plan.curve[0]) <= far(plan.curve[1]);
    p.curve = {first ? size_t(0) : size_t(1), first ? size_t(1) : size_t(0)};
  }
  plan.piece.push_back(std::move(p));
  return plan;
}

/// Cuts along one curve; what faces what across it.
std::string cut_curve(Mesh& m, const std::vector<Crossing>& curve, simplex::Delta& delta, Facing& mouth) {
  const simplex::OperatorResult o = simplex::t4_edges(m, curve, simplex::CutPolicy::any, delta);
  if (!o) {
    switch (o.answer) {
      case simplex::Answer::on_contour:
        return "the cut crosses a kept contour";
      case simplex::Answer::locked:
        return "the cut crosses locked bone";
      case simplex::Answer::end_face:
        return "the cut runs over the ring of a hole";
      case simplex::Answer::too_short:
        return "the cut is too small: it crosses fewer than three edges";
      case simplex::Answer::repeated_vertex:
      case simplex::Answer::touches_face_twice:
        return "the cut turns too sharply for the bone's mesh: it leaves a face and comes back to it";
      default:
        return simplex::sentence(o.answer);
    }
  }
  mouth.face_left = o.face[0], mouth.face_right = o.face[1];
  mouth.right = m.ring(o.face[1]), mouth.left = m.ring(o.face[0]);
  std::reverse(mouth.left.begin(), mouth.left.end());
  const auto at = std::find_if(mouth.left.begin(), mouth.left.end(),
                               [&](int32_t v) { return m.x_mm[size_t(v)] == m.x_mm[size_t(mouth.right[0])]; });
  std::rotate(mouth.left.begin(), at, mouth.left.end());
  return "";
}

std::vector<Vec3> ring_places(const Mesh& m, const Facing& f) {
  std::vector<Vec3> x;
  for (int32_t v : f.right) x.push_back(m.x_mm[size_t(v)]);
  return x;
}

bool cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const auto side = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x() > 0;
  };
  return side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b);
}

/// The wall of solid bone, divided where the blade folds: each part lies in a plane. A fold that its ring crosses
/// more than twice is left.
std::vector<Facing> folded(Mesh& m, const Facing& wall, const CornerBlade& blade, simplex::Delta& delta) {
  constexpr double kFromEnds = 0.1;  // of an edge
  std::vector<Facing> parts{wall};
  for (size_t fold = 1; fold < blade.sectors(); ++fold)
    for (size_t i = 0; i < parts.size(); ++i) {
      const std::vector<Vec3> x = ring_places(m, parts[i]);
      std::vector<std::pair<int32_t, Vec3>> crossing;
      for (size_t k = 0; k < x.size(); ++k) {
        const Vec3 &a = x[k], &b = x[(k + 1) % x.size()];
        const size_t sa = blade.sector(a), sb = blade.sector(b);
        if (std::min(sa, sb) != fold - 1 || std::max(sa, sb) != fold) continue;
        const double da = blade.past_fold(fold, a), db = blade.past_fold(fold, b);
        const double t = da == db ? 0.5 : std::clamp(da / (da - db), kFromEnds, 1 - kFromEnds);
        crossing.emplace_back(int32_t(k), a + t * (b - a));
      }
      if (crossing.size() != 2) continue;
      const Rung across{crossing[0].first, crossing[1].first, crossing[0].second, crossing[1].second};
      const std::array<Facing, 2> both = divide_wall(m, parts[i], across, delta);
      parts[i] = both[0];
      parts.push_back(both[1]);
      break;
    }
  return parts;
}

/// Walls for one piece of cut surface: the outer mouth and the mouths within it.
std::string wall_piece(Mesh& m, std::vector<Facing> mouth, const Plan& plan, simplex::Delta& delta, Cut& out) {
  std::vector<Facing> walls;
  const auto keep = [&](const Facing& w) {
    out.wall_left.push_back(w.face_left), out.wall_right.push_back(w.face_right);
  };
  if (mouth.size() == 1) {
    close_by_walls(m, mouth[0], delta);
    for (const Facing& w : plan.blade ? folded(m, mouth[0], *plan.blade, delta) : std::vector{mouth[0]}) keep(w);
    return "";
  }
  if (!plan.flat || mouth.size() == 2) {
    if (std::string bad = join_by_walls(m, mouth[0], mouth[1],
                                        plan_rungs(ring_places(m, mouth[0]), ring_places(m, mouth[1])), delta, walls);
        !bad.empty())
      return bad;
    for (const Facing& w : walls) keep(w);
    return "";
  }
  // Several cavities in one plane: each in turn, in the face that
  // holds it. Lines that would cross another ring are left out.
  const auto& flat = plan.flat;
  std::vector<std::vector<Vec2>> ring(mouth.size());
  for (size_t i = 0; i < mouth.size(); ++i)
    for (const Vec3& x : ring_places(m, mouth[i])) ring[i].push_back(flat(x));
  std::vector<Facing> around{mouth[0]};
  for (size_t i = 1; i < mouth.size(); ++i) {
    size_t host = around.size();
    for (size_t k = 0; k < around.size() && host == around.size(); ++k) {
      std::vector<Vec2> p;
      for (const Vec3& x : ring_places(m, around[k])) p.push_back(flat(x));
      if (std::all_of(ring[i].begin(), ring[i].end(), [&](const Vec2& x) { return inside_polygon(p, x); })) host = k;
    }
    if (host == around.size()) return "the cut surface has cavities that lie too close together for the bone's mesh";
    std::vector<Rung> rungs = plan_rungs(ring_places(m, around[host]), ring_places(m, mouth[i]));
    std::vector<Vec2> host_ring;
    for (const Vec3& x : ring_places(m, around[host])) host_ring.push_back(flat(x));
    std::erase_if(rungs, [&](const Rung& r) {
      const Vec2 a = flat(r.a_mm), b = flat(r.b_mm);
      const auto meets = [&](const std::vector<Vec2>& p, int32_t but) {
        for (size_t e = 0; e < p.size(); ++e)
          if (int32_t(e) != but && cross(a, b, p[e], p[(e + 1) % p.size()])) return true;
        return false;
      };
      if (meets(host_ring, r.a) || meets(ring[i], r.b)) return true;
      for (size_t j = i + 1; j < mouth.size(); ++j)
        if (meets(ring[j], -1)) return true;
      return false;
    });
    if (std::string bad = join_by_walls(m, around[host], mouth[i], rungs, delta, walls); !bad.empty()) return bad;
    around.erase(around.begin() + std::ptrdiff_t(host));
    for (const Facing& w : walls)
      if (w.face_left < 0) return "the two sides of the cut do not agree";
    around.insert(around.end(), walls.begin(), walls.end());
  }
  for (const Facing& w : around) keep(w);
  return "";
}

}  // namespace

Cut cut_bone(Mesh& m, int32_t inside, const Osteotomy& o, simplex::Delta& delta) {
  Cut out;
  if (!m.alive(inside)) {
    out.reason = "there is no such bone";
    return out;
  }
  const std::vector<uint8_t> in = component_of(m, inside);
  const Plan plan = o.kind == Osteotomy::Kind::plane ? plan_plane(m, in, o)
                    : o.kind == Osteotomy::Kind::fan ? plan_fan(m, in, o)
                                                     : plan_contour(m, in, o);
  out.reason = plan.reason;
  if (!out) return out;
  simplex::Delta d;
  const auto refuse = [&](std::string why) {
    simplex::undo(m, d);
    Cut no;
    no.reason = std::move(why);
    return no;
  };
  for (const Piece& p : plan.piece) {
    std::vector<Facing> mouth(p.curve.size());
    for (size_t i = 0; i < p.curve.size(); ++i) {
      if (std::string bad = cut_curve(m, plan.curve[p.curve[i]], d, mouth[i]); !bad.empty()) return refuse(bad);
      ++out.curves;
    }
    if (std::string bad = wall_piece(m, std::move(mouth), plan, d, out); !bad.empty()) return refuse(bad);
  }
  // What came of it: the parts that hold the walls.
  std::vector<int32_t> of;
  const int32_t count = simplex::components(m, of);
  const std::vector<Bulk> bulk = bulks(m, of, count);
  std::vector<int32_t> parts;
  for (const auto* side : {&out.wall_left, &out.wall_right})
    for (int32_t f : *side) parts.push_back(of[size_t(m.face_edge[size_t(f)] / 3)]);
  std::sort(parts.begin(), parts.end());
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  if (parts.size() < 2 && o.must_divide) return refuse("the cut does not divide the bone: it hangs together elsewhere");
  for (int32_t c : parts)
    if (bulk[size_t(c)].volume_mm3 < kSmallest_mm3) {
      if (!(bulk[size_t(c)].volume_mm3 > 0))
        return refuse("there is no bone within the cut: is it along one that is there already?");
      const std::string text = fmt::format("the piece is too small: {:.1f} mm^3; at least {:.0f} mm^3 was expected",
                                           bulk[size_t(c)].volume_mm3, kSmallest_mm3);
      return refuse(text);
    }
  delta.append(std::move(d));
  return out;
}

}  // namespace limberg::bone
