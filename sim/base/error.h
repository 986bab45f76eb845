#pragma once
// What goes wrong with input. The program prints `limberg:
// FILE:LINE: what is wrong; what was expected` and exits with 2.
#include <stdexcept>
#include <string>

namespace limberg {

/// Thrown for any input that cannot be used: a file, a call, a script line. Never for a defect of the program.
class InputError : public std::runtime_error {
 public:
  InputError(std::string file, int line, const std::string& what_is_wrong)
      : std::runtime_error(format(file, line, what_is_wrong)), file_(std::move(file)), line_(line) {}
  const std::string& file() const { return file_; }
  int line() const { return line_; }  // 0: the file as a whole

 private:
  static std::string format(const std::string& file, int line, const std::string& what) {
    if (file.empty()) return what;
    std::string text = file;
    if (line > 0) text.append(":").append(std::to_string(line));
    return text.append(": ").append(what);
  }
  std::string file_;
  int line_;
};

}  // namespace limberg
