#include "app/head/skull_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/head/cache.h"
#include "app/output.h"
#include "app/tables.h"
#include "render/gl_context.h"
#include "render/picture.h"
#include "sim/error.h"
#include "sim/simplex/dual.h"

namespace limberg {

namespace {

/// The triangles of a mesh that are bone's own surface; appended.
void add_surface(Surface& s, const simplex::Mesh& mesh, const simplex::FanTriangles& fan) {
  const auto base = int32_t(s.x_mm.size());
  s.x_mm.insert(s.x_mm.end(), fan.X_mm.begin(), fan.X_mm.end());
  for (size_t t = 0; t < fan.tri.size(); ++t)
    if (mesh.kind(fan.face[t]) == simplex::FaceKind::surface) s.tri.push_back({fan.tri[t][0] + base, fan.tri[t][1] + base, fan.tri[t][2] + base});
}

/// Only the vertices that a triangle has.
Surface compacted(const Surface& s, std::vector<int32_t>* fragment) {
  std::vector<int32_t> number(s.x_mm.size(), -1), of;
  Surface out;
  for (const Tri& t : s.tri) {
    Tri k{};
    for (size_t c = 0; c < 3; ++c) {
      int32_t& n = number[size_t(t[c])];
      if (n < 0) {
        n = int32_t(out.x_mm.size()), out.x_mm.push_back(s.x_mm[size_t(t[c])]);
        if (fragment) of.push_back((*fragment)[size_t(t[c])]);
      }
      k[c] = n;
    }
    out.tri.push_back(k);
  }
  if (fragment) *fragment = std::move(of);
  return out;
}

struct Spread {
  double mean = 0, rms = 0, p95 = 0;
};
Spread spread(const std::vector<double>& all, const std::vector<int32_t>& fragment, int32_t id) {
  Spread s;
  std::vector<double> size;
  for (size_t v = 0; v < all.size(); ++v)
    if ((id < 0 || fragment[v] == id) && std::isfinite(all[v])) s.mean += all[v], s.rms += all[v] * all[v], size.push_back(std::abs(all[v]));
  if (size.empty()) return s;
  s.mean /= double(size.size()), s.rms = std::sqrt(s.rms / double(size.size()));
  std::sort(size.begin(), size.end());
  s.p95 = size[size.size() * 95 / 100];
  return s;
}

std::string map_csv(const SkullComparison& c) {
  std::string out = "x_mm,y_mm,z_mm,fragment,before_mm,after_mm\n";
  char line[160];
  for (size_t v = 0; v < c.now_mm.size(); ++v) {
    const Vec3& x = c.at_rest_mm[v];
    std::snprintf(line, sizeof line, "%.3f,%.3f,%.3f,%d,%.4f,%.4f\n", x.x(), x.y(), x.z(), c.fragment[v], c.before.signed_mm[v], c.after.signed_mm[v]);
    out += line;
  }
  return out;
}

}  // namespace

Snapshot coloured_skull(const Surface& skull, const DistanceMap& distance, uint64_t version) {
  auto top = std::make_shared<SurfaceTopology>();
  top->version = version;
  Snapshot s;
  for (size_t v = 0; v < skull.x_mm.size(); ++v)
    top->view.X_mm.push_back(skull.x_mm[v]), s.x_mm.push_back(skull.x_mm[v].cast<float>()), s.moved_mm.push_back(float(std::abs(distance.signed_mm[v])));
  for (const Tri& t : skull.tri) top->view.tri.push_back(t), top->view.kind.push_back(FaceKind::free), top->organ.push_back(Organ::face), top->object.push_back(-1);
  s.topology = std::move(top), s.topology_version = version;
  return s;
}

IcpSettings skull_fit() {
  IcpSettings s;
  s.samples = 4000, s.iterations = 80;
  return s;
}

Surface mirror_image(const Surface& skull, std::string& reason, Workers& w) {
  const MirrorPlane m = mirror_plane(skull, Vec3::UnitX(), skull_fit(), w);
  if (!m) return reason = m.reason, Surface{};
  Surface other = skull;
  for (Vec3& x : other.x_mm) x = m.reflect(x);
  for (Tri& t : other.tri) std::swap(t[1], t[2]);
  return other;
}

Surface bone_surface(const Head& head, bool at_rest, std::vector<int32_t>* fragment) {
  const simplex::Mesh& mesh = at_rest ? head.bones().mesh() : head.bones_now();
  const simplex::FanTriangles fan = simplex::fan_triangles(mesh);
  Surface s;
  add_surface(s, mesh, fan);
  if (fragment) {
    fragment->assign(s.x_mm.size(), -1);
    for (int32_t v = 0; v < mesh.slots(); ++v) (*fragment)[size_t(v)] = head.bones().fragment_of(v);
    for (const Tri& t : fan.tri) (*fragment)[size_t(t[0])] = (*fragment)[size_t(t[1])];
  }
  return compacted(s, fragment);
}

SkullComparison compare_with(const Head& head, const Surface& other, const std::string& words, bool with_scale, Workers& w) {
  SkullComparison c;
  c.with = words;
  Surface rest = bone_surface(head, true, &c.fragment), now = bone_surface(head, false);
  IcpSettings s = skull_fit();
  s.with_scale = with_scale;
  const SurfaceTarget target(other);
  const IcpResult r = icp(rest, target, {}, s, w);
  if (!r) {
    c.reason = "The skull could not be laid upon " + words + ": " + r.reason;
    return c;
  }
  c.map = r.map, c.fit_rms_mm = r.rms_mm;
  c.before = distance_map(rest, c.map, target, w);
  c.after = distance_map(now, c.map, target, w);
  c.at_rest_mm = std::move(rest.x_mm), c.now_mm = std::move(now.x_mm), c.tri = std::move(now.tri);
  return c;
}

SkullComparison compare_with_mirror(const Head& head, Workers& w) {
  SkullComparison c;
  c.with = "its mirror image";
  std::string reason;
  const Surface other = mirror_image(bone_surface(head, true), reason, w);
  if (!reason.empty()) {
    c.reason = "No mirror plane of the skull was found: " + reason;
    return c;
  }
  return compare_with(head, other, c.with, false, w);
}

Surface normal_skull(Workers& w) {
  const HeadModel normal = cached_head({}, w);
  Surface s;
  for (const simplex::Mesh* m : {&normal.cranium, &normal.mandible}) add_surface(s, *m, simplex::fan_triangles(*m));
  return compacted(s, nullptr);
}

std::vector<std::string> report_skull(Result& r, const Head& head, const std::string& dir, const Snapshot& last, const Camera& camera, Workers& w) {
  std::vector<std::string> problems;
  const nlohmann::json so_far = nlohmann::json::parse(r.text());
  const auto standing = [&](const char* list) { return so_far.contains(list) ? int(so_far.at(list).size()) : 0; };
  int gallery = standing("gallery"), n = 0;
  ResultTable t;
  t.title = "The skull beside another";
  t.about = "Distance of the skull's surface from the one that it was laid upon, in mm, outside of it positive. It was laid upon it as it was before the operation, by the places that differ least.";
  t.columns = {"laid upon", "part", "mean before", "mean after", "rms before", "rms after", "95 % within, before", "after"};
  const SkullComparison all[] = {compare_with(head, normal_skull(w), "a normal skull", false, w), compare_with_mirror(head, w)};
  const char* const files[] = {"skull-normal", "skull-mirror"};
  for (const SkullComparison& c : all) {
    const std::string file = files[&c - all];
    if (!c) {
      problems.push_back(c.reason);
      continue;
    }
    const std::string p = "/skull/" + std::to_string(n++);
    r.set(p + "/with", c.with), r.set(p + "/fit_rms_mm", c.fit_rms_mm);
    const auto row = [&](const std::string& part, int32_t id) {
      const Spread a = spread(c.before.signed_mm, c.fragment, id), b = spread(c.after.signed_mm, c.fragment, id);
      t.rows.push_back({c.with, part, short_number(a.mean, 3), short_number(b.mean, 3), short_number(a.rms, 3), short_number(b.rms, 3), short_number(a.p95, 3), short_number(b.p95, 3)});
      if (id >= 0) return;
      r.set(p + "/before_rms_mm", a.rms), r.set(p + "/after_rms_mm", b.rms), r.set(p + "/before_mean_mm", a.mean), r.set(p + "/after_mean_mm", b.mean);
    };
    row("all", -1);
    for (const bone::Fragment& f : head.bones().fragments()) row(f.name, f.id);
    write_whole_file(dir + "/" + file + ".csv", map_csv(c));
    if (!last.topology) continue;
    try {
      PictureMaker pictures(1080, 1080);
      pictures.set_camera(camera);
      PictureOptions o;
      o.legend = "Distance";
      double most = 1;  // what stands out is on some fragment
      for (const bone::Fragment& f : head.bones().fragments())
        for (const DistanceMap* d : {&c.before, &c.after}) most = std::max(most, spread(d->signed_mm, c.fragment, f.id).p95);
      o.field_max = std::ceil(most);
      for (const bool after : {false, true}) {
        o.title = std::string("Distance from ") + c.with + (after ? ", after" : ", before");
        const std::string name = "head/" + file + (after ? "-after.png" : "-before.png");
        write_png(dir + "/" + name, pictures.moved(coloured_skull({after ? c.now_mm : c.at_rest_mm, c.tri}, after ? c.after : c.before, after ? 2 : 1), o));
        const std::string q = "/gallery/" + std::to_string(gallery++);
        r.set(q + "/picture", name), r.set(q + "/caption", o.title);
      }
    } catch (const RenderUnavailable&) {
      // said once already, where the other pictures were to be made
    }
  }
  if (!t.rows.empty()) add_table(r, standing("tables"), t);
  return problems;
}

}  // namespace limberg
