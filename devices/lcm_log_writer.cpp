#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>

#include "devices/big_endian.h"
#include "devices/lcm_log.h"
#include "sim/base/error.h"

namespace limberg {

namespace {
constexpr int64_t kFlushUs = 100'000;
constexpr size_t kFlushBytes = 256 * 1024, kMostHeld = size_t(64) << 20;
constexpr size_t kLongestEvent = LogReader::kHeader + LogReader::kMaxChannel + LogReader::kMaxData;

void put_event(uint8_t* p, int64_t number, int64_t time_us, std::string_view channel, const uint8_t* data,
               size_t size) {
  put_big_endian<uint32_t>(p, LogReader::kSync);
  put_big_endian<int64_t>(p + 4, number);
  put_big_endian<int64_t>(p + 12, time_us);
  put_big_endian<uint32_t>(p + 20, uint32_t(channel.size()));
  put_big_endian<uint32_t>(p + 24, uint32_t(size));
  std::memcpy(p + LogReader::kHeader, channel.data(), channel.size());
  if (size > 0) std::memcpy(p + LogReader::kHeader + channel.size(), data, size);
}

/// 0, or the error; `done` says how much of it the file has.
int write_all(int fd, const uint8_t* data, size_t size, size_t& done) {
  for (done = 0; done < size;) {
    const ssize_t n = ::write(fd, data + done, size - done);
    if (n > 0)
      done += size_t(n);
    else if (n == 0)
      return ENOSPC;
    else if (errno != EINTR)
      return errno;
  }
  return 0;
}

/// Everything of a file, whether it has a name still or not. 0, or the error.
int copy_contents(int from, int to) {
  const int in = ::open(("/proc/self/fd/" + std::to_string(from)).c_str(), O_RDONLY | O_CLOEXEC);
  if (in < 0) return errno;
  std::vector<uint8_t> part(65'536);
  int wrong = 0;
  for (ssize_t n = 0; wrong == 0 && (n = ::read(in, part.data(), part.size())) != 0;) {
    size_t done = 0;
    if (n > 0)
      wrong = write_all(to, part.data(), size_t(n), done);
    else if (errno != EINTR)
      wrong = errno;
  }
  ::close(in);
  return wrong;
}

}  // namespace

void LogWriter::open(const std::string& path, bool replace) {
  close();
  path_ = path;
  error_.clear();
  buffer_.clear(), buffer_.reserve(kFlushBytes + kLongestEvent);
  lengths_.clear(), lengths_.reserve(buffer_.capacity() / LogReader::kHeader);
  events_ = flushed_us_ = file_bytes_ = 0;
  given_up_ = false;
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (replace ? O_TRUNC : O_EXCL), 0666);
  if (fd_ < 0 && errno == EEXIST)
    throw InputError(path, 0, "exists already; expected a new file name (an existing recording is never overwritten)");
  if (fd_ < 0)
    throw InputError(path, 0,
                     std::string("cannot be created (") + std::strerror(errno) + "); expected a writable place");
  struct stat st {};
  regular_ = fstat(fd_, &st) == 0 && S_ISREG(st.st_mode);
  if (regular_)
    flock(fd_, LOCK_EX | LOCK_NB);  // where a file system has no locks, a left file is found by its end alone
}

bool LogWriter::write(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size) noexcept {
  if (fd_ < 0 || given_up_) return false;
  if (channel.empty() || channel.size() > LogReader::kMaxChannel || size > LogReader::kMaxData) {
    say_error("an event is too large for a log");
    give_up();
    return false;
  }
  const size_t at = buffer_.size(), length = LogReader::kHeader + channel.size() + size;
  try {
    if (at + length > kMostHeld) throw std::bad_alloc();
    buffer_.resize(at + length);
    lengths_.push_back(uint32_t(length));
  } catch (const std::bad_alloc&) {  // the disk has refused for long, and now there is no room here either
    buffer_.resize(at);
    give_up();
    return false;
  }
  put_event(buffer_.data() + at, events_, time_us, channel, data, size);
  ++events_;
  const bool late = time_us - flushed_us_ >= kFlushUs || time_us < flushed_us_;
  if (late || (buffer_.size() >= kFlushBytes && error_.empty())) {
    flushed_us_ = time_us;
    return flush();
  }
  return error_.empty();
}

void LogWriter::write_first_again(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size) {
  if (!flush()) return;
  std::vector<uint8_t> event(LogReader::kHeader + channel.size() + size);
  put_event(event.data(), 0, time_us, channel, data, size);
  [[maybe_unused]] const ssize_t n = ::pwrite(fd_, event.data(), event.size(), 0);  // same bytes, same room
}

bool LogWriter::flush() noexcept {
  if (fd_ < 0 || given_up_) return false;
  bring_back();
  size_t done = 0;
  if (const int e = write_all(fd_, buffer_.data(), buffer_.size(), done)) {
    refused(e, done);
    return false;
  }
  file_bytes_ += int64_t(done);
  buffer_.clear();
  lengths_.clear();
  error_.clear();
  return true;
}

// Keeps whole events only in the file, so that it stays one that anybody can play; the others wait.
void LogWriter::refused(int error_number, size_t done) noexcept {
  size_t whole = 0, kept = 0;
  while (kept < lengths_.size() && whole + lengths_[kept] <= done) whole += lengths_[kept++];
  file_bytes_ += int64_t(whole);
  buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(whole));
  lengths_.erase(lengths_.begin(), lengths_.begin() + std::ptrdiff_t(kept));
  // A device such as /dev/full cannot be shortened; there is nothing to keep there either.
  if (regular_ && ::ftruncate(fd_, file_bytes_) != 0 && done > whole) give_up();
  if (!regular_ || ::lseek(fd_, file_bytes_, SEEK_SET) < 0) give_up();
  char kept_words[64];
  std::snprintf(kept_words, sizeof kept_words, "); the %lld events before that are kept",
                static_cast<long long>(events_ - int64_t(lengths_.size())));
  say_error("cannot be written (", std::strerror(error_number), kept_words);
  if (!given_up_) return;
  events_ -= int64_t(lengths_.size());
  buffer_.clear(), lengths_.clear();
}

void LogWriter::say_error(const char* what, const char* more, const char* end) noexcept {
  try {
    error_ = path_ + ": " + what + more + end;
  } catch (const std::bad_alloc&) {
    error_ = "no memory";  // short enough to need none
  }
}

void LogWriter::bring_back() noexcept {
  struct stat st {};
  if (!regular_ || fstat(fd_, &st) != 0 || st.st_nlink > 0) return;
  namespace fs = std::filesystem;
  try {
    std::error_code ec;
    const fs::path old(path_),
        aside = fs::temp_directory_path(ec) / (old.stem().string() + "-" + std::to_string(getpid()) + ".lcm");
    for (const fs::path& to : {old, aside}) {
      if (to.has_parent_path()) fs::create_directories(to.parent_path(), ec);
      const int fd = ::open(to.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_EXCL, 0666);
      if (fd < 0) continue;
      if (copy_contents(fd_, fd) != 0) {
        ::close(fd);
        ::unlink(to.c_str());
        continue;
      }
      flock(fd, LOCK_EX | LOCK_NB);
      ::close(fd_);
      fd_ = fd, path_ = to.string();
      return;
    }
    // Nowhere: what is written goes on into the file without a name, and is tried again.
  } catch (const std::bad_alloc&) {
  }
}

bool LogWriter::close() noexcept {
  if (fd_ < 0) return error_.empty();
  if (!given_up_) flush();
  struct stat st {};
  if (regular_ && fstat(fd_, &st) == 0 && st.st_nlink == 0 && error_.empty())
    say_error("was removed, and there is no room to make it again");
  const auto failed = [&](const char* what) {
    if (error_.empty()) say_error(what, std::strerror(errno), ")");
  };
  if (regular_ && ::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) failed("cannot be brought to the disk (");
  if (::close(fd_) != 0) failed("cannot be closed (");
  fd_ = -1;
  return error_.empty();
}

}  // namespace limberg
