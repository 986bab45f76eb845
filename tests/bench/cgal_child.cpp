#include "tests/bench/cgal_child.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sim/base/error.h"

extern char** environ;

namespace limberg::bench {
namespace {

namespace fs = std::filesystem;

void write_mesh(const std::string& file, const std::vector<Int3>& x, std::span<const Tri> tri) {
  std::ofstream out(file, std::ios::binary);
  const int64_t size[2] = {int64_t(x.size()), int64_t(tri.size())};
  out.write(reinterpret_cast<const char*>(size), sizeof size);
  for (const Int3& p : x) {
    const double c[3] = {double(p.x), double(p.y), double(p.z)};
    out.write(reinterpret_cast<const char*>(c), sizeof c);
  }
  out.write(reinterpret_cast<const char*>(tri.data()), std::streamsize(tri.size() * sizeof(Tri)));
  if (!out.flush())
    throw InputError(file, 0, "cannot be written; a file for the comparison with CGAL was to be written");
}

}  // namespace

std::string cgal_program() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return error ? "limberg_bench_cgal" : (self.parent_path() / "limberg_bench_cgal").string();
}

CgalChild::CgalChild(std::string program) : program_(std::move(program)) {
  if (::access(program_.c_str(), X_OK) != 0) {
    why_ = "CGAL was not there at build (no " + program_ +
           "); install libcgal-dev and build the target limberg_bench_cgal, or call ./do bench cutting";
    return;
  }
  std::string name = (fs::temp_directory_path() / "limberg-cgal-XXXXXX").string();
  if (!::mkdtemp(name.data())) {
    why_ = "no temporary directory can be made: " + name;
    return;
  }
  dir_ = name;
}

CgalChild::~CgalChild() {
  std::error_code ignored;
  if (!dir_.empty()) fs::remove_all(dir_, ignored);
}

void CgalChild::set_input(const std::vector<Int3>& body, std::span<const Tri> body_tri, const Blade& blade) {
  if (!available()) return;
  write_mesh(dir_ + "/body", body, body_tri);
  write_mesh(dir_ + "/blade", blade.vertex, blade.tri);
}

std::optional<CgalChild::Answer> CgalChild::corefine(bool exact_points) {
  if (!available()) return std::nullopt;
  int pipe_ends[2];
  if (::pipe(pipe_ends) != 0) return why_ = "no pipe can be made", std::nullopt;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], 1);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[0]);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[1]);
  std::string body = dir_ + "/body", blade = dir_ + "/blade", kernel = exact_points ? "epeck" : "epick";
  char* argument[] = {program_.data(), body.data(), blade.data(), kernel.data(), nullptr};
  pid_t pid = 0;
  const int failed = ::posix_spawn(&pid, program_.c_str(), &actions, nullptr, argument, environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe_ends[1]);
  std::string text;
  char buffer[256];
  for (ssize_t n; !failed && (n = ::read(pipe_ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, size_t(n));
  ::close(pipe_ends[0]);
  int status = 0;
  if (!failed) ::waitpid(pid, &status, 0);
  Answer a;
  std::istringstream in(text);
  if (failed || status != 0 || !(in >> a.ms >> a.new_vertices >> a.version)) {
    why_ = "limberg_bench_cgal failed on " + kernel;
    return std::nullopt;
  }
  return a;
}

}  // namespace limberg::bench
