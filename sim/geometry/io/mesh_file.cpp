#include "sim/geometry/io/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>

#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/text_rows.h"

namespace limberg {
namespace {

constexpr const char* kColour[] = {"red", "green", "blue"};

bool blank(std::string_view s) { return s.find_first_not_of(" \t\r") == std::string_view::npos; }

double number_of(std::string_view w, const std::string& file, int line) {
  const std::optional<double> v = finite_number(w.starts_with('+') ? w.substr(1) : w);
  if (!v) throw InputError(file, line, quoted(w.starts_with('+') ? w.substr(1) : w) + " is no finite number");
  return *v;
}

class MeshReader {
 public:
  MeshReader(std::string_view bytes, const std::string& name, const ObjTextLimits& limits)
      : s_(bytes), name_(name), limits_(limits) {}

  ObjText ply() {
    size_t at = 0;
    std::string_view l, w;
    std::vector<Kind> kinds;
    int line = 0, format = -1;  // 0 ascii, 1 little endian, 2 big endian
    bool ended = false;
    while (!ended && next_line(s_, at, l)) {
      ++line;
      std::string_view rest = l;
      if (!next_word(rest, w) || w == "comment" || w == "obj_info" || w == "ply") continue;
      if (w == "end_header") {
        ended = true;
      } else if (w == "format") {
        next_word(rest, w);
        format = w == "ascii" ? 0 : w == "binary_little_endian" ? 1 : w == "binary_big_endian" ? 2 : -1;
        if (format < 0)
          fail(line, "the format is not known; expected ascii, binary_little_endian or binary_big_endian");
      } else if (w == "element") {
        Kind k;
        next_word(rest, w), k.name = w, next_word(rest, w);
        const double n = number_of(w, name_, line);
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
        next_word(rest, w);
        if (w == "list") {
          p.list = true;
          next_word(rest, w);
          if (!type(w, p.count_bytes, p.count_kind) || p.count_kind == 'f')
            fail(line, "the count of a list has no whole type");
          next_word(rest, w);
        }
        if (!type(w, p.bytes, p.kind)) fail(line, "the type " + quoted(w) + " is not known");
        next_word(rest, w), p.name = w;
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
        Vec3 x = Vec3::Constant(NAN), rgb = Vec3::Constant(NAN);
        std::vector<int64_t> corner;
        std::string_view rest;
        if (format == 0) {
          do {
            if (!next_line(s_, at, rest))
              fail(0, "the data are cut short: " + std::to_string(i) + " of " + std::to_string(k.count) +
                          " of element " + k.name.substr(0, 30));
            ++line;
          } while (blank(rest));
        }
        const auto value = [&](int bytes, char kind) {
          if (format != 0) return binary(at, bytes, kind, format == 2);
          if (!next_word(rest, w)) fail(line, "too few numbers");
          return number_of(w, name_, line);
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
              for (int c = 0; c < 3; ++c)
                if (p.name == kColour[c]) rgb[c] = p.kind == 'f' ? v : v / (p.bytes == 1 ? 255. : 65535.);
            } else if (k.name == "face" && p.list && (p.name == "vertex_indices" || p.name == "vertex_index")) {
              corner.push_back(std::abs(v) < 1e15 ? int64_t(v) : -1);
            }
          }
        }
        if (k.name == "vertex") {
          if (!x.allFinite()) fail(format == 0 ? line : 0, "vertex " + std::to_string(i) + " has no finite x, y and z");
          out_.v.push_back(x);
          if (rgb.allFinite() && out_.rgb.size() + 1 == out_.v.size())
            out_.rgb.push_back(rgb.cwiseMax(0).cwiseMin(1).cast<float>());
        } else if (k.name == "face" && !corner.empty()) {
          polygon(corner, format == 0 ? line : 0);
        }
        within_limits(line);
      }
    }
    if (out_.rgb.size() != out_.v.size()) out_.rgb.clear();
    check_indices();
    return std::move(out_);
  }

  ObjText stl() {
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
        weld(corner);
        return std::move(out_);
      }
    }
    size_t at = 0;
    std::string_view l, w;
    for (int line = 1; next_line(s_, at, l); ++line) {
      std::string_view rest = l;
      if (next_word(rest, w) && w == "vertex") corner.push_back(point_of_row(rest, name_, line));
      if (corner.size() > 3 * limits_.triangles) fail(line, "has more triangles than are read");
    }
    if (corner.size() % 3 != 0) fail(0, "its last triangle is cut short");
    weld(corner);
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const { throw InputError(name_, line, what); }
  void face(std::span<const int32_t> corner, int line) {
    out_.face.push_back({out_.corner.size(), corner.size(), line, -1});
    for (const int32_t c : corner) out_.corner.push_back({c, -1});
    triangles_ += corner.size() - 2;
  }
  void polygon(const std::vector<int64_t>& corner, int line) {
    if (corner.size() < 3) fail(line, "a face has fewer than three corners");
    if (corner.size() > limits_.polygon_corners)
      fail(line, fmt::format("a face with {} corners; expected at most {}", corner.size(), limits_.polygon_corners));
    std::vector<int32_t> named;
    for (const int64_t c : corner) named.push_back(c >= 0 && c < INT32_MAX ? int32_t(c) : -1);
    face(named, line);
  }
  /// Points may follow the faces that name them.
  void check_indices() const {
    for (const ObjText::Face& f : out_.face)
      for (size_t k = 0; k < f.corners; ++k)
        if (const int32_t c = out_.corner[f.first + k].v; c < 0 || size_t(c) >= out_.v.size())
          fail(f.line, fmt::format("a face names point {}; there are {}", c, out_.v.size()));
  }
  void within_limits(int line) const {
    if (out_.v.size() > limits_.vertices) fail(line, fmt::format("more than {} vertices", limits_.vertices));
    if (triangles_ > limits_.triangles) fail(line, fmt::format("more than {} triangles", limits_.triangles));
  }

  void weld(const std::vector<Vec3>& corner) {
    if (corner.size() > 3 * limits_.triangles) fail(0, fmt::format("more than {} triangles", limits_.triangles));
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
      if (first[i] == int32_t(i)) number[i] = int32_t(out_.v.size()), out_.v.push_back(corner[i]);
    for (size_t t = 0; t + 2 < corner.size(); t += 3) {
      const Tri tri{number[size_t(first[t])], number[size_t(first[t + 1])], number[size_t(first[t + 2])]};
      if (tri[0] != tri[1] && tri[1] != tri[2] && tri[2] != tri[0]) face(tri, 0);
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

  std::string_view s_;
  const std::string& name_;
  const ObjTextLimits& limits_;
  ObjText out_;
  size_t triangles_ = 0;
};

}  // namespace

Vec3 point_of_row(std::string_view row, const std::string& file, int line) {
  Vec3 x;
  for (int k = 0; k < 3; ++k) {
    std::string_view w;
    if (!next_word(row, w)) throw InputError(file, line, "a point has fewer than three numbers");
    x[k] = number_of(w, file, line);
  }
  return x;
}

bool is_ply(std::string_view bytes) { return bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n"); }

bool is_stl_name(std::string_view file) { return file.ends_with(".stl") || file.ends_with(".STL"); }

ObjText parse_ply(std::string_view bytes, const std::string& file, const ObjTextLimits& limits) {
  return MeshReader(bytes, file, limits).ply();
}

ObjText parse_stl(std::string_view bytes, const std::string& file, const ObjTextLimits& limits) {
  return MeshReader(bytes, file, limits).stl();
}

ObjText parse_mesh_file(std::string_view bytes, const std::string& file, const ObjTextLimits& limits) {
  if (is_ply(bytes)) return parse_ply(bytes, file, limits);
  if (is_stl_name(file)) return parse_stl(bytes, file, limits);
  return parse_obj_text(bytes, file, limits);
}

}  // namespace limberg
