// Acts whose places are given in space: cuts look at the skin through a plane of their own (body/skin_view.h); hooks
// and stitches, which need no plane, find each place by itself, and rows run along their two paths.
#include <algorithm>

#include "sim/body/skin_view.h"
#include "sim/commands/texture_script.h"
#include "sim/geometry/polyline.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {
namespace {

/// Paths in space that are measured along themselves. On the chart that an act sees, path k is the straight line y = k
/// and x its length.
struct Unrolled {
  static constexpr double kApart_mm = 1e5;  // between two paths
  std::vector<std::vector<Vec3>> path;

  std::vector<ChartPoint> points(size_t k) const {
    std::vector<ChartPoint> out;
    double s = 0;
    for (size_t i = 0; i < path[k].size(); ++i) {
      if (i > 0) s += (path[k][i] - path[k][i - 1]).norm();
      out.emplace_back(s, double(k) * kApart_mm);
    }
    return out;
  }
  Vec3 place_mm(const ChartPoint& p) const {
    const std::vector<Vec3>& way =
        path[size_t(std::clamp(std::round(p.y() / kApart_mm), 0.0, double(path.size() - 1)))];
    double left = p.x();
    for (size_t i = 1; i < way.size(); ++i) {
      const double length = (way[i] - way[i - 1]).norm();
      if (left <= length && length > 0) return way[i - 1] + std::max(0.0, left / length) * (way[i] - way[i - 1]);
      left -= length;
    }
    return way.back();
  }
};

/// Takes the look away when the act is over, however it ends.
struct Looking {
  Tissue& tissue;
  Looking(Tissue& t, const Tissue::Look& look) : tissue(t) { tissue.look(&look); }
  ~Looking() { tissue.look(nullptr); }
  Looking(const Looking&) = delete;
  Looking& operator=(const Looking&) = delete;
};

}  // namespace

Outcome SoftTissue::draw_on(const Command& command) const {
  const auto* c = std::get_if<InSpace>(&command);
  if (!c) return {true, {}};
  std::string reason;
  const auto laid = on_texture(*c, tissue_.body(), reason);
  if (!laid) return {false, reason};
  for (const Vec3& X : places_of(*laid))
    if (!place_on_skin(tissue_.skin(), X, reason)) return {false, reason};
  return {true, {}};
}

Acted<TissueChange> SoftTissue::act_in_space(const InSpace& c) {
  if (has_texture_places(c)) {
    std::string reason;
    const auto laid = on_texture(c, tissue_.body(), reason);
    return laid ? act_in_space(*laid) : Acted<TissueChange>{false, reason};
  }
  const std::vector<Vec3> places = places_of(c);
  const bool cuts = std::holds_alternative<Incise>(c.act) || std::holds_alternative<Undermine>(c.act) ||
                    std::holds_alternative<Excise>(c.act);
  const auto carried_out = [&](const SkinAct& act) {
    return std::visit([&](const auto& a) { return carry_out_act(a); }, act);
  };
  Tissue::Look look;
  if (cuts) {
    std::string reason;
    const auto view = view_of(tissue_.skin(), places, reason);
    if (!view) return {false, reason};
    std::vector<ChartPoint> points;
    for (const Vec3& X : view->place) points.push_back(view->chart.to_chart(X));
    look.view = &*view;
    look.skin = [&](const ChartPoint& p) { return tissue_.skin().at(p, *view); };
    look.place_mm = [&](const ChartPoint& p) { return view->chart.to_space(p, view->height_mm(p)); };
    const Looking looking(tissue_, look);
    return carried_out(with_points(c, points));
  }
  Unrolled ways;
  if (const auto* row = std::get_if<SutureRow>(&c.act)) {
    ways.path.emplace_back(places.begin(), places.begin() + std::ptrdiff_t(row->a.size()));
    ways.path.emplace_back(places.begin() + std::ptrdiff_t(row->a.size()), places.end());
  } else {
    for (const Vec3& X : places) ways.path.push_back({X});
  }
  std::vector<ChartPoint> points;
  for (size_t k = 0; k < ways.path.size(); ++k)
    for (const ChartPoint& p : ways.points(k)) points.push_back(p);
  look.place_mm = [&](const ChartPoint& p) { return ways.place_mm(p); };
  look.skin = [&](const ChartPoint& p) -> std::optional<SkinHit> {
    const Vec3 X = ways.place_mm(p);
    const SkinHit hit = tissue_.skin().nearest(X);
    if (hit.triangle < 0 || !((hit.X_mm - X).norm() <= kOffSkin_mm)) return std::nullopt;
    return hit;
  };
  const Looking looking(tissue_, look);
  return carried_out(with_points(c, points));
}

}  // namespace limberg
