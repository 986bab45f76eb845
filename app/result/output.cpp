#include "app/result/output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "sim/base/error.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

std::string reason(int error) { return std::strerror(error); }

/// Creates and removes an empty file with a name of its own; 0 or the error.
int try_create_in(const std::string& dir) {
  std::string name = dir + "/.limberg-XXXXXX";
  const int fd = mkstemp(name.data());
  if (fd < 0) return errno;
  close(fd);
  unlink(name.c_str());
  return 0;
}

std::string folder_of(const std::string& file) {
  const std::string dir = fs::path(file).parent_path().string();
  return dir.empty() ? "." : dir;
}

}  // namespace

void prepare_folder(const std::string& dir) {
  std::error_code ec;
  fs::create_directories(dir, ec);
  if (std::error_code why; !fs::is_directory(dir, why))
    throw InputError(dir, 0,
                     "cannot be used as output folder (" +
                         (ec    ? ec.message()
                          : why ? why.message()
                                : "it is not a folder") +
                         "); expected a folder that can be written");
  if (const int e = try_create_in(dir))
    throw InputError(dir, 0,
                     "output folder is not writable (" + reason(e) + "); expected a folder that can be written");
}

void check_writable(const std::string& file) {
  struct stat st {};
  if (stat(file.c_str(), &st) == 0) {
    if (S_ISDIR(st.st_mode)) throw InputError(file, 0, "is a folder; expected the name of a file to write");
    if (!S_ISREG(st.st_mode)) return;  // a device or a pipe: the write will tell
    if (access(file.c_str(), W_OK) != 0)
      throw InputError(file, 0, "cannot be written (" + reason(errno) + "); expected a file that can be written");
  } else if (errno != ENOENT) {  // a link that goes round, a name that no file system takes
    throw InputError(file, 0, "cannot be written (" + reason(errno) + "); expected a file in an existing folder");
  }
  const std::string dir = folder_of(file);
  if (std::error_code why; !fs::is_directory(dir, why))
    throw InputError(file, 0,
                     why && why != std::errc::no_such_file_or_directory
                         ? "cannot be written (" + why.message() + "); expected a file in an existing folder"
                         : "cannot be written: there is no folder " + dir + "; expected an existing folder");
  if (const int e = try_create_in(dir))
    throw InputError(file, 0, "cannot be written (" + reason(e) + "); expected a folder that takes files");
}

void check_replaces(const std::string& file, const std::string& begins, const std::string& kind) {
  struct stat st {};
  if (stat(file.c_str(), &st) != 0 || !S_ISREG(st.st_mode) || st.st_size == 0) return;
  std::string start;
  for (const char c : read_beginning(file, 4096))
    if (start.size() < begins.size() && c != ' ' && c != '\n' && c != '\r' && c != '\t') start += c;
  if (start != begins)
    throw InputError(
        file, 0,
        "exists and is not " + kind + ", which would replace it; expected the name of a new file, or of " + kind);
}

}  // namespace limberg
