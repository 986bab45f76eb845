#include "app/head/skull_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "app/head/cache.h"
#include "app/result/output.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "render/gl_context.h"
#include "render/picture.h"
#include "sim/base/error.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

/// The triangles of a mesh that are bone's own surface; appended.
void add_surface(Surface& s, const simplex::Mesh& mesh, const simplex::FanTriangles& fan) {
  const auto base = int32_t(s.x_mm.size());
  s.x_mm.insert(s.x_mm.end(), fan.X_mm.begin(), fan.X_mm.end());
  for (size_t t = 0; t < fan.tri.size(); ++t)
    if (mesh.kind(fan.face[t]) == simplex::FaceKind::surface)
      s.tri.push_back({fan.tri[t][0] + base, fan.tri[t][1] + base, fan.tri[t][2] + base});
}

struct Spread {
  double mean = 0, rms = 0, p95 = 0;
};
Spread spread(const std::vector<double>& all, const std::vector<int32_t>& fragment, int32_t id) {
  Spread s;
  std::vector<double> size;
  for (size_t v = 0; v < all.size(); ++v)
    if ((id < 0 || fragment[v] == id) && std::isfinite(all[v]))
      s.mean += all[v], s.rms += all[v] * all[v], size.push_back(std::abs(all[v]));
  if (size.empty()) return s;
  s.mean /= double(size.size()), s.rms = std::sqrt(s.rms / double(size.size()));
  std::sort(size.begin(), size.end());
  s.p95 = size[size.size() * 95 / 100];
  return s;
}

std::string map_csv(const SkullComparison& c) {
  std::string out = "x_mm,y_mm,z_mm,fragment,before_mm,after_mm\n";
  std::string line;
  for (size_t v = 0; v < c.now_mm.size(); ++v) {
    const Vec3& x = c.at_rest_mm[v];
    line = fmt::format("{:.3f},{:.3f},{:.3f},{},{:.4f},{:.4f}\n", x.x(), x.y(), x.z(), c.fragment[v],
                       c.before.signed_mm[v], c.after.signed_mm[v]);
    out += line;
  }
  return out;
}

}  // namespace

Snapshot coloured_skull(const Surface& skull, const DistanceMap& distance, uint64_t version) {
  Snapshot s = snapshot_of(skull, Organ::face, version);
  for (const double d : distance.signed_mm) s.moved_mm.push_back(float(std::abs(d)));
  return s;
}

Snapshot snapshot_of(const Surface& surface, Organ organ, uint64_t version) {
  auto top = std::make_shared<SurfaceTopology>();
  top->version = version;
  Snapshot s;
  for (const Vec3& x : surface.x_mm) top->view.X_mm.push_back(x), s.x_mm.push_back(x.cast<float>());
  for (const Tri& t : surface.tri)
    top->view.tri.push_back(t), top->view.kind.push_back(FaceKind::free), top->organ.push_back(organ),
        top->object.push_back(-1);
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

namespace {

/// `fragment`: per vertex slot on entry, per vertex of the surface afterwards.
Surface surface_of(const simplex::Mesh& mesh, std::vector<int32_t>* fragment) {
  const simplex::FanTriangles fan = simplex::fan_triangles(mesh);
  Surface s;
  add_surface(s, mesh, fan);
  if (fragment) {
    fragment->resize(s.x_mm.size(), -1);
    for (const Tri& t : fan.tri) (*fragment)[size_t(t[0])] = (*fragment)[size_t(t[1])];
  }
  return compacted(s, fragment);
}

}  // namespace

Surface bone_surface(const Head& head, bool at_rest, std::vector<int32_t>* fragment) {
  const simplex::Mesh& mesh = at_rest ? head.bones().mesh() : head.bones_now();
  if (fragment) {
    fragment->resize(size_t(mesh.slots()));
    for (int32_t v = 0; v < mesh.slots(); ++v) (*fragment)[size_t(v)] = head.bones().fragment_of(v);
  }
  return surface_of(mesh, fragment);
}

SkullFit lay_upon(const Surface& skull, const Surface& other, const std::string& words, bool with_scale, Workers& w,
                  bool anywhere) {
  SkullFit f;
  f.with = words;
  IcpSettings s = skull_fit();
  s.with_scale = with_scale;
  f.target.emplace(other);
  const IcpResult r = anywhere ? icp_from_anywhere(skull, *f.target, other, s, w) : icp(skull, *f.target, {}, s, w);
  if (!r) f.reason = "The skull could not be laid upon " + words + ": " + r.reason;
  f.map = r.map, f.rms_mm = r.rms_mm;
  return f;
}

SkullComparison measure_on(const SkullFit& fit, Surface rest, Surface now, std::vector<int32_t> fragment, Workers& w) {
  SkullComparison c;
  c.with = fit.with, c.reason = fit.reason;
  if (!c) return c;
  c.map = fit.map, c.fit_rms_mm = fit.rms_mm;
  c.before = distance_map(rest, c.map, *fit.target, w);
  c.after = distance_map(now, c.map, *fit.target, w);
  c.fragment = std::move(fragment);
  c.at_rest_mm = std::move(rest.x_mm), c.now_mm = std::move(now.x_mm), c.tri = std::move(now.tri);
  return c;
}

SkullComparison compare_with(const Head& head, const Surface& other, const std::string& words, bool with_scale,
                             Workers& w) {
  std::vector<int32_t> fragment;
  const Surface rest = bone_surface(head, true, &fragment);
  return measure_on(lay_upon(rest, other, words, with_scale, w), rest, bone_surface(head, false), std::move(fragment),
                    w);
}

namespace {

constexpr const char* kMirrorImage = "its unmoved mirror image";

SkullFit fit_to_mirror(const Surface& skull, Workers& w) {
  SkullFit f;
  f.with = kMirrorImage;
  std::string reason;
  const Surface other = mirror_image(skull, reason, w);
  if (reason.empty()) return lay_upon(skull, other, f.with, false, w);
  f.reason = "No mirror plane of the skull was found: " + reason;
  return f;
}

}  // namespace

Surface normal_skull(Workers& w) {
  const HeadModel normal = cached_head({}, w);
  Surface s;
  for (const simplex::Mesh* m : {&normal.cranium, &normal.mandible}) add_surface(s, *m, simplex::fan_triangles(*m));
  return compacted(s);
}

SkullFit lay_upon_normal(const Surface& skull, const std::vector<std::string>& files, Workers& w) {
  if (files.empty()) return lay_upon(skull, normal_skull(w), "a normal skull", false, w);
  SkullFit f;
  f.with = "the scene's normal skull";
  try {
    Surface other;
    for (const std::string& file : files) append(other, load_surface(file));
    f.reason = lacks_shape(other);
    if (f.reason.empty()) return lay_upon(skull, other, f.with, false, w, true);
    f.reason = files.front() + " " + f.reason;
  } catch (const InputError& e) {
    f.reason = e.what();
  }
  f.reason = "The skull could not be laid upon " + f.with + ": " + f.reason;
  return f;
}

namespace {

/// Pictures of skulls in colours, into DIR/head and the gallery; nothing where none can be made.
class SkullPictures {
 public:
  SkullPictures(Result& r, const std::string& dir, const Camera& camera) : result_(r), dir_(dir) {
    try {
      maker_ = std::make_unique<PictureMaker>(1080, 1080);
      maker_->set_camera(camera);
    } catch (const RenderUnavailable&) {
      // said once already, where the other pictures were to be made
    }
  }
  /// `label` stands in the picture, which is no wider than a third of the page; `caption` says what is laid on what.
  void draw(const std::string& file, const std::string& label, const std::string& caption, const Surface& skull,
            const DistanceMap& d, double most_mm) {
    if (!maker_) return;
    PictureOptions o;
    o.legend = "Distance", o.field_max = std::ceil(std::max(1.0, most_mm)), o.title = label;
    write_png(dir_ + "/head/" + file, maker_->moved(coloured_skull(skull, d, ++version_), o));
    append(result_, "/gallery", ResultPicture{"head/" + file, caption});
  }

 private:
  Result& result_;
  std::string dir_;
  std::unique_ptr<PictureMaker> maker_;
  uint64_t version_ = 0;
};

/// skull: beside another, at the end.
struct ResultSkull {
  MaybeText with;
  double fit_rms_mm, before_rms_mm, after_rms_mm, before_mean_mm, after_mean_mm;
};
void fields(ResultSkull& x, auto&& f) {
  f("with", x.with), f("fit_rms_mm", x.fit_rms_mm), f("before_rms_mm", x.before_rms_mm);
  f("after_rms_mm", x.after_rms_mm), f("before_mean_mm", x.before_mean_mm), f("after_mean_mm", x.after_mean_mm);
}

/// skull_moments: beside another, when it was asked for.
struct ResultSkullMoment {
  MaybeText name, with;
  double mean_mm, rms_mm, p95_mm;
};
void fields(ResultSkullMoment& x, auto&& f) {
  f("name", x.name), f("with", x.with), f("mean_mm", x.mean_mm), f("rms_mm", x.rms_mm), f("p95_mm", x.p95_mm);
}

/// The largest 95th percentile of any fragment: what stands out is on some fragment.
double largest_p95(const std::vector<double>& d, const std::vector<int32_t>& fragment) {
  double most = 0;
  for (const int32_t id : std::set<int32_t>(fragment.begin(), fragment.end()))
    most = std::max(most, spread(d, fragment, id).p95);
  return most;
}

std::string label_of(const std::string& with, bool after) {
  return (with == kMirrorImage ? "From its mirror image" : "From " + with) + (after ? ", after" : ", before");
}
/// The mirror image is always that of the skull before the operation.
std::string caption_of(const std::string& with, bool after) {
  if (with != kMirrorImage)
    return "Distance from " + with + (after ? ", after the operation" : ", before the operation");
  return after ? "After the operation: distance from the mirror image of the skull before it"
               : "Before the operation: distance from its own mirror image";
}

/// At the end, before the operation and after it.
void report_end(Result& r, const Head& head, const SkullFit (&fits)[2], const std::string& dir, SkullPictures* pictures,
                Workers& w) {
  ResultTable t;
  t.title = "The skull beside another";
  t.about =
      "Distance of the skull's surface from the one that it was laid upon, in mm, outside of it positive. It was laid "
      "upon it as it was before the operation, by the places that differ least. The mirror image, too, is that of the "
      "skull as it was before: what was moved since is compared with where the other side had been.";
  t.columns = {"laid upon",  "part",      "mean before",         "mean after",
               "rms before", "rms after", "95 % within, before", "after"};
  const char* const files[] = {"skull-normal", "skull-mirror"};
  std::vector<int32_t> fragment;
  const Surface rest = bone_surface(head, true, &fragment), now = bone_surface(head, false);
  for (const SkullFit& fit : fits) {
    const SkullComparison c = measure_on(fit, rest, now, fragment, w);
    if (!c) continue;
    const std::string file = files[&fit - fits];
    const auto row = [&](const std::string& part, int32_t id) {
      const Spread a = spread(c.before.signed_mm, c.fragment, id), b = spread(c.after.signed_mm, c.fragment, id);
      t.rows.push_back({c.with, part, short_number(a.mean, 3), short_number(b.mean, 3), short_number(a.rms, 3),
                        short_number(b.rms, 3), short_number(a.p95, 3), short_number(b.p95, 3)});
      if (id < 0) append(r, "/skull", ResultSkull{c.with, c.fit_rms_mm, a.rms, b.rms, a.mean, b.mean});
    };
    row("all", -1);
    for (const bone::Fragment& f : head.bones().fragments()) row(f.name, f.id);
    write_whole_file(dir + "/" + file + ".csv", map_csv(c));
    if (!pictures) continue;
    const double most =
        std::max(largest_p95(c.before.signed_mm, c.fragment), largest_p95(c.after.signed_mm, c.fragment));
    for (const bool after : {false, true})
      pictures->draw(file + (after ? "-after.png" : "-before.png"), label_of(c.with, after), caption_of(c.with, after),
                     {after ? c.now_mm : c.at_rest_mm, c.tri}, after ? c.after : c.before, most);
  }
  if (!t.rows.empty()) add_table(r, t);
}

/// When it was asked for.
void report_moments(Result& r, const Head& head, const SkullFit (&fits)[2], const std::string& dir,
                    SkullPictures* pictures, Workers& w) {
  ResultTable t;
  t.title = "The skull beside another, when it was asked for";
  t.about =
      "Distance of the skull's surface at that moment, in mm, outside positive; laid upon the other as in the table of "
      "the whole operation.";
  t.columns = {"moment", "laid upon", "part", "mean", "rms", "95 % within"};
  int n = 0;
  for (const SkullMoment& m : head.skull_moments()) {
    std::vector<int32_t> fragment = m.fragment;
    const Surface rest = surface_of(*m.rest, &fragment);
    simplex::Mesh placed = *m.rest;
    placed.x_mm = m.now_mm;
    const SkullComparison c =
        measure_on(fits[m.on == SkullBeside::mirror], rest, surface_of(placed, nullptr), std::move(fragment), w);
    if (!c) continue;
    const std::string file = "skull-moment-" + std::to_string(++n);
    const auto row = [&](const std::string& part, int32_t id) {
      const Spread a = spread(c.after.signed_mm, c.fragment, id);
      t.rows.push_back({m.name, c.with, part, short_number(a.mean, 3), short_number(a.rms, 3), short_number(a.p95, 3)});
      if (id < 0) append(r, "/skull_moments", ResultSkullMoment{m.name, c.with, a.mean, a.rms, a.p95});
    };
    row("all", -1);
    for (const auto& [id, name] : m.names) row(name, id);
    write_whole_file(dir + "/" + file + ".csv", map_csv(c));
    if (pictures)
      pictures->draw(file + ".png", m.name, m.name + ": distance from " + c.with, {c.now_mm, c.tri}, c.after,
                     largest_p95(c.after.signed_mm, c.fragment));
  }
  if (!t.rows.empty()) add_table(r, t);
}

}  // namespace

std::vector<std::string> report_skull(Result& r, const Head& head, const std::vector<std::string>& normal_files,
                                      const std::string& dir, const Snapshot& last, const Camera& camera, Workers& w) {
  // A skull worth laying upon another unasked has more than a few hundred places.
  constexpr int kLeastVertices = 2000;
  const bool whole = head.bones().mesh().vertices() >= kLeastVertices, moments = !head.skull_moments().empty();
  if (!whole && !moments) return {};
  bool wanted[2] = {whole, whole};
  for (const SkullMoment& m : head.skull_moments()) wanted[m.on == SkullBeside::mirror] = true;
  const Surface rest = bone_surface(head, true);
  SkullFit fits[2];
  if (wanted[0]) fits[0] = lay_upon_normal(rest, normal_files, w);
  if (wanted[1]) fits[1] = fit_to_mirror(rest, w);
  std::vector<std::string> problems;
  for (const SkullFit& f : fits)
    if (!f.reason.empty()) problems.push_back(f.reason);
  std::optional<SkullPictures> pictures;
  if (last.topology) pictures.emplace(r, dir, camera);
  if (whole) report_end(r, head, fits, dir, pictures ? &*pictures : nullptr, w);
  if (moments) report_moments(r, head, fits, dir, pictures ? &*pictures : nullptr, w);
  return problems;
}

}  // namespace limberg
