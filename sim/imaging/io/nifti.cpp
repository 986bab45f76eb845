#include "sim/imaging/io/nifti.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/io/header.h"

namespace limberg::imaging {
namespace {

constexpr size_t kHeader = 348;

bool is_gzip(std::string_view s) { return s.size() > 2 && uint8_t(s[0]) == 0x1f && uint8_t(s[1]) == 0x8b; }

/// As much of the beginning as can be had, at most `most` bytes; never throws.
std::string beginning(std::string_view in, size_t most) {
  z_stream z{};
  if (inflateInit2(&z, 15 + 32) != Z_OK) return {};
  std::string out(most, 0);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data())),
  z.avail_in = uInt(std::min<size_t>(in.size(), size_t(1) << 30));
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(most);
  inflate(&z, Z_NO_FLUSH);
  out.resize(most - z.avail_out);
  inflateEnd(&z);
  return out;
}

class Fields {
 public:
  Fields(std::string_view s, bool swap) : s_(s), swap_(swap) {}
  template <class T>
  T at(size_t offset) const {
    char b[sizeof(T)];
    std::memcpy(b, s_.data() + offset, sizeof(T));
    if (swap_) std::reverse(b, b + sizeof(T));
    T v;
    std::memcpy(&v, b, sizeof(T));
    return v;
  }

 private:
  std::string_view s_;
  bool swap_;
};

bool is_header(std::string_view h, bool& swap) {
  if (h.size() < kHeader) return false;
  const std::string_view magic = h.substr(344, 4);
  if (magic != std::string_view("n+1\0", 4) && magic != std::string_view("ni1\0", 4)) return false;
  swap = Fields(h, false).at<int32_t>(0) != 348;
  return Fields(h, swap).at<int32_t>(0) == 348;
}

Mat3 rotation(double b, double c, double d) {
  const double aa = 1 - b * b - c * c - d * d;
  double a = aa > 0 ? std::sqrt(aa) : 0;
  if (aa < 1e-7) {  // a half turn: b, c, d are made to unit length
    const double l = std::sqrt(b * b + c * c + d * d);
    if (l > 0) b /= l, c /= l, d /= l;
    a = 0;
  }
  Mat3 R;
  R << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),  //
      2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),   //
      2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c;
  return R;
}

}  // namespace

bool looks_like_nifti(std::string_view head) {
  bool swap = false;
  if (is_header(head, swap)) return true;
  return is_gzip(head) && is_header(beginning(head, kHeader), swap);
}

Volume load_nifti(const std::string& path) {
  const std::string start = read_beginning(path, VolumeLimits::header_bytes, "a volume");
  const bool packed = is_gzip(start);
  const std::string head = packed ? beginning(start, kHeader) : start.substr(0, kHeader);
  bool swap = false;
  if (!is_header(head, swap))
    throw InputError(path, 0, "is no NIfTI-1 file; expected a header of 348 bytes that ends in n+1 or ni1");
  const Fields f(head, swap);
  const int dims = f.at<int16_t>(40);
  if (dims < 3 || dims > 7)
    throw InputError(path, 0, "the volume has " + std::to_string(dims) + " dimensions; 3 were expected");
  std::array<int64_t, 3> size;
  for (size_t k = 0; k < 3; ++k) size[k] = f.at<int16_t>(42 + 2 * k);
  for (int k = 3; k < dims; ++k)
    if (f.at<int16_t>(42 + 2 * size_t(k)) > 1)
      throw InputError(path, 0, "the file holds a series of volumes; one volume was expected");
  Number number = Number::u8;
  switch (const int type = f.at<int16_t>(70)) {
    case 2:
      number = Number::u8;
      break;
    case 4:
      number = Number::i16;
      break;
    case 8:
      number = Number::i32;
      break;
    case 16:
      number = Number::f32;
      break;
    case 64:
      number = Number::f64;
      break;
    case 256:
      number = Number::i8;
      break;
    case 512:
      number = Number::u16;
      break;
    case 768:
      number = Number::u32;
      break;
    default:
      throw InputError(path, 0,
                       "numbers of NIfTI type " + std::to_string(type) +
                           " are not read; expected integers of 8 to 32 bits, float or double");
  }
  if (f.at<int16_t>(72) != int16_t(8 * bytes_of(number)))
    throw InputError(path, 0, "the bits of a voxel do not go with its type");
  double unit = 1;
  switch (head[123] & 7) {
    case 1:
      unit = 1000;
      break;
    case 3:
      unit = 1e-3;
      break;
    default:
      break;
  }
  double spacing[3];
  for (size_t k = 0; k < 3; ++k) spacing[k] = double(f.at<float>(80 + 4 * k));
  Mat3 step = Vec3(spacing[0], spacing[1], spacing[2]).asDiagonal();
  Vec3 origin = Vec3::Zero();
  if (f.at<int16_t>(254) > 0) {
    for (int r = 0; r < 3; ++r) {
      for (int k = 0; k < 3; ++k) step(r, k) = double(f.at<float>(280 + size_t(16 * r + 4 * k)));
      origin[r] = double(f.at<float>(280 + size_t(16 * r + 12)));
    }
  } else if (f.at<int16_t>(252) > 0) {
    const double handed = f.at<float>(76) < 0 ? -1 : 1;
    step = rotation(double(f.at<float>(256)), double(f.at<float>(260)), double(f.at<float>(264))) *
           Vec3(spacing[0], spacing[1], handed * spacing[2]).asDiagonal();
    for (int r = 0; r < 3; ++r) origin[r] = double(f.at<float>(268 + size_t(4 * r)));
  }
  if (!step.allFinite() || !origin.allFinite())
    throw InputError(path, 0, "the place of the volume must be given by finite numbers");
  Volume v;
  const Vec3 turn(-unit, -unit, unit);
  v.step_mm = turn.asDiagonal() * step, v.origin_mm = turn.cwiseProduct(origin);
  const auto voxels = size_t(check_extent(size, v.step_mm, path));
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t(size[k]);
  const float offset = f.at<float>(108);
  const bool pair = head[345] == 'i';
  if (!(offset >= 0 && offset <= 1e9f) || (!pair && offset < 352))
    throw InputError(path, 0, "the data do not begin behind the header: vox_offset is " + std::to_string(offset));
  std::string data_file = path;
  if (pair) {
    const std::filesystem::path p(path);
    data_file = (p.extension() == ".gz" ? p.parent_path() / p.stem().replace_extension(".img.gz")
                                        : std::filesystem::path(p).replace_extension(".img"))
                    .string();
  }
  NumberBlock block;
  block.packed = is_gzip(read_beginning(data_file, 3, "the data of a volume"));
  (block.packed ? block.skip_plain : block.at) = size_t(offset);
  block.number = number, block.count = voxels;
  block.big_endian = swap == (std::endian::native == std::endian::little);
  v.value = read_numbers(data_file, block);
  const float slope = f.at<float>(112), inter = f.at<float>(116);
  if (!std::isfinite(slope) || !std::isfinite(inter))
    throw InputError(path, 0, "the scale of the numbers is not finite");
  if (slope != 0)
    for (float& x : v.value) {
      x = slope * x + inter;
      if (!std::isfinite(x)) throw InputError(path, 0, "a voxel holds no finite number once it is scaled");
    }
  return v;
}

}  // namespace limberg::imaging
