#pragma once
// Streams of a hand whose truth is known, for the recordings that are shipped and for rehearsals:
//
//   glove    forefinger and thumb of a glove: points down at the skin, closes, carries 25 mm, opens; twice
//   cursor   a stylus at 0.25 gain pushes the surface cursor round a flap, scalpel in hand
//   tremor   a stylus cuts a straight line of 60 mm with a strong tremor, a damaged line and gaps
//   force    a force device in a hand presses and strokes (readings at 1 kHz)
//   pivot, touch, open   what a user does to calibrate a stylus, the world, a glove
//   forefinger, thumb   the tip held on a place while the hand turns; pointing: the forefinger points at one place
//   metal    as touch, on a grid of points in a field that metal bends: for the correction of distortion
#include <cstdint>
#include <string>
#include <vector>

#include "devices/lcm_log.h"
#include "devices/sample.h"

namespace limberg {

struct KnownStream {
  std::vector<Sample> samples;
  std::string truth_csv;        // t_s, then what is known of that moment; the first line names the columns
  std::string truth;            // in words, a line
  std::vector<Vec3> points_mm;  // touch: what was touched
};

/// InputError: an unknown name.
KnownStream known_stream(const std::string& name, uint64_t seed);

/// A plain stream on its way into a file, sample by sample: what
/// `limberg calibrate` reads. InputError as LogWriter::open.
class StreamWriter {
 public:
  StreamWriter(const std::string& path, bool replace);
  void write(const Sample& sample);
  /// InputError when the disk refused something.
  void close();
  int64_t samples() const { return log_.events(); }

 private:
  std::string path_;
  LogWriter log_;
  int64_t last_us_ = 0;
};

/// A plain stream: a log of samples without a session. InputError as LogWriter::open.
void write_stream(const std::string& path, const std::vector<Sample>& samples, bool replace);

}  // namespace limberg
