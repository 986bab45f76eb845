#pragma once
// Files are read whole, and written whole or not at all.
//
// Every reader of this house opens its files here: what is no regular file (a pipe, /dev/zero, a folder) is refused
// without waiting for it, and no more is read than the reader's own limit.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "sim/base/error.h"

namespace limberg {

/// A regular file, open for reading; closed with its owner.
class OpenedFile {
 public:
  /// InputError: missing, a folder, a pipe or a device, or not readable. `expected` says what it should be.
  OpenedFile(const std::string& file, const std::string& expected) : file_(file) {
    // (O_NONBLOCK: a pipe that nobody writes to is opened all the same, and refused)
    fd_ = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    const int e = errno;
    std::string wrong;
    struct stat st {};
    if (fd_ < 0)
      wrong = e == ENOENT ? "no such file" : std::string("cannot be opened (") + std::strerror(e) + ")";
    else if (fstat(fd_, &st) != 0)
      wrong = std::string("cannot be read (") + std::strerror(errno) + ")";
    else if (S_ISDIR(st.st_mode))
      wrong = "is a folder";
    else if (!S_ISREG(st.st_mode))
      wrong = "is not a regular file";
    size_ = size_t(std::max<off_t>(0, st.st_size));
    if (wrong.empty()) return;
    if (fd_ >= 0) close(fd_);
    throw InputError(file, 0, wrong + "; expected " + expected);
  }
  ~OpenedFile() { close(fd_); }
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;

  size_t size() const { return size_; }
  /// The next byte that is read; beyond the end nothing is.
  void go_to(size_t at) { lseek(fd_, off_t(at), SEEK_SET); }
  /// The next bytes, fewer only at the end. InputError when the disk refuses.
  size_t read(void* to, size_t most) {
    size_t done = 0;
    while (done < most) {
      const ssize_t n = ::read(fd_, static_cast<char*>(to) + done, most - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) throw InputError(file_, 0, std::string("cannot be read to its end (") + std::strerror(errno) + ")");
      if (n == 0) break;
      done += size_t(n);
    }
    return done;
  }

 private:
  std::string file_;
  int fd_ = -1;
  size_t size_ = 0;
};

/// The first bytes of a regular file, at most so many.
inline std::string read_beginning(const std::string& file, size_t most, const std::string& expected = "a file") {
  OpenedFile in(file, expected);
  std::string text(std::min(most, std::max<size_t>(in.size(), 4096)), '\0');
  text.resize(in.read(text.data(), text.size()));
  return text;
}

/// The bytes of a regular file. InputError as OpenedFile, and when it is larger than `limit`: nothing is read then.
template <class Bytes = std::string>
Bytes read_whole_file(const std::string& file, size_t limit = size_t(256) << 20,
                      const std::string& expected = "a file") {
  OpenedFile in(file, expected);
  const auto too_large = [&](size_t bytes) {
    const auto words = [](size_t n) {
      return n >> 20 > 0 ? std::to_string(n >> 20) + " MB" : std::to_string(n) + " bytes";
    };
    return InputError(file, 0, "is too large (" + words(bytes) + "); expected at most " + words(limit));
  };
  if (in.size() > limit) throw too_large(in.size());
  Bytes all;
  all.resize(in.size());
  size_t done = in.read(all.data(), all.size());
  // One that grows while it is read, or does not tell its size (/proc).
  for (constexpr size_t kPart = 65'536; done == all.size();) {
    all.resize(done + kPart);
    done += in.read(all.data() + done, kPart);
    if (done > limit) throw too_large(done);
  }
  all.resize(done);
  return all;
}

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
