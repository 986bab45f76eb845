#pragma once
// Entry points for fuzzers: bytes from outside, given to what reads them. libFuzzer calls them (fuzzer.cpp,
// ./do fuzz); an ordinary test runs each over its sound inputs, over damaged ones and over its
// corpus (test_entries.cpp), and another finds what reads bytes and has no entry (test_readers_covered.cpp).
//
// A reader may refuse the bytes, with an InputError that names the file and gives a reason, or take them and hand over
// something sound. Anything else is a fault.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace limberg::fuzz {

struct Entry {
  std::string name;                // "OBJ", "calibration", "packet_stylus": also its folder below tests/fuzz/corpus
  std::vector<std::string> reads;  // the files of the tree whose reading it is
  std::vector<std::string> sound;  // what is taken
  /// What is wrong; empty: nothing. `taken` says whether the bytes were accepted.
  std::function<std::string(std::string_view bytes, bool& taken)> run;
};

std::vector<Entry> entries();

/// tests/fuzz/corpus/NAME of the source tree.
std::string corpus_of(const Entry& entry);

}  // namespace limberg::fuzz
