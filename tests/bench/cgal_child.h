#pragma once
// CGAL's corefinement on the same input, timed in a program of its own.
//
// CGAL's Polygon Mesh Processing is under the GPL; Limberg's own program does not link it. `limberg_bench_cgal` is a
// separate program beside it, built when CGAL was found (CMake option LIMBERG_CGAL_BENCH). It reads two meshes from
// files, measures the CPU time of one corefinement after the other, and prints it.
#include <optional>
#include <span>
#include <string>

#include "sim/cutting/strokes/blade.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg::bench {

class CgalChild {
 public:
  /// `program` may be missing: then available() is false and why() says it.
  explicit CgalChild(std::string program);
  ~CgalChild();
  CgalChild(const CgalChild&) = delete;
  CgalChild& operator=(const CgalChild&) = delete;

  bool available() const { return why_.empty(); }
  const std::string& why() const { return why_; }

  /// Both meshes in integer half-units, exact in doubles.
  void set_input(const std::vector<Int3>& body, std::span<const Tri> body_tri, const Blade& blade);

  struct Answer {
    double ms = 0;
    long new_vertices = 0;  // of the body: intersection points
    std::string version;
  };
  /// Times one corefinement; nothing (and why() set) when the program failed.
  std::optional<Answer> corefine(bool exact_points);

 private:
  std::string program_, dir_, why_;
};

/// The helper beside the running program.
std::string cgal_program();

}  // namespace limberg::bench
