#include "sim/imaging/io/dicom_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg::imaging {
namespace {

constexpr uint32_t kUndefined = 0xffffffff;
constexpr int kDeepest = 16;  // sequences within sequences
constexpr size_t kUsualHeader = 65'536;
constexpr size_t kText = 256;  // so much of a text is kept: every frame has its own (names have 64 letters, PS3.5 6.2)

enum Tag : uint32_t {
  kItem = 0xfffee000,
  kItemEnds = 0xfffee00d,
  kSequenceEnds = 0xfffee0dd,
  kPixels = 0x7fe00010,
  kSharedGroups = 0x52009229,    // of all frames
  kPerFrameGroups = 0x52009230,  // an item for each frame
};

/// The groups that hold what a slice's file has at its top (PS3.3 C.7.6.16.2, C.8.15.3, C.8.21.3).
bool is_read_group(uint32_t tag) {
  constexpr uint32_t kRead[] = {0x00189314,   // reconstruction: its kernel
                                0x00189329,   // frame type of a CT
                                0x00209111,   // frame content: its stack
                                0x00209113,   // plane position
                                0x00209116,   // plane orientation
                                0x00289110,   // pixel measures
                                0x00289145};  // pixel value transformation
  return std::find(std::begin(kRead), std::end(kRead), tag) != std::end(kRead);
}

struct Element {
  uint32_t tag = 0;
  char vr[2] = {0, 0};
  uint32_t length = 0;
};

class Parser {
 public:
  Parser(std::string_view s, const std::string& file, size_t file_bytes)
      : s_(s), file_(file), file_bytes_(std::max(file_bytes, s.size())) {}

  std::vector<DicomFile> run() {
    DicomFile d;
    std::vector<DicomFile> frame;  // as far as their own groups tell
    d.file = file_;
    if (s_.size() >= 132 && s_.substr(128, 4) == "DICM")
      at_ = 132;
    else if (!(s_.size() >= 8 && (u16(0) == 2 || u16(0) == 8) && u16(2) < 0x100))
      throw InputError(file_, 0, "is no DICOM file; expected DICM behind 128 bytes");
    d.syntax = "1.2.840.10008.1.2";
    bool chosen = false;
    while (at_ + 8 <= s_.size()) {
      const bool meta = u16(at_) == 2;
      if (!meta && !chosen) choose(d), chosen = true;
      const Element e = element(meta || explicit_);
      if (e.tag == kPixels) {
        d.has_pixels = true, d.pixels_at = at_, d.pixel_bytes = std::min(size_t(e.length), file_bytes_ - at_);
        d.compressed = compressed_ || e.length == kUndefined;
        break;
      }
      if (e.tag == kSharedGroups) {
        const bool vr = has_vr(e, explicit_);
        items(
            e, vr, 0, [] { return true; }, [&](const Element& group) { take_group(d, group, vr); });
      } else if (e.tag == kPerFrameGroups) {
        const bool vr = has_vr(e, explicit_);
        const auto next = [&] {
          if (int32_t(frame.size()) == d.frames) other_number(d, "more");
          frame.push_back(d), frame.back().frame = int32_t(frame.size()) - 1;
          return true;
        };
        items(e, vr, 0, next, [&](const Element& group) { take_group(frame.back(), group, vr); });
      } else if (e.length == kUndefined) {
        skip(e, explicit_, 0);
      } else {
        if (e.length > s_.size() - at_) cut(e);
        take(d, e, s_.substr(at_, e.length));
        at_ += e.length;
      }
    }
    if (!chosen) choose(d);
    if (!d.has_pixels && at_ < s_.size()) throw InputError(file_, 0, "the file is cut short within an element");
    if (frame.empty()) {
      d.frame = d.frames == 1 ? 0 : -1;
      return {d};
    }
    if (int32_t(frame.size()) != d.frames) other_number(d, "fewer");
    for (DicomFile& f : frame)
      f.has_pixels = d.has_pixels, f.compressed = d.compressed, f.pixels_at = d.pixels_at,
      f.pixel_bytes = d.pixel_bytes;
    return frame;
  }

 private:
  uint32_t u16(size_t i) const { return uint32_t(uint8_t(s_[i])) | uint32_t(uint8_t(s_[i + 1])) << 8; }
  uint32_t u32(size_t i) const { return u16(i) | u16(i + 2) << 16; }
  static bool is(const Element& e, const char* vr) { return e.vr[0] == vr[0] && e.vr[1] == vr[1]; }

  [[noreturn]] void cut(const Element& e) const {
    const std::string b =
        fmt::format("the file is cut short or damaged: element ({:04x},{:04x}) has {} bytes, but only {} are left",
                    e.tag >> 16, e.tag & 0xffff, e.length, s_.size() - at_);
    throw InputError(file_, 0, b);
  }

  [[noreturn]] void other_number(const DicomFile& d, const char* how) const {
    throw InputError(file_, 0,
                     fmt::format("holds {} frames, and groups that describe {}; expected one for each", d.frames, how));
  }

  void choose(const DicomFile& d) {
    const std::string& t = d.syntax;
    if (t == "1.2.840.10008.1.2")
      explicit_ = false;
    else if (t == "1.2.840.10008.1.2.1")
      explicit_ = true;
    else if (t == "1.2.840.10008.1.2.2" || t == "1.2.840.10008.1.2.1.99")
      throw InputError(file_, 0,
                       std::string("its transfer syntax is ") + (t.ends_with("99") ? "deflated" : "big endian") + " (" +
                           t + "), which is not read; expected Explicit or Implicit VR little endian");
    else if (t.starts_with("1.2.840.10008.1.2.4") || t == "1.2.840.10008.1.2.5")
      explicit_ = true, compressed_ = true;
    else
      throw InputError(
          file_, 0,
          "its transfer syntax " + t.substr(0, 64) + " is not known; expected Explicit or Implicit VR little endian");
  }

  Element element(bool with_vr) {
    if (at_ + 8 > s_.size()) throw InputError(file_, 0, "the file is cut short within an element");
    Element e;
    e.tag = u16(at_) << 16 | u16(at_ + 2);
    if (!with_vr || e.tag >> 16 == 0xfffe) {
      e.length = u32(at_ + 4), at_ += 8;
      return e;
    }
    e.vr[0] = s_[at_ + 4], e.vr[1] = s_[at_ + 5];
    bool is_long = false;
    for (const char* l : {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})
      is_long |= is(e, l);
    if (is_long) {
      if (at_ + 12 > s_.size()) throw InputError(file_, 0, "the file is cut short within an element");
      e.length = u32(at_ + 8), at_ += 12;
    } else {
      e.length = u16(at_ + 6), at_ += 8;
    }
    return e;
  }

  /// Do the elements in one of undefined length have types? Of unknown type, they have none (PS3.5 6.2.2).
  static bool has_vr(const Element& e, bool with_vr) { return with_vr && !is(e, "UN"); }
  /// Where it ends; where only its last element says so, behind all bytes.
  size_t end_of(const Element& e) const {
    if (e.length == kUndefined) return std::string_view::npos;
    if (e.length > s_.size() - at_) cut(e);
    return at_ + e.length;
  }
  /// The items of a sequence whose head was read, to its end. `begin` is called for each item: is it to be read, though
  /// its length is known? `on` is called for each of its elements, and goes past it.
  template <class Begin, class On>
  void items(const Element& sequence, bool with_vr, int depth, const Begin& begin, const On& on) {
    if (depth > kDeepest) throw InputError(file_, 0, "sequences lie more than 16 deep");
    const size_t end = end_of(sequence);
    while (at_ < end) {
      const Element item = element(with_vr);
      if (item.tag == kSequenceEnds && sequence.length == kUndefined) return;
      if (item.tag != kItem) throw InputError(file_, 0, "a sequence holds something that is no item");
      const size_t item_end = end_of(item);
      if (!begin() && item.length != kUndefined) {
        at_ = item_end;
        continue;
      }
      while (at_ < item_end) {
        const Element e = element(with_vr);
        if (e.tag == kItemEnds && item.length == kUndefined) break;
        on(e);
      }
    }
  }
  /// Goes past an element whose head was read.
  void skip(const Element& e, bool with_vr, int depth) {
    const bool vr = has_vr(e, with_vr);
    if (e.length == kUndefined)
      items(
          e, vr, depth, [] { return false; }, [&](const Element& in) { skip(in, vr, depth + 1); });
    else
      at_ = end_of(e);
  }
  /// A group of a frame's, or of all frames': what it says goes to `d`.
  void take_group(DicomFile& d, const Element& group, bool with_vr) {
    if (!is_read_group(group.tag)) return skip(group, with_vr, 1);
    const bool vr = has_vr(group, with_vr);
    items(
        group, vr, 1, [] { return true; },
        [&](const Element& e) {
          if (e.length == kUndefined) return skip(e, vr, 2);
          const size_t end = end_of(e);
          take(d, e, s_.substr(at_, e.length));
          at_ = end;
        });
  }

  static std::string text(std::string_view v) {
    while (!v.empty() && (v.back() == ' ' || v.back() == 0)) v.remove_suffix(1);
    while (!v.empty() && v.front() == ' ') v.remove_prefix(1);
    return std::string(v.substr(0, kText));
  }
  void numbers(std::string_view v, int count, const char* what, double* out) const {
    for (int i = 0; i < count; ++i) {
      const size_t end = std::min(v.find('\\'), v.size());
      const std::string t = text(v.substr(0, end));
      const char* b = t.data() + (t.starts_with("+") ? 1 : 0);
      const auto [p, ec] = std::from_chars(b, t.data() + t.size(), out[i]);
      if (ec != std::errc() || p != t.data() + t.size() || !std::isfinite(out[i]))
        throw InputError(file_, 0, std::string(what) + " is not " + std::to_string(count) + " finite numbers");
      v.remove_prefix(std::min(v.size(), end + 1));
    }
  }
  int32_t whole(std::string_view v, const char* what) const {
    if (v.size() < 2) throw InputError(file_, 0, std::string(what) + " is no number of 16 bits");
    return int32_t(uint32_t(uint8_t(v[0])) | uint32_t(uint8_t(v[1])) << 8);
  }

  void take(DicomFile& d, const Element& e, std::string_view v) const {
    double n[6];
    switch (e.tag) {
      case 0x00020010:
        d.syntax = text(v);
        break;
      case 0x00080008:
        d.image_type = text(v);
        break;
      case 0x00080018:
        d.instance = text(v);
        break;
      case 0x00100020:
        d.patient = text(v);
        break;
      case 0x00180015:
        d.body_part = text(v);
        break;
      case 0x00181210:
        d.kernel = text(v);
        break;
      case 0x00089007:  // of a frame
        d.image_type = text(v);
        break;
      case 0x00209056:
        d.stack = text(v);
        break;
      case 0x00080060:
        d.modality = text(v);
        break;
      case 0x0008103e:
        d.description = text(v);
        break;
      case 0x0020000e:
        d.series = text(v);
        break;
      case 0x00200032:
        numbers(v, 3, "the position of the slice", n), d.position_mm = {n[0], n[1], n[2]}, d.has_position = true;
        break;
      case 0x00200037:
        numbers(v, 6, "the direction of the slice", n);
        d.across = {n[0], n[1], n[2]}, d.down = {n[3], n[4], n[5]}, d.has_direction = true;
        break;
      case 0x00280002:
        d.samples = whole(v, "samples per pixel");
        break;
      case 0x00280008:
        numbers(v, 1, "the number of frames", n);
        if (!(n[0] >= 1 && n[0] <= kDicomFrames))
          throw InputError(file_, 0, fmt::format("holds {:g} frames; expected 1 to {}", n[0], kDicomFrames));
        d.frames = int32_t(n[0]);
        break;
      case 0x00280010:
        d.rows = whole(v, "the number of rows");
        break;
      case 0x00280011:
        d.columns = whole(v, "the number of columns");
        break;
      case 0x00280030:
        numbers(v, 2, "the pixel spacing", n), d.row_step_mm = n[0], d.column_step_mm = n[1], d.has_spacing = true;
        break;
      case 0x00280100:
        d.allocated = whole(v, "bits allocated");
        break;
      case 0x00280101:
        d.stored = whole(v, "bits stored");
        break;
      case 0x00280102:
        d.high_bit = whole(v, "high bit");
        break;
      case 0x00280103:
        d.is_signed = whole(v, "pixel representation") == 1;
        break;
      case 0x00280120:
        d.padding = d.padding_limit = whole(v, "the padding value"), d.has_padding = true;
        break;
      case 0x00280121:
        d.padding_limit = whole(v, "the limit of the padding");
        break;
      case 0x00281052:
        numbers(v, 1, "the rescale intercept", n), d.intercept = n[0];
        break;
      case 0x00281053:
        numbers(v, 1, "the rescale slope", n), d.slope = n[0];
        break;
      default:
        break;
    }
  }

  std::string_view s_;
  const std::string& file_;
  size_t file_bytes_;
  size_t at_ = 0;
  bool explicit_ = false, compressed_ = false;
};

}  // namespace

std::vector<DicomFile> parse_dicom(std::string_view bytes, const std::string& file, size_t file_bytes) {
  return Parser(bytes, file, file_bytes).run();
}

std::vector<DicomFile> read_dicom_header(const std::string& file) {
  // Headers of many frames are long: a beginning that holds no pixels is read again, sixteen times as long.
  for (size_t most = kUsualHeader; most < kDicomBytes; most *= 16) {
    OpenedFile in(file, "a DICOM file");
    if (most >= in.size() || in.size() > kDicomBytes) break;
    std::string head(most, '\0');
    head.resize(in.read(head.data(), head.size()));
    try {
      std::vector<DicomFile> frames = parse_dicom(head, file, in.size());
      if (frames.front().has_pixels) return frames;
    } catch (const InputError&) {
      // The header goes on beyond what was read.
    }
  }
  return parse_dicom(read_whole_file(file, kDicomBytes), file);
}

}  // namespace limberg::imaging
