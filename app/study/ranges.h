#pragma once
// What is not known of a tissue: for each parameter of a study a distribution, with where it comes from. TOML files;
// app/study/ranges/facial-skin.toml is the shipped one, and says what a file may hold.
#include <string>
#include <vector>

#include "app/study/study.h"

namespace limberg::study {

enum class Spread { uniform, log_uniform, normal, log_normal, whole };

struct Distribution {
  std::string parameter, source;
  Spread spread = Spread::uniform;
  double low = 0, high = 1;  // its ends; of the normal ones its 5 % and 95 % quantiles

  /// The value that a share u of 0 to 1 lies below; u is kept 1e-6 off both ends.
  double quantile(double u) const;
  std::string words() const;  // "log-normal, 20 to 180 for nine in ten"
};

struct Ranges {
  std::string name, note;
  std::vector<Distribution> parameters;
};

/// InputError with file and line: no such parameter in the family, ends out of its range or the wrong way round, an
/// unknown distribution, no source.
Ranges parse_ranges(const std::string& text, const std::string& path, const Family& family);
/// Of a file, or of a shipped one by its name. InputError with the place that was looked at.
Ranges load_ranges(const std::string& name_or_path, const Family& family);

}  // namespace limberg::study
