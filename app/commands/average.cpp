#include "app/commands/average.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "app/export/solids.h"
#include "app/result/output.h"
#include "app/result/tables.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

std::string spread_csv(const AverageSurface& a) {
  std::string out = "x_mm,y_mm,z_mm,spread_mm\n";
  for (size_t v = 0; v < a.mean.x_mm.size(); ++v) {
    const Vec3& x = a.mean.x_mm[v];
    out += fmt::format("{:.4f},{:.4f},{:.4f},{:.5f}\n", x.x(), x.y(), x.z(), a.spread_mm[v]);
  }
  return out;
}

}  // namespace

std::optional<ResultAverage> average_files(const std::vector<std::string>& files, const std::vector<Surface>& surfaces,
                                           const std::string& to, const AverageSettings& settings,
                                           const std::string& out_dir, Result& result, Workers& workers,
                                           std::string& reason) {
  const std::string kind = std::filesystem::path(to).extension().string();
  if (kind != ".obj" && kind != ".ply" && kind != ".stl")
    throw InputError(to, 0, "is no name of a surface that is written; expected one that ends in .obj, .ply or .stl");
  const AverageSurface a = average_surface(surfaces, settings, workers);
  if (!a) return reason = a.reason, std::nullopt;
  write_whole_file(to, kind == ".obj"   ? obj_text(a.mean)
                       : kind == ".ply" ? ply_bytes(a.mean, "the mean of several surfaces")
                                        : stl_bytes(a.mean, "the mean of several surfaces"));
  ResultAverage r{to, a.mean.x_mm.size(), a.rounds, a.still, 0, 0, 0, a.half, {}};
  std::vector<double> spread = a.spread_mm;
  std::sort(spread.begin(), spread.end());
  for (const double x : spread) r.spread_mean_mm += x / double(spread.size());
  r.spread_p95_mm = spread[spread.size() * 95 / 100], r.spread_max_mm = spread.back();
  ResultTable t{"The mean, and each surface",
                "Distance of the mean from each surface, along the mean's normals.",
                {"surface", "rms, mm", "95 % within, mm", "share of the mean that it has", "times as large"},
                {}};
  for (size_t k = 0; k < files.size(); ++k) {
    const AverageSurface::One& one = a.of[k];
    std::printf("%-11s %.3f mm rms from the mean, 95 %% within %.3f mm, %.0f %% of it there: %s\n",
                k == 0 ? "surfaces" : "", one.rms_mm, one.p95_mm, 100 * one.reached, files[k].c_str());
    r.surfaces.push_back({files[k], one.rms_mm, one.p95_mm, one.reached, one.map.scale});
    t.rows.push_back({std::filesystem::path(files[k]).filename().string(), fmt::format("{:.3f}", one.rms_mm),
                      fmt::format("{:.3f}", one.p95_mm), fmt::format("{:.3f}", one.reached),
                      fmt::format("{:.4f}", one.map.scale)});
  }
  add_table(result, t);
  std::printf("mean        %zu vertices, %d rounds%s, spread %.3f mm on average, 95 %% within %.3f, at most %.3f: %s\n",
              a.mean.x_mm.size(), a.rounds, a.still ? "" : ", not at rest", r.spread_mean_mm, r.spread_p95_mm,
              r.spread_max_mm, to.c_str());
  if (!out_dir.empty()) write_whole_file(out_dir + "/spread.csv", spread_csv(a));
  return r;
}

}  // namespace limberg
