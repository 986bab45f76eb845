#pragma once
// Finished trials of a sweep in a file: a line that names the scene and the kind of sweep, then one line per trial,
// with tabs between its numbers. A sweep that was stopped goes on behind them.
#include <map>
#include <string>
#include <vector>

#include "app/operating_point/accuracy.h"

namespace limberg::bench {

/// The trials of the sweep `title`; none when the text is of another one. A line that was cut off is no trial.
std::vector<AccuracyTrial> parse_kept_trials(const std::string& text, const std::string& title);
/// As a line of the file, with its end.
std::string kept_line(const AccuracyTrial& trial);

class KeptTrials {
 public:
  /// Takes what the file holds of this sweep, and begins the file anew where it is of another one. An empty name:
  /// nothing is kept. InputError: the file cannot be read or written.
  KeptTrials(const std::string& file, const std::string& title);
  const AccuracyTrial* find(const AccuracyTrial& trial) const;
  void add(const AccuracyTrial& trial) const;

 private:
  std::string file_;
  std::map<std::string, AccuracyTrial> trials_;
};

}  // namespace limberg::bench
