#include "app/result/progress.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "app/program/shown.h"
#include "app/session/clock.h"

namespace limberg {

Progress::Progress(std::string label) : Progress(std::move(label), STDERR_FILENO, kLogEvery_ns) {}

Progress::Progress(std::string label, int to, int64_t log_every_ns)
    : label_(std::move(label)),
      to_(to),
      log_every_ns_(log_every_ns),
      last_ns_(RealClock::monotonic_ns()),
      place_(place_of(to)) {}

Progress::Place Progress::place_of(int to) {
  if (isatty(to) == 1) return Place::terminal;
  struct stat st {};
  return fstat(to, &st) == 0 && S_ISREG(st.st_mode) ? Place::log : Place::nowhere;
}

/// Whether enough time has passed since the last words.
bool Progress::due() {
  if (place_ == Place::nowhere) return false;
  const int64_t now = RealClock::monotonic_ns(), every = place_ == Place::log ? log_every_ns_ : 100 * kNsPerMs;
  if ((shown_ || place_ == Place::log) && now - last_ns_ < every) return false;
  last_ns_ = now;
  return true;
}

void Progress::write(const std::string& words) {
  const std::string text = place_ == Place::log ? "limberg: " + label_ + ": " + shown(words) + "\n"
                                                : "\r" + label_ + "  " + shown(words) + "\033[K";
  shown_ = place_ == Place::terminal;
  [[maybe_unused]] const ssize_t n = ::write(to_, text.data(), text.size());  // words that are lost are no loss
}

void Progress::show(double done, double total, const char* unit) {
  if (!due()) return;
  // Whole things are counted, seconds and megabytes have tenths.
  write(total > 0 ? fmt::format("{:.{}f} of {:.{}f} {}  {:3.0f} %", done, int(done != std::round(done)), total,
                                int(total != std::round(total)), unit, 100 * done / total)
                  : fmt::format("{:.1f} {}", done, unit));
}

void Progress::note(const std::string& text) {
  if (place_ == Place::terminal || due()) write(text);
}

void Progress::clear() {
  if (!shown_) return;
  [[maybe_unused]] const ssize_t n = ::write(to_, "\r\033[K", 4);
  shown_ = false;
}

void say(const std::string& line) {
  if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
  std::fprintf(stderr, "limberg: %s\n", shown(line).c_str());
}

}  // namespace limberg
