#pragma once
// Entry points for fuzzers: bytes from outside, given to what reads them. libFuzzer calls them (fuzzer.cpp, CMake
// option LIMBERG_FUZZERS); an ordinary test runs each over its sound inputs and over damaged ones (test_entries.cpp).
//
// A reader may refuse the bytes, with an InputError that names the file and gives a reason, or take them and hand over
// something sound. Anything else is a fault.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace limberg::fuzz {

struct Entry {
  std::string name;                // "obj", "dicom_2", "packet_stylus"
  std::vector<std::string> sound;  // the corpus to begin with
  /// What is wrong; empty: nothing. `taken` says whether the bytes were accepted.
  std::function<std::string(std::string_view bytes, bool& taken)> run;
};

/// Images, surfaces, meshes, scenes, scripts, recordings; packets of the network, lines of the tracker.
std::vector<Entry> entries();

}  // namespace limberg::fuzz
