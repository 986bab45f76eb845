// The libFuzzer program: LIMBERG_FUZZ_ENTRY names the entry.
//
//   build-fuzz/limberg_fuzzer --entries                                  their names
//   LIMBERG_FUZZ_ENTRY=OBJ build-fuzz/limberg_fuzzer --corpus=CORPUS     writes the sound inputs there
//   LIMBERG_FUZZ_ENTRY=OBJ build-fuzz/limberg_fuzzer CORPUS -max_total_time=600
//
// ./do fuzz does it for all of them.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "tests/fuzz/entries.h"

namespace {

const limberg::fuzz::Entry& entry() {
  static const limberg::fuzz::Entry chosen = [] {
    const char* wanted = std::getenv("LIMBERG_FUZZ_ENTRY");
    for (auto& e : limberg::fuzz::entries())
      if (wanted && e.name == wanted) return e;
    std::fprintf(stderr, "limberg_fuzzer: LIMBERG_FUZZ_ENTRY names no entry; expected one of");
    for (const auto& e : limberg::fuzz::entries()) std::fprintf(stderr, " %s", e.name.c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }();
  return chosen;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
  constexpr std::string_view kCorpus = "--corpus=";
  for (int i = 1; i < *count; ++i) {
    const std::string_view word = (*words)[i];
    if (word == "--entries") {
      for (const auto& e : limberg::fuzz::entries()) std::printf("%s\n", e.name.c_str());
      std::exit(0);
    }
    if (!word.starts_with(kCorpus)) continue;
    const std::filesystem::path folder(word.substr(kCorpus.size()));
    std::filesystem::create_directories(folder);
    for (size_t k = 0; k < entry().sound.size(); ++k)
      std::ofstream(folder / (entry().name + "-" + std::to_string(k)), std::ios::binary) << entry().sound[k];
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  bool taken = false;
  const std::string fault = entry().run({reinterpret_cast<const char*>(data), size}, taken);
  if (fault.empty()) return 0;
  std::fprintf(stderr, "%s: %s\n", entry().name.c_str(), fault.c_str());
  std::abort();
}
