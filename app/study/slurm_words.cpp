#include "app/study/slurm_words.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <sstream>

namespace limberg::study {

namespace {

bool waits_as_usual(const std::string& reason) {
  constexpr const char* kUsual[] = {"", "None", "Priority", "Resources", "JobArrayTaskLimit", "BeginTime", "Prolog"};
  return std::find(std::begin(kUsual), std::end(kUsual), reason) != std::end(kUsual);
}

}  // namespace

Queue read_queue(const std::string& text) {
  Queue q;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t bar = line.find('|');
    if (bar == std::string::npos || bar == 0) continue;
    const std::string state = line.substr(0, bar), reason = line.substr(bar + 1);
    if (state != "PD") {
      ++q.running;
      continue;
    }
    ++q.waiting;
    if (!waits_as_usual(reason) && q.held.empty()) q.held = reason.substr(0, 80);
  }
  return q;
}

int read_max_array(const std::string& text) {
  constexpr int kDefault = 1001;
  const std::string key = "MaxArraySize";
  size_t at = text.find(key);
  if (at == std::string::npos) return kDefault;
  at = text.find_first_not_of(" \t=", at + key.size());
  if (at == std::string::npos) return kDefault;
  int value = 0;
  const auto r = std::from_chars(text.data() + at, text.data() + text.size(), value);
  return r.ec == std::errc() && value > 0 ? value : kDefault;
}

std::string read_job(const std::string& text) {
  const size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
  return text.substr(0, end);
}

}  // namespace limberg::study
