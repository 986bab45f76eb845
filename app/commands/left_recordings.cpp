#include "app/commands/left_recordings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/result/progress.h"
#include "devices/unfinished.h"

namespace limberg {

namespace fs = std::filesystem;

std::string offer_to_continue(const std::vector<std::string>& folders) {
  std::string first;
  std::vector<std::string> looked_at;
  for (const std::string& folder : folders) {
    std::error_code ec;
    const std::string real = folder.empty() ? "" : fs::canonical(folder, ec).string();
    if (real.empty() || ec || std::find(looked_at.begin(), looked_at.end(), real) != looked_at.end()) continue;
    looked_at.push_back(real);
    if (auto left = longest_unfinished(folder)) {
      left->file = fs::path(left->file).lexically_normal().string();
      const std::string line =
          fmt::format("{}: a session that was cut off after {:.1f} s; limberg run --continue {} goes on with it",
                      left->file, left->length_s, left->file);
      say(line);
      if (first.empty()) first = line;
    }
  }
  return first;
}

std::string name_of_continuation(const std::string& recording) {
  const fs::path file(recording);
  std::string stem = file.stem().string();
  if (const size_t dash = stem.find_last_not_of("0123456789");
      dash != std::string::npos && dash > 0 && stem[dash] == '-' && dash + 1 < stem.size())
    stem.resize(dash);
  std::error_code ec;
  for (int n = 2;; ++n)
    if (const fs::path name = file.parent_path() / fmt::format("{}-{}.lcm", stem, n); !fs::exists(name, ec))
      return name.string();
}

}  // namespace limberg
