#pragma once
// One table of a TOML file, read strictly: scenes and libraries of tissues. Heavy: include it from .cpp files only.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/toml.h"
#include "sim/base/error.h"
#include "sim/geometry/vec.h"

namespace limberg {

inline std::string number(double v) {
  std::ostringstream s;
  s << v;
  return s.str();
}

/// A file that another one names, whose path is relative to that one's folder.
inline std::string beside(const std::string& file, const std::string& name) {
  namespace fs = std::filesystem;
  return fs::path(name).is_absolute() ? name : (fs::path(file).parent_path() / name).lexically_normal().string();
}

/// Every key that is asked for is ticked off; finish() complains about the others. All complaints are InputErrors with
/// the line, what is wrong and what was expected.
class Table {
 public:
  Table(const toml::table* table, std::string name, const std::string& file)
      : t_(table), name_(std::move(name)), file_(file) {}

  bool present() const { return t_ != nullptr; }
  bool has(const char* key) const { return t_ && t_->contains(key); }

  [[noreturn]] void fail(const char* key, const std::string& what) const {
    int line = t_ ? int(t_->source().begin.line) : 0;
    if (has(key)) line = int(t_->get(key)->source().begin.line);
    throw InputError(file_, line, full(key) + " " + what);
  }

  void real(const char* key, double& value, double lo, double hi, bool open = false) {
    const toml::node* n = take(key);
    if (!n) return;
    const std::string range =
        "; expected a number " + std::string(open ? "above " : "from ") + number(lo) + " to " + number(hi);
    const std::optional<double> v = n->is_number() ? n->value<double>() : std::nullopt;
    if (!v) fail(key, "is not a number" + range);
    if (!std::isfinite(*v) || *v < lo || *v > hi || (open && *v == lo)) fail(key, "is " + number(*v) + range);
    value = *v;
  }
  void integer(const char* key, int64_t lo, int64_t hi, const std::function<void(int64_t)>& set) {
    const toml::node* n = take(key);
    if (!n) return;
    const std::string range = "; expected an integer from " + std::to_string(lo) + " to " + std::to_string(hi);
    const std::optional<int64_t> v = n->is_integer() ? n->value<int64_t>() : std::nullopt;
    if (!v) fail(key, "is not an integer" + range);
    if (*v < lo || *v > hi) fail(key, "is " + std::to_string(*v) + range);
    set(*v);
  }
  /// The number of the format that a file is in: 1, and it must be given.
  void first_format(const char* key) {
    integer(key, 1, 1, [](int64_t) {});
    if (!has(key)) fail(key, "is missing; expected " + std::string(key) + " = 1");
  }
  void boolean(const char* key, bool& value) {
    const toml::node* n = take(key);
    if (!n) return;
    if (!n->is_boolean()) fail(key, "is neither true nor false; expected one of them");
    value = *n->value<bool>();
  }
  /// true, false or "auto": set(1), set(0), set(-1).
  void choice(const char* key, const std::function<void(int)>& set) {
    const toml::node* n = take(key);
    if (!n) return;
    if (n->is_boolean())
      set(*n->value<bool>() ? 1 : 0);
    else if (n->is_string() && *n->value<std::string>() == "auto")
      set(-1);
    else
      fail(key, "is neither \"auto\" nor true nor false; expected one of them");
  }
  /// One number, or with `most_count` above 1 a list of at most so many.
  void numbers(const char* key, std::vector<double>& value, double lo, double hi, bool open, int most_count) {
    const toml::node* n = take(key);
    if (!n) return;
    const toml::array* a = n->as_array();
    const std::string range = std::string(open ? "above " : "from ") + number(lo) + " to " + number(hi);
    const std::string expected = most_count > 1
                                     ? "; expected a list of 1 to " + std::to_string(most_count) + " numbers " + range
                                     : "; expected a number " + range;
    if (a && (most_count == 1 || a->empty() || a->size() > size_t(most_count)))
      fail(key, "is a list of " + std::to_string(a->size()) + expected);
    std::vector<double> out;
    const auto take_one = [&](const toml::node& e) {
      const std::optional<double> v = e.is_number() ? e.value<double>() : std::nullopt;
      if (!v) fail(key, "is not a number" + expected);
      if (!std::isfinite(*v) || *v < lo || *v > hi || (open && *v == lo)) fail(key, "is " + number(*v) + expected);
      out.push_back(*v);
    };
    if (!a)
      take_one(*n);
    else
      for (const toml::node& e : *a) take_one(e);
    value = std::move(out);
  }
  /// [[a, b], ...]
  void pairs(const char* key, std::vector<std::pair<double, double>>& value, const char* expected) {
    const toml::node* n = take(key);
    if (!n) return;
    value.clear();
    const toml::array* a = n->as_array();
    if (!a || a->size() > 16) fail(key, std::string("is no list of at most 16 pairs; expected ") + expected);
    for (const toml::node& e : *a) {
      const toml::array* p = e.as_array();
      std::optional<double> v[2];
      for (size_t i = 0; i < 2; ++i)
        if (p && p->size() == 2 && p->get(i)->is_number()) v[i] = p->get(i)->value<double>();
      if (!v[0] || !v[1] || !std::isfinite(*v[0]) || !std::isfinite(*v[1]))
        fail(key, std::string("holds something else than pairs of numbers; expected ") + expected);
      value.push_back({*v[0], *v[1]});
    }
  }
  /// A place on the skin, [x, y] in mm.
  void place(const char* key, Vec2& value) {
    const toml::node* n = take(key);
    if (!n) return;
    const toml::array* a = n->as_array();
    for (size_t i = 0; i < 2; ++i) {
      const std::optional<double> v =
          a && a->size() == 2 && a->get(i)->is_number() ? a->get(i)->value<double>() : std::nullopt;
      if (!v || !(std::abs(*v) <= 1e4)) fail(key, "is no place; expected [x, y] in mm");
      value[Eigen::Index(i)] = *v;
    }
  }
  /// Whatever stands there; nullptr when nothing does.
  const toml::node* node(const char* key) { return take(key); }
  /// A table inside this one; nullptr when there is none.
  const toml::table* table(const char* key) {
    const toml::node* n = take(key);
    if (!n) return nullptr;
    if (!n->is_table()) fail(key, "is not a table; expected [" + full(key) + "]");
    return n->as_table();
  }
  void text(const char* key, std::string& value, size_t max_bytes = 1000) {
    const toml::node* n = take(key);
    if (!n) return;
    if (!n->is_string()) fail(key, "is not a text; expected \"...\"");
    value = *n->value<std::string>();
    if (value.empty() || value.size() > max_bytes)
      fail(key, "is empty or too long; expected 1 to " + std::to_string(max_bytes) + " bytes");
    if (value.find('\0') != std::string::npos) fail(key, "holds a zero byte; expected plain text");
  }
  /// The path of a file, relative to the one that is read.
  void path(const char* key, std::string& value) {
    text(key, value, 4000);
    if (has(key)) value = beside(file_, value);
  }
  /// A list of `least` to `most` rows of N numbers of at most 1e4; `one`: what a row is called; `expected`: "; expected
  /// ...".
  template <size_t N>
  std::vector<std::array<double, N>> rows(const char* key, size_t least, size_t most, const std::string& one,
                                          const std::string& expected) {
    std::vector<std::array<double, N>> out;
    const toml::node* n = take(key);
    if (!n) return out;
    const toml::array* a = n->as_array();
    if (!a || a->size() < least || a->size() > most) fail(key, "is no such list" + expected);
    for (const toml::node& e : *a) {
      const toml::array* row = e.as_array();
      for (size_t i = 0; i < N; ++i) {
        const std::optional<double> v =
            row && row->size() == N && row->get(i)->is_number() ? row->get(i)->value<double>() : std::nullopt;
        if (!v || !(std::abs(*v) <= 1e4)) fail(key, "holds something that is no " + one + expected);
        if (i == 0) out.emplace_back();
        out.back()[i] = *v;
      }
    }
    return out;
  }
  void vector(const char* key, Vec3& value, double limit) {
    const toml::node* n = take(key);
    if (!n) return;
    const toml::array* a = n->as_array();
    if (!a || a->size() != 3) fail(key, "is not [x, y, z]; expected three numbers");
    for (size_t i = 0; i < 3; ++i) {
      const std::optional<double> v = a->get(i)->is_number() ? a->get(i)->value<double>() : std::nullopt;
      if (!v || !std::isfinite(*v) || std::abs(*v) > limit)
        fail(key, "holds a value that cannot be used; expected finite numbers of at most " + number(limit));
      value[Eigen::Index(i)] = *v;
    }
  }
  /// sRGB, three numbers from 0 to 1.
  void colour(const char* key, std::optional<Vec3f>& value) {
    Vec3 srgb = Vec3::Zero();
    const bool given = has(key);
    vector(key, srgb, 1);
    if (srgb.minCoeff() < 0) fail(key, "has a part below 0; expected three numbers from 0 to 1");
    if (given) value = srgb.cast<float>();
  }
  void direction(const char* key, Vec3& value) {
    vector(key, value, 1e6);
    if (value.norm() < 1e-6) fail(key, "has no length; expected a direction");
  }

  /// Every key of the table must have been asked for, or be listed here.
  void finish(std::initializer_list<const char*> others = {}) {
    if (!t_) return;
    asked_.insert(asked_.end(), others.begin(), others.end());
    for (const auto& [k, n] : *t_) {
      if (std::find(asked_.begin(), asked_.end(), k.str()) != asked_.end()) continue;
      std::string list;
      for (const auto& a : asked_) list += (list.empty() ? "" : ", ") + a;
      throw InputError(file_, int(n.source().begin.line),
                       "unknown key \"" + shown(k.str()) + "\" in " + where() + "; expected " + list);
    }
  }

 private:
  const toml::node* take(const char* key) {
    asked_.emplace_back(key);
    return t_ ? t_->get(key) : nullptr;
  }
  static std::string shown(std::string_view s) {
    std::string out;
    for (char c : s.substr(0, 40)) out += (c >= ' ' && c != 127) ? c : '?';
    return out;
  }
  std::string full(const char* key) const { return name_.empty() ? key : name_ + "." + key; }
  std::string where() const { return name_.empty() ? "the scene" : "[" + name_ + "]"; }

  const toml::table* t_;
  std::string name_;
  const std::string& file_;
  std::vector<std::string> asked_;
};

inline Table section(const toml::table& root, const char* key, const std::string& file) {
  const toml::node* n = root.get(key);
  if (n && !n->is_table())
    throw InputError(file, int(n->source().begin.line), std::string(key) + " is not a table; expected [" + key + "]");
  return Table(n ? n->as_table() : nullptr, key, file);
}

/// The tables of a list [[KEY]], of which there may be so many; `with`: what each of them has, for messages.
inline std::vector<const toml::node*> list_of_tables(const toml::table& root, const std::string& key,
                                                     const std::string& file, size_t most, const std::string& with) {
  std::vector<const toml::node*> out;
  const toml::node* n = root.get(key);
  if (!n) return out;
  const auto fail = [&](const toml::node& at, const std::string& what) {
    throw InputError(file, int(at.source().begin.line), key + " " + what + "; expected [[" + key + "]] with " + with);
  };
  const toml::array* all = n->as_array();
  if (!all || all->empty() || all->size() > most) fail(*n, "is no list of 1 to " + std::to_string(most) + " tables");
  for (const toml::node& e : *all) {
    if (!e.is_table()) fail(e, "holds something else than tables");
    out.push_back(&e);
  }
  return out;
}

/// InputError says "broken TOML; expected WHAT".
inline toml::table parse_toml(const std::string& text, const std::string& path, const std::string& expected) {
  try {
    return toml::parse(std::string_view(text), std::string_view(path));
  } catch (const toml::parse_error& e) {
    std::string what(e.description());
    std::replace_if(
        what.begin(), what.end(), [](char c) { return c < ' ' || c == 127; }, ' ');
    throw InputError(path, int(e.source().begin.line), "broken TOML: " + what + "; expected " + expected);
  } catch (const BrokenToml&) {
    throw InputError(path, 0, "broken TOML; expected " + expected);
  }
}

}  // namespace limberg
