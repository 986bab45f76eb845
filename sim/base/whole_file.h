#pragma once
// A file is written whole or not at all: beside its place, under a name that no other process has, then renamed.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "sim/base/error.h"

namespace limberg {

/// InputError when anything fails; an older file is then still there.
/// What is no regular file (/dev/stdout) is written to as it is.
inline void write_whole_file(const std::string& file, const std::string& text) {
  struct stat st {};
  const bool special = stat(file.c_str(), &st) == 0 && !S_ISREG(st.st_mode);
  const size_t slash = file.find_last_of('/');
  std::string name =
      special ? file : (slash == std::string::npos ? "./" : file.substr(0, slash + 1)) + ".limberg-XXXXXX";
  const int fd = special ? open(file.c_str(), O_WRONLY) : mkstemp(name.data());
  const auto fail = [&](int e) {
    if (fd >= 0) close(fd);
    if (!special && fd >= 0) unlink(name.c_str());
    throw InputError(file, 0,
                     std::string("cannot be written (") + std::strerror(e) + "); expected room and permission");
  };
  if (fd < 0) fail(errno);
  for (size_t done = 0; done < text.size();) {
    const ssize_t n = write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(errno);
    done += size_t(n);
  }
  if (special) {
    close(fd);
    return;
  }
  fchmod(fd, 0644);
  if (close(fd) != 0 || std::rename(name.c_str(), file.c_str()) != 0) {
    const int e = errno;
    unlink(name.c_str());
    throw InputError(file, 0,
                     std::string("cannot be written (") + std::strerror(e) + "); expected room and permission");
  }
}

}  // namespace limberg
