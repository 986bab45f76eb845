#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "devices/big_endian.h"
#include "devices/lcm_log.h"
#include "sim/base/error.h"

namespace limberg {

namespace {
constexpr int64_t kFlushUs = 500'000;
constexpr size_t kFlushBytes = 256 * 1024;

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
}  // namespace

void LogWriter::open(const std::string& path, bool replace) {
  close();
  path_ = path;
  error_.clear();
  buffer_.clear();
  lengths_.clear();
  events_ = flushed_us_ = file_bytes_ = 0;
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (replace ? O_TRUNC : O_EXCL), 0666);
  if (fd_ < 0 && errno == EEXIST)
    throw InputError(path, 0, "exists already; expected a new file name (an existing recording is never overwritten)");
  if (fd_ < 0)
    throw InputError(path, 0,
                     std::string("cannot be created (") + std::strerror(errno) + "); expected a writable place");
}

bool LogWriter::write(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size) {
  if (fd_ < 0 || !error_.empty()) return false;
  if (channel.empty() || channel.size() > LogReader::kMaxChannel || size > LogReader::kMaxData) {
    error_ = path_ + ": an event is too large for a log";
    return false;
  }
  const size_t at = buffer_.size(), length = LogReader::kHeader + channel.size() + size;
  buffer_.resize(at + length);
  put_event(buffer_.data() + at, events_, time_us, channel, data, size);
  lengths_.push_back(uint32_t(length));
  ++events_;
  if (buffer_.size() >= kFlushBytes || time_us - flushed_us_ >= kFlushUs || time_us < flushed_us_) {
    flushed_us_ = time_us;
    return flush();
  }
  return true;
}

void LogWriter::write_first_again(int64_t time_us, std::string_view channel, const uint8_t* data, size_t size) {
  if (!flush()) return;
  std::vector<uint8_t> event(LogReader::kHeader + channel.size() + size);
  put_event(event.data(), 0, time_us, channel, data, size);
  [[maybe_unused]] const ssize_t n = ::pwrite(fd_, event.data(), event.size(), 0);  // same bytes, same room
}

bool LogWriter::flush() {
  if (fd_ < 0 || !error_.empty()) return false;
  size_t done = 0;
  int failed = 0;
  while (done < buffer_.size() && failed == 0) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n > 0)
      done += size_t(n);
    else if (n == 0)
      failed = ENOSPC;
    else if (errno != EINTR)
      failed = errno;
  }
  if (failed != 0) {
    // Keep whole events only, so that the log stays one that anybody can play.
    size_t whole = 0, kept = 0;
    while (kept < lengths_.size() && whole + lengths_[kept] <= done) whole += lengths_[kept++];
    events_ -= int64_t(lengths_.size() - kept);
    // A device such as /dev/full cannot be shortened; there is nothing to keep there either.
    if (::ftruncate(fd_, file_bytes_ + int64_t(whole)) == 0) ::lseek(fd_, 0, SEEK_END);
    file_bytes_ += int64_t(whole);
    error_ = path_ + ": cannot be written (" + std::strerror(failed) + "); the " + std::to_string(events_) +
             " events before that are kept";
  } else {
    file_bytes_ += int64_t(done);
  }
  buffer_.clear();
  lengths_.clear();
  return failed == 0;
}

bool LogWriter::close() {
  if (fd_ < 0) return error_.empty();
  flush();
  if (::close(fd_) != 0 && error_.empty()) error_ = path_ + ": cannot be closed (" + std::strerror(errno) + ")";
  fd_ = -1;
  return error_.empty();
}

}  // namespace limberg
