#include "sim/base/part.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>

namespace limberg {

std::vector<std::string> folders_above_code() {
  namespace fs = std::filesystem;
  std::error_code ec;
  std::vector<std::string> out;
  const auto add = [&](const fs::path& file) {
    fs::path folder = file.parent_path();
    for (int up = 0; up <= 4 && !folder.empty(); ++up, folder = folder.parent_path()) {
      // What lies in a folder that anybody may write to is anybody's.
      if (up > 0 && (fs::status(folder, ec).permissions() & fs::perms::others_write) != fs::perms::none) break;
      if (std::find(out.begin(), out.end(), folder.string()) == out.end()) out.push_back(folder.string());
      if (folder == folder.root_path()) break;
    }
  };
  if (const fs::path program = fs::read_symlink("/proc/self/exe", ec); !ec) add(program);
  Dl_info here{};
  if (dladdr(reinterpret_cast<const void*>(&folders_above_code), &here) && here.dli_fname)
    if (const fs::path library = fs::canonical(here.dli_fname, ec); !ec) add(library);
  return out;
}

LoadedPart load_part(const std::string& name, const char* entry, const std::string& needs) {
  namespace fs = std::filesystem;
  std::error_code ec;
  const std::string file = "limberg-" + name + ".so";
  std::vector<std::string> places;
  for (const std::string& folder : folders_above_code()) {
    places.push_back(folder + "/parts/" + file);
    places.push_back(folder + "/lib/limberg/" + file);
  }
  for (const std::string& path : places) {
    if (!fs::exists(path, ec)) continue;
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const made = library ? dlsym(library, entry) : nullptr;
    if (made) return {made, ""};
    const char* const why = dlerror();
    return {nullptr, path + " cannot be loaded (" + (why ? why : "no reason given") + "); expected " + needs +
                         " to be installed"};
  }
  return {nullptr, file + " is not beside the program; expected a build or an installation with it, and " + needs};
}

}  // namespace limberg
