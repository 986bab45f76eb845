#include "app/result/output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

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
  if (!fs::is_directory(dir))
    throw InputError(dir, 0,
                     "cannot be used as output folder (" + (ec ? ec.message() : "it is not a folder") +
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
  }
  const std::string dir = folder_of(file);
  if (!fs::is_directory(dir))
    throw InputError(file, 0, "cannot be written: there is no folder " + dir + "; expected an existing folder");
  if (const int e = try_create_in(dir))
    throw InputError(file, 0, "cannot be written (" + reason(e) + "); expected a folder that takes files");
}

void check_replaces(const std::string& file, const std::string& begins, const std::string& kind) {
  struct stat st {};
  if (stat(file.c_str(), &st) != 0 || !S_ISREG(st.st_mode) || st.st_size == 0) return;
  std::ifstream in(file, std::ios::binary);
  std::string start;
  for (char c; start.size() < begins.size() && in.get(c);)
    if (c != ' ' && c != '\n' && c != '\r' && c != '\t') start += c;
  if (start != begins)
    throw InputError(
        file, 0,
        "exists and is not " + kind + ", which would replace it; expected the name of a new file, or of " + kind);
}

std::string read_whole_file(const std::string& file, size_t limit) {
  struct stat st {};
  if (stat(file.c_str(), &st) != 0)
    throw InputError(file, 0, "cannot be read (" + reason(errno) + "); expected an existing file");
  if (S_ISDIR(st.st_mode)) throw InputError(file, 0, "is a folder; expected a file");
  if (!S_ISREG(st.st_mode)) throw InputError(file, 0, "is not a regular file; expected a file");
  if (size_t(st.st_size) > limit)
    throw InputError(file, 0,
                     "is too large (" + std::to_string(st.st_size >> 20) + " MB); expected at most " +
                         std::to_string(limit >> 20) + " MB");
  const int fd = open(file.c_str(), O_RDONLY);
  if (fd < 0) throw InputError(file, 0, "cannot be read (" + reason(errno) + "); expected a readable file");
  std::string text(size_t(st.st_size), '\0');
  size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = read(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int e = errno;
      close(fd);
      throw InputError(file, 0, "cannot be read (" + reason(e) + ")");
    }
    if (n == 0) break;
    done += size_t(n);
  }
  close(fd);
  text.resize(done);
  return text;
}

}  // namespace limberg
