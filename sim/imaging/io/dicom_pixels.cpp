#include "sim/imaging/io/dicom_pixels.h"

#include <fmt/format.h>

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
constexpr size_t kMostUnpacked = size_t(2) << 30;  // of one file

[[noreturn]] void packed_badly(const DicomFile& d, const std::string& what) {
  throw InputError(d.name(), 0, "its run lengths are damaged: " + what);
}

uint32_t u32(std::string_view s, size_t at) {
  uint32_t v = 0;
  for (size_t k = 0; k < 4; ++k) v |= uint32_t(uint8_t(s[at + k])) << (8 * k);
  return v;
}

/// What was packed of a slice: the fragments of the only frame, one behind the other, or one fragment of a frame among
/// several (PS3.5 A.4: run lengths have one a frame). Before them lies the table of offsets.
std::string fragments(const DicomFile& d, std::string_view s) {
  std::string out;
  int32_t frame = -1;
  for (size_t at = d.pixels_at; at + 8 <= s.size();) {
    const uint32_t tag = u32(s, at), length = u32(s, at + 4);
    at += 8;
    if (tag == 0xe0ddfffe && d.frames == 1) return out;
    if (tag == 0xe0ddfffe) packed_badly(d, "there are fewer of them than frames");
    if (tag != 0xe000fffe || length > s.size() - at) break;
    if (d.frames > 1 && frame == d.frame) return std::string(s.substr(at, length));
    if (d.frames == 1 && frame >= 0) out += s.substr(at, length);
    ++frame, at += length;
  }
  packed_badly(d, "a fragment is cut short, or the last one has no end");
}

/// One plane of bytes per byte of a number, the highest first; each by PackBits (PS3.5 annex G).
std::string unpacked_run_lengths(const DicomFile& d, const std::string& s) {
  const size_t numbers = size_t(d.rows) * size_t(d.columns);
  const size_t planes = size_t(d.allocated) / 8;
  if (s.size() < 64 || u32(s, 0) != planes)
    packed_badly(d, "expected a header of 64 bytes with " + std::to_string(planes) + " segments");
  // 128 numbers come of 2 bytes at most: no memory is asked for where the file cannot hold so many.
  if (numbers > 64 * s.size()) packed_badly(d, "there are too few of them for so many pixels");
  std::string out(numbers * planes, '\0');
  for (size_t p = 0; p < planes; ++p) {
    const size_t begin = u32(s, 4 + 4 * p), end = p + 1 < planes ? size_t(u32(s, 8 + 4 * p)) : s.size();
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

std::string DicomPixels::bytes_of(const DicomFile& d) {
  const size_t bytes = d.frame_bytes();
  if (!d.compressed) {
    OpenedFile in(d.file, "a DICOM file");
    std::string out(std::min(bytes, in.size()), '\0');
    const size_t before = size_t(d.frame) * bytes, left = d.pixel_bytes > before ? d.pixel_bytes - before : 0;
    in.go_to(d.pixels_at + before);
    out.resize(std::min(left, in.read(out.data(), out.size())));
    if (out.size() < bytes)
      throw InputError(d.name(), 0,
                       "the pixels are cut short: " + std::to_string(out.size()) + " bytes; " + std::to_string(bytes) +
                           " were expected");
    return out;
  }
  const Compression c = compression_of(d);
  const bool kept = file_ == d.file;
  if (!kept) file_.clear(), kept_.clear();
  if (c.run_length) {
    if (!kept) kept_ = read_whole_file(d.file, kDicomBytes), file_ = d.file;
    return unpacked_run_lengths(d, fragments(d, kept_));
  }
  if (!kept) {
    const LoadedPart part = gdcm_part();
    if (!part.entry)
      throw InputError(d.file, 0,
                       "its pixels are compressed (" + c.name +
                           "); expected plain ones, or a build with GDCM (Debian: libgdcm-dev, -DLIMBERG_GDCM=ON); a "
                           "converter such as gdcmconv --raw makes them plain. " +
                           part.why);
    if (bytes * size_t(d.frames) > kMostUnpacked)
      throw InputError(d.file, 0,
                       fmt::format("its {} frames come to {} MB; expected at most {}", d.frames,
                                   bytes * size_t(d.frames) >> 20, kMostUnpacked >> 20));
    std::string why;
    reinterpret_cast<UnpackPixels>(part.entry)(d.file, bytes * size_t(d.frames), kept_, why);
    if (!why.empty()) throw InputError(d.file, 0, why);
    file_ = d.file;
  }
  return kept_.substr(size_t(d.frame) * bytes, bytes);
}

}  // namespace limberg::imaging
