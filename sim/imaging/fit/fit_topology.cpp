#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/geometry/bvh.h"
#include "sim/imaging/fit/fit_parts.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::imaging {

using namespace simplex;

namespace {

constexpr double kMeeting = 1.5;  // edges: sheets nearer than this face each other
// edges: a part of the mesh that can be reached so soon belongs to the same tube, not to another sheet
constexpr int kWayRound = 6;

std::string place_text(const Vec3& x) { return fmt::format("({:.0f}, {:.0f}, {:.0f}) mm", x.x(), x.y(), x.z()); }

}  // namespace

std::vector<std::vector<int32_t>> borders_of(const Mesh& m, const std::vector<uint8_t>& in) {
  std::vector<std::vector<int32_t>> out;
  std::vector<uint8_t> walked(3 * m.nbr.size(), 0);
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!in[size_t(f)]) continue;
    m.around(f, [&](int32_t first) {
      if (walked[size_t(first)] || in[size_t(m.face(m.twin(first)))]) return;
      out.emplace_back();
      int32_t h = first;
      do {
        walked[size_t(h)] = 1;
        out.back().push_back(m.from(h));
        h = m.next(h);
        while (in[size_t(m.face(m.twin(h)))]) h = m.next(m.twin(h));
      } while (h != first);
    });
  }
  return out;
}

bool Topology::near(int32_t v, int32_t face, int depth) const {
  std::vector<int32_t> reached{v};
  std::vector<int32_t> front{v};
  for (int d = 0; d <= depth; ++d) {
    std::vector<int32_t> next;
    for (int32_t u : front) {
      for (int32_t f : m_.left[size_t(u)])
        if (f == face) return true;
      for (int32_t w : m_.nbr[size_t(u)])
        if (std::find(reached.begin(), reached.end(), w) == reached.end()) reached.push_back(w), next.push_back(w);
    }
    front.swap(next);
  }
  return false;
}

void Topology::check(double edge_mm, std::vector<uint8_t>& still) {
  still.assign(m_.nbr.size(), 0);
  if (!sight_.knows_air()) return;
  std::vector<int32_t> in_air;
  std::vector<double> air(m_.nbr.size(), 0);
  const double least = 0.75 * sight_.voxel();
  for (int32_t v = 0; v < m_.slots(); ++v)
    if (m_.alive(v) && (air[size_t(v)] = sight_.air(m_.x_mm[size_t(v)])) > least) in_air.push_back(v);
  if (in_air.empty()) return;
  const FanTriangles fan = fan_triangles(m_);
  const Bvh bvh(fan.X_mm, fan.tri);
  struct Meeting {
    int32_t v, face;
    double air;
  };
  std::vector<Meeting> meeting;
  std::vector<Neck> neck;
  for (int32_t v : in_air) {
    const LocalFrame f = m_.frame(v);
    if (f.degenerate) continue;
    const Vec3& x = m_.x_mm[size_t(v)];
    Bvh::LineHit hit[8];
    const int n = std::min(8, bvh.line(x, -f.N, 1e-3 * edge_mm, kMeeting * edge_mm, hit));
    for (int i = 0; i < n; ++i) {
      const int32_t face = fan.face[size_t(hit[i].triangle)];
      if (hit[i].from_outside) continue;  // inwards, the other sheet is met from within
      if (sight_.air(x - 0.5 * hit[i].t * f.N) <= 0) break;
      bool own = false;
      for (int32_t q : m_.left[size_t(v)]) own |= q == face;
      if (own) continue;
      still[size_t(v)] = 1;
      if (near(v, face, kWayRound))
        still[size_t(v)] = 2, neck.push_back({v, x - 0.5 * hit[i].t * f.N, air[size_t(v)]});
      else
        meeting.push_back({v, face, air[size_t(v)]});
      break;
    }
  }
  // The middle of a tunnel first: there the walls are farthest away.
  std::sort(meeting.begin(), meeting.end(),
            [](const Meeting& a, const Meeting& b) { return a.air != b.air ? a.air > b.air : a.v < b.v; });
  bool any = false;
  for (const Meeting& c : meeting) {
    const Vec3 at = m_.x_mm[size_t(c.v)];
    bool before = false;
    for (const Join& j : done_) before |= (j.at_mm - at).norm() < j.radius_mm;
    if (before || !m_.alive_face(c.face) || is_end(m_.kind(c.face))) continue;
    const Vec3 there = face_centre(m_, c.face);
    int32_t best = -1;
    double nearest = 1e300;
    for (int32_t f : m_.left[size_t(c.v)])
      if (!is_end(m_.kind(f)))
        if (const double d = (face_centre(m_, f) - there).norm(); d < nearest) nearest = d, best = f;
    if (best < 0) continue;
    Delta d;
    const OperatorResult o = t3(m_, best, c.face, d);
    if (o)
      ++joined, any = true;
    else
      notes.push_back("sheets that meet at " + place_text(at) + " were not joined: " + sentence(o.answer));
    done_.push_back({at, 3 * c.air + 3 * edge_mm});  // (a refusal is said once)
  }
  std::sort(neck.begin(), neck.end(),
            [](const Neck& a, const Neck& b) { return a.air != b.air ? a.air > b.air : a.v < b.v; });
  if (!any) cut_necks(neck, edge_mm);
}

/// A tube through air is cut across: by the plane through its
/// middle that gives the shortest closed curve wholly in air.
void Topology::cut_necks(const std::vector<Neck>& neck, double edge_mm) {
  int tries = 0;
  for (const Neck& c : neck) {
    if (++tries > 6) return;
    const LocalFrame f = m_.frame(c.v);
    const Vec3 e1 = f.N.unitOrthogonal(), e2 = f.N.cross(e1);
    std::vector<Crossing> best;
    double shortest = 12 * kMeeting * edge_mm;  // as long as a tube may be around
    for (int k = 0; k < 8; ++k) {
      const double angle = k * 3.14159265358979 / 8;
      const PlaneCurves curves =
          curves_of_plane(m_, c.middle_mm, elementary::cos(angle) * e1 + elementary::sin(angle) * e2);
      for (const auto& curve : curves.curve) {
        double around = 0;
        bool air = true, close = false;
        Vec3 before = Vec3::Zero();
        for (size_t i = 0; i <= curve.size() && air; ++i) {
          const Crossing& x = curve[i % curve.size()];
          const Vec3 at = m_.x_mm[size_t(x.right)] + x.t * (m_.x_mm[size_t(x.left)] - m_.x_mm[size_t(x.right)]);
          if (i > 0) around += (at - before).norm();
          before = at;
          air = sight_.air(at) > 0 && around < shortest;
          close |= (at - m_.x_mm[size_t(c.v)]).norm() < 1.5 * edge_mm;
        }
        if (air && close && curve.size() >= 3) best = curve, shortest = around;
      }
    }
    if (best.empty()) continue;
    Delta d;
    const OperatorResult o = t4_edges(m_, best, CutPolicy::any, d);
    if (!o) continue;
    if (o.divided) {
      // A tip that has come loose, or a piece of the tube, is no body:
      // on either side some of the surface must have been reached.
      std::vector<int32_t> of;
      components(m_, of);
      int64_t left = 0;
      const int32_t part = of[size_t(m_.from(m_.face_edge[size_t(o.face[0])]))],
                    other = of[size_t(m_.from(m_.face_edge[size_t(o.face[1])]))];
      int64_t right = 0;
      for (size_t q = 0; q < of.size(); ++q)
        if (of[q] >= 0 && std::abs(sight_.air(m_.x_mm[q])) < sight_.voxel())
          left += of[q] == part, right += of[q] == other;
      if (std::min(left, right) < 12) {
        undo(m_, d);
        continue;
      }
    }
    Edit e(m_, d);
    for (int32_t mouth : o.face)
      e.save_face(mouth), m_.face_kind[size_t(mouth)] = FaceKind::surface;  // grown over, not open
    ++m_.version, ++cut;
    return;  // the mesh has changed: the others at the next check
  }
}

namespace {

using Faces = std::vector<uint8_t>;

/// Adds the faces beside (grow) or takes away those with a neighbour outside (shrink).
Faces step(const Mesh& m, const Faces& in, bool grow) {
  Faces out = in;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || is_end(m.kind(f)) || (in[size_t(f)] != 0) == grow) continue;
    m.around(f, [&](int32_t h) {
      const int32_t q = m.face(m.twin(h));
      if ((grow || !is_end(m.kind(q))) && (in[size_t(q)] != 0) == grow) out[size_t(f)] = grow;
    });
  }
  return out;
}

std::vector<std::vector<int32_t>> parts_of(const Mesh& m, const Faces& in, bool inside) {
  std::vector<std::vector<int32_t>> out;
  Faces done(in.size(), 0);
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || (in[size_t(f)] != 0) != inside || done[size_t(f)]) continue;
    out.emplace_back(1, f);
    done[size_t(f)] = 1;
    for (size_t i = 0; i < out.back().size(); ++i)
      m.around(out.back()[i], [&](int32_t h) {
        const int32_t q = m.face(m.twin(h));
        if (!done[size_t(q)] && (in[size_t(q)] != 0) == inside) done[size_t(q)] = 1, out.back().push_back(q);
      });
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

/// Opens a region: small islands of surface in it go with it; where larger parts of the surface remain on several sides
/// of it, each is cut off along its own border and gets a hole of its own.
OperatorResult open_region(Mesh& m, std::vector<int32_t> region) {
  Faces in(m.face_edge.size(), 0);
  for (int32_t f : region) in[size_t(f)] = 1;
  bool largest = true;
  std::vector<std::vector<int32_t>> side;  // parts that stay, without the largest
  const size_t size = region.size();
  for (const auto& part : parts_of(m, in, false)) {
    bool touches = false;  // other parts of the mesh are no islands
    for (int32_t f : part) m.around(f, [&](int32_t h) { touches |= in[size_t(m.face(m.twin(h)))] != 0; });
    if (!touches) continue;
    if (!largest && part.size() * 5 > size && part.size() > 12)
      side.push_back(part);
    else if (!largest)
      region.insert(region.end(), part.begin(), part.end());
    largest = false;
  }
  Delta all;
  OperatorResult o;
  for (const auto& part : side) {
    const ContourResult border = contour_of_faces(m, part);
    o.answer = Answer::not_a_cycle;
    Delta d;
    if (border) o = t4(m, border.contour, CutPolicy::any, d);
    if (!o) {
      undo(m, all);
      return o;
    }
    Edit e(m, d);
    e.save_face(o.face[0]);
    m.face_kind[size_t(o.face[0])] = FaceKind::hole;  // of the part that stays
    region.push_back(o.face[1]);
    all.append(std::move(d));
  }
  Delta d;
  o = open_hole(m, region, d);
  if (!o) undo(m, all);
  return o;
}

}  // namespace

int open_blind(Mesh& m, std::vector<uint8_t> blind, std::vector<std::string>& notes) {
  std::vector<uint8_t> was_alive(m.face_edge.size(), 0);
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f)) was_alive[size_t(f)] = 1, blind[size_t(f)] |= is_end(m.kind(f));
  int opened = 0;
  for (const auto& g : parts_of(m, blind, true)) {
    size_t surface = 0;
    bool whole = true;
    for (int32_t f : g) whole &= m.alive_face(f) && was_alive[size_t(f)], surface += whole && !is_end(m.kind(f));
    if (!whole || surface < 3) continue;
    const Vec3 at = face_centre(m, g[g.size() / 2]);
    // As it is; else smoother: closed (grown, then shrunk), grown, opened.
    OperatorResult o;
    for (int attempt = 0; attempt < 5; ++attempt) {
      Faces in(m.face_edge.size(), 0);
      for (int32_t f : g) in[size_t(f)] = 1;
      if (attempt == 1) in = step(m, step(m, in, true), false);
      if (attempt == 2) in = step(m, in, true);
      if (attempt == 3) in = step(m, step(m, in, true), true);
      if (attempt == 4) in = step(m, step(m, in, false), true);
      const auto parts = parts_of(m, in, true);
      if (parts.empty()) continue;
      o = open_region(m, parts.front());
      if (o) break;
    }
    if (o)
      ++opened;
    else
      notes.push_back("a region of " + std::to_string(surface) + " faces without surface at " + place_text(at) +
                      " was not opened: " + sentence(o.answer));
  }
  return opened;
}

void split_rims(Mesh& m, double edge_mm) {
  for (int pass = 0; pass < 3; ++pass) {
    bool any = false;
    for (const EndContour& e : end_contours(m))
      for (size_t i = 0; i < e.rim.size(); ++i) {
        const int32_t a = e.rim[i], b = e.rim[(i + 1) % e.rim.size()];
        if (m.slot(a, b) < 0 || (m.x_mm[size_t(a)] - m.x_mm[size_t(b)]).norm() <= edge_mm) continue;
        const int32_t h = m.face(m.edge(a, b)) == e.face ? m.edge(b, a) : m.edge(a, b), f = m.face(h);
        if (is_end(m.kind(f)) || m.face_size[size_t(f)] < 5) continue;
        int32_t across = h;  // the edge opposite
        for (int32_t k = 0; k < m.face_size[size_t(f)] / 2; ++k) across = m.next(across);
        Delta d;
        any |= bool(t2(m, f, m.from(h), m.from(across), d));
      }
    if (!any) return;
  }
}

namespace {

/// Largest first. The largest opening near the midline that looks forwards is the nose; the largest ones beside it that
/// look so, not below it, are the orbits; those far to the side in front the temporal fossae; those in the middle that
/// look down the base and, before it,
/// the choanae.
void name_skull(std::vector<FitHole>& holes, const Vec3& middle, const Vec3& half) {
  const auto u = [&](const FitHole& h) { return Vec3((h.centre_mm - middle).cwiseQuotient(half)); };
  const auto free = [](const FitHole& h) { return !h.place.starts_with("volume") && h.vertices >= 6; };
  double nose_z = -1e300;
  const auto nose = [&](bool forwards) {
    for (FitHole& h : holes)
      if (const Vec3 a = u(h); free(h) && a.y() < -0.4 && std::abs(a.x()) < 0.12 &&
                               (forwards ? h.place.ends_with("anterior") : a.z() > -0.4)) {
        h.place = "nose (" + h.place + ")", nose_z = h.centre_mm.z();
        return true;
      }
    return false;
  };
  if (!nose(true)) nose(false);
  for (const double side : {-1., 1.})
    for (FitHole& h : holes)
      if (const Vec3 a = u(h); free(h) && !h.place.starts_with("nose") && a.y() < -0.35 && side * a.x() > 0.1 &&
                               side * a.x() < 0.6 &&
                               h.centre_mm.z() > (nose_z > -1e299 ? nose_z + 0.05 * half.z() : middle.z()) &&
                               (h.place.ends_with("anterior") || h.centre_mm.z() > middle.z())) {
        h.place = std::string("orbit, ") + (side < 0 ? "right" : "left") + " (" + h.place + ")";
        break;
      }
  for (FitHole& h : holes) {
    const Vec3 a = u(h);
    if (!free(h) || h.place.starts_with("nose") || h.place.starts_with("orbit")) continue;
    if (std::abs(a.x()) > 0.5 && a.y() < 0)
      h.place = std::string("temporal fossa, ") + (a.x() < 0 ? "right" : "left") + " (" + h.place + ")";
    else if (std::abs(a.x()) < 0.25 && a.y() > -0.4 && h.place.ends_with("inferior"))
      h.place = "base (" + h.place + ")";
    else if (std::abs(a.x()) < 0.25 && a.y() <= -0.4 && h.place.ends_with("inferior"))
      h.place = "choanae (" + h.place + ")";
  }
}

}  // namespace

std::vector<FitHole> places(const Mesh& m, const Sight& s, const Vec3& low, const Vec3& high, bool skull) {
  std::vector<FitHole> out;
  const Vec3 middle = 0.5 * (low + high), half = (0.5 * (high - low)).cwiseMax(1e-9);
  for (const EndContour& e : end_contours(m)) {
    FitHole h;
    h.vertices = int32_t(e.rim.size());
    Vec3 area = Vec3::Zero();
    int at_border[6] = {};
    Vec3 outward[6];
    for (size_t i = 0; i < e.rim.size(); ++i) {
      const Vec3 &a = m.x_mm[size_t(e.rim[i])], &b = m.x_mm[size_t(e.rim[(i + 1) % e.rim.size()])];
      h.centre_mm += a / double(e.rim.size()), h.around_mm += (b - a).norm();
      area += 0.5 * a.cross(b);
      Vec3 o;
      double way = 0;
      if (const int k = s.border(a, 3 * s.voxel(), o, way); k >= 0) ++at_border[k], outward[k] = o;
    }
    const auto direction = [](const Vec3& d) {
      int k = 0;
      d.cwiseAbs().maxCoeff(&k);
      constexpr const char* name[3][2] = {{"right", "left"}, {"anterior", "posterior"}, {"inferior", "superior"}};
      return std::string(name[k][d[k] > 0]);
    };
    const int most = int(std::max_element(at_border, at_border + 6) - at_border);
    if (2 * at_border[most] > int(e.rim.size())) {
      h.place = "volume border, " + direction(outward[most]);
    } else {
      const Vec3 u = (h.centre_mm - middle).cwiseQuotient(half);
      h.place = u.z() > 0.33 ? "upper" : u.z() < -0.33 ? "lower" : "middle";
      h.place += u.y() < -0.25 ? " anterior" : u.y() > 0.25 ? " posterior" : "";
      h.place += u.x() > 0.12 ? " left" : u.x() < -0.12 ? " right" : " midline";
      if (const double l = area.norm(); l > 0) h.place += ", looking " + direction(area / l);
    }
    out.push_back(std::move(h));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const FitHole& a, const FitHole& b) { return a.around_mm > b.around_mm; });
  if (skull) name_skull(out, middle, half);
  return out;
}

}  // namespace limberg::imaging
