#pragma once
// One line of a script being read: gives each key by its type
// and complains in the words of the house, with file and line.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/commands/script.h"

namespace limberg {

class ScriptReader {
 public:
  /// One JSON object. Throws InputError: broken, nested too deeply, a key given twice, a number out of range.
  ScriptReader(std::string_view text, const std::string& name, int line);
  ~ScriptReader();

  [[noreturn]] void fail(const std::string& what) const;
  bool has(const char* key) const;
  bool is_list(const char* key) const;
  /// Whether the key holds [x, y, z] or {"uv": [u, v]}, or a list that begins with one.
  bool has_places(const char* key) const;
  /// Any other key is refused.
  void only(const std::vector<const char*>& keys, const std::string& where) const;

  std::string text(const char* key, bool required, size_t max_bytes) const;
  int64_t integer(const char* key, int64_t lo, int64_t hi) const;
  bool boolean(const char* key, bool otherwise) const;
  /// lo <= value <= hi; with `open`, lo < value.
  double real(const char* key, double otherwise, double lo, double hi, bool open) const;

  ChartPoint point(const char* key) const;                            // [x, y]
  std::vector<ChartPoint> path(const char* key, size_t least) const;  // [[x, y], ...]
  /// allowed: {"uv": [u, v]} may stand for [x, y, z], and is (u, v, NaN) (in_space.h).
  enum class Textures { none, allowed };
  Vec3 place(const char* key, Textures textures = Textures::none) const;  // [x, y, z]
  std::vector<Vec3> places(const char* key, size_t least, Textures textures = Textures::none) const;

  /// Named points: {"name":[x, y], ...}.
  std::vector<Landmark> landmarks(const char* key) const;
  std::optional<PlannedProcedure> plan(const char* key) const;
  /// A stitch: its number, or a place.
  StitchPick stitch(const char* key) const;
  /// A fragment: its number, or a place on it.
  FragmentPick fragment(const char* key) const;
  /// The number of the name that the line gives.
  size_t choice(const char* key, std::span<const char* const> names) const;

  /// A text from the file, made fit for a one-line message.
  static std::string shown(const std::string& s);
  static std::string quoted(const char* key) { return "\"" + std::string(key) + "\""; }
  static std::string number(double v);
  /// "a, b or c".
  static std::string listed(const std::vector<std::string>& names);

 private:
  [[noreturn]] void missing(const char* key, const std::string& what) const;
  void coordinates(const void* value, double* out, size_t n, const char* key) const;
  Vec3 place_of(const void* value, const char* key, Textures textures) const;
  void check_depth(std::string_view text) const;
  size_t list_size(const char* key, size_t least, const char* of) const;

  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace limberg
