#include "sim/measure/cephalometry.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "sim/base/elementary.h"
#include "sim/geometry/rotation.h"
#include "sim/geometry/vec.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace {

using Places = std::vector<Vec3>;  // of a measure's landmarks, in its order
using Figure = std::function<double(const Places&)>;

double angle(const Vec3& a, const Vec3& b) { return elementary::atan2(a.cross(b).norm(), a.dot(b)) * kDeg; }
double at_corner(const Places& p) { return angle(p[0] - p[1], p[2] - p[1]); }
double length(const Places& p) { return (p[1] - p[0]).norm(); }
Vec3 sagittal(const Vec3& v) { return {0, v.y(), v.z()}; }
/// Angle from direction a to direction b on the film, positive where b points further down at the front.
double on_film(const Vec3& a, const Vec3& b) {
  return (elementary::atan2(a.z(), a.y()) - elementary::atan2(b.z(), b.y())) * kDeg;
}
double lines(const Places& p) { return on_film(p[1] - p[0], p[3] - p[2]); }
/// Go of both sides as one point.
double mandibular(const Places& p, const Vec3& from, const Vec3& to) {
  return on_film(to - from, p.back() - 0.5 * (p[p.size() - 3] + p[p.size() - 2]));
}
/// How far p lies before the line from a to b, on the film.
double before_line(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = sagittal(b - a).normalized(),
             n(0, -d.z(), d.y());  // turned so that it points forwards for a line that goes down
  return n.dot(sagittal(p - a));
}

struct Entry {
  CephalometricMeasure measure;
  Figure figure;
};

const std::vector<Entry>& table() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> t;
    const std::string usual = "usual textbook norm for adults (Steiner, Downs, Ricketts, Legan)",
                      table_of_widths = "published adult means of facial widths";
    const auto add = [&](std::string name, std::string unit, std::string definition, std::vector<std::string> points,
                         Figure f, std::optional<double> norm = {}, std::optional<double> sd = {},
                         std::string source = "") {
      t.push_back(
          {{std::move(name), std::move(unit), std::move(definition), norm, sd, std::move(source), std::move(points)},
           std::move(f)});
    };
    for (const auto& [name, a, b] : {std::array<const char*, 3>{"S-N", "S", "N"},
                                     {"N-Me", "N", "Me"},
                                     {"N-ANS", "N", "ANS"},
                                     {"ANS-Me", "ANS", "Me"},
                                     {"PNS-A", "PNS", "A"},
                                     {"Go-Me left", "Go_L", "Me"},
                                     {"Go-Me right", "Go_R", "Me"},
                                     {"Go-S left", "Go_L", "S"},
                                     {"Go-S right", "Go_R", "S"},
                                     {"Co-Go left", "Co_L", "Go_L"},
                                     {"Co-Go right", "Co_R", "Go_R"}})
      add(name, "mm", std::string("distance of ") + a + " and " + b, {a, b}, length);
    add("SNA", "deg", "angle S-N-A", {"S", "N", "A"}, at_corner, 82, 2, usual);
    add("SNB", "deg", "angle S-N-B", {"S", "N", "B"}, at_corner, 80, 2, usual);
    add(
        "ANB", "deg", "angle A-N-B in space, positive when SNA is larger than SNB", {"A", "N", "B", "S"},
        [](const Places& p) {
          return std::copysign(angle(p[0] - p[1], p[2] - p[1]),
                               angle(p[3] - p[1], p[0] - p[1]) - angle(p[3] - p[1], p[2] - p[1]));
        },
        2, 2, usual);
    add("Ba-S-N", "deg", "angle Ba-S-N, the base of the skull", {"Ba", "S", "N"}, at_corner, 130, 5, usual);
    add("SN-palatal", "deg", "line S-N to line PNS-ANS on the film", {"S", "N", "PNS", "ANS"}, lines, 8, 3, usual);
    add(
        "palatal-mandibular", "deg", "line PNS-ANS to line Go-Me on the film (Go: middle of both sides)",
        {"PNS", "ANS", "Go_L", "Go_R", "Me"}, [](const Places& p) { return mandibular(p, p[0], p[1]); }, 25, 5, usual);
    add(
        "SN-mandibular", "deg", "line S-N to line Go-Me on the film (Go: middle of both sides)",
        {"S", "N", "Go_L", "Go_R", "Me"}, [](const Places& p) { return mandibular(p, p[0], p[1]); }, 32, 5, usual);
    add(
        "FMA", "deg", "Frankfurt plane (Po-Or, middle of both sides) to line Go-Me on the film",
        {"Po_L", "Po_R", "Or_L", "Or_R", "Go_L", "Go_R", "Me"},
        [](const Places& p) { return mandibular(p, 0.5 * (p[0] + p[1]), 0.5 * (p[2] + p[3])); }, 25, 5, usual);
    add(
        "overjet", "mm", "Is before Ii along the Frankfurt plane's front, y", {"Is", "Ii"},
        [](const Places& p) { return (p[0] - p[1]).y(); }, 2.5, 1, usual);
    add(
        "overbite", "mm", "Is below Ii, along z; negative: open", {"Is", "Ii"},
        [](const Places& p) { return (p[1] - p[0]).z(); }, 2.5, 1, usual);
    add("nasolabial", "deg", "angle prn-sn-ls", {"prn", "sn", "ls"}, at_corner, 100, 8,
        "usual range 90 to 110 (of the columella's tangent; here of prn)");
    add(
        "facial convexity", "deg", "180 less the angle g'-sn-pog'", {"g'", "sn", "pog'"},
        [](const Places& p) { return 180 - at_corner(p); }, 12, 4, usual);
    add(
        "upper lip to E-line", "mm", "ls before the line prn-pog' on the film", {"ls", "prn", "pog'"},
        [](const Places& p) { return before_line(p[0], p[1], p[2]); }, -4, 2, usual);
    add(
        "lower lip to E-line", "mm", "li before the line prn-pog' on the film", {"li", "prn", "pog'"},
        [](const Places& p) { return before_line(p[0], p[1], p[2]); }, -2, 2, usual);
    add("intercanthal", "mm", "distance of en_L and en_R", {"en_L", "en_R"}, length, 32, 3, usual);
    add("nose width", "mm", "distance of al_L and al_R", {"al_L", "al_R"}, length);
    add("mouth width", "mm", "distance of ch_L and ch_R", {"ch_L", "ch_R"}, length, 54, 4, "usual range 52 to 56");
    add("bizygomatic", "mm", "distance of Zy_L and Zy_R", {"Zy_L", "Zy_R"}, length, 132, 5,
        table_of_widths + ", 130 to 134");
    add("bigonial", "mm", "distance of Go_L and Go_R", {"Go_L", "Go_R"}, length, 102, 6,
        table_of_widths + ", 97 to 107");
    add("face height", "mm", "distance of n' and me'", {"n'", "me'"}, length);
    return t;
  }();
  return entries;
}

std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (char c : s) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace

const std::vector<CephalometricMeasure>& cephalometric_measures() {
  static const std::vector<CephalometricMeasure> measures = [] {
    std::vector<CephalometricMeasure> m;
    for (const Entry& e : table()) m.push_back(e.measure);
    return m;
  }();
  return measures;
}

std::vector<CephalometricRow> cephalometry(std::span<const NamedPoint> points) {
  std::map<std::string, const NamedPoint*> by_name;
  for (const NamedPoint& p : points) by_name[p.name] = &p;
  std::vector<CephalometricRow> rows;
  for (size_t i = 0; i < table().size(); ++i) {
    CephalometricRow r;
    r.measure = &cephalometric_measures()[i];
    Places at;
    std::vector<double> sd;
    for (const std::string& name : r.measure->landmarks) {
      const auto it = by_name.find(name);
      if (it == by_name.end() || !it->second->at_mm.allFinite())
        r.missing.push_back(name);
      else
        at.push_back(it->second->at_mm), sd.push_back(it->second->sd_mm);
    }
    if (r.missing.empty()) {
      const Figure& f = table()[i].figure;
      const double v = f(at);
      double square = 0;
      for (size_t k = 0; k < at.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          Places plus = at, minus = at;
          plus[k][c] += sd[k], minus[k][c] -= sd[k];
          const double d = 0.5 * (f(plus) - f(minus));
          square += d * d;
        }
      if (std::isfinite(v) && std::isfinite(square)) r.value = v, r.sd = std::sqrt(square);
    }
    rows.push_back(std::move(r));
  }
  return rows;
}

Asymmetry asymmetry(std::span<const NamedPoint> points) {
  std::map<std::string, Vec3> at;
  for (const NamedPoint& p : points)
    if (p.at_mm.allFinite()) at[p.name] = p.at_mm;
  Asymmetry out;
  std::vector<Vec3> middle;
  for (const char* name : {"S", "N", "Ba", "ANS", "PNS"})
    if (const auto it = at.find(name); it != at.end()) middle.push_back(it->second);
  if (middle.size() >= 3) {
    Vec3 c = Vec3::Zero();
    for (const Vec3& p : middle) c += p / double(middle.size());
    Mat3 S = Mat3::Zero();
    for (const Vec3& p : middle) S += (p - c) * (p - c).transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> e(S);
    if (e.eigenvalues()[1] > 1) {  // not on one line
      out.point_mm = c, out.normal = e.eigenvectors().col(0), out.fitted = true;
      if (out.normal.x() < 0) out.normal = -out.normal;
    }
  }
  for (const auto& [name, right] : at) {
    if (name.size() < 3 || !name.ends_with("_R")) continue;
    const std::string base = name.substr(0, name.size() - 2);
    const auto left = at.find(base + "_L");
    if (left == at.end()) continue;
    AsymmetryRow r;
    r.name = base;
    const Vec3 mirrored = left->second - 2 * out.normal.dot(left->second - out.point_mm) * out.normal;
    r.difference_mm = right - mirrored, r.distance_mm = r.difference_mm.norm();
    out.rms_mm += r.distance_mm * r.distance_mm;
    out.rows.push_back(r);
  }
  if (!out.rows.empty()) out.rms_mm = std::sqrt(out.rms_mm / double(out.rows.size()));
  return out;
}

FragmentMotion fragment_motion(const Eigen::Isometry3d& pose, const Vec3& centre) {
  FragmentMotion m;
  const Mat3 R = pose.linear();
  m.translation_mm = pose * centre - centre;
  // R = Rz(yaw) Rx(pitch) Ry(roll): the front goes to (-sin yaw cos pitch, cos yaw cos pitch, sin pitch).
  m.pitch_deg = elementary::asin(std::clamp(R(2, 1), -1., 1.)) * kDeg;
  if (std::abs(R(2, 1)) < 1 - 1e-12) {
    m.yaw_deg = elementary::atan2(-R(0, 1), R(1, 1)) * kDeg;
    m.roll_deg = elementary::atan2(-R(2, 0), R(2, 2)) * kDeg;
  } else {
    m.yaw_deg = elementary::atan2(R(1, 0), R(0, 0)) * kDeg;
  }
  m.angle_deg = axis_angle(R).angle * kDeg;
  return m;
}

std::optional<Snapped> snap(const simplex::Mesh& mesh, const Vec3& picked, double vertex_mm, double most_mm) {
  const simplex::FanTriangles fan = simplex::fan_triangles(mesh);
  if (fan.tri.empty() || !picked.allFinite()) return std::nullopt;
  const Bvh::Closest c = Bvh(fan.X_mm, fan.tri).closest(picked, most_mm);
  if (c.triangle < 0) return std::nullopt;
  Snapped s;
  s.face = fan.face[size_t(c.triangle)], s.at_mm = c.point_mm;
  double best = vertex_mm;
  for (int32_t v : mesh.ring(s.face))
    if (const double d = (mesh.x_mm[size_t(v)] - c.point_mm).norm(); d <= best)
      best = d, s.vertex = v, s.at_mm = mesh.x_mm[size_t(v)];
  s.moved_mm = (s.at_mm - picked).norm();
  return s;
}

std::string to_csv(std::span<const CephalometricRow> rows) {
  std::string out = "name,value,unit,sd,norm,norm_sd,source,definition,missing\n";
  const auto number = [](std::optional<double> v) {
    std::string text;
    if (v) text = fmt::format("{:.4f}", *v);
    return std::string(text);
  };
  for (const CephalometricRow& r : rows) {
    std::string missing;
    for (const std::string& m : r.missing) missing += (missing.empty() ? "" : " ") + m;
    const CephalometricMeasure& m = *r.measure;
    out += quoted(m.name) + "," + number(r.value) + "," + m.unit + "," + (r.value ? number(r.sd) : "") + "," +
           number(m.norm) + "," + number(m.norm_sd) + "," + quoted(m.source) + "," + quoted(m.definition) + "," +
           quoted(missing) + "\n";
  }
  return out;
}

}  // namespace limberg
