#pragma once
// A private folder that goes away with its owner.
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "sim/base/error.h"

namespace limberg {

class TemporaryFolder {
 public:
  /// InputError when none can be made; `expected` says what would help.
  explicit TemporaryFolder(const std::string& expected = "room in the folder for temporary files") {
    std::string name = (std::filesystem::temp_directory_path() / "limberg-XXXXXX").string();
    if (!mkdtemp(name.data())) throw InputError(name, 0, "no temporary folder can be made; expected " + expected);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace limberg
