#include "app/export/moment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/export/guide.h"
#include "app/export/solids.h"
#include "app/head/skull_comparison.h"
#include "app/program/version.h"
#include "app/result/output.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace {

using PlanJson = nlohmann::ordered_json;

constexpr double kPlateRadius_mm = 1;
constexpr int kPlateSides = 12;

PlanJson json_of(const Mat3& R) {
  PlanJson rows = PlanJson::array();
  for (int i = 0; i < 3; ++i) rows.push_back({R(i, 0), R(i, 1), R(i, 2)});
  return rows;
}
PlanJson json_of(const Vec3& v) { return PlanJson::array({v.x(), v.y(), v.z()}); }
PlanJson json_of(const Eigen::Isometry3d& m) {
  return {{"rotation", json_of(Mat3(m.linear()))}, {"translation_mm", json_of(Vec3(m.translation()))}};
}

/// A rod from end to end, closed.
void add_rod(Surface& s, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  if (!(d.norm() > 1e-6)) return;
  const Vec3 u = d.unitOrthogonal(), v = d.normalized().cross(u);
  const auto first = int32_t(s.x_mm.size());
  for (const Vec3& end : {a, b}) {
    for (int i = 0; i < kPlateSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPlateSides;
      s.x_mm.push_back(end + kPlateRadius_mm * (std::cos(angle) * u + std::sin(angle) * v));
    }
    s.x_mm.push_back(end);
  }
  const int32_t n = kPlateSides, ca = first + n, second = first + n + 1, cb = second + n;
  for (int32_t i = 0; i < n; ++i) {
    const int32_t j = (i + 1) % n;
    s.tri.push_back({ca, first + j, first + i}), s.tri.push_back({cb, second + i, second + j});
    s.tri.push_back({first + i, first + j, second + j}), s.tri.push_back({first + i, second + j, second + i});
  }
}

Surface of_organ(const Snapshot& s, Organ organ) {
  Surface out;
  for (const Vec3f& x : s.x_mm) out.x_mm.push_back(x.cast<double>());
  const SurfaceTopology& t = *s.topology;
  for (size_t i = 0; i < t.view.tri.size(); ++i)
    if (t.organ_of(i) == organ) out.tri.push_back(t.view.tri[i]);
  return compacted(out);
}

class Exporter {
 public:
  Exporter(const World& world, const Scene& scene, const ExportSettings& settings, Workers& workers)
      : world_(world), settings_(settings), workers_(workers) {
    if (scene.head && scene.head->picture_from_head)
      picture_ = *scene.head->picture_from_head * Eigen::Translation3d(-scene.head->offset_mm);
    if (settings.in_picture && !picture_)
      throw InputError(scene.path, 0,
                       "the scene does not say where the head lies in its picture; expected head.picture_from_head, as "
                       "`limberg patient` writes it");
  }
  ExportedMoment out;

  void run() {
    Snapshot now;
    world_.fill(now);
    if (has_surface(now)) {
      if (const Surface skin = of_organ(now, Organ::flesh); !skin.tri.empty()) leave("skin", skin);
      if (const Surface face = of_organ(now, Organ::face); !face.tri.empty()) leave("face", face);
    }
    if (world_.head()) bones(*world_.head());
  }

 private:
  /// Two fragments may have one name, or names that differ in what a file name cannot hold.
  std::string unused(const std::string& wanted) const {
    const auto taken = [&](const std::string& n) {
      return std::any_of(out.files.begin(), out.files.end(), [&](const ExportedFile& f) { return f.file == n; });
    };
    std::string name = wanted;
    for (int k = 2; taken(name); ++k) name = wanted + "-" + std::to_string(k);
    return name;
  }
  const ExportedFile& leave(const std::string& wanted, Surface s) {
    if (settings_.in_picture) move(s, *picture_);
    const SolidFigures f = solid_figures(s);
    const std::string name = unused(wanted);
    write_whole_file(out.folder + "/" + name + ".stl", stl_bytes(s, "limberg " + name + ", mm"));
    write_whole_file(out.folder + "/" + name + ".ply", ply_bytes(s, "limberg " + name + ", mm"));
    out.files.push_back({name, int64_t(s.tri.size()), f.closed(), f.closed() ? f.volume_mm3 : 0});
    return out.files.back();
  }

  void bones(const Head& head) {
    plan_["limberg"] = program_name(), plan_["scene_moment"] = out.name;
    plan_["frames"] = {{"head", "x right, y forwards, z up, origin between the porions, mm"},
                       {"files", settings_.in_picture ? "picture" : "head"}};
    if (picture_) {
      plan_["frames"]["picture"] = "left, posterior, superior, as the CT has its places, mm";
      plan_["picture_from_head"] = json_of(*picture_);
    }
    plan_["fragments"] = PlanJson::array();
    BoneField at_rest;
    for (const bone::Fragment& f : head.bones().fragments()) fragment(head, f, at_rest);
    plates(head);
    if (settings_.mirror) mirror(head);
    if (settings_.guides) guides(head, at_rest);
    if (settings_.splint) {
      const Made s = splint(head, {}, workers_);
      for (const Surface& part : s.parts) tell("splint", leave("splint", part), {});
      if (!s.why.empty()) left_out("splint", s.why);
    }
    plan_["left_out"] = out.left_out;
    write_whole_file(out.folder + "/plan.json", plan_.dump(2, ' ', false, PlanJson::error_handler_t::replace) + "\n");
  }

  void fragment(const Head& head, const bone::Fragment& f, BoneField& at_rest) {
    Surface s = fragment_surface(head.bones(), f);
    at_rest.add(s);
    move(s, f.pose);
    const ExportedFile& file = leave(file_name_of(f.name), s);
    const Vec3 way = f.pose * f.centre_mm - f.centre_mm;
    PlanJson j{{"id", f.id},
               {"name", f.name},
               {"files", {file.file + ".stl", file.file + ".ply"}},
               {"fixed", f.fixed},
               {"closed", file.closed},
               {"volume_mm3", f.volume_mm3},
               {"centre_mm", json_of(Vec3(f.centre_mm))},
               {"centre_moved_mm", json_of(way)},
               {"turned_deg", Eigen::AngleAxisd(f.pose.linear()).angle() * 180 / std::numbers::pi},
               {"head", json_of(f.pose)}};
    if (picture_) j["picture"] = json_of(Eigen::Isometry3d(*picture_ * f.pose * picture_->inverse()));
    plan_["fragments"].push_back(std::move(j));
  }

  void plates(const Head& head) {
    plan_["plates"] = PlanJson::array();
    Surface s;
    for (const bone::Plate& p : head.bones().plates()) {
      const Vec3 a = head.bones().fragment(p.a)->pose * p.a_mm, b = head.bones().fragment(p.b)->pose * p.b_mm;
      add_rod(s, a, b);
      plan_["plates"].push_back({{"fragments", {p.a, p.b}}, {"a_mm", json_of(a)}, {"b_mm", json_of(b)}});
    }
    if (!s.tri.empty()) leave("plates", s);
  }

  /// Each fragment as it lay before it was moved, seen in the plane of the whole bones.
  void mirror(const Head& head) {
    const Surface skull = bone_surface(head, true);
    const MirrorPlane plane = mirror_plane(skull, Vec3::UnitX(), skull_fit(), workers_);
    if (!plane) return left_out("mirrored parts", plane.reason);
    plan_["mirror"] = {
        {"normal", json_of(plane.normal)}, {"point_mm", json_of(plane.point_mm)}, {"rms_mm", plane.rms_mm}};
    for (const bone::Fragment& f : head.bones().fragments()) {
      Surface s = fragment_surface(head.bones(), f);
      for (Vec3& x : s.x_mm) x = plane.reflect(x);
      for (Tri& t : s.tri) std::swap(t[1], t[2]);
      leave("mirror-" + file_name_of(f.name), s);
    }
  }

  void guides(const Head& head, const BoneField& at_rest) {
    for (const bone::Fragment& f : head.bones().fragments()) {
      if (f.fixed || f.pose.matrix() == Eigen::Matrix4d::Identity()) continue;
      if (head.bones().fragments().size() < 2) continue;
      const GuideSettings set;
      const Made g = cutting_guide(head.bones(), f, at_rest, set, workers_);
      if (!g.why.empty()) left_out("guide for " + f.name, g.why);
      for (size_t i = 0; i < g.parts.size(); ++i)
        tell("guides", leave(fmt::format("guide-{}-{}", file_name_of(f.name), i + 1), g.parts[i]),
             {{"fragment", f.id},
              {"slot_mm", set.slot_mm},
              {"thick_mm", set.thick_mm},
              {"off_bone_mm", set.off_bone_mm}});
    }
  }

  void tell(const char* list, const ExportedFile& file, PlanJson more) {
    PlanJson j{
        {"files", {file.file + ".stl", file.file + ".ply"}}, {"closed", file.closed}, {"volume_mm3", file.volume_mm3}};
    if (!more.is_null()) j.update(more);
    plan_[list].push_back(std::move(j));
  }
  void left_out(const std::string& what, const std::string& why) { out.left_out.push_back(what + ": " + why); }

  const World& world_;
  const ExportSettings& settings_;
  Workers& workers_;
  std::optional<Eigen::Isometry3d> picture_;
  PlanJson plan_;
};

}  // namespace

std::string file_name_of(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain)
      out += c;
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out.empty() ? "part" : out.substr(0, 80);
}

ExportedMoment export_moment(const World& world, const Scene& scene, const std::string& name, const std::string& folder,
                             const ExportSettings& settings, Workers& workers) {
  Exporter e(world, scene, settings, workers);
  prepare_folder(folder);
  e.out.name = name, e.out.folder = folder;
  e.run();
  return std::move(e.out);
}

}  // namespace limberg
