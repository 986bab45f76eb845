#include "app/export/guide.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "app/export/solids.h"
#include "sim/geometry/point_tree.h"
#include "sim/imaging/fit/level_set.h"
#include "sim/skull/bone/surface.h"

namespace limberg {

namespace {

constexpr double kFree_mm = 100;  // a place is reached from outside where a line along its normal meets no bone so far
constexpr double kSample_mm = 0.5;   // along the rim of a cut
constexpr double kLeastRim_mm = 15;  // of a rim that can be reached
constexpr double kLipschitz = 2;     // the fields change by at most so much a mm near their zero

/// A place on the rim of a cut: the edge between the wall and the bone's own surface.
struct RimPlace {
  Vec3 x_mm, out, across;  // out: normal of the bone's surface; across: of the wall
  double s_mm = 0;         // along its stretch
  double length_mm = 0;    // of the stretch
};

/// Stretches of the rim that can be reached from outside, in places kSample_mm apart.
std::vector<RimPlace> open_rim(const bone::Bones& bones, const bone::Fragment& f, const BoneField& all) {
  const simplex::Mesh& m = bones.mesh();
  const std::vector<uint8_t> in = bone::component_of(m, f.vertex);
  struct Edge {
    int32_t to;
    Vec3 out, across;
    bool reached;
  };
  std::map<int32_t, Edge> next;  // along walls, a vertex of the rim to the next one
  const auto normal_of = [&](int32_t face) {
    Vec3 n = Vec3::Zero();
    const Vec3 c = bone::fan_centre(m, face);
    m.around(face, [&](int32_t h) { n += (m.x_mm[size_t(m.from(h))] - c).cross(m.x_mm[size_t(m.to(h))] - c); });
    return n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
  };
  for (int32_t face = 0; face < m.face_slots(); ++face) {
    if (!m.alive_face(face) || m.kind(face) != simplex::FaceKind::wall || !in[size_t(m.face_edge[size_t(face)] / 3)])
      continue;
    const Vec3 across = normal_of(face);
    m.around(face, [&](int32_t h) {
      const int32_t beside = m.face(m.twin(h));
      if (m.kind(beside) != simplex::FaceKind::surface) return;
      const Vec3 out = normal_of(beside), middle = 0.5 * (m.x_mm[size_t(m.from(h))] + m.x_mm[size_t(m.to(h))]);
      next[m.from(h)] = {m.to(h), out, across, !all.meets(middle + 1.0 * out, out, kFree_mm)};
    });
  }
  std::vector<RimPlace> places;
  std::map<int32_t, uint8_t> done;
  const auto walk = [&](int32_t start) {
    const size_t first = places.size();
    double s = 0;
    for (int32_t v = start; next.count(v) && next.at(v).reached && !done[v]; v = next.at(v).to) {
      done[v] = 1;
      const Edge& e = next.at(v);
      const Vec3 &a = m.x_mm[size_t(v)], &b = m.x_mm[size_t(e.to)];
      const double l = (b - a).norm();
      const int n = std::max(1, int(std::ceil(l / kSample_mm)));
      for (int i = 0; i < n; ++i)
        places.push_back({a + (i + 0.5) / n * (b - a), e.out, e.across, s + (i + 0.5) / n * l, 0});
      s += l;
    }
    if (s < kLeastRim_mm) places.resize(first);
    for (size_t i = first; i < places.size(); ++i) places[i].length_mm = s;
  };
  // Stretches begin where the edge before cannot be reached; what is left are closed rings.
  std::map<int32_t, uint8_t> follows;
  for (const auto& [v, e] : next)
    if (e.reached) follows[e.to] = 1;
  for (const auto& [v, e] : next)
    if (e.reached && !follows.count(v)) walk(v);
  for (const auto& [v, e] : next)
    if (e.reached && !done[v]) walk(v);
  return places;
}

/// > 0 on a bridge over the slot: how far from its end.
double into_bridge(const RimPlace& p, const GuideSettings& g) {
  const double end = std::min(p.s_mm, p.length_mm - p.s_mm);
  const double at_end = g.bridge_mm - end;
  const int n = std::max(1, int(std::lround(p.length_mm / g.between_bridges_mm)));
  const double every = p.length_mm / n, off = std::abs(p.s_mm - every * std::round(p.s_mm / every));
  return std::max(at_end, 0.5 * g.bridge_mm - off);
}

Surface marched(const LevelSet& field, double grid_mm, Workers& workers) {
  Surface s;
  march(field, grid_mm, workers, s.x_mm, s.tri);
  return s;
}

bool of_mandible(const bone::Fragment& f) { return f.name.starts_with("mandible"); }

}  // namespace

Made cutting_guide(const bone::Bones& bones, const bone::Fragment& f, const BoneField& all, const GuideSettings& g,
                   Workers& workers) {
  Made out;
  const std::vector<RimPlace> rim = open_rim(bones, f, all);
  if (rim.empty()) {
    out.why = fmt::format("no {:.0f} mm of its cuts can be reached from outside", kLeastRim_mm);
    return out;
  }
  std::vector<Vec3> x;
  LevelSet field;
  field.low_mm = field.high_mm = rim.front().x_mm;
  for (const RimPlace& p : rim) {
    x.push_back(p.x_mm);
    field.low_mm = field.low_mm.cwiseMin(p.x_mm), field.high_mm = field.high_mm.cwiseMax(p.x_mm);
  }
  const double margin = g.half_width_mm + g.thick_mm + 3;
  field.low_mm.array() -= margin, field.high_mm.array() += margin;
  field.lipschitz = kLipschitz;
  const PointTree near(x);
  field.distance_mm = [&](const Vec3& p) {
    const PointTree::Nearest n = near.nearest(p);
    const double along = n.distance - g.half_width_mm;
    if (along > 2) return along;
    const RimPlace& at = rim[size_t(n.index)];
    const double bone = all.distance_mm(p);
    const double shell = std::max(bone - g.off_bone_mm - g.thick_mm, g.off_bone_mm - bone);
    const double slot = std::max(std::abs(at.across.dot(p - at.x_mm)) - 0.5 * g.slot_mm, into_bridge(at, g));
    // On the outer side only: not what lies behind the bone's edge.
    const double behind = -at.out.dot(p - at.x_mm) - 0.7 * g.half_width_mm;
    return std::max({along, shell, -slot, behind});
  };
  out.parts = parts_of(marched(field, g.grid_mm, workers), g.least_mm3);
  if (out.parts.empty()) out.why = "too little of the bone beside its cuts can be reached for a guide";
  return out;
}

Made splint(const Head& head, const SplintSettings& set, Workers& workers) {
  Made out;
  std::optional<Vec3> is, ii;
  for (const HeadLandmark& l : head.landmarks()) {
    if (l.name == "Is") is = head.landmark_mm(l);
    if (l.name == "Ii") ii = head.landmark_mm(l);
  }
  if (!is || !ii) {
    out.why = "the landmarks Is and Ii (edges of the front teeth) are not both there";
    return out;
  }
  BoneField upper, lower;
  for (const bone::Fragment& f : head.bones().fragments()) {
    Surface s = fragment_surface(head.bones(), f);
    move(s, f.pose);
    (of_mandible(f) ? lower : upper).add(s);
  }
  if (upper.empty() || lower.empty()) {
    out.why = "there is no bone with teeth above or below";
    return out;
  }
  // The plane between both arches: midway, by least squares over columns where both have a surface near.
  const Vec3 o = 0.5 * (*is + *ii);
  const double open = is->z() - ii->z();
  std::vector<Vec3> middle;
  std::vector<double> apart;
  for (double x = -32; x <= 32; x += 2)
    for (double y = o.y() - set.deep_mm; y <= o.y() + 4; y += 2) {
      // Up from well within the lower teeth: the end of these, then the beginning of the upper ones.
      double below = std::numeric_limits<double>::quiet_NaN(), above = below;
      for (double z = o.z() - std::abs(open) - 12; z <= o.z() + std::abs(open) + 12; z += 0.5) {
        const Vec3 p(o.x() + x, y, z);
        if (lower.distance_mm(p) < 0) below = z;
        if (std::isnan(above) && upper.distance_mm(p) < 0) above = z;
      }
      if (!std::isnan(below) && !std::isnan(above) && std::abs(above - below) < std::abs(open) + 8)
        middle.push_back(Vec3(x, y - o.y(), 0.5 * (above + below) - o.z())), apart.push_back(above - below);
    }
  if (middle.size() < 12) {
    out.why = "upper and lower teeth do not lie opposite each other";
    return out;
  }
  Eigen::MatrixXd A(middle.size(), 3);
  Eigen::VectorXd z(middle.size());
  for (size_t i = 0; i < middle.size(); ++i)
    A.row(Eigen::Index(i)) = Vec3(1, middle[i].x(), middle[i].y()).transpose(), z[Eigen::Index(i)] = middle[i].z();
  const Vec3 abc = A.colPivHouseholderQr().solve(z);
  const Vec3 n = Vec3(-abc.y(), -abc.z(), 1).normalized(), at = o + Vec3(0, 0, abc.x());
  // As high as nine tenths of the columns are open, and over the edges.
  std::sort(apart.begin(), apart.end());
  const double gap = std::max(0., apart[apart.size() * 9 / 10]), half = 0.5 * gap + set.over_edges_mm;
  LevelSet field;
  field.low_mm = o + Vec3(-50, -set.deep_mm - 6, -half - 25), field.high_mm = o + Vec3(50, 18, half + 25);
  field.lipschitz = kLipschitz;
  field.distance_mm = [&](const Vec3& p) {
    const double flat = std::abs(n.dot(p - at)) - half, back = (o.y() - set.deep_mm) - p.y();
    const double block = std::max({flat, back, p.y() - o.y() - 12, std::abs(p.x() - o.x()) - 45});
    if (block > 2) return block;
    const double u = upper.distance_mm(p), l = lower.distance_mm(p), teeth = std::min(u, l);
    // Around each tooth, and what lies between opposite ones.
    const double filled = std::min(teeth - set.around_mm, std::max(u, l) - 0.5 * gap - set.around_mm);
    return std::max({block, filled, set.off_teeth_mm - teeth});
  };
  out.parts = parts_of(marched(field, set.grid_mm, workers), 500);
  if (out.parts.size() > 1) out.parts.resize(1);
  if (out.parts.empty()) out.why = "there is no room for it between the teeth";
  return out;
}

}  // namespace limberg
