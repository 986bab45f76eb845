#include "sim/geometry/io/obj_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>

#include "sim/base/error.h"

namespace limberg {
namespace {

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& file, const ObjTextLimits& limits)
      : text_(text), file_(file), limits_(limits) {}

  ObjText run() {
    std::string joined;
    for (size_t at = 0; at < text_.size();) {
      const size_t end = std::min(text_.find('\n', at), text_.size());
      std::string_view l = text_.substr(at, end - at);
      at = end + 1;
      ++line_;
      if (!l.empty() && l.back() == '\r') l.remove_suffix(1);
      const bool goes_on = !l.empty() && l.back() == '\\';
      if (goes_on) l.remove_suffix(1);
      if (goes_on || !joined.empty()) {
        if (joined.size() + l.size() > (1u << 20)) fail("a line is longer than 1 MB");
        joined.append(l).push_back(' ');
        if (goes_on) continue;
        statement(joined);
        joined.clear();
      } else {
        statement(l);
      }
    }
    if (!joined.empty()) statement(joined);
    check_indices();
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_, line_, what); }

  static std::string_view word(std::string_view& l) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; };
    size_t a = 0;
    while (a < l.size() && blank(l[a])) ++a;
    size_t b = a;
    while (b < l.size() && !blank(l[b])) ++b;
    const std::string_view w = l.substr(a, b - a);
    l.remove_prefix(b);
    return w;
  }

  void statement(std::string_view l) {
    const std::string_view key = word(l);
    if (key == "v") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = real(word(l), "a vertex needs three finite numbers");
      if (out_.v.size() == limits_.vertices) fail(fmt::format("more than {} vertices", limits_.vertices));
      out_.v.push_back(p);
      colour(l);
    } else if (key == "vt" && limits_.texture) {
      Eigen::Vector2f uv;
      for (int k = 0; k < 2; ++k) {
        const std::string_view w = word(l);
        uv[k] = k == 1 && w.empty() ? 0 : float(real(w, "a texture coordinate needs finite numbers"));
      }
      if (out_.vt.size() == 3 * limits_.vertices) fail("too many texture coordinates");
      out_.vt.push_back(uv);
    } else if (key == "f") {
      face(l);
    } else if (key == "usemtl") {
      use(word(l));
    }
  }

  /// What stands behind a place: three numbers from 0 to 1, or nothing of ours.
  void colour(std::string_view l) {
    if (out_.rgb.size() + 1 != out_.v.size()) return;  // one before had none
    Vec3f c;
    for (int k = 0; k < 3; ++k) {
      const std::string_view w = word(l);
      const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), c[k]);
      if (w.empty() || ec != std::errc() || end != w.data() + w.size() || !(c[k] >= 0 && c[k] <= 1)) return;
    }
    out_.rgb.push_back(c);
  }

  void use(std::string_view name) {
    if (name.size() > 200) fail("the name of a material is longer than 200 bytes");
    const auto known = material_.find(name);
    if (known != material_.end()) return void(now_ = known->second);
    if (out_.material.size() == limits_.materials) fail(fmt::format("more than {} materials", limits_.materials));
    now_ = int32_t(out_.material.size());
    out_.material.emplace_back(name);
    material_.emplace(name, now_);
  }

  double real(std::string_view w, const char* what) const {
    if (!w.empty() && w[0] == '+') w.remove_prefix(1);
    double v = 0;
    const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), v);
    if (w.empty() || ec != std::errc() || end != w.data() + w.size() || !std::isfinite(v)) fail(what);
    return v;
  }

  // 1-based, negative from the end; gives 0-based.
  int32_t index(std::string_view w, size_t count, const char* of) const {
    int32_t i = 0;
    const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), i);
    if (w.empty() || ec != std::errc() || end != w.data() + w.size())
      fail("a face has a broken index; expected v, v/vt, v//vn or v/vt/vn");
    if (i == 0 || -int64_t(i) > int64_t(count))
      fail(fmt::format("a face names {} {}; there are {} so far", of, i, count));
    return i > 0 ? i - 1 : int32_t(count) + i;
  }

  void face(std::string_view l) {
    ObjText::Face f{out_.corner.size(), 0, line_, now_};
    for (std::string_view w = word(l); !w.empty() && w[0] != '#'; w = word(l)) {
      const size_t s = w.find('/');
      ObjText::Corner c{index(w.substr(0, s), out_.v.size(), "vertex"), -1};
      if (s != std::string_view::npos) {
        const std::string_view rest = w.substr(s + 1), vt = rest.substr(0, rest.find('/'));
        if (!vt.empty() && limits_.texture) c.vt = index(vt, out_.vt.size(), "texture coordinate");
      }
      out_.corner.push_back(c);
      if (++f.corners > limits_.polygon_corners)
        fail(fmt::format("a face has more than {} corners", limits_.polygon_corners));
    }
    if (f.corners < 3) fail(fmt::format("a face has {} corners; expected at least 3", f.corners));
    triangles_ += f.corners - 2;
    if (triangles_ > limits_.triangles) fail(fmt::format("more than {} triangles", limits_.triangles));
    out_.face.push_back(f);
  }

  void check_indices() {
    if (out_.rgb.size() != out_.v.size()) out_.rgb.clear();
    const auto check = [&](int32_t i, size_t count, const char* of) {
      if (i >= 0 && size_t(i) >= count)
        fail(fmt::format("a face names {} {}; there are {}", of, int64_t(i) + 1, count));
    };
    for (const ObjText::Face& f : out_.face) {
      line_ = f.line;
      for (size_t k = f.first; k < f.first + f.corners; ++k)
        check(out_.corner[k].v, out_.v.size(), "vertex"),
            check(out_.corner[k].vt, out_.vt.size(), "texture coordinate");
    }
  }

  std::string_view text_;
  const std::string& file_;
  const ObjTextLimits& limits_;
  int line_ = 0;
  size_t triangles_ = 0;
  int32_t now_ = -1;  // material
  std::map<std::string, int32_t, std::less<>> material_;
  ObjText out_;
};

}  // namespace

ObjText parse_obj_text(std::string_view text, const std::string& file, const ObjTextLimits& limits) {
  return ObjParser(text, file, limits).run();
}

}  // namespace limberg
