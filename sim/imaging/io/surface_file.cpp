#include "sim/imaging/io/surface_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/io/obj_text.h"
#include "sim/imaging/io/header.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/file.h"

namespace limberg {
namespace {

using imaging::next_line;

/// Words of a line.
bool word(std::string_view& s, std::string_view& w) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t' || s.front() == ',' || s.front() == ';'))
    s.remove_prefix(1);
  size_t n = 0;
  while (n < s.size() && s[n] != ' ' && s[n] != '\t' && s[n] != ',' && s[n] != ';') ++n;
  w = s.substr(0, n), s.remove_prefix(n);
  return n > 0;
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : s_(bytes), name_(name) {}

  Surface run() {
    if (s_.starts_with("limberg-simplex")) {
      const simplex::FanTriangles f = simplex::fan_triangles(simplex::parse_mesh(s_, name_));
      return {f.X_mm, f.tri};
    }
    const auto ends = [&](const char* e) { return std::string_view(name_).ends_with(e); };
    if (s_.starts_with("ply\n") || s_.starts_with("ply\r\n"))
      ply();
    else if (ends(".stl") || ends(".STL"))
      stl();
    else if (ends(".xyz") || ends(".XYZ"))
      xyz();
    else
      obj();
    if (out_.x_mm.empty()) fail(0, "holds no points");
    for (const Vec3& x : out_.x_mm)
      if (!(x.cwiseAbs().maxCoeff() <= SurfaceFileLimits::extent_mm))
        fail(0, "a point is not at a finite place within " + std::to_string(int(SurfaceFileLimits::extent_mm)) + " mm");
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const { throw InputError(name_, line, what); }

  double number(std::string_view w, int line) const {
    if (w.starts_with('+')) w.remove_prefix(1);
    double v = 0;
    const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), v);
    if (w.empty() || ec != std::errc() || end != w.data() + w.size() || !std::isfinite(v))
      fail(line, quoted(w) + " is no finite number");
    return v;
  }
  Vec3 point(std::string_view rest, int line) const {
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      std::string_view w;
      if (!word(rest, w)) fail(line, "a point has fewer than three numbers");
      x[k] = number(w, line);
    }
    return x;
  }
  void polygon(const std::vector<int64_t>& corner, int line) {
    if (corner.size() < 3) fail(line, "a face has fewer than three corners");
    for (const int64_t c : corner)
      if (c < 0 || c >= int64_t(out_.x_mm.size()))
        fail(line, "a face names point " + std::to_string(c) + "; there are " + std::to_string(out_.x_mm.size()));
    for (size_t i = 1; i + 1 < corner.size(); ++i)
      out_.tri.push_back({int32_t(corner[0]), int32_t(corner[i]), int32_t(corner[i + 1])});
  }
  void limits(int line) const {
    if (out_.x_mm.size() > SurfaceFileLimits::points || out_.tri.size() > SurfaceFileLimits::triangles)
      fail(line, "has more points or triangles than are read");
  }

  void xyz() {
    size_t at = 0;
    std::string_view l;
    for (int line = 1; next_line(s_, at, l); ++line) {
      std::string_view w, rest = l;
      if (!word(rest, w) || w.starts_with('#')) continue;
      out_.x_mm.push_back(point(l, line));
      limits(line);
    }
  }

  void obj() {
    if (s_.find('\0') != std::string_view::npos) fail(0, "is no text; expected an OBJ, PLY, STL or xyz file");
    ObjText text = parse_obj_text(
        s_, name_,
        {.vertices = SurfaceFileLimits::points, .triangles = SurfaceFileLimits::triangles, .texture = false});
    if (text.v.empty()) fail(0, "is of no kind that is known here; expected an OBJ, PLY, STL, xyz or simplex file");
    out_.x_mm = std::move(text.v);
    for (const ObjText::Face& f : text.face)
      for (size_t k = f.first + 1; k + 1 < f.first + f.corners; ++k)
        out_.tri.push_back({text.corner[f.first].v, text.corner[k].v, text.corner[k + 1].v});
  }

  void stl() {
    std::vector<Vec3> corner;
    if (s_.size() >= 84) {
      uint32_t n = 0;
      std::memcpy(&n, s_.data() + 80, 4);
      if (84 + size_t(n) * 50 == s_.size() || !s_.starts_with("solid")) {
        if (84 + size_t(n) * 50 > s_.size())
          fail(0, "is cut short: " + std::to_string(n) + " triangles are said, " +
                      std::to_string((s_.size() - 84) / 50) + " are there");
        for (size_t t = 0; t < n; ++t)
          for (size_t c = 0; c < 3; ++c) {
            float x[3];
            std::memcpy(x, s_.data() + 84 + 50 * t + 12 + 12 * c, 12);
            corner.emplace_back(x[0], x[1], x[2]);
          }
        return weld(corner);
      }
    }
    size_t at = 0;
    std::string_view l, w;
    for (int line = 1; next_line(s_, at, l); ++line) {
      std::string_view rest = l;
      if (word(rest, w) && w == "vertex") corner.push_back(point(rest, line));
      if (corner.size() > 3 * SurfaceFileLimits::triangles) fail(line, "has more triangles than are read");
    }
    if (corner.size() % 3 != 0) fail(0, "its last triangle is cut short");
    weld(corner);
  }
  void weld(const std::vector<Vec3>& corner) {
    std::vector<int32_t> order(corner.size()), number(corner.size());
    for (const Vec3& x : corner)
      if (!x.allFinite()) fail(0, "a corner is not at a finite place");
    for (size_t i = 0; i < order.size(); ++i) order[i] = int32_t(i);
    const auto less = [&](int32_t a, int32_t b) {
      for (int k = 0; k < 3; ++k)
        if (corner[size_t(a)][k] != corner[size_t(b)][k]) return corner[size_t(a)][k] < corner[size_t(b)][k];
      return a < b;
    };
    std::sort(order.begin(), order.end(), less);
    std::vector<int32_t> first(corner.size());
    for (size_t i = 0; i < order.size(); ++i)
      first[size_t(order[i])] =
          i > 0 && corner[size_t(order[i])] == corner[size_t(order[i - 1])] ? first[size_t(order[i - 1])] : order[i];
    for (size_t i = 0; i < corner.size(); ++i)
      if (first[i] == int32_t(i)) number[i] = int32_t(out_.x_mm.size()), out_.x_mm.push_back(corner[i]);
    for (size_t t = 0; t + 2 < corner.size(); t += 3) {
      const Tri tri{number[size_t(first[t])], number[size_t(first[t + 1])], number[size_t(first[t + 2])]};
      if (tri[0] != tri[1] && tri[1] != tri[2] && tri[2] != tri[0]) out_.tri.push_back(tri);
    }
  }

  struct Property {
    std::string name;
    int bytes = 4;
    char kind = 'f';  // f float, i signed, u unsigned
    bool list = false;
    int count_bytes = 1;
    char count_kind = 'u';
  };
  struct Kind {
    std::string name;
    size_t count = 0;
    std::vector<Property> property;
  };

  bool type(std::string_view w, int& bytes, char& kind) const {
    struct T {
      const char *a, *b;
      int n;
      char k;
    };
    for (const T& t : {T{"char", "int8", 1, 'i'},
                       {"uchar", "uint8", 1, 'u'},
                       {"short", "int16", 2, 'i'},
                       {"ushort", "uint16", 2, 'u'},
                       {"int", "int32", 4, 'i'},
                       {"uint", "uint32", 4, 'u'},
                       {"float", "float32", 4, 'f'},
                       {"double", "float64", 8, 'f'}})
      if (w == t.a || w == t.b) return bytes = t.n, kind = t.k, true;
    return false;
  }

  double binary(size_t& at, int bytes, char kind, bool big) const {
    if (at + size_t(bytes) > s_.size()) fail(0, "the data are cut short: " + std::to_string(s_.size()) + " bytes");
    char b[8];
    std::memcpy(b, s_.data() + at, size_t(bytes));
    at += size_t(bytes);
    if (big != (std::endian::native == std::endian::big)) std::reverse(b, b + bytes);
    const auto as = [&]<class T>(T v) {
      std::memcpy(&v, b, sizeof(T));
      return double(v);
    };
    switch (kind) {
      case 'f':
        return bytes == 4 ? as(float{}) : as(double{});
      case 'u':
        return bytes == 1 ? as(uint8_t{}) : bytes == 2 ? as(uint16_t{}) : as(uint32_t{});
      default:
        return bytes == 1 ? as(int8_t{}) : bytes == 2 ? as(int16_t{}) : as(int32_t{});
    }
  }

  void ply() {
    size_t at = 0;
    std::string_view l, w;
    std::vector<Kind> kinds;
    int line = 0, format = -1;  // 0 ascii, 1 little endian, 2 big endian
    bool ended = false;
    while (!ended && next_line(s_, at, l)) {
      ++line;
      std::string_view rest = l;
      if (!word(rest, w) || w == "comment" || w == "obj_info" || w == "ply") continue;
      if (w == "end_header") {
        ended = true;
      } else if (w == "format") {
        word(rest, w);
        format = w == "ascii" ? 0 : w == "binary_little_endian" ? 1 : w == "binary_big_endian" ? 2 : -1;
        if (format < 0)
          fail(line, "the format is not known; expected ascii, binary_little_endian or binary_big_endian");
      } else if (w == "element") {
        Kind k;
        word(rest, w), k.name = w, word(rest, w);
        const double n = number(w, line);
        if (!(n >= 0 && n == std::floor(n))) fail(line, "the number of elements is no whole number");
        // An element has at least a byte.
        if (n > double(s_.size()))
          fail(line, "says " + std::string(w.substr(0, 30)) + " elements, more than the file has bytes");
        k.count = size_t(n);
        if (kinds.size() >= 32) fail(line, "has more than 32 kinds of elements");
        kinds.push_back(std::move(k));
      } else if (w == "property") {
        if (kinds.empty()) fail(line, "a property stands before every element");
        Property p;
        word(rest, w);
        if (w == "list") {
          p.list = true;
          word(rest, w);
          if (!type(w, p.count_bytes, p.count_kind) || p.count_kind == 'f')
            fail(line, "the count of a list has no whole type");
          word(rest, w);
        }
        if (!type(w, p.bytes, p.kind)) fail(line, "the type " + quoted(w) + " is not known");
        word(rest, w), p.name = w;
        if (kinds.back().property.size() >= 256) fail(line, "has more than 256 properties");
        kinds.back().property.push_back(std::move(p));
      } else {
        fail(line, quoted(w) + " is not known in the header of a PLY");
      }
    }
    if (!ended || format < 0) fail(0, "the PLY header does not end, or has no format");
    for (const Kind& k : kinds) {
      if (k.property.empty() && k.count > 0) fail(0, "an element has no properties");
      for (size_t i = 0; i < k.count; ++i) {
        Vec3 x = Vec3::Constant(NAN);
        std::vector<int64_t> corner;
        std::string_view rest;
        if (format == 0) {
          do {
            if (!next_line(s_, at, rest))
              fail(0, "the data are cut short: " + std::to_string(i) + " of " + std::to_string(k.count) +
                          " of element " + k.name.substr(0, 30));
            ++line;
          } while (imaging::trimmed(rest).empty());
        }
        const auto value = [&](int bytes, char kind) {
          if (format != 0) return binary(at, bytes, kind, format == 2);
          if (!word(rest, w)) fail(line, "too few numbers");
          return number(w, line);
        };
        for (const Property& p : k.property) {
          const double n = p.list ? value(p.count_bytes, p.count_kind) : 1;
          if (!(n >= 0 && n <= 1e5)) fail(line, "a list of " + std::to_string(n) + " numbers; at most 100000 are read");
          for (size_t q = 0; q < size_t(n); ++q) {
            const double v = value(p.bytes, p.kind);
            if (k.name == "vertex" && !p.list) {
              if (p.name == "x") x.x() = v;
              if (p.name == "y") x.y() = v;
              if (p.name == "z") x.z() = v;
            } else if (k.name == "face" && p.list && (p.name == "vertex_indices" || p.name == "vertex_index")) {
              corner.push_back(std::abs(v) < 1e15 ? int64_t(v) : -1);
            }
          }
        }
        if (k.name == "vertex") {
          if (!x.allFinite()) fail(format == 0 ? line : 0, "vertex " + std::to_string(i) + " has no finite x, y and z");
          out_.x_mm.push_back(x);
        } else if (k.name == "face" && !corner.empty()) {
          polygon(corner, format == 0 ? line : 0);
        }
        limits(line);
      }
    }
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
