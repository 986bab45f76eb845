#include "app/program/shipped.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "app/program/places.h"
#include "sim/base/part.h"

namespace limberg {

namespace fs = std::filesystem;

std::vector<std::string> shipped_roots() {
  std::vector<std::string> roots{"."};
  std::error_code ec;
  if (const char* told = std::getenv("LIMBERG_DATA"); told && *told) roots.insert(roots.begin(), told);
  for (const std::string& folder : folders_above_code()) {
    const std::string share = folder + "/share/limberg";
    if (fs::is_directory(share, ec) && std::find(roots.begin(), roots.end(), share) == roots.end())
      roots.push_back(share);
  }
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
