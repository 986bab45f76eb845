#include "sim/imaging/io/dicom_pixels.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/part.h"
#include "sim/base/whole_file.h"

namespace limberg::imaging {
namespace {

using UnpackPixels = void (*)(const std::string& file, size_t bytes, std::string& out, std::string& why);

LoadedPart gdcm_part() { return load_part("gdcm", "limberg_gdcm_pixels", "GDCM (Debian: libgdcm-dev to build it)"); }

struct KnownSyntax {
  const char* uid;
  const char* name;
  bool lossy;
};
constexpr KnownSyntax kCompressed[] = {
    {"1.2.840.10008.1.2.4.50", "JPEG baseline", true},       {"1.2.840.10008.1.2.4.51", "JPEG extended", true},
    {"1.2.840.10008.1.2.4.57", "JPEG lossless", false},      {"1.2.840.10008.1.2.4.70", "JPEG lossless", false},
    {"1.2.840.10008.1.2.4.80", "JPEG-LS lossless", false},   {"1.2.840.10008.1.2.4.81", "JPEG-LS near lossless", true},
    {"1.2.840.10008.1.2.4.90", "JPEG 2000 lossless", false}, {"1.2.840.10008.1.2.4.91", "JPEG 2000", true}};
constexpr const char* kRunLength = "1.2.840.10008.1.2.5";

[[noreturn]] void packed_badly(const DicomFile& d, const std::string& what) {
  throw InputError(d.file, 0, "its run lengths are damaged: " + what);
}

/// The fragments of a frame, one behind the other, without the table of offsets (PS3.5 A.4).
std::string fragments(const DicomFile& d, std::string_view s) {
  const auto u32 = [&](size_t i) {
    uint32_t v = 0;
    for (size_t k = 0; k < 4; ++k) v |= uint32_t(uint8_t(s[i + k])) << (8 * k);
    return v;
  };
  std::string out;
  bool table = true;
  for (size_t at = d.pixels_at; at + 8 <= s.size();) {
    const uint32_t tag = u32(at), length = u32(at + 4);
    at += 8;
    if (tag == 0xe0ddfffe) return out;
    if (tag != 0xe000fffe || length > s.size() - at) break;
    if (!table) out += s.substr(at, length);
    table = false, at += length;
  }
  packed_badly(d, "a fragment is cut short, or the last one has no end");
}

/// One plane of bytes per byte of a number, the highest first; each by PackBits (PS3.5 annex G).
std::string unpacked_run_lengths(const DicomFile& d, size_t numbers) {
  const std::string all = read_whole_file(d.file, kDicomBytes), s = fragments(d, all);
  const size_t planes = size_t(d.allocated) / 8;
  const auto u32 = [&](size_t i) {
    uint32_t v = 0;
    for (size_t k = 0; k < 4; ++k) v |= uint32_t(uint8_t(s[i + k])) << (8 * k);
    return v;
  };
  if (s.size() < 64 || u32(0) != planes)
    packed_badly(d, "expected a header of 64 bytes with " + std::to_string(planes) + " segments");
  // 128 numbers come of 2 bytes at most: no memory is asked for where the file cannot hold so many.
  if (numbers > 64 * s.size()) packed_badly(d, "there are too few of them for so many pixels");
  std::string out(numbers * planes, '\0');
  for (size_t p = 0; p < planes; ++p) {
    const size_t begin = u32(4 + 4 * p), end = p + 1 < planes ? size_t(u32(8 + 4 * p)) : s.size();
    if (begin < 64 || begin > end || end > s.size()) packed_badly(d, "a segment lies outside its fragment");
    size_t done = 0, at = begin;
    const auto give = [&](char c) { out[planes * done++ + (planes - 1 - p)] = c; };
    while (done < numbers) {
      if (at >= end) packed_badly(d, "a segment ends after " + std::to_string(done) + " of its bytes");
      const int n = int(int8_t(s[at++]));
      if (n >= 0) {
        for (int k = 0; k <= n && done < numbers; ++k) {
          if (at >= end) packed_badly(d, "a segment ends within a run");
          give(s[at++]);
        }
      } else if (n > -128) {
        if (at >= end) packed_badly(d, "a segment ends within a run");
        for (int k = 0; k <= -n && done < numbers; ++k) give(s[at]);
        ++at;
      }
    }
  }
  return out;
}

}  // namespace

Compression compression_of(const DicomFile& d) {
  if (d.syntax == kRunLength) return {"run lengths, " + d.syntax, false, true};
  for (const KnownSyntax& k : kCompressed)
    if (d.syntax == k.uid) return {std::string(k.name) + ", " + k.uid, k.lossy, false};
  throw InputError(d.file, 0,
                   "its pixels are compressed in a way that is not read (transfer syntax " + d.syntax.substr(0, 64) +
                       "); expected plain ones, run lengths, JPEG, JPEG-LS or JPEG 2000");
}

std::string why_no_gdcm() { return gdcm_part().why; }

std::string pixel_bytes_of(const DicomFile& d) {
  const size_t numbers = size_t(d.rows) * size_t(d.columns), bytes = numbers * size_t(d.allocated / 8);
  if (!d.compressed) {
    std::string all = read_whole_file(d.file, kDicomBytes);
    all.erase(0, std::min(d.pixels_at, all.size()));
    if (std::min(all.size(), d.pixel_bytes) < bytes)
      throw InputError(d.file, 0,
                       "the pixels are cut short: " + std::to_string(std::min(all.size(), d.pixel_bytes)) + " bytes; " +
                           std::to_string(bytes) + " were expected");
    return all;
  }
  const Compression c = compression_of(d);
  if (c.run_length) return unpacked_run_lengths(d, numbers);
  const LoadedPart part = gdcm_part();
  if (!part.entry)
    throw InputError(d.file, 0,
                     "its pixels are compressed (" + c.name +
                         "); expected plain ones, or a build with GDCM (Debian: libgdcm-dev, -DLIMBERG_GDCM=ON); a "
                         "converter such as gdcmconv --raw makes them plain. " +
                         part.why);
  std::string out, why;
  reinterpret_cast<UnpackPixels>(part.entry)(d.file, bytes, out, why);
  if (!why.empty()) throw InputError(d.file, 0, why);
  return out;
}

}  // namespace limberg::imaging
