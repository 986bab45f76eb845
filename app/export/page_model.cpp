#include "app/export/page_model.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "app/export/glb.h"
#include "app/export/page_mesh.h"
#include "app/pictures/skin_fields.h"
#include "app/program/version.h"
#include "app/report/report_names.h"
#include "render/overlay.h"
#include "render/picture.h"
#include "render/render_scene.h"
#include "render/stitches.h"
#include "render/textures.h"
#include "sim/base/whole_file.h"
#include "sim/commands/strokes.h"
#include "sim/commands/words.h"

namespace limberg {

namespace {

using PageJson = nlohmann::ordered_json;

constexpr size_t kMostModelBytes = 12'000'000;  // packed and in a page less than half of it
constexpr double kLayers_mm = 12;               // so deep the layers' colours are told
constexpr int kLayerColours = 64;
constexpr float kDepthStep_mm = 0.05f;  // of a vertex's depth, in a byte

/// Numbers in a text: a hundredth of what is seen.
double told(double v) { return std::round(v * 1000) / 1000; }
PageJson told(const Vec3f& v) { return {told(double(v.x())), told(double(v.y())), told(double(v.z()))}; }

std::string hex_of(std::span<const uint8_t> bytes) {
  static const char* const kDigit = "0123456789abcdef";
  std::string s;
  for (const uint8_t b : bytes) s += kDigit[b >> 4], s += kDigit[b & 15];
  return s;
}

int look_of(Part part) {
  switch (part) {
    case Part::skin:
      return kSkinLook;
    case Part::wall:
      return kWoundLook;
    case Part::face:
      return kFaceLook;
    case Part::bone:
      return kBoneLook;
    case Part::bone_cut:
      return kCutBoneLook;
    default:
      return kSideLook;
  }
}

using Place = std::array<int32_t, 3>;  // in steps from the lowest corner

/// One version of the surface, while it lasts.
struct PageShape {
  std::shared_ptr<const SurfaceTopology> topology;
  std::shared_ptr<const TissueMesh> mesh;
  std::vector<double> at;
  std::vector<std::vector<Place>> x;
  std::vector<std::vector<std::vector<uint8_t>>> fields;  // per frame, per field: of each vertex; empty: none
};

/// A field's look and scale; of the last frame that has it.
struct PageField {
  SkinField field = SkinField::none;
  FieldShown scale;  // without values
};

class PageBuffer {
 public:
  PageJson views = PageJson::array(), accessors = PageJson::array();
  std::string bytes;

  int accessor(const void* data, size_t count, size_t stride, int type, const char* kind, int target, bool unit = false,
               size_t row = 0) {
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", count * stride}});
    if (target) views.back()["target"] = target;
    if (target == kVertices) views.back()["byteStride"] = stride;
    if (row) views.back()["extras"] = {{"row", row}};  // so wide its numbers repeat: whoever packs it may want to know
    bytes.append(static_cast<const char*>(data), count * stride);
    while (bytes.size() % 4) bytes += '\0';
    accessors.push_back({{"bufferView", views.size() - 1}, {"componentType", type}, {"count", count}, {"type", kind}});
    if (unit) accessors.back()["normalized"] = true;
    return int(accessors.size()) - 1;
  }
  /// Three numbers of 16 bits, and two bytes that make it a multiple of four.
  template <class Number>
  int places(const std::vector<Place>& x, int type) {
    std::vector<std::array<Number, 4>> out(x.size());
    Place low = x.at(0), high = low;
    for (size_t v = 0; v < x.size(); ++v)
      for (size_t k = 0; k < 3; ++k)
        out[v][k] = Number(x[v][k]), low[k] = std::min(low[k], x[v][k]), high[k] = std::max(high[k], x[v][k]);
    const int a = accessor(out.data(), out.size(), 8, type, "VEC3", kVertices);
    accessors[size_t(a)]["min"] = low, accessors[size_t(a)]["max"] = high;
    return a;
  }
  int floats(const std::vector<float>& v, const char* kind, size_t components) {
    const int a = accessor(v.data(), v.size() / components, 4 * components, 5126, kind, 0);
    if (components == 1)
      accessors[size_t(a)]["min"] = {*std::min_element(v.begin(), v.end())},
      accessors[size_t(a)]["max"] = {*std::max_element(v.begin(), v.end())};
    return a;
  }
  /// A file as it is: its view; -1: it is empty.
  int file(const std::string& content) {
    if (content.empty()) return -1;
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", content.size()}});
    bytes += content;
    while (bytes.size() % 4) bytes += '\0';
    return int(views.size()) - 1;
  }
  int bytes_of(const std::vector<uint8_t>& v) { return accessor(v.data(), v.size(), 1, 5121, "SCALAR", 0, true); }
  int indices(std::span<const std::array<uint32_t, 3>> tri, size_t vertices) {
    if (vertices <= 65535) {
      std::vector<uint16_t> small;
      for (const auto& t : tri)
        for (const uint32_t v : t) small.push_back(uint16_t(v));
      return accessor(small.data(), small.size(), 2, 5123, "SCALAR", kIndices, false, 6);
    }
    return accessor(tri.data(), 3 * tri.size(), 4, 5125, "SCALAR", kIndices, false, 12);
  }

  static constexpr int kVertices = 34962, kIndices = 34963;
};

class PageWriter {
 public:
  PageBuffer buffer;
  PageJson meshes = PageJson::array(), nodes = PageJson::array(), samplers = PageJson::array(),
           channels = PageJson::array(), children = PageJson::array();

  void shape(const PageShape& s, double from, double until, double first, double last, bool moving) {
    const TissueMesh& m = *s.mesh;
    PageJson attributes{{"POSITION", buffer.places<uint16_t>(s.x[0], 5123)}};
    std::vector<std::array<int16_t, 2>> chart(m.chart_mm.size());
    for (size_t v = 0; v < chart.size(); ++v)
      for (int k = 0; k < 2; ++k)
        chart[v][size_t(k)] =
            int16_t(std::clamp(std::lround(double(m.chart_mm[v][k]) / kPageStep_mm), -32767l, 32767l));
    attributes["TEXCOORD_0"] = buffer.accessor(chart.data(), chart.size(), 4, 5122, "VEC2", PageBuffer::kVertices);
    std::vector<std::array<uint8_t, 4>> about(m.source.size());
    for (size_t v = 0; v < about.size(); ++v)
      about[v] = {uint8_t(std::clamp(std::lround(m.depth_mm[v] / kDepthStep_mm), 0l, 255l)),
                  uint8_t(std::clamp(std::lround(m.rim_mm[v] / kRimReach_mm * 255), 0l, 255l)), uint8_t(m.part[v]), 0};
    attributes["_DEPTH_RIM_PART"] = buffer.accessor(about.data(), about.size(), 4, 5121, "VEC4", PageBuffer::kVertices);
    // Not COLOR_0: other programs multiply a material's colour by that. A region's colour is sRGB and lies over the
    // material's, as much of it as its fourth number says.
    if (!m.rgba.empty())
      attributes["_COLOUR"] =
          buffer.accessor(m.rgba.data(), m.rgba.size(), 4, 5121, "VEC4", PageBuffer::kVertices, true);
    if (m.image && m.uv.size() == m.source.size()) {
      std::vector<std::array<uint16_t, 2>> at(m.uv.size());
      for (size_t v = 0; v < at.size(); ++v)
        for (size_t k = 0; const float x : from_above(m.uv[v].x(), m.uv[v].y()))
          at[v][k++] = uint16_t(std::lround(std::clamp(x, 0.0f, 1.0f) * 65535));
      attributes["TEXCOORD_1"] = buffer.accessor(at.data(), at.size(), 4, 5123, "VEC2", PageBuffer::kVertices, true);
    }
    PageJson targets = PageJson::array();
    for (size_t f = 1; f < s.x.size(); ++f) {
      std::vector<Place> way(s.x[f].size());
      for (size_t v = 0; v < way.size(); ++v)
        for (size_t k = 0; k < 3; ++k) way[v][k] = s.x[f][v][k] - s.x[0][v][k];
      targets.push_back({{"POSITION", buffer.places<int16_t>(way, 5122)}});
    }
    PageJson primitives = PageJson::array(), parts = PageJson::array();
    size_t at = 0;
    for (const Part part : kTissueParts) {
      const size_t n = m.triangles_of[size_t(part)];
      if (n == 0) continue;
      primitives.push_back({{"attributes", attributes},
                            {"indices", buffer.indices(std::span(m.tri).subspan(at, n), m.source.size())},
                            {"material", look_of(part)},
                            {"mode", 4}});
      if (!targets.empty()) primitives.back()["targets"] = targets;
      parts.push_back(kGltfLooks[size_t(look_of(part))].name);
      at += n;
    }
    PageJson fields = PageJson::array();
    for (const auto& frame : s.fields) {
      PageJson row = PageJson::array();
      for (const std::vector<uint8_t>& v : frame) row.push_back(v.empty() ? PageJson() : PageJson(buffer.bytes_of(v)));
      fields.push_back(row);
    }
    meshes.push_back(
        {{"primitives", primitives},
         {"extras", {{"at", s.at}, {"from", from}, {"until", until}, {"parts", parts}, {"fields", fields}}}});
    if (!targets.empty()) meshes.back()["weights"] = std::vector<float>(targets.size(), 0);
    const int node = int(nodes.size()) + 2;  // after the root and the node that has the steps
    nodes.push_back({{"mesh", meshes.size() - 1}});
    children.push_back(node);
    if (!moving) return;
    if (!targets.empty()) {
      std::vector<float> t, weights(s.x.size() * targets.size(), 0);
      for (size_t f = 0; f < s.x.size(); ++f) {
        t.push_back(float(s.at[f] - first));
        if (f > 0) weights[f * targets.size() + f - 1] = 1;
      }
      sample(node, "weights", t, weights, "SCALAR", 1, "LINEAR");
    }
    std::vector<float> t, size;  // a surface that is not there yet, or no more, has no size
    const auto step = [&](double when, float to) { t.push_back(float(when - first)), size.insert(size.end(), 3, to); };
    if (from > first) step(first, 0);
    step(from, 1);
    if (until < last) step(until, 0);
    if (t.size() > 1) sample(node, "scale", t, size, "VEC3", 3, "STEP");
  }

  /// What does not move, in a material of its own.
  void still(const Collider& c, const Vec3& low, double step_mm, int material) {
    std::vector<Place> x(c.mesh.X_mm.size());
    for (size_t v = 0; v < x.size(); ++v)
      for (int k = 0; k < 3; ++k) x[v][size_t(k)] = int32_t(std::lround((c.mesh.X_mm[v][k] - low[k]) / step_mm));
    std::vector<std::array<uint32_t, 3>> tri;
    for (const Tri& t : c.mesh.tri) tri.push_back({uint32_t(t[0]), uint32_t(t[1]), uint32_t(t[2])});
    PageJson attributes{{"POSITION", buffer.places<uint16_t>(x, 5123)}};
    if (const auto rgba = colours_of(c); !rgba.empty())
      attributes["COLOR_0"] = buffer.accessor(rgba.data(), rgba.size(), 4, 5121, "VEC4", PageBuffer::kVertices, true);
    meshes.push_back({{"name", c.name},
                      {"primitives", PageJson::array({{{"attributes", attributes},
                                                       {"indices", buffer.indices(tri, x.size())},
                                                       {"material", material},
                                                       {"mode", 4}}})},
                      {"extras", {{"still", true}}}});
    children.push_back(int(nodes.size()) + 2);
    nodes.push_back({{"name", c.name}, {"mesh", meshes.size() - 1}});
  }

 private:
  void sample(int node, const char* path, const std::vector<float>& t, const std::vector<float>& v, const char* kind,
              size_t components, const char* how) {
    samplers.push_back({{"input", buffer.floats(t, "SCALAR", 1)},
                        {"output", buffer.floats(v, kind, components)},
                        {"interpolation", how}});
    channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }
};

/// What is in the hand's reach at a frame, beside the surface.
PageJson things_of(const RenderScene& scene, const Snapshot& s, double at) {
  PageJson j{{"at", at}};
  for (const SutureState& u : s.sutures) {
    const StitchWay way = stitch_way(scene, s, u);
    if (way.path_mm.empty()) continue;
    PageJson path = PageJson::array();
    for (const Vec3f& p : way.path_mm) path.push_back(told(p));
    j["stitches"].push_back({{"id", u.id},
                             {"force_N", told(double(u.force_N))},
                             {"gap_mm", told(double(u.gap_mm))},
                             {"up", told(way.up)},
                             {"path", path}});
  }
  for (const HookState& h : s.hooks)
    if (h.at_mm.allFinite() && h.handle_mm.allFinite())
      j["hooks"].push_back({{"id", h.id},
                            {"up", told(nearest_skin(scene, h.at_mm).normal)},
                            {"at", told(h.at_mm)},
                            {"handle", told(h.handle_mm)},
                            {"force_N", told(double(h.force_N.norm()))}});
  for (const auto& [a, b] : s.plate_mm) j["plates"].push_back({told(a), told(b)});
  return j;
}

/// A byte for each vertex of the mesh: where the value lies on the scale.
std::vector<uint8_t> field_bytes(const FieldShown& shown, const FieldShown& scale, const TissueMesh& mesh) {
  if (shown.value.size() != mesh.vertices_of_view) return {};
  const double per = 255 / std::max(scale.hi - scale.lo, 1e-12);
  std::vector<uint8_t> out(mesh.source.size(), 0);
  for (size_t v = 0; v < out.size(); ++v) {
    const double x = double(shown.value[size_t(mesh.source[v])]);
    if ((mesh.part[v] == Part::skin || mesh.part[v] == Part::face) && std::isfinite(x))
      out[v] = uint8_t(std::lround(std::clamp((x - scale.lo) * per, 0.0, 255.0)));
  }
  return out;
}

/// What the tissue lies against; a head without skin has none.
std::vector<std::shared_ptr<const Collider>> colliders_of_page(const Snapshot& s) {
  return s.topology->body ? s.topology->body->colliders : std::vector<std::shared_ptr<const Collider>>();
}

double face_scale_end(const Snapshot& s) {
  SceneBuilder builder;
  return moved_scale_end(builder.build(s));
}

}  // namespace

void PageModel::frame(double at, const Snapshot& snapshot) {
  if (!has_surface(snapshot)) return;
  if (!frames_.empty() && !(at > frames_.back().at)) {
    frames_.back().shown = snapshot;
    return;
  }
  frames_.push_back({at, false, snapshot});
}

void PageModel::stage(double at, const std::string& name, const Snapshot& snapshot) {
  if (!has_surface(snapshot)) return;
  frame(at, snapshot);
  frames_.back().stage = true;
  marks_.push_back({at, name, true});
}

void PageModel::acted(const Command& command, const Snapshot& snapshot) {
  if (const auto* s = std::get_if<Stage>(&command)) return stage(at_, s->name, snapshot);
  if (!std::holds_alternative<Wait>(command)) done(at_ += 1, command);
  frame(at_, snapshot);
}

void PageModel::done(double at, const Command& command) {
  const auto* piece = std::get_if<InciseMore>(&command);
  if (piece) stroke_.push_back(command);
  if (piece && !piece->last) return;
  if (!stroke_.empty()) act(at, in_words(join_strokes(stroke_).front()));  // it has ended, or was stopped
  stroke_.clear();
  if (!piece) act(at, in_words(command));
}

void PageModel::thin() {
  std::vector<Frame> kept;
  bool keep = true;
  for (Frame& f : frames_)
    if (f.stage || &f == &frames_.front() || &f == &frames_.back() || (keep = !keep)) kept.push_back(std::move(f));
  frames_ = std::move(kept);
}

void PageModel::ended(const Snapshot& snapshot) {
  if (!frames_.empty() && has_surface(snapshot)) frames_.back().shown = snapshot;
}

std::string PageModel::bytes(const std::string& title, const Camera& camera, double aspect, size_t most_bytes) const {
  if (frames_.empty()) return {};
  // Where everything lies.
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  for (const Frame& f : frames_)
    for (const Vec3f& x : f.shown.x_mm) low = low.cwiseMin(x.cast<double>()), high = high.cwiseMax(x.cast<double>());
  const std::vector<std::shared_ptr<const Collider>> colliders = colliders_of_page(frames_.back().shown);
  for (const auto& c : colliders)
    for (const Vec3& x : c->mesh.X_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double step_mm = std::max(kPageStep_mm, (high - low).maxCoeff() / 32767);

  // The fields, on the scale of the last frame.
  const Snapshot& last_shown = frames_.back().shown;
  SkinFields maker;
  std::vector<PageField> fields;
  for (int i = 1; i < kSkinFields; ++i) {
    const FieldShown& shown = maker.show(SkinField(i), last_shown);
    if (shown.value.empty()) continue;
    fields.push_back({SkinField(i), shown});
    fields.back().scale.value.clear();
    if (last_shown.topology->body || SkinField(i) != SkinField::moved) continue;
    FieldShown& scale = fields.back().scale;  // of a face: as its picture has it
    scale.hi = face_scale_end(last_shown), scale.intervals = int(std::lround(scale.hi / round_step(scale.hi, 6)));
  }

  Vec3f operated_low = low.cast<float>(), operated_high = high.cast<float>();
  operated_box(frames_.back().shown, operated_low, operated_high);
  const auto mesh_of = [&](const SurfaceTopology& t) {
    TissueMesh mesh = make_tissue_mesh(t, camera.eye_mm - camera.target_mm);
    return std::make_shared<TissueMesh>(t.body ? coarser_away(mesh, operated_low, operated_high) : std::move(mesh));
  };
  std::vector<PageShape> shapes;
  PageJson things = PageJson::array();
  RenderScene scene;
  for (const Frame& f : frames_) {
    const Snapshot& s = f.shown;
    if (shapes.empty() || shapes.back().topology != s.topology) {
      shapes.push_back({s.topology, mesh_of(*s.topology), {}, {}, {}});
      scene.mesh = shapes.back().mesh;
    }
    PageShape& shape = shapes.back();
    const TissueMesh& mesh = *shape.mesh;
    scene.x_mm.resize(mesh.source.size());
    for (size_t v = 0; v < mesh.source.size(); ++v) scene.x_mm[v] = s.x_mm[size_t(mesh.source[v])];
    vertex_normals(mesh.tri, scene.x_mm, scene.normal);
    shape.at.push_back(f.at);
    std::vector<Place>& x = shape.x.emplace_back(mesh.source.size());
    for (size_t v = 0; v < x.size(); ++v)
      for (int k = 0; k < 3; ++k) x[v][size_t(k)] = int32_t(std::lround((double(scene.x_mm[v][k]) - low[k]) / step_mm));
    auto& of_frame = shape.fields.emplace_back();
    for (const PageField& field : fields)
      of_frame.push_back(field_bytes(maker.show(field.field, s), field.scale, mesh));
    things.push_back(things_of(scene, s, f.at));
  }

  PageWriter w;
  const double first = frames_.front().at, last = frames_.back().at;
  for (size_t i = 0; i < shapes.size(); ++i) {
    const auto between = [&](size_t a, size_t b) { return 0.5 * (shapes[a].at.back() + shapes[b].at.front()); };
    w.shape(shapes[i], i == 0 ? first : between(i - 1, i), i + 1 == shapes.size() ? last : between(i, i + 1), first,
            last, frames_.size() > 1);
  }

  PageJson materials = PageJson::array();
  for (const GltfLook& l : kGltfLooks) materials.push_back(gltf_material<PageJson>(l));
  for (const auto& c : colliders) {
    w.still(*c, low, step_mm, int(materials.size()));
    materials.push_back(gltf_material<PageJson>(look_of(*c)));
  }

  int picture = -1;  // the view that it lies in
  if (const auto& image = last_shown.topology->image) picture = w.buffer.file(png_of(*image));

  PageJson told_fields = PageJson::array();
  for (const PageField& f : fields) {
    const SkinFieldLook& look = look_of(f.field);
    told_fields.push_back({{"name", look.name},
                           {"title", look.title},
                           {"unit", look.unit},
                           {"scale", look.scale == ColourScale::signed_value ? "signed" : "magnitude"},
                           {"lo", f.scale.lo},
                           {"hi", f.scale.hi},
                           {"intervals", f.scale.intervals},
                           {"above", f.scale.above},
                           {"below", f.scale.below}});
  }
  PageJson acts = PageJson::array();
  for (const Mark& m : marks_) acts.push_back({{"at", m.at}, {"words", m.words}, {"stage", m.stage}});
  PageJson extras{{"limberg_page_model", 1},
                  {"unit", unit_},
                  {"from", first},
                  {"until", last},
                  {"step_mm", step_mm},
                  {"low_mm", {low.x(), low.y(), low.z()}},
                  {"eye_mm", told(camera.eye_mm)},
                  {"target_mm", told(camera.target_mm)},
                  {"up", told(camera.up)},
                  {"lamp", told(shapes.back().mesh->lamp)},
                  {"fov_deg", told(double(camera.fov_deg))},
                  {"aspect", told(aspect)},
                  {"acts", acts},
                  {"fields", told_fields},
                  {"frames", things}};
  if (const auto& body = frames_.back().shown.topology->body) {
    std::vector<uint8_t> rgb;
    const Texels layers = layer_texture(body->layers, kLayers_mm, kLayerColours);
    for (size_t i = 0; i < size_t(kLayerColours); ++i)
      rgb.insert(rgb.end(), layers.rgba.begin() + std::ptrdiff_t(4 * i),
                 layers.rgba.begin() + std::ptrdiff_t(4 * i + 3));
    extras["layers"] = {{"range_mm", kLayers_mm}, {"srgb", hex_of(rgb)}};
  }

  // mm to m, z up to y up: a turn by -90 degrees about x; below it steps to mm.
  PageJson steps{{"scale", {step_mm, step_mm, step_mm}}, {"translation", {low.x(), low.y(), low.z()}}};
  steps["children"] = w.children;
  PageJson nodes = PageJson::array({{{"name", title},
                                     {"rotation", {-0.70710678, 0, 0, 0.70710678}},
                                     {"scale", {.001, .001, .001}},
                                     {"children", {1}}},
                                    steps});
  for (const PageJson& n : w.nodes) nodes.push_back(n);
  PageJson j{{"asset", {{"version", "2.0"}, {"generator", program_name()}, {"extras", extras}}},
             {"extensionsUsed", {"KHR_mesh_quantization"}},
             {"extensionsRequired", {"KHR_mesh_quantization"}},
             {"scene", 0},
             {"scenes", PageJson::array({{{"nodes", {0}}}})},
             {"nodes", nodes},
             {"meshes", w.meshes},
             {"materials", materials},
             {"accessors", w.buffer.accessors},
             {"bufferViews", w.buffer.views},
             {"buffers", PageJson::array({{{"byteLength", w.buffer.bytes.size()}}})}};
  if (picture >= 0) put_on(j, last_shown.topology->image_on == Organ::face ? kFaceLook : kSkinLook, picture, 1);
  if (!w.channels.empty())
    j["animations"] = PageJson::array({{{"name", "operation"}, {"channels", w.channels}, {"samplers", w.samplers}}});
  std::string out = glb_bytes(j.dump(-1, ' ', false, PageJson::error_handler_t::replace), w.buffer.bytes);
  if (most_bytes > 0 && out.size() > most_bytes) {
    PageModel fewer = *this;
    fewer.thin();
    if (fewer.frames_.size() < frames_.size()) return fewer.bytes(title, camera, aspect, most_bytes);
  }
  return out;
}

void PageModel::leave(const std::string& dir, const std::string& title, const Camera& camera, double aspect) const {
  if (!empty()) write_whole_file(dir + "/" + report_names::model, bytes(title, camera, aspect, kMostModelBytes));
}

}  // namespace limberg
