#include "app/program/shipped.h"

#include <filesystem>

#include "app/program/places.h"

namespace limberg {

namespace fs = std::filesystem;

std::vector<std::string> shipped_roots() {
  std::vector<std::string> roots{"."};
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  if (!ec) roots.push_back((program.parent_path() / ".." / "share" / "limberg").lexically_normal().string());
  roots.push_back(source_dir());
  return roots;
}

std::string shipped_file(const std::string& path) {
  std::error_code ec;
  for (const std::string& root : shipped_roots()) {
    const std::string file = root == "." ? path : root + "/" + path;
    if (fs::exists(file, ec)) return file;
  }
  return "";
}

std::string given_or_shipped(const std::string& path) {
  std::error_code ec;
  if (path.empty() || fs::exists(path, ec)) return path;
  const std::string shipped = shipped_file(path);
  return shipped.empty() ? path : shipped;
}

}  // namespace limberg
