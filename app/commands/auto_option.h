#pragma once
// --auto of run and replay: the session works with the cell size and the iterations that fit a frame
// (app/operating_point/operating_point.h).
#include <optional>
#include <string>

#include "app/operating_point/operating_point.h"

namespace CLI {
class App;
}

namespace limberg {

struct AutoOption {
  bool on = false;
  double budget_ms = 0;
  std::string file;  // result.json of bench accuracy; empty: measured now

  void add(CLI::App& command);
  /// Changes the scene, when asked to, and says so. Nothing when not asked to.
  std::optional<bench::OperatingPoint> apply(Scene& scene) const;
};

}  // namespace limberg
