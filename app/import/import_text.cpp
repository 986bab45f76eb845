// What an import leaves: scene, surface, script.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "app/import/import.h"
#include "render/image.h"
#include "sim/body/thickness.h"

namespace limberg {
namespace {

const char* what_of(int material) {
  switch (material) {
    case peer_material::skin:
      return "skin";
    case peer_material::periosteum:
      return "held";
    case peer_material::periphery:
      return "held_softly";
    default:
      return "cut";
  }
}

std::string direction(const Vec3& v) { return fmt::format("[{:.4f}, {:.4f}, {:.4f}]", v.x(), v.y(), v.z()); }
std::string place(const Vec3& v) { return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", v.x(), v.y(), v.z()); }

std::string file_name(const std::string& path) {
  std::string s = std::filesystem::path(path).filename().string();
  for (char& c : s)
    if (static_cast<unsigned char>(c) < ' ' || c == '"' || c == '\\' || static_cast<unsigned char>(c) >= 127) c = '_';
  return s;
}

/// Of a region of a scene: at most 40 bytes, no two alike.
std::string region_name(const Imported& x, size_t i) {
  const std::string name = file_name(x.volumes[i].solid->name).substr(0, 36);
  return x.volumes.size() > 1 ? fmt::format("{} {}", name, i + 1) : name;
}

constexpr double kSoft_kPa = 15;  // as the last layer below

}  // namespace

std::string scene_toml(const Imported& x) {
  const CarriedOperation& o = x.operation;
  const Vec3 n = o.outwards;
  // Seen from outside, the model's y as far up as it goes.
  Vec3 up = std::abs(n.y()) < 0.95 ? Vec3::UnitY() : Vec3(-Vec3::UnitZ());
  const Vec3 e1 = up.cross(n).normalized(), e2 = n.cross(e1);
  std::string t = fmt::format(
      "# Of {}{}. One unit of that file is {:g} mm{}.\nname = \"{}\"\nnote = \"Imported from a peer's files; what was "
      "carried stands in {}.html.\"\n\n[body]\nsource = \"obj\"\nmesh = \"{}.obj\"\n{}chart_origin_mm = {}\nchart_e1 = "
      "{}\n"
      "chart_e2 = {}\ntension_direction = {}\n",
      file_name(x.model_file), x.bed_file.empty() ? "" : " and " + file_name(x.bed_file), x.unit_mm,
      x.unit_guessed ? ", guessed by its size" : "", x.name, x.name, x.name,
      x.texture.empty() ? "" : fmt::format("texture = \"{}\"\n", picture_name(x)), place(o.middle_mm), direction(e1),
      direction(e2), direction(e1));
  for (const int material : std::set<int>(x.model.material.begin(), x.model.material.end()))
    t += fmt::format("\n[[body.tag]]\nmaterial = \"{}\"\nwhat = \"{}\"\n", material, what_of(material));
  for (size_t i = 0; i < x.colliders.size(); ++i)
    t += fmt::format("\n# {}\n[[collider]]\nmesh = \"{}.obj\"\n", file_name(x.colliders[i]->name), collider_name(x, i));
  std::string regions;
  for (size_t i = 0; i < x.volumes.size(); ++i)
    regions += fmt::format(
        "# {}: {:.3g} times as stiff as the tissue around it, as the peer weighs its strain\n[[region]]\nname = "
        "\"{}\"\nvolume = \"{}.obj\"\nyoung_kPa = {:.4g}\npoisson = 0.45\ndensity_kg_m3 = 1100\ncolour = [0.88, "
        "0.89, 0.86]\n\n",
        file_name(x.volumes[i].file), x.volumes[i].stiffness, region_name(x, i), volume_name(x, i),
        kSoft_kPa * x.volumes[i].stiffness);
  t += fmt::format(
      "\n# As in our face.toml: skin 60 kPa, the soft tissue of a face taken together 15 kPa (Chabanas 2003). The\n"
      "# thickness is the median of the deep points.\n[[layer]]\nname = \"skin\"\nthickness_mm = {:.2f}\n{}young_kPa "
      "= 60\npoisson = 0.45\ndensity_kg_m3 = 1100\n\n[[layer]]\nname = \"fat and muscle\"\nthickness_mm = "
      "100\nyoung_kPa = "
      "15\n"
      "poisson = 0.45\ndensity_kg_m3 = 950\n\n{}[lattice]\ncell_mm = {:.3g}\nregion_mm = {:.0f}  # what lies farther "
      "from the "
      "operation holds still\n\n[solver]\niterations_per_step = 10\nseed = 1\n\n[tools]\nmax_depth_mm = 40\n"
      "default_depth_mm = {:.2f}\ndefault_spacing_mm = {:.3g}\n\n[springs]\nsuture_bite_mm = {:.3g}\nhook_tip_mm = "
      "{:.3g}\n\n",
      x.skin_mm, thickness_name(x).empty() ? "" : fmt::format("thickness_file = \"{}\"\n", thickness_name(x)), regions,
      x.cell_mm, x.region_mm, std::clamp(1.1 * x.skin_mm, 0.1, 40.0), x.spacing_mm, x.bite_mm, x.bite_mm);
  const double distance = std::clamp(5.0 * o.reach_mm + 40, 60.0, 2000.0);
  t += fmt::format("[camera]\ntarget_mm = {}\nfrom = {}\nup = {}\ndistance_mm = {:.0f}\nfov_deg = 28\n",
                   place(o.middle_mm), direction(n), direction(e2), distance);
  return t;
}

std::string surface_obj(const Imported& x) {
  const TriMesh& m = x.model.mesh;
  std::string t = fmt::format("# {} in mm\n", file_name(x.model_file));
  for (const Vec3& v : m.X_mm) t += fmt::format("v {:.5f} {:.5f} {:.5f}\n", v.x(), v.y(), v.z());
  std::map<std::pair<float, float>, size_t> number;
  std::string faces;
  for (const int material : std::set<int>(x.model.material.begin(), x.model.material.end())) {
    faces += fmt::format("usemtl {}\n", material);
    for (size_t i = 0; i < m.tri.size(); ++i) {
      if (x.model.material[i] != material) continue;
      faces += 'f';
      for (size_t k = 0; k < 3; ++k) {
        const auto& uv = m.uv[i][k];
        const auto [at, fresh] = number.insert({{uv.x(), uv.y()}, number.size() + 1});
        if (fresh) t += fmt::format("vt {} {}\n", uv.x(), uv.y());
        faces += fmt::format(" {}/{}", m.tri[i][k] + 1, at->second);
      }
      faces += '\n';
    }
  }
  return t + faces;
}

std::string thickness_name(const Imported& x) {
  const bool known =
      std::any_of(x.model.deep_mm.begin(), x.model.deep_mm.end(), [](const Vec3& p) { return p.allFinite(); });
  return known ? x.name + "-skin.txt" : "";
}

std::string thickness_text(const Imported& x) {
  std::string t;
  for (size_t v = 0; v < x.model.deep_mm.size(); ++v) {
    if (!x.model.deep_mm[v].allFinite()) continue;
    const Vec3& X = x.model.mesh.X_mm[v];
    const double thick =
        std::clamp((x.model.deep_mm[v] - X).norm(), ThicknessLimits::least_mm, ThicknessLimits::most_mm);
    t += fmt::format("{:.5f} {:.5f} {:.5f} {:.4f}\n", X.x(), X.y(), X.z(), thick);
  }
  return fmt::format("# Of {}: x y z thickness of the skin there, mm\n", file_name(x.bed_file)) + t;
}

std::string picture_name(const Imported& x) {
  return x.texture.empty() ? "" : x.name + (is_jpeg(x.texture) ? ".jpg" : ".png");
}

std::string volume_name(const Imported& x, size_t i) { return fmt::format("{}-region-{}", x.name, i + 1); }
std::string collider_name(const Imported& x, size_t i) { return fmt::format("{}-collider-{}", x.name, i + 1); }

std::vector<std::pair<std::string, std::shared_ptr<const Collider>>> solid_files(const Imported& x) {
  std::vector<std::pair<std::string, std::shared_ptr<const Collider>>> out;
  for (size_t i = 0; i < x.colliders.size(); ++i) out.emplace_back(collider_name(x, i) + ".obj", x.colliders[i]);
  for (size_t i = 0; i < x.volumes.size(); ++i) out.emplace_back(volume_name(x, i) + ".obj", x.volumes[i].solid);
  return out;
}

std::string collider_obj(const Collider& c) {
  std::string t = fmt::format("# {} in mm\n", file_name(c.name));
  for (size_t v = 0; v < c.mesh.X_mm.size(); ++v) {
    const Vec3& X = c.mesh.X_mm[v];
    t += fmt::format("v {:.5f} {:.5f} {:.5f}", X.x(), X.y(), X.z());
    if (!c.rgb.empty()) t += fmt::format(" {:.3f} {:.3f} {:.3f}", c.rgb[v].x(), c.rgb[v].y(), c.rgb[v].z());
    t += '\n';
  }
  for (const Tri& f : c.mesh.tri) t += fmt::format("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
  return t;
}

std::string script_text(const Imported& x) {
  std::string t = fmt::format("{{\"limberg_script\":1,\"scene\":\"{}.toml\",\"note\":\"{}\"}}\n", x.name,
                              file_name(x.history_file.empty() ? x.scene_file : x.history_file));
  for (const std::string& line : x.operation.script) t += line + "\n";
  return t;
}

}  // namespace limberg
