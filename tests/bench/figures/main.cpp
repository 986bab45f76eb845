// limberg_figures: docs/figures.md from results of benches.
//   limberg_figures FOLDER PAGE [--date DAY] [--remark TEXT] [RESULT.json ...]
#include <fmt/format.h>

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "tests/bench/figures/figures.h"

int main(int argc, char** argv) {
  using namespace limberg;
  try {
    bench::KeepOptions options;
    std::vector<std::string> places;
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--date" || word == "--remark") {
        if (i + 1 == argc) throw InputError("", 0, word + " has no value; expected one");
        (word == "--date" ? options.date : options.remark) = argv[++i];
      } else {
        places.push_back(word);
      }
    }
    if (places.size() < 2)
      throw InputError(
          "", 0, "limberg_figures wants two places; expected FOLDER PAGE [--date DAY] [--remark TEXT] [RESULT ...]");
    for (size_t i = 2; i < places.size(); ++i)
      fmt::print("kept {}\n", bench::keep_result(places[i], places[0], options));
    bench::write_page(places[0], places[1]);
    return 0;
  } catch (const InputError& e) {
    fmt::print(stderr, "limberg: {}\n", e.what());
    return 2;
  }
}
