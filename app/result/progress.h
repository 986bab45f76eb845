#pragma once
// How far long work has come: on one line of a terminal; in a file that standard error goes to, a log, a line every ten
// seconds; nothing in a pipe.
#include <cstdint>
#include <string>

namespace limberg {

class Progress {
 public:
  static constexpr int64_t kLogEvery_ns = 10'000'000'000;

  explicit Progress(std::string label);
  /// Shown on this file descriptor instead of standard error; into a log every so many ns.
  Progress(std::string label, int to, int64_t log_every_ns);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// At most ten times a second; `total` <= 0: unknown.
  void show(double done, double total, const char* unit);
  /// A text instead of figures.
  void note(const std::string& text);
  void clear();

 private:
  enum class Place : uint8_t { terminal, log, nowhere };
  static Place place_of(int to);
  bool due();
  void write(const std::string& words);

  std::string label_;
  int to_;
  int64_t log_every_ns_, last_ns_;
  Place place_;
  bool shown_ = false;
};

/// A line on stderr for the user, "limberg: ...", whatever is shown at the time.
void say(const std::string& line);

}  // namespace limberg
