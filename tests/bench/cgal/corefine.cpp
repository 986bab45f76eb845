// limberg_bench_cgal BODY BLADE epick|epeck: the CPU time of one corefinement of two meshes by CGAL.
//
// A program of its own because CGAL's Polygon Mesh Processing is under GPL-3.0-or-later (so is this program, once
// linked); `limberg bench cutting` runs it beside its own measurements. Reads what tests/bench/cgal_child.cpp writes:
// counts of vertices and triangles (int64), coordinates (double), triangles (int32). Prints milliseconds, the number of
// vertices that the body has gained, and CGAL's version.
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/version.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <vector>

namespace {

double cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

template <class Mesh>
bool read(const char* file, Mesh& mesh) {
  std::ifstream in(file, std::ios::binary);
  int64_t size[2] = {0, 0};
  in.read(reinterpret_cast<char*>(size), sizeof size);
  if (!in || size[0] <= 0 || size[1] <= 0) return false;
  std::vector<std::array<double, 3>> x(static_cast<size_t>(size[0]));
  std::vector<std::array<int32_t, 3>> tri(static_cast<size_t>(size[1]));
  in.read(reinterpret_cast<char*>(x.data()), std::streamsize(x.size() * sizeof x[0]));
  in.read(reinterpret_cast<char*>(tri.data()), std::streamsize(tri.size() * sizeof tri[0]));
  if (!in) return false;
  using Vertex = typename Mesh::Vertex_index;
  mesh.reserve(uint32_t(size[0]), uint32_t(size[1] * 3 / 2), uint32_t(size[1]));
  for (const auto& p : x) mesh.add_vertex(typename Mesh::Point(p[0], p[1], p[2]));
  for (const auto& t : tri)
    if (mesh.add_face(Vertex(uint32_t(t[0])), Vertex(uint32_t(t[1])), Vertex(uint32_t(t[2]))) == Mesh::null_face())
      return false;
  return true;
}

template <class Kernel>
int run(const char* body_file, const char* blade_file) {
  using Mesh = CGAL::Surface_mesh<typename Kernel::Point_3>;
  Mesh body, blade;
  if (!read(body_file, body) || !read(blade_file, blade)) {
    std::fprintf(stderr, "limberg_bench_cgal: %s or %s cannot be read\n", body_file, blade_file);
    return 2;
  }
  const auto before = body.number_of_vertices();
  const double start = cpu_ms();
  CGAL::Polygon_mesh_processing::corefine(body, blade);
  const double ms = cpu_ms() - start;
  std::printf("%.6f %ld %s\n", ms, long(body.number_of_vertices() - before), CGAL_VERSION_STR);
  return 0;
}

}  // namespace

int main(int count, char** argument) {
  if (count != 4) {
    std::fprintf(stderr, "limberg_bench_cgal BODY BLADE epick|epeck\n");
    return 2;
  }
  if (std::strcmp(argument[3], "epeck") == 0)
    return run<CGAL::Exact_predicates_exact_constructions_kernel>(argument[1], argument[2]);
  return run<CGAL::Exact_predicates_inexact_constructions_kernel>(argument[1], argument[2]);
}
