// How far the tip of the stylus went in a recording.
//
//   hand_path recordings/rhomboid.lcm
#include <fmt/core.h>

#include "devices/recording.h"
#include "sim/base/error.h"

int main(int argc, char** argv) try {
  using namespace limberg;
  if (argc < 2) {
    fmt::print(stderr, "hand_path RECORDING\n");
    return 2;
  }
  const Recording r = read_recording(argv[1]);
  double path_mm = 0;
  int64_t readings = 0;
  const StylusSample* last = nullptr;
  for (const Sample& s : r.samples)
    if (const auto* now = std::get_if<StylusSample>(&s)) {
      if (last) path_mm += (now->tip_mm - last->tip_mm).norm();
      last = now, ++readings;
    }
  fmt::print("{} readings, {:.1f} mm\n", readings, path_mm);
} catch (const limberg::InputError& e) {
  fmt::print(stderr, "hand_path: {}\n", e.what());
  return 2;
}
