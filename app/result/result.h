#pragma once
// result.json: what a command came to, under the names that the contract fixes.
//
//   Result r("replay", "rhomboid");
//   r.set("/solver/steps", 1234);
//   r.set("/stages/0/name", "flap cut");     // a number names an entry of a list; entries come in order
//   r.write("out/result.json");
//
// What more than one line of the program knows by name is a struct with its fields (schema.h, run_result.h).
//
// Paths are JSON pointers. Numbers that are not finite become null. The file is written beside its place and renamed,
// so an older one is replaced whole or not at all.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace limberg {

class Result {
 public:
  /// Fills `limberg` {version, commit}, `command`, `scene`, `machine` {cpu, cores} and `ok` (true).
  Result(const std::string& command, const std::string& scene);
  ~Result();
  Result(Result&&) noexcept;

  void set(std::string_view path, double v);
  void set(std::string_view path, int64_t v);
  void set(std::string_view path, uint64_t v) { set(path, int64_t(v)); }
  void set(std::string_view path, int v) { set(path, int64_t(v)); }
  void set(std::string_view path, bool v);
  void set(std::string_view path, const char* v) { set(path, std::string(v)); }
  void set(std::string_view path, const std::string& v);
  void set(std::string_view path, std::span<const float> v);
  void set_empty_list(std::string_view path);
  /// How many entries the list at `path` has; 0 where there is none.
  int entries(std::string_view path) const;

  /// Copies what another result.json holds at `path`, if anything. InputError when that file is no JSON object.
  void take(std::string_view path, const std::string& other_file);

  void set_ok(bool ok) { set("/ok", ok); }

  std::string text() const;  // indented JSON with a line end
  /// InputError when it cannot be written.
  void write(const std::string& file) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Peak resident memory of this process in MB.
double peak_memory_mb();
/// "0123456789abcdef"
std::string hex(uint64_t v);

}  // namespace limberg
