#pragma once
// `limberg bench fuzz --readers`: damaged files against every reader of images, surfaces, meshes and scenes.
//
// A case is one sound file (sound_files.h) that was hit: bits, bytes and stretches changed, lost, doubled or cut off,
// numbers of a text replaced by absurd ones, lengths and counts in binary headers blown up; of a series also slices
// missing, doubled or of another one. The reader must
// refuse it with an InputError that names the file and gives a reason, or take it and hand over something sound. Cases
// run in a child process whose memory is limited, so that a crash, a loop without end or memory asked for because a
// header claims it is a violation with a number, not the end of the run: `signal`, `time` or `memory`.
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/operating_point/bench.h"

namespace limberg::bench {

/// A sound file, or several that belong together; what is opened is one of them, or (open empty) their folder.
struct SoundFiles {
  std::vector<std::pair<std::string, std::string>> file;  // name, content
  std::string open;
};

struct Reader {
  std::string name;
  std::vector<SoundFiles> sound;
  /// Reads; throws what the reader throws. What it returns: empty, or what is unsound in what was taken.
  std::function<std::string(const std::string& path)> read;
};

/// Every reader of the program: NRRD, MetaImage, NIfTI, DICOM, PLY, STL, OBJ, xyz, simplex meshes, scenes.
std::vector<Reader> readers();

/// What is wrong with how a file was refused (the words of the InputError); empty: nothing.
std::string fault_of_refusal(const std::string& what, const std::string& file);

struct ReadersFuzzSettings {
  int64_t cases = 100'000;  // over all readers
  uint64_t seed = 1;
  std::string out_dir;                      // the files of violations are kept here; empty: nowhere
  int64_t most_bytes = int64_t(256) << 20;  // of memory beyond what the process has; the sound files are below 2 kB
  int most_s = 5;                           // of CPU time for one case
  std::function<void(const std::string&)> progress;  // empty: silent
};

struct ReadersFuzzReport {
  struct Family {
    std::string name;
    int64_t cases = 0, taken = 0, refused = 0, violations = 0;
    double cpu_ms = 0, slowest_ms = 0;
  };
  std::vector<Family> family;
  std::vector<std::string> violation;  // the first ones: reader, case, what
  uint64_t seed = 0;
  int64_t cases() const;
  int64_t violations() const;
  Result result() const;
};

/// Throws InputError when no child process or no temporary folder is to be had.
ReadersFuzzReport readers_fuzz(const ReadersFuzzSettings& settings, const std::vector<Reader>& readers);

}  // namespace limberg::bench
