#include "sim/imaging/io/volume.h"

#include <zlib.h>

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/io/dicom.h"
#include "sim/imaging/io/header.h"
#include "sim/imaging/io/nifti.h"

namespace limberg {
namespace imaging {

namespace {

constexpr size_t kMostOfOneByte = 1032;  // what deflate can make of it: 258 bytes of a length code of two bits
constexpr size_t kPart = size_t(1) << 20;

template <class T>
void convert(const char* in, size_t n, bool swap, std::vector<float>& out) {
  for (size_t i = 0; i < n; ++i) {
    char b[sizeof(T)];
    std::memcpy(b, in + i * sizeof(T), sizeof(T));
    if (swap) std::reverse(b, b + sizeof(T));
    T v;
    std::memcpy(&v, b, sizeof(T));
    out.push_back(float(v));
  }
}

/// Numbers out of bytes as these come, so that none of the bytes need be kept.
class Numbers {
 public:
  Numbers(const NumberBlock& block) : b_(block), swap_(block.big_endian != (std::endian::native == std::endian::big)) {}
  size_t wanted() const { return b_.skip_plain + b_.count * bytes_of(b_.number); }
  size_t came() const { return came_; }
  bool full() const { return came_ >= wanted(); }

  void add(std::string_view bytes) {
    bytes = bytes.substr(0, wanted() - came_);
    const size_t before = came_ < b_.skip_plain ? std::min(b_.skip_plain - came_, bytes.size()) : 0;
    came_ += bytes.size();
    bytes.remove_prefix(before);
    const size_t size = bytes_of(b_.number);
    while (!part_.empty() && !bytes.empty()) {  // a number that lies across two parts
      part_ += bytes.front(), bytes.remove_prefix(1);
      if (part_.size() == size) convert_whole(part_.data(), 1), part_.clear();
    }
    convert_whole(bytes.data(), bytes.size() / size);
    part_.append(bytes.substr(bytes.size() / size * size));
  }
  std::vector<float> take(const std::string& file) {
    for (const float f : out_)
      if (!std::isfinite(f)) throw InputError(file, 0, "a voxel holds no finite number");
    return std::move(out_);
  }

 private:
  void convert_whole(const char* in, size_t n) {
    if (n == 0) return;
    if (out_.empty()) out_.reserve(b_.count);
    switch (b_.number) {
      case Number::i8:
        return convert<int8_t>(in, n, swap_, out_);
      case Number::u8:
        return convert<uint8_t>(in, n, swap_, out_);
      case Number::i16:
        return convert<int16_t>(in, n, swap_, out_);
      case Number::u16:
        return convert<uint16_t>(in, n, swap_, out_);
      case Number::i32:
        return convert<int32_t>(in, n, swap_, out_);
      case Number::u32:
        return convert<uint32_t>(in, n, swap_, out_);
      case Number::f32:
        return convert<float>(in, n, swap_, out_);
      case Number::f64:
        return convert<double>(in, n, swap_, out_);
    }
  }

  NumberBlock b_;
  bool swap_;
  size_t came_ = 0;
  std::string part_;
  std::vector<float> out_;
};

void inflate_into(Numbers& numbers, OpenedFile& in, const std::string& file) {
  z_stream z{};
  if (inflateInit2(&z, 15 + 32) != Z_OK) throw InputError(file, 0, "cannot be decompressed");
  std::string fed(kPart, '\0'), out(kPart, '\0');
  int r = Z_OK;
  while (!numbers.full() && r != Z_STREAM_END) {
    if (z.avail_in == 0) {
      z.next_in = reinterpret_cast<Bytef*>(fed.data());
      z.avail_in = uInt(in.read(fed.data(), fed.size()));
    }
    z.next_out = reinterpret_cast<Bytef*>(out.data());
    z.avail_out = uInt(out.size());
    r = inflate(&z, Z_NO_FLUSH);
    numbers.add(std::string_view(out).substr(0, out.size() - z.avail_out));
    if (r != Z_OK && r != Z_STREAM_END) break;  // (also Z_BUF_ERROR: nothing more to read)
  }
  inflateEnd(&z);
  if (numbers.full()) return;
  throw InputError(file, 0,
                   std::string("the compressed data ") + (r == Z_DATA_ERROR ? "are damaged" : "are cut short") + ": " +
                       std::to_string(numbers.came()) + " of " + std::to_string(numbers.wanted()) + " bytes came out");
}

}  // namespace

std::vector<float> read_numbers(const std::string& file, const NumberBlock& block) {
  OpenedFile in(file, "the data of a volume");
  Numbers numbers(block);
  size_t at = block.at;
  if (block.at_end && in.size() > at + numbers.wanted()) at = in.size() - numbers.wanted();
  if (at > in.size()) throw InputError(file, 0, "there are fewer bytes than the header says to skip");
  const size_t there = in.size() - at;
  const auto cut_short = [&] {
    return InputError(file, 0,
                      "the data are cut short: " + std::to_string(there) + " bytes; " +
                          std::to_string(numbers.wanted()) + " were expected");
  };
  if (!block.packed && there < numbers.wanted()) throw cut_short();  // before anything is asked for
  if (block.packed && numbers.wanted() > kMostOfOneByte * there)
    throw InputError(file, 0,
                     "the compressed data are cut short: " + std::to_string(there) + " bytes cannot hold the " +
                         std::to_string(numbers.wanted()) + " that were expected");
  std::string part(kPart, '\0');
  while (at > 0) {
    const size_t n = in.read(part.data(), std::min(at, part.size()));
    if (n == 0) throw cut_short();
    at -= n;
  }
  if (block.packed) {
    inflate_into(numbers, in, file);
  } else {
    while (!numbers.full()) {
      const size_t n = in.read(part.data(), part.size());
      if (n == 0) throw cut_short();  // it shrinks while it is read
      numbers.add(std::string_view(part).substr(0, n));
    }
  }
  return numbers.take(file);
}

int64_t check_extent(const std::array<int64_t, 3>& size, const Mat3& step_mm, const std::string& file) {
  bool sensible = true;
  for (const int64_t n : size) sensible &= n >= 1 && n <= 1'000'000;
  const int64_t voxels = sensible ? size[0] * size[1] * size[2] : 0;
  if (voxels > VolumeLimits::voxels || voxels < 1)
    throw InputError(file, 0,
                     "the volume has " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                         std::to_string(size[2]) + " voxels; at most " + std::to_string(VolumeLimits::voxels) +
                         " are read");
  for (int k = 0; k < 3; ++k) {
    const double l = step_mm.col(k).norm();
    if (!(l >= VolumeLimits::min_step_mm && l <= VolumeLimits::max_step_mm))
      throw InputError(file, 0,
                       "a voxel is " + std::to_string(l) + " mm long along axis " + std::to_string(k) +
                           "; expected 0.001 to 100 mm");
  }
  const double det = step_mm.determinant(), box = step_mm.col(0).norm() * step_mm.col(1).norm() * step_mm.col(2).norm();
  if (!(std::abs(det) > 1e-3 * box)) throw InputError(file, 0, "the axes of the volume lie in a plane");
  return voxels;
}

Volume read_data(const Header& h, const std::string& file) {
  const int64_t voxels = check_extent(h.size, h.step_mm, file);
  const std::string path =
      h.data_file.empty() ? file : (std::filesystem::path(file).parent_path() / h.data_file).string();
  NumberBlock block;
  block.number = *h.number, block.big_endian = h.big_endian, block.packed = h.compressed, block.count = size_t(voxels);
  block.at = (h.data_file.empty() ? h.data_at : 0) + size_t(std::max<int64_t>(0, h.skip));
  block.at_end = h.skip == -1 && !h.compressed;
  Volume v;
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t(h.size[k]);
  v.step_mm = h.step_mm, v.origin_mm = h.origin_mm;
  v.value = read_numbers(path, block);
  return v;
}

}  // namespace imaging

LoadedVolume load_volume(const std::string& path, const LoadSettings& settings) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec)) return imaging::load_dicom(path, settings);
  const std::string head = read_beginning(path, VolumeLimits::header_bytes, "a volume");
  if (head.starts_with("NRRD000")) return {imaging::read_data(imaging::nrrd_header(head, path), path), {}};
  if (imaging::looks_like_nifti(head)) return {imaging::load_nifti(path), {}};
  if (imaging::looks_like_dicom(head)) return imaging::load_dicom(path, settings);
  size_t at = 0;
  std::string_view first;
  next_line(head, at, first);
  const size_t equals = first.find('=');
  const std::string_view key = imaging::trimmed(first.substr(0, equals));
  if (equals != std::string_view::npos && (key == "ObjectType" || key == "NDims" || key == "Comment"))
    return {imaging::read_data(imaging::meta_header(head, path), path), {}};
  throw InputError(path, 1,
                   "is of no kind that is known here; expected an NRRD (NRRD0001...), a MetaImage (ObjectType = "
                   "Image), a NIfTI-1 or a DICOM file or folder");
}

Volume load_volume(const std::string& path, const std::string& series) {
  return load_volume(path, LoadSettings{series, false}).volume;
}

double longest_step_mm(const Volume& v) { return v.step_mm.colwise().norm().maxCoeff(); }
double shortest_step_mm(const Volume& v) { return v.step_mm.colwise().norm().minCoeff(); }

double VolumeSampler::value(const Vec3& x_mm) const {
  const Vec3 p = to_voxel_ * (x_mm - v_.origin_mm);
  int32_t i[3];
  double w[3];
  for (int k = 0; k < 3; ++k) {
    const int32_t n = v_.size[size_t(k)];
    const double q = std::clamp(p[k], 0., double(n - 1));
    i[k] = std::min(int32_t(q), std::max(0, n - 2));
    w[k] = n > 1 ? q - i[k] : 0;
  }
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    double f = 1;
    int32_t j[3];
    for (int k = 0; k < 3; ++k) {
      const int up = c >> k & 1;
      f *= up ? w[k] : 1 - w[k];
      j[k] = std::min(i[k] + up, v_.size[size_t(k)] - 1);
    }
    if (f != 0) sum += f * double(v_.value[v_.index(j[0], j[1], j[2])]);
  }
  return sum;
}

Vec3 VolumeSampler::gradient(const Vec3& x_mm) const {
  const double h = 0.5 * std::min({v_.step_mm.col(0).norm(), v_.step_mm.col(1).norm(), v_.step_mm.col(2).norm()});
  Vec3 g;
  for (int k = 0; k < 3; ++k) g[k] = (value(x_mm + h * Vec3::Unit(k)) - value(x_mm - h * Vec3::Unit(k))) / (2 * h);
  return g;
}

bool VolumeSampler::inside(const Vec3& x_mm) const {
  const Vec3 p = to_voxel_ * (x_mm - v_.origin_mm);
  for (int k = 0; k < 3; ++k)
    if (!(p[k] >= 0 && p[k] <= v_.size[size_t(k)] - 1)) return false;
  return true;
}

}  // namespace limberg
