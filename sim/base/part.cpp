#include "sim/base/part.h"

#include <dlfcn.h>

#include <filesystem>

namespace limberg {

LoadedPart load_part(const std::string& name, const char* entry, const std::string& needs) {
  namespace fs = std::filesystem;
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec), folder = program.parent_path();
  const std::string file = "limberg-" + name + ".so";
  for (const fs::path& place :
       {folder / "parts", folder.parent_path() / "parts", folder.parent_path() / "lib/limberg"}) {
    const std::string path = (place / file).string();
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
