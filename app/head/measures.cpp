#include "app/head/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "sim/base/csv_text.h"
#include "sim/measure/cephalometry.h"

namespace limberg {

namespace {

std::vector<NamedPoint> points(const NamedPlaces& places) {
  std::vector<NamedPoint> out;
  for (const auto& [name, at] : places) out.push_back({name, at, 1});
  return out;
}

double angle_deg(const Vec3& a, const Vec3& at, const Vec3& b) {
  const Vec3 u = a - at, v = b - at;
  return std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / std::numbers::pi;
}

}  // namespace

int picked_number(const std::string& name) {
  if (name.size() < 2 || name.size() > 9 || name[0] != 'M' ||
      name.find_first_not_of("0123456789", 1) != std::string::npos)
    return 0;
  return std::atoi(name.c_str() + 1);
}

std::vector<HeadMeasure> head_measures(const NamedPlaces& before, const NamedPlaces& now) {
  using Group = HeadMeasure::Group;
  std::vector<HeadMeasure> out;
  const std::vector<NamedPoint> was = points(before), is = points(now);
  const std::vector<CephalometricRow> a = cephalometry(was), b = cephalometry(is);
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const CephalometricMeasure& m = *a[i].measure;
    if (!a[i].value || !b[i].value) continue;
    std::string norm;
    if (m.norm) norm = fmt::format("{:.4g}", *m.norm);
    out.push_back({Group::cephalometry, m.name, m.unit, *a[i].value, *b[i].value, norm});
  }
  const Asymmetry x = asymmetry(was), y = asymmetry(is);
  if (!x.rows.empty() && !y.rows.empty())
    out.push_back({Group::asymmetry, "rms of all pairs", "mm", x.rms_mm, y.rms_mm, "0"});
  for (const AsymmetryRow& r : x.rows)
    for (const AsymmetryRow& s : y.rows)
      if (r.name == s.name) out.push_back({Group::asymmetry, r.name, "mm", r.distance_mm, s.distance_mm, "0"});
  struct Place {
    int number;
    Vec3 was, is;
  };
  std::vector<Place> place;
  for (const auto& [name, at] : now)
    if (const int n = picked_number(name))
      for (const auto& [other, x0] : before)
        if (other == name) place.push_back({n, x0, at});
  std::stable_sort(place.begin(), place.end(), [](const Place& p, const Place& q) { return p.number < q.number; });
  const auto called = [&](size_t i) { return "M" + std::to_string(place[i].number); };
  for (size_t i = 0; i + 1 < place.size(); ++i)
    out.push_back({Group::picked, called(i) + "-" + called(i + 1), "mm", (place[i + 1].was - place[i].was).norm(),
                   (place[i + 1].is - place[i].is).norm(), ""});
  for (size_t i = 0; i + 2 < place.size(); ++i)
    out.push_back({Group::picked, called(i) + "-" + called(i + 1) + "-" + called(i + 2), "deg",
                   angle_deg(place[i].was, place[i + 1].was, place[i + 2].was),
                   angle_deg(place[i].is, place[i + 1].is, place[i + 2].is), ""});
  return out;
}

std::string to_csv(const std::vector<HeadMeasure>& measures) {
  static constexpr const char* kGroups[] = {"cephalometry", "asymmetry", "picked"};
  std::string out = "group,name,unit,before,now,change,norm\n";
  for (const HeadMeasure& m : measures) {
    const std::string figures = fmt::format(",{},{:.4f},{:.4f},{:.4f},", m.unit, m.before, m.now, m.change());
    out += std::string(kGroups[size_t(m.group)]) + "," + csv_text(m.name) + figures + m.norm + "\n";
  }
  return out;
}

}  // namespace limberg
