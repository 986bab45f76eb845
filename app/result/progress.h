#pragma once
// How far long work has come, on one line of a terminal; nothing in a pipe.
#include <cstdint>
#include <string>

namespace limberg {

class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// At most ten times a second; `total` <= 0: unknown.
  void show(double done, double total, const char* unit);
  /// A text instead of figures.
  void note(const std::string& text);
  void clear();

 private:
  std::string label_;
  bool terminal_, shown_ = false;
  int64_t last_ns_ = 0;
};

/// A line on stderr for the user, "limberg: ...", whatever is shown at the time.
void say(const std::string& line);

}  // namespace limberg
