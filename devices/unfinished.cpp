#include "devices/unfinished.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "devices/message_codec.h"
#include "devices/recording.h"
#include "sim/base/hash.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

constexpr size_t kEnd = 128 * 1024, kMostFiles = 200;

/// First event and last bytes of a file; closes it with itself.
struct Ends {
  explicit Ends(const std::string& file) : fd(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    struct stat st {};
    if (fd < 0 || fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) return;
    first = part(0, std::min<size_t>(size_t(st.st_size), 4096));
    last = part(st.st_size - std::min<off_t>(st.st_size, kEnd), kEnd);
  }
  ~Ends() {
    if (fd >= 0) ::close(fd);
  }
  Ends(const Ends&) = delete;
  Ends& operator=(const Ends&) = delete;
  std::vector<uint8_t> part(off_t from, size_t most) const {
    std::vector<uint8_t> bytes(most);
    const ssize_t n = ::pread(fd, bytes.data(), most, from);
    bytes.resize(size_t(std::max<ssize_t>(0, n)));
    return bytes;
  }
  int fd;
  std::vector<uint8_t> first, last;
};

struct Beginning {
  bool session = false;
  int64_t time_us = 0;
  uint64_t mark = 0, goes_on_with = 0;
};

Beginning beginning(std::vector<uint8_t> bytes) {
  Beginning b;
  LogReader log(std::move(bytes));
  LogEvent e;
  limberg_msg::session_t m;
  if (!log.next(e) || e.channel != kSessionChannel || decode_message(e.data, e.size, m)) return b;
  b.session = true, b.time_us = m.utc_start_ns / 1000, b.goes_on_with = uint64_t(m.seeds[SessionInfo::kGoesOnWith]);
  Hash64 h;
  h.bytes(e.data, e.size);
  b.mark = std::max<uint64_t>(1, h.value());
  return b;
}

/// What the end of a file says, beside what its beginning does.
std::optional<UnfinishedRecording> look(const std::string& file, const Ends& ends, const Beginning& begin) {
  if (!begin.session || flock(ends.fd, LOCK_SH | LOCK_NB) != 0) return std::nullopt;
  LogReader log(ends.last);
  int64_t time_us = begin.time_us;
  for (LogEvent e; log.next(e); time_us = e.time_us)
    if (e.channel == kEndChannel) return std::nullopt;
  return UnfinishedRecording{file, double(std::max<int64_t>(0, time_us - begin.time_us)) * 1e-6};
}

}  // namespace

std::optional<UnfinishedRecording> unfinished_recording(const std::string& file) {
  const Ends ends(file);
  return look(file, ends, beginning(ends.first));
}

std::optional<UnfinishedRecording> longest_unfinished(const std::string& folder) {
  std::vector<std::pair<UnfinishedRecording, uint64_t>> left;
  std::set<uint64_t> gone_on_with;
  std::error_code ec;
  size_t files = 0;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end && files < kMostFiles; it.increment(ec)) {
    if (it->path().extension() != ".lcm") continue;
    ++files;
    const std::string file = it->path().string();
    const Ends ends(file);
    const Beginning begin = beginning(ends.first);
    if (begin.goes_on_with != 0) gone_on_with.insert(begin.goes_on_with);
    if (auto u = look(file, ends, begin)) left.emplace_back(*u, begin.mark);
  }
  std::erase_if(left, [&](const auto& l) { return gone_on_with.contains(l.second); });
  const auto longest = std::max_element(left.begin(), left.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.length_s, a.first.file) < std::pair(b.first.length_s, b.first.file);
  });
  if (longest == left.end()) return std::nullopt;
  return longest->first;
}

uint64_t recording_mark(const std::string& file) { return beginning(Ends(file).first).mark; }

}  // namespace limberg
