#include "app/headset/session.h"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "sim/base/part.h"

namespace limberg {

std::unique_ptr<HeadsetSession> open_headset(const MakeContext& make_context) {
  const LoadedPart part =
      load_part("openxr", "limberg_headset_session",
                "OpenXR (Debian: libopenxr-loader1; to build it: ./do headset, or libopenxr-dev and LIMBERG_OPENXR)");
  if (!part.entry) throw RenderUnavailable("no headset: " + part.why);
  const auto make = reinterpret_cast<HeadsetSession* (*)(const MakeContext&)>(part.entry);
  return std::unique_ptr<HeadsetSession>(make(make_context));
}

std::string headset_runtime_file() {
  namespace fs = std::filesystem;
  const auto value = [](const char* name) -> std::string {
    const char* v = std::getenv(name);
    return v ? v : "";
  };
  std::vector<std::string> places{value("XR_RUNTIME_JSON")};
  if (places[0].empty()) {
    const std::string tail = "/openxr/1/active_runtime.json";
    if (const std::string config = value("XDG_CONFIG_HOME"); !config.empty())
      places.push_back(config + tail);
    else if (const std::string home = value("HOME"); !home.empty())
      places.push_back(home + "/.config" + tail);
    for (const char* folder : {"/etc/xdg", "/etc", "/usr/local/share", "/usr/share"}) places.push_back(folder + tail);
  }
  std::error_code ec;
  for (const std::string& file : places)
    if (!file.empty() && fs::exists(file, ec)) return file;
  return "";
}

}  // namespace limberg
