#include "sim/imaging/io/volume.h"

#include <zlib.h>

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "sim/imaging/io/dicom.h"
#include "sim/imaging/io/header.h"
#include "sim/imaging/io/nifti.h"

namespace limberg {
namespace imaging {

std::string inflated(std::string_view in, size_t wanted, const std::string& file) {
  z_stream z{};
  if (inflateInit2(&z, 15 + 32) != Z_OK) throw InputError(file, 0, "cannot be decompressed");
  std::string out;
  size_t fed = 0;
  int r = Z_OK;
  while (out.size() < wanted && r != Z_STREAM_END) {
    if (z.avail_in == 0 && fed < in.size()) {
      const size_t n = std::min<size_t>(in.size() - fed, size_t(1) << 30);
      z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data() + fed));
      z.avail_in = uInt(n), fed += n;
    }
    const size_t had = out.size(), room = std::min<size_t>(wanted - had, size_t(4) << 20);
    out.resize(had + room);
    z.next_out = reinterpret_cast<Bytef*>(out.data() + had);
    z.avail_out = uInt(room);
    r = inflate(&z, Z_NO_FLUSH);
    out.resize(had + room - z.avail_out);
    if (r != Z_OK && r != Z_STREAM_END) break;  // (also Z_BUF_ERROR: nothing more to read)
  }
  inflateEnd(&z);
  if (out.size() < wanted) {
    const char* why = r == Z_DATA_ERROR ? "are damaged" : "are cut short";
    throw InputError(file, 0,
                     "the compressed data " + std::string(why) + ": " + std::to_string(out.size()) + " of " +
                         std::to_string(wanted) + " bytes came out");
  }
  return out;
}

namespace {

template <class T>
void convert(std::string_view in, bool swap, std::vector<float>& out) {
  for (size_t i = 0; i < out.size(); ++i) {
    char b[sizeof(T)];
    std::memcpy(b, in.data() + i * sizeof(T), sizeof(T));
    if (swap) std::reverse(b, b + sizeof(T));
    T v;
    std::memcpy(&v, b, sizeof(T));
    out[i] = float(v);
  }
}

}  // namespace

std::string read_bytes(const std::string& path, size_t most) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec)) throw InputError(path, 0, "is a folder; expected a volume");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, 0, std::string("cannot be opened (") + std::strerror(errno) + ")");
  std::string text;
  std::vector<char> part(1 << 20);
  while (text.size() < most && (in.read(part.data(), std::streamsize(part.size())), in.gcount() > 0))
    text.append(part.data(), std::min(size_t(in.gcount()), most - text.size()));
  if (in.bad()) throw InputError(path, 0, "cannot be read to its end");
  return text;
}

std::vector<float> as_floats(std::string_view data, Number number, bool big_endian, size_t count,
                             const std::string& file) {
  std::vector<float> out(count);
  const bool swap = big_endian != (std::endian::native == std::endian::big);
  switch (number) {
    case Number::i8:
      convert<int8_t>(data, swap, out);
      break;
    case Number::u8:
      convert<uint8_t>(data, swap, out);
      break;
    case Number::i16:
      convert<int16_t>(data, swap, out);
      break;
    case Number::u16:
      convert<uint16_t>(data, swap, out);
      break;
    case Number::i32:
      convert<int32_t>(data, swap, out);
      break;
    case Number::u32:
      convert<uint32_t>(data, swap, out);
      break;
    case Number::f32:
      convert<float>(data, swap, out);
      break;
    case Number::f64:
      convert<double>(data, swap, out);
      break;
  }
  for (const float f : out)
    if (!std::isfinite(f)) throw InputError(file, 0, "a voxel holds no finite number");
  return out;
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
  const size_t bytes = size_t(voxels) * bytes_of(*h.number);
  const std::string path =
      h.data_file.empty() ? file : (std::filesystem::path(file).parent_path() / h.data_file).string();
  // What a sound file can need: the data, what is skipped, and the header.
  const size_t most = h.compressed ? size_t(1) << 32
                                   : bytes + size_t(std::max<int64_t>(0, std::min<int64_t>(h.skip, int64_t(1) << 30))) +
                                         VolumeLimits::header_bytes;
  const std::string all = read_bytes(path, h.skip == -1 ? size_t(1) << 32 : most);
  std::string_view data(all);
  if (h.data_file.empty()) data.remove_prefix(std::min(h.data_at, data.size()));
  if (h.skip == -1 && !h.compressed) {
    if (data.size() > bytes) data.remove_prefix(data.size() - bytes);
  } else if (h.skip > 0) {
    if (uint64_t(h.skip) > data.size()) throw InputError(path, 0, "there are fewer bytes than the header says to skip");
    data.remove_prefix(size_t(h.skip));
  }
  std::string plain;
  if (h.compressed) plain = inflated(data, bytes, path), data = plain;
  if (data.size() < bytes)
    throw InputError(path, 0,
                     "the data are cut short: " + std::to_string(data.size()) + " bytes; " + std::to_string(bytes) +
                         " were expected");
  Volume v;
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t(h.size[k]);
  v.step_mm = h.step_mm, v.origin_mm = h.origin_mm;
  v.value = as_floats(data, *h.number, h.big_endian, size_t(voxels), path);
  return v;
}

}  // namespace imaging

Volume load_volume(const std::string& path, const std::string& series) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec)) return imaging::load_dicom(path, series);
  const std::string head = imaging::read_bytes(path, VolumeLimits::header_bytes);
  if (head.starts_with("NRRD000")) return imaging::read_data(imaging::nrrd_header(head, path), path);
  if (imaging::looks_like_nifti(head)) return imaging::load_nifti(path);
  if (imaging::looks_like_dicom(head)) return imaging::load_dicom(path, series);
  size_t at = 0;
  std::string_view first;
  imaging::next_line(head, at, first);
  const size_t equals = first.find('=');
  const std::string_view key = imaging::trimmed(first.substr(0, equals));
  if (equals != std::string_view::npos && (key == "ObjectType" || key == "NDims" || key == "Comment"))
    return imaging::read_data(imaging::meta_header(head, path), path);
  throw InputError(path, 1,
                   "is of no kind that is known here; expected an NRRD (NRRD0001...), a MetaImage (ObjectType = "
                   "Image), a NIfTI-1 or a DICOM file or folder");
}

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
