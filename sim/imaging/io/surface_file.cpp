#include "sim/imaging/io/surface_file.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/text_rows.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/io/mesh_file.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/file.h"

namespace limberg {
namespace {

constexpr ObjTextLimits kLimits{
    .vertices = SurfaceFileLimits::points, .triangles = SurfaceFileLimits::triangles, .texture = false};

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : s_(bytes), name_(name) {}

  Surface run() {
    if (s_.starts_with("limberg-simplex")) {
      const simplex::FanTriangles f = simplex::fan_triangles(simplex::parse_mesh(s_, name_));
      return {f.X_mm, f.tri};
    }
    const auto ends = [&](const char* e) { return std::string_view(name_).ends_with(e); };
    if (is_ply(s_))
      mesh(parse_ply(s_, name_, kLimits));
    else if (is_stl_name(name_))
      mesh(parse_stl(s_, name_, kLimits));
    else if (ends(".xyz") || ends(".XYZ"))
      xyz();
    else
      mesh(obj());
    if (out_.x_mm.empty()) fail(0, "holds no points");
    for (const Vec3& x : out_.x_mm)
      if (!(x.cwiseAbs().maxCoeff() <= SurfaceFileLimits::extent_mm))
        fail(0, "a point is not at a finite place within " + std::to_string(int(SurfaceFileLimits::extent_mm)) + " mm");
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const { throw InputError(name_, line, what); }

  void limits(int line) const {
    if (out_.x_mm.size() > SurfaceFileLimits::points || out_.tri.size() > SurfaceFileLimits::triangles)
      fail(line, "has more points or triangles than are read");
  }

  void xyz() {
    size_t at = 0;
    std::string_view l;
    for (int line = 1; next_line(s_, at, l); ++line) {
      std::string_view w, rest = l;
      if (!next_word(rest, w) || w.starts_with('#')) continue;
      out_.x_mm.push_back(point_of_row(l, name_, line));
      limits(line);
    }
  }

  void mesh(ObjText text) {
    out_.x_mm = std::move(text.v);
    out_.coloured = !text.rgb.empty() || (!is_ply(s_) && !is_stl_name(name_) && s_.find("\nvt ") != s_.npos);
    for (const ObjText::Face& f : text.face)
      for (size_t k = f.first + 1; k + 1 < f.first + f.corners; ++k)
        out_.tri.push_back({text.corner[f.first].v, text.corner[k].v, text.corner[k + 1].v});
  }
  ObjText obj() const {
    if (s_.find('\0') != std::string_view::npos) fail(0, "is no text; expected an OBJ, PLY, STL or xyz file");
    ObjText text = parse_obj_text(s_, name_, kLimits);
    if (text.v.empty()) fail(0, "is of no kind that is known here; expected an OBJ, PLY, STL, xyz or simplex file");
    return text;
  }

  std::string_view s_;
  const std::string& name_;
  Surface out_;
};

}  // namespace

void append(Surface& to, const Surface& s) {
  const auto first = int32_t(to.x_mm.size());
  to.x_mm.insert(to.x_mm.end(), s.x_mm.begin(), s.x_mm.end());
  for (const Tri& t : s.tri) to.tri.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Surface compacted(const Surface& s, std::vector<int32_t>* of_vertex) {
  std::vector<int32_t> number(s.x_mm.size(), -1), of;
  Surface out;
  for (const Tri& t : s.tri) {
    Tri k{};
    for (size_t c = 0; c < 3; ++c) {
      int32_t& n = number[size_t(t[c])];
      if (n < 0) {
        n = int32_t(out.x_mm.size()), out.x_mm.push_back(s.x_mm[size_t(t[c])]);
        if (of_vertex) of.push_back((*of_vertex)[size_t(t[c])]);
      }
      k[c] = n;
    }
    out.tri.push_back(k);
  }
  if (of_vertex) *of_vertex = std::move(of);
  return out;
}

Surface triangles_of(const simplex::Mesh& m) {
  const simplex::FanTriangles fan = simplex::fan_triangles(m);
  Surface s;
  s.x_mm = fan.X_mm;
  for (size_t t = 0; t < fan.tri.size(); ++t)
    if (!simplex::is_end(m.kind(fan.face[t]))) s.tri.push_back(fan.tri[t]);
  return s;
}

bool is_surface_name(std::string_view path) {
  for (const char* e : {".obj", ".ply", ".stl", ".xyz", ".simplex", ".OBJ", ".PLY", ".STL", ".XYZ"})
    if (path.ends_with(e)) return true;
  return false;
}

Surface parse_surface(std::string_view bytes, const std::string& name) { return Reader(bytes, name).run(); }

Surface load_surface(const std::string& path) {
  return parse_surface(read_whole_file(path, SurfaceFileLimits::file_bytes, "a surface or a scan"), path);
}

}  // namespace limberg
