#include "app/export/achieved.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/result/read_result.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace {

constexpr size_t kMostPlanBytes = size_t(1) << 26;

/// STL has each corner by itself: those with the same bits are one.
Surface joined(const Surface& s) {
  Surface out;
  std::map<std::array<double, 3>, int32_t> number;
  for (const Tri& t : s.tri) {
    Tri own;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3& x = s.x_mm[size_t(t[k])];
      const auto [at, fresh] = number.try_emplace({x.x(), x.y(), x.z()}, int32_t(out.x_mm.size()));
      if (fresh) out.x_mm.push_back(x);
      own[k] = at->second;
    }
    if (own[0] != own[1] && own[1] != own[2] && own[2] != own[0]) out.tri.push_back(own);
  }
  return out;
}

/// Of the vertex that is farthest from the middle.
double reach_mm(const Surface& s) {
  const Vec3 middle = middle_of(s.x_mm);
  double most = 0;
  for (const Vec3& x : s.x_mm) most = std::max(most, (x - middle).norm());
  return most;
}

}  // namespace

Achieved planned_against_achieved(const std::vector<PlannedFragment>& plan, const Surface& later, double moved_mm,
                                  Workers& workers) {
  Achieved out;
  const auto stays = [&](const PlannedFragment& f) {
    return f.fixed || f.planned_mm.norm() + f.planned_deg * std::numbers::pi / 180 * reach_mm(f.surface) < moved_mm;
  };
  Surface skull;
  for (const PlannedFragment& f : plan)
    if (f.fixed) append(skull, f.surface);
  if (skull.tri.empty())
    for (const PlannedFragment& f : plan)
      if (stays(f)) append(skull, f.surface);
  if (skull.tri.empty()) {
    out.reason = "every fragment of the plan is moved: nothing says where the head lies";
    return out;
  }
  const SurfaceTarget target(later);
  IcpSettings s;
  const IcpResult laid = icp_from_anywhere(skull, target, later, s, workers);
  if (!laid) {
    out.reason = laid.reason;
    return out;
  }
  out.skull_rms_mm = laid.rms_mm;
  for (const PlannedFragment& f : plan) {
    if (stays(f)) continue;
    AchievedFragment a;
    a.name = f.name;
    const IcpResult own = icp(f.surface, target, laid.map, s, workers);
    if (own) {
      const Similarity off = laid.map.inverse() * own.map;
      const Vec3 middle = middle_of(f.surface.x_mm);
      a.off_mm = off(middle) - middle, a.off_deg = off.angle_deg(), a.rms_mm = own.rms_mm;
    } else {
      a.reason = own.reason;
    }
    out.fragments.push_back(std::move(a));
  }
  return out;
}

std::vector<PlannedFragment> read_plan(const std::string& folder) {
  using result_json::member;
  const std::string file = folder + "/plan.json";
  const nlohmann::json plan = nlohmann::json::parse(read_whole_file(file, kMostPlanBytes, "a plan"), nullptr, false);
  const nlohmann::json& list = member(plan, "fragments");
  if (!list.is_array() || list.empty())
    throw InputError(file, 0, "holds no fragments; expected what `limberg export` writes of a head");
  if (result_json::words(member(member(plan, "frames"), "files")) != "head")
    throw InputError(file, 0, "its surfaces are in the picture's frame; expected an export with --frame head");
  std::vector<PlannedFragment> out;
  for (const nlohmann::json& j : list) {
    PlannedFragment f;
    f.name = result_json::words(member(j, "name"));
    f.fixed = member(j, "fixed").is_boolean() && member(j, "fixed").get<bool>();
    const nlohmann::json &way = member(j, "centre_moved_mm"), &files = member(j, "files");
    if (!way.is_array() || way.size() != 3 || !files.is_array() || files.empty())
      throw InputError(file, 0, "a fragment lacks its files or its move; expected what `limberg export` writes");
    for (size_t k = 0; k < 3; ++k) f.planned_mm[Eigen::Index(k)] = result_json::number(way[k]).value_or(0);
    f.planned_deg = result_json::number(member(j, "turned_deg")).value_or(0);
    const std::string name = result_json::words(files[0]);
    if (name.empty() || name.find('/') != std::string::npos)
      throw InputError(file, 0, "a fragment's file is no plain name; expected one beside the plan");
    f.surface = joined(load_surface(folder + "/" + name));
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace limberg
