#include "app/result/progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "app/program/shown.h"
#include "app/session/clock.h"

namespace limberg {

Progress::Progress(std::string label) : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(double done, double total, const char* unit) {
  if (!terminal_) return;
  const int64_t now = RealClock::monotonic_ns();
  if (shown_ && now - last_ns_ < 100 * kNsPerMs) return;
  last_ns_ = now;
  shown_ = true;
  if (total > 0)  // whole things are counted, seconds and megabytes have tenths
    std::fprintf(stderr, "\r%s  %.*f of %.*f %s  %3.0f %%\033[K", label_.c_str(), done != std::round(done), done,
                 total != std::round(total), total, unit, 100 * done / total);
  else
    std::fprintf(stderr, "\r%s  %.1f %s\033[K", label_.c_str(), done, unit);
  std::fflush(stderr);
}

void Progress::note(const std::string& text) {
  if (!terminal_) return;
  shown_ = true;
  std::fprintf(stderr, "\r%s  %s\033[K", label_.c_str(), shown(text).c_str());
  std::fflush(stderr);
}

void Progress::clear() {
  if (!shown_) return;
  std::fputs("\r\033[K", stderr);
  shown_ = false;
}

void say(const std::string& line) {
  if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
  std::fprintf(stderr, "limberg: %s\n", shown(line).c_str());
}

}  // namespace limberg
