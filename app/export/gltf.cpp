#include "app/export/gltf.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "app/export/glb.h"
#include "app/program/version.h"

namespace limberg {

namespace {

using GltfJson = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "glTF is little endian");

/// The binary chunk and the JSON's lists that point into it.
class GltfBuffer {
 public:
  GltfJson views = GltfJson::array(), accessors = GltfJson::array();
  std::string bytes;

  int positions(const std::vector<Vec3f>& x) {
    const int a = floats(x.empty() ? nullptr : x[0].data(), x.size(), 3, "VEC3", 34962);
    Vec3f low = x.at(0), high = x.at(0);
    for (const Vec3f& v : x) low = low.cwiseMin(v), high = high.cwiseMax(v);
    accessors[size_t(a)]["min"] = {low.x(), low.y(), low.z()};
    accessors[size_t(a)]["max"] = {high.x(), high.y(), high.z()};
    return a;
  }
  int times(const std::vector<float>& t) {
    const int a = floats(t.data(), t.size(), 1, "SCALAR", 0);
    accessors[size_t(a)]["min"] = {t.front()}, accessors[size_t(a)]["max"] = {t.back()};
    return a;
  }
  int numbers(const std::vector<float>& v, int components, const char* type) {
    return floats(v.data(), v.size() / size_t(components), components, type, 0);
  }
  int colours(const std::vector<std::array<uint8_t, 4>>& rgba) {
    const int v = view(rgba.data(), rgba.size() * 4, 34962);
    accessors.push_back(
        {{"bufferView", v}, {"componentType", 5121}, {"normalized", true}, {"count", rgba.size()}, {"type", "VEC4"}});
    return int(accessors.size()) - 1;
  }
  int places_in_picture(const std::vector<Eigen::Vector2f>& uv) {
    return floats(uv[0].data(), uv.size(), 2, "VEC2", 34962);
  }
  /// A file as it is: its view; -1: it is empty.
  int file(const std::string& content) { return content.empty() ? -1 : view(content.data(), content.size(), 0); }
  int indices(const std::vector<uint32_t>& index) {
    const int v = view(index.data(), index.size() * 4, 34963);
    accessors.push_back({{"bufferView", v}, {"componentType", 5125}, {"count", index.size()}, {"type", "SCALAR"}});
    return int(accessors.size()) - 1;
  }

 private:
  int view(const void* data, size_t n, int target) {
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", n}});
    if (target) views.back()["target"] = target;
    bytes.append(static_cast<const char*>(data), n);
    while (bytes.size() % 4) bytes += '\0';
    return int(views.size()) - 1;
  }
  int floats(const float* data, size_t count, int components, const char* type, int target) {
    const int v = view(data, count * size_t(components) * 4, target);
    accessors.push_back({{"bufferView", v}, {"componentType", 5126}, {"count", count}, {"type", type}});
    return int(accessors.size()) - 1;
  }
};

int gltf_look(const SurfaceTopology& t, size_t triangle) {
  switch (t.organ_of(triangle)) {
    case Organ::face:
      return kFaceLook;
    case Organ::bone:
      return kBoneLook;
    case Organ::bone_cut:
      return kCutBoneLook;
    case Organ::flesh:
      break;
  }
  switch (t.view.kind[triangle]) {
    case FaceKind::skin:
      return kSkinLook;
    case FaceKind::wall:
      return kWoundLook;
    default:
      return kSideLook;
  }
}

}  // namespace

void GltfStory::frame(int series, double t_s, const std::string& key, std::vector<Vec3f> x_mm,
                      const std::function<std::vector<Part>()>& parts, const char* name, bool lines) {
  int& now = last_[series];
  if (now >= 0 &&
      (x_mm.empty() || shapes_[size_t(now)].key != key || shapes_[size_t(now)].x_mm[0].size() != x_mm.size()))
    shapes_[size_t(now)].until_s = t_s, now = -1;
  if (x_mm.empty()) return;
  if (now < 0) {
    now = int(shapes_.size());
    shapes_.push_back({key, name, lines, parts(), {}, {}, {}});
  }
  Shape& s = shapes_[size_t(now)];
  if (!s.t_s.empty() && !(t_s > s.t_s.back())) {  // one moment, seen twice: as it was seen last
    s.x_mm.back() = std::move(x_mm);
    return;
  }
  s.t_s.push_back(t_s), s.x_mm.push_back(std::move(x_mm));
}

GltfStory::Pictured GltfStory::pictured(const SurfaceTopology& topology, const std::string& key) {
  const SurfaceView& view = topology.view;
  const int wears = topology.image_on == Organ::face ? kFaceLook : kSkinLook;
  Pictured p;
  p.key = key;
  const size_t n = view.X_mm.size();
  p.uv.assign(n, Eigen::Vector2f::Zero());
  std::vector<bool> has(n, false);
  std::multimap<uint32_t, uint32_t> again;  // of a vertex of the view: where it comes again
  for (size_t t = 0; t < view.tri.size(); ++t) {
    auto& out = p.tri.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = uint32_t(view.tri[t][int(k)]);
      out[k] = v;
      if (gltf_look(topology, t) != wears) continue;
      const auto [u, from_top] = from_above(view.uv[t][k].x(), view.uv[t][k].y());
      const Eigen::Vector2f at(u, from_top);
      if (!has[v]) p.uv[v] = at, has[v] = true;
      if (p.uv[v] == at) continue;
      const auto [first, last] = again.equal_range(v);
      const auto found = std::find_if(first, last, [&](const auto& a) { return p.uv[a.second] == at; });
      out[k] = found != last ? found->second : uint32_t(p.uv.size());
      if (found != last) continue;
      again.emplace(v, out[k]), p.more.push_back(v), p.uv.push_back(at);
    }
  }
  return p;
}

void GltfStory::add(double t_s, const std::string& name, const Snapshot& snapshot) {
  if (!has_surface(snapshot)) return;
  if (frames_++ == 0) first_s_ = t_s;
  last_s_ = std::max(last_s_, t_s);
  if (!name.empty()) moments_.push_back({t_s, name});
  const SurfaceTopology& topology = *snapshot.topology;
  if (topology.body) colliders_ = topology.body->colliders;
  const SurfaceView& view = topology.view;
  const std::string version = std::to_string(topology.version) + "/" + std::to_string(topology.hash);
  std::vector<Vec3f> x_mm = snapshot.x_mm;
  if (topology.image && view.uv.size() == view.tri.size()) {
    image_ = topology.image, on_face_ = topology.image_on == Organ::face;
    if (pictured_.key != version) pictured_ = pictured(topology, version);
    for (const uint32_t v : pictured_.more) x_mm.push_back(snapshot.x_mm[v]);
  }
  const bool on_it = pictured_.key == version;
  const auto surface_parts = [&] {
    static const char* const kNames[] = {"skin", "wound", "side", "face", "bone", "cut bone"};
    std::map<int, Part> by_look;
    for (size_t t = 0; t < view.tri.size(); ++t) {
      const int look = gltf_look(topology, t);
      Part& p = by_look.try_emplace(look, Part{kNames[look], look, {}}).first->second;
      for (size_t k = 0; k < 3; ++k) p.index.push_back(on_it ? pictured_.tri[t][k] : uint32_t(view.tri[t][k]));
    }
    std::vector<Part> out;
    for (auto& [look, p] : by_look) out.push_back(std::move(p));
    return out;
  };
  frame(0, t_s, version, std::move(x_mm), surface_parts, "surface", false);
  if (on_it) shapes_[size_t(last_[0])].uv = pictured_.uv;

  // Lines: their two ends, and numbers that say which they are.
  const auto lines = [&](int series, const char* what, int look,
                         const std::vector<std::pair<int, std::array<Vec3f, 2>>>& of) {
    std::string key;
    std::vector<Vec3f> ends;
    for (const auto& [id, e] : of) key += std::to_string(id) + " ", ends.insert(ends.end(), {e[0], e[1]});
    const auto part = [&] {
      Part p{what, look, {}};
      for (uint32_t i = 0; i < ends.size(); ++i) p.index.push_back(i);
      return std::vector<Part>{p};
    };
    frame(series, t_s, key, ends, part, what, true);
  };
  std::vector<std::pair<int, std::array<Vec3f, 2>>> stitches, hooks;
  for (const SutureState& s : snapshot.sutures) stitches.push_back({s.id, {s.a_mm, s.b_mm}});
  for (const HookState& h : snapshot.hooks) hooks.push_back({h.id, {h.at_mm, h.handle_mm}});
  lines(1, "stitches", kThreadLook, stitches);
  lines(2, "hooks", kHookLook, hooks);
}

std::string GltfStory::bytes(const std::string& title) const {
  GltfBuffer buffer;
  GltfJson nodes = GltfJson::array(), meshes = GltfJson::array(), channels = GltfJson::array(),
           samplers = GltfJson::array(), children = GltfJson::array();
  const auto sample = [&](int node, const char* path, int input, int output, const char* how) {
    samplers.push_back({{"input", input}, {"output", output}, {"interpolation", how}});
    channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  };
  for (const Shape& s : shapes_) {
    if (s.until_s >= 0 && s.until_s <= s.t_s[0]) continue;  // gone in the moment in which it came
    const int position = buffer.positions(s.x_mm[0]);
    GltfJson targets = GltfJson::array();
    for (size_t f = 1; f < s.x_mm.size(); ++f) {
      std::vector<Vec3f> way(s.x_mm[f].size());
      for (size_t v = 0; v < way.size(); ++v) way[v] = s.x_mm[f][v] - s.x_mm[0][v];
      targets.push_back({{"POSITION", buffer.positions(way)}});
    }
    GltfJson primitives = GltfJson::array();
    GltfJson attributes{{"POSITION", position}};
    if (!s.uv.empty()) attributes["TEXCOORD_0"] = buffer.places_in_picture(s.uv);
    for (const Part& p : s.parts) {
      primitives.push_back({{"attributes", attributes},
                            {"indices", buffer.indices(p.index)},
                            {"material", p.material},
                            {"mode", s.lines ? 1 : 4}});
      if (!targets.empty()) primitives.back()["targets"] = targets;
    }
    meshes.push_back({{"name", s.name}, {"primitives", primitives}});
    if (!targets.empty()) meshes.back()["weights"] = std::vector<float>(targets.size(), 0);
    const int node = int(nodes.size()) + 1;  // after the root
    nodes.push_back({{"name", s.name + " " + std::to_string(node)}, {"mesh", meshes.size() - 1}});
    children.push_back(node);
    if (frames_ < 2) continue;
    if (!targets.empty()) {
      std::vector<float> t, weights(s.x_mm.size() * targets.size(), 0);
      for (size_t f = 0; f < s.t_s.size(); ++f) {
        t.push_back(float(s.t_s[f] - first_s_));
        if (f > 0) weights[f * targets.size() + f - 1] = 1;
      }
      sample(node, "weights", buffer.times(t), buffer.numbers(weights, 1, "SCALAR"), "LINEAR");
    }
    // A shape that is not there yet, or no more, has no size.
    std::vector<float> t, size;
    const auto step = [&](double at_s, float to) { t.push_back(float(at_s)), size.insert(size.end(), {to, to, to}); };
    const double from_s = s.t_s[0] - first_s_;
    if (from_s > 0) step(0, 0);
    step(from_s, 1);
    if (s.until_s >= 0) step(s.until_s - first_s_, 0);
    if (t.size() > 1) sample(node, "scale", buffer.times(t), buffer.numbers(size, 3, "VEC3"), "STEP");
  }
  GltfJson materials = GltfJson::array();
  for (const GltfLook& l : kGltfLooks) materials.push_back(gltf_material<GltfJson>(l));
  for (const auto& c : colliders_) {
    std::vector<Vec3f> x;
    for (const Vec3& v : c->mesh.X_mm) x.push_back(v.cast<float>());
    std::vector<uint32_t> index;
    for (const Tri& t : c->mesh.tri)
      for (const int32_t v : t) index.push_back(uint32_t(v));
    GltfJson attributes{{"POSITION", buffer.positions(x)}};
    if (const auto rgba = colours_of(*c); !rgba.empty()) attributes["COLOR_0"] = buffer.colours(rgba);
    GltfJson primitive{
        {"attributes", attributes}, {"indices", buffer.indices(index)}, {"material", materials.size()}, {"mode", 4}};
    meshes.push_back({{"name", c->name}, {"primitives", GltfJson::array({primitive})}});
    children.push_back(int(nodes.size()) + 1);
    nodes.push_back({{"name", c->name}, {"mesh", meshes.size() - 1}});
    materials.push_back(gltf_material<GltfJson>(look_of(*c)));
  }
  const int picture = image_ ? buffer.file(png_of(*image_)) : -1;
  // mm to m, z up to y up: a turn by -90 degrees about x.
  GltfJson root{{"name", title}, {"rotation", {-0.70710678, 0, 0, 0.70710678}}, {"scale", {.001, .001, .001}}};
  root["children"] = children;
  nodes.insert(nodes.begin(), root);
  GltfJson told = GltfJson::array();
  for (const auto& [t_s, name] : moments_) told.push_back({{"name", name}, {"t_s", t_s}, {"at_s", t_s - first_s_}});
  GltfJson j{{"asset", {{"version", "2.0"}, {"generator", program_name()}, {"extras", {{"moments", told}}}}},
             {"scene", 0},
             {"scenes", GltfJson::array({{{"nodes", {0}}}})},
             {"nodes", nodes},
             {"meshes", meshes},
             {"materials", materials},
             {"accessors", buffer.accessors},
             {"bufferViews", buffer.views},
             {"buffers", GltfJson::array({{{"byteLength", buffer.bytes.size()}}})}};
  if (picture >= 0) put_on(j, on_face_ ? kFaceLook : kSkinLook, picture, 0);
  if (!channels.empty())
    j["animations"] = GltfJson::array({{{"name", "operation"}, {"channels", channels}, {"samplers", samplers}}});
  return glb_bytes(j.dump(-1, ' ', false, GltfJson::error_handler_t::replace), buffer.bytes);
}

}  // namespace limberg
