#include "app/program/shown.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace limberg {
namespace {

constexpr char kC1 = '\xC2';  // leads U+0080 to U+00BF in UTF-8

bool commands(char c) { return (static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t') || c == 127; }
bool is_c1(char c) { return static_cast<unsigned char>(c) >= 0x80 && static_cast<unsigned char>(c) < 0xA0; }

/// A character's first byte waits here for its second.
struct Filter {
  bool led = false;
  void add(char c, std::string& out) {
    if (led && !is_c1(c)) out += kC1;
    if (c == kC1) {
      led = true;
      return;
    }
    out += commands(c) || (led && is_c1(c)) ? '?' : c;
    led = false;
  }
  void end(std::string& out) {
    if (led) out += kC1;
    led = false;
  }
};

bool write_all(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(size_t(n));
  }
  return true;
}

ssize_t put(void* filter, const char* bytes, size_t n) {
  std::string out;
  for (size_t i = 0; i < n; ++i) static_cast<Filter*>(filter)->add(bytes[i], out);
  return write_all(out) ? ssize_t(n) : 0;  // 0: stdio marks the error
}

int end(void* filter) {
  std::string out;
  static_cast<Filter*>(filter)->end(out);
  return write_all(out) ? 0 : EOF;
}

}  // namespace

std::string shown(std::string_view text) {
  std::string out;
  Filter filter;
  for (const char c : text) filter.add(c, out);
  filter.end(out);
  return out;
}

void show_standard_output() {
  static Filter filter;  // as long as stdout
  std::FILE* const filtered = fopencookie(&filter, "w", {nullptr, put, nullptr, end});
  if (!filtered) return;
  if (isatty(STDOUT_FILENO) == 1) std::setvbuf(filtered, nullptr, _IOLBF, BUFSIZ);
  std::fflush(stdout);
  stdout = filtered;
}

}  // namespace limberg
