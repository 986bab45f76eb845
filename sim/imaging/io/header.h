#pragma once
// What the headers of both formats come to, and the reading of the data that they describe.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/text_rows.h"
#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

enum class Number { i8, u8, i16, u16, i32, u32, f32, f64 };
size_t bytes_of(Number n);

struct Header {
  std::array<int64_t, 3> size{0, 0, 0};
  std::optional<Number> number;
  Mat3 step_mm = Mat3::Identity();
  Vec3 origin_mm = Vec3::Zero();
  bool big_endian = false;
  bool compressed = false;
  std::string data_file;  // empty: after the header, in the same file
  int64_t skip = 0;       // bytes before the data; -1: the data are the last bytes of the file
  size_t data_at = 0;     // where the data begin in the header's own file
};

std::string_view trimmed(std::string_view s);
/// Numbers of a line; throws InputError naming `what`, unless there are `count` finite ones.
std::vector<double> numbers(std::string_view s, size_t count, const std::string& file, int line, const char* what);

Header nrrd_header(std::string_view text, const std::string& file);
Header meta_header(std::string_view text, const std::string& file);

/// Numbers in a file: where they begin, how they are written, how many.
struct NumberBlock {
  size_t at = 0;          // bytes before them
  bool at_end = false;    // the last ones of the file
  bool packed = false;    // with gzip or zlib
  size_t skip_plain = 0;  // bytes before them once unpacked
  Number number = Number::u8;
  bool big_endian = false;
  size_t count = 0;
};
/// Reads and unpacks piece by piece: beside the numbers no memory to speak of is used, and none is asked for where the
/// file cannot hold so many. InputError: cut short, damaged, a number that is not finite.
std::vector<float> read_numbers(const std::string& file, const NumberBlock& block);
/// InputError unless size and axes of a voxel are sensible (VolumeLimits); returns the number of voxels.
int64_t check_extent(const std::array<int64_t, 3>& size, const Mat3& step_mm, const std::string& file);

/// Checks sizes and steps and reads the numbers. `file`: of the header.
Volume read_data(const Header& header, const std::string& file);

}  // namespace limberg::imaging
