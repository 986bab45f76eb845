#include "sim/imaging/io/header.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/quoted.h"

namespace limberg::imaging {
namespace {

std::string lower(std::string_view s) {
  std::string o(s);
  for (char& c : o) c = char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return o;
}

int64_t whole(std::string_view s, const std::string& file, int line, const char* what) {
  const std::string_view t = trimmed(s);
  int64_t v = 0;
  const auto [end, ec] = std::from_chars(t.data(), t.data() + t.size(), v);
  if (t.empty() || ec != std::errc() || end != t.data() + t.size())
    throw InputError(file, line, std::string(what) + " is no whole number");
  return v;
}

void sizes(Header& h, std::string_view s, const std::string& file, int line) {
  const std::vector<double> n = numbers(s, 3, file, line, "the sizes");
  for (size_t k = 0; k < 3; ++k) {
    if (n[k] != std::floor(n[k]) || n[k] < 1 || n[k] > 1e6)
      throw InputError(file, line, "a size is not a whole number from 1 to a million");
    h.size[k] = int64_t(n[k]);
  }
}

/// Of the file with the data: in the header's folder or below it. A header from elsewhere does not say which other
/// files of this machine are read.
std::string name_of(std::string_view s, const std::string& file, int line) {
  for (const char c : s)
    if (static_cast<unsigned char>(c) < ' ' || c == 127)
      throw InputError(file, line,
                       "the name of the file with the data has a character that no name has; the header is damaged");
  const std::filesystem::path path(s);
  if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
    throw InputError(file, line,
                     "the data file " + limberg::quoted(s) +
                         " lies outside of the header's folder; expected the name of a file in it");
  return std::string(s);
}

}  // namespace

size_t bytes_of(Number n) {
  switch (n) {
    case Number::i8:
    case Number::u8:
      return 1;
    case Number::i16:
    case Number::u16:
      return 2;
    case Number::i32:
    case Number::u32:
    case Number::f32:
      return 4;
    case Number::f64:
      return 8;
  }
  return 1;
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

std::vector<double> numbers(std::string_view s, size_t count, const std::string& file, int line, const char* what) {
  std::vector<double> out;
  for (;;) {
    while (!s.empty() &&
           (s.front() == ' ' || s.front() == '\t' || s.front() == ',' || s.front() == '(' || s.front() == ')'))
      s.remove_prefix(1);
    if (s.empty()) break;
    if (s.front() == '+') s.remove_prefix(1);
    double v = 0;
    const auto [end, ec] = std::from_chars(s.data(), s.data() + s.size(), v);
    if (ec != std::errc() || end == s.data() || !std::isfinite(v))
      throw InputError(file, line, std::string(what) + " must be finite numbers");
    out.push_back(v);
    s.remove_prefix(size_t(end - s.data()));
    if (out.size() > count) break;
  }
  if (out.size() != count)
    throw InputError(file, line, std::string(what) + ": " + std::to_string(count) + " numbers were expected");
  return out;
}

Header nrrd_header(std::string_view text, const std::string& file) {
  Header h;
  size_t at = 0;
  std::string_view l;
  next_line(text, at, l);  // the magic
  Vec3 flip(1, 1, 1);
  bool dimension = false, encoding = false, endian = false, ended = false;
  std::optional<Mat3> directions;
  int line = 1;
  while (next_line(text, at, l)) {
    ++line;
    if (l.empty()) {
      ended = true;
      break;
    }
    if (l[0] == '#' || l.find(":=") != std::string_view::npos) continue;
    const size_t colon = l.find(':');
    if (colon == std::string_view::npos) throw InputError(file, line, "a field of the NRRD header has no colon");
    const std::string key = lower(trimmed(l.substr(0, colon)));
    const std::string_view raw = trimmed(l.substr(colon + 1));
    const std::string v = lower(raw);
    if (key == "dimension") {
      if (whole(raw, file, line, "the dimension") != 3)
        throw InputError(file, line, "the volume has " + v + " dimensions; 3 were expected");
      dimension = true;
    } else if (key == "type") {
      const auto is = [&](std::initializer_list<const char*> names) {
        return std::find(names.begin(), names.end(), v) != names.end();
      };
      if (is({"signed char", "int8", "int8_t"}))
        h.number = Number::i8;
      else if (is({"uchar", "unsigned char", "uint8", "uint8_t"}))
        h.number = Number::u8;
      else if (is({"short", "short int", "signed short", "signed short int", "int16", "int16_t"}))
        h.number = Number::i16;
      else if (is({"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}))
        h.number = Number::u16;
      else if (is({"int", "signed int", "int32", "int32_t"}))
        h.number = Number::i32;
      else if (is({"uint", "unsigned int", "uint32", "uint32_t"}))
        h.number = Number::u32;
      else if (v == "float")
        h.number = Number::f32;
      else if (v == "double")
        h.number = Number::f64;
      else
        throw InputError(file, line,
                         "numbers of type " + limberg::quoted(v) +
                             " are not read; expected integers of 8 to 32 bits, float or double");
    } else if (key == "sizes") {
      sizes(h, raw, file, line);
    } else if (key == "encoding") {
      if (v == "gzip" || v == "gz")
        h.compressed = true;
      else if (v != "raw")
        throw InputError(file, line, "the encoding " + limberg::quoted(v) + " is not read; expected raw or gzip");
      encoding = true;
    } else if (key == "endian") {
      if (v != "little" && v != "big") throw InputError(file, line, "endian is little or big");
      h.big_endian = v == "big", endian = true;
    } else if (key == "space") {
      if (v == "right-anterior-superior" || v == "ras")
        flip = {-1, -1, 1};
      else if (v == "left-anterior-superior" || v == "las")
        flip = {1, -1, 1};
      else if (v != "left-posterior-superior" && v != "lps")
        throw InputError(
            file, line,
            "the space " + limberg::quoted(v) +
                " is not known; expected left-posterior-superior, right-anterior-superior or left-anterior-superior");
    } else if (key == "space directions") {
      const std::vector<double> n = numbers(raw, 9, file, line, "the space directions");
      Mat3 m;
      for (int k = 0; k < 3; ++k) m.col(k) = Vec3(n[size_t(3 * k)], n[size_t(3 * k + 1)], n[size_t(3 * k + 2)]);
      directions = m;
    } else if (key == "spacings") {
      const std::vector<double> n = numbers(raw, 3, file, line, "the spacings");
      h.step_mm = Vec3(n[0], n[1], n[2]).asDiagonal();
    } else if (key == "space origin") {
      const std::vector<double> n = numbers(raw, 3, file, line, "the space origin");
      h.origin_mm = {n[0], n[1], n[2]};
    } else if (key == "data file" || key == "datafile") {
      if (raw.empty() || v.starts_with("list") || raw.find('%') != std::string_view::npos)
        throw InputError(file, line, "one data file was expected, not a list of them");
      h.data_file = name_of(raw, file, line);
    } else if (key == "byte skip" || key == "byteskip") {
      h.skip = whole(raw, file, line, "the byte skip");
      if (h.skip < -1) throw InputError(file, line, "the byte skip is below -1");
    } else if (key == "line skip" || key == "lineskip") {
      if (whole(raw, file, line, "the line skip") != 0)
        throw InputError(file, line, "lines before the data are not skipped here; expected line skip 0");
    }
  }
  if (directions) h.step_mm = *directions;
  h.step_mm = flip.asDiagonal() * h.step_mm;
  h.origin_mm = flip.cwiseProduct(h.origin_mm);
  h.data_at = std::min(at, text.size());
  if (!dimension) throw InputError(file, 0, "the NRRD header has no dimension");
  if (h.size[0] == 0) throw InputError(file, 0, "the NRRD header has no sizes");
  if (!h.number) throw InputError(file, 0, "the NRRD header has no type");
  if (!encoding) throw InputError(file, 0, "the NRRD header has no encoding");
  if (!endian && bytes_of(*h.number) > 1)
    throw InputError(file, 0, "the NRRD header does not say the endian of its numbers");
  if (!ended && h.data_file.empty())
    throw InputError(file, 0, "the NRRD header does not end: no empty line before the data");
  return h;
}

Header meta_header(std::string_view text, const std::string& file) {
  Header h;
  size_t at = 0;
  std::string_view l;
  int line = 0;
  bool dimension = false, data = false;
  Vec3 spacing(1, 1, 1);
  Mat3 direction = Mat3::Identity();
  while (!data && next_line(text, at, l)) {
    ++line;
    if (trimmed(l).empty()) continue;
    const size_t equals = l.find('=');
    if (equals == std::string_view::npos) throw InputError(file, line, "a field of the MetaImage header has no =");
    const std::string key = lower(trimmed(l.substr(0, equals)));
    const std::string_view raw = trimmed(l.substr(equals + 1));
    const std::string v = lower(raw);
    if (key == "objecttype") {
      if (v != "image") throw InputError(file, line, "the object is no image");
    } else if (key == "ndims") {
      if (whole(raw, file, line, "the number of dimensions") != 3)
        throw InputError(file, line, "the volume has " + v + " dimensions; 3 were expected");
      dimension = true;
    } else if (key == "dimsize") {
      sizes(h, raw, file, line);
    } else if (key == "elementspacing") {
      const std::vector<double> n = numbers(raw, 3, file, line, "the spacing");
      spacing = {n[0], n[1], n[2]};
    } else if (key == "offset" || key == "position" || key == "origin") {
      const std::vector<double> n = numbers(raw, 3, file, line, "the offset");
      h.origin_mm = {n[0], n[1], n[2]};
    } else if (key == "transformmatrix" || key == "rotation" || key == "orientation") {
      const std::vector<double> n = numbers(raw, 9, file, line, "the transform matrix");
      for (int k = 0; k < 3; ++k) direction.col(k) = Vec3(n[size_t(3 * k)], n[size_t(3 * k + 1)], n[size_t(3 * k + 2)]);
    } else if (key == "binarydatabyteordermsb" || key == "elementbyteordermsb") {
      h.big_endian = v == "true";
    } else if (key == "compresseddata") {
      h.compressed = v == "true";
    } else if (key == "binarydata") {
      if (v != "true") throw InputError(file, line, "data written as text are not read; expected BinaryData = True");
    } else if (key == "elementnumberofchannels") {
      if (whole(raw, file, line, "the number of channels") != 1)
        throw InputError(file, line, "one number per voxel was expected");
    } else if (key == "headersize") {
      h.skip = whole(raw, file, line, "the header size");
      if (h.skip < -1) throw InputError(file, line, "the header size is below -1");
    } else if (key == "elementtype") {
      if (v == "met_char")
        h.number = Number::i8;
      else if (v == "met_uchar")
        h.number = Number::u8;
      else if (v == "met_short")
        h.number = Number::i16;
      else if (v == "met_ushort")
        h.number = Number::u16;
      else if (v == "met_int" || v == "met_long")
        h.number = Number::i32;  // (a long of this format has 4 bytes)
      else if (v == "met_uint" || v == "met_ulong")
        h.number = Number::u32;
      else if (v == "met_float")
        h.number = Number::f32;
      else if (v == "met_double")
        h.number = Number::f64;
      else
        throw InputError(file, line,
                         "numbers of type " + limberg::quoted(v) +
                             " are not read; expected MET_CHAR to MET_UINT, MET_FLOAT or MET_DOUBLE");
    } else if (key == "elementdatafile") {
      if (raw.empty() || v == "list" || raw.find('%') != std::string_view::npos)
        throw InputError(file, line, "one data file or LOCAL was expected, not a list");
      if (v != "local") h.data_file = name_of(raw, file, line);
      data = true;
    }
  }
  h.step_mm = direction * spacing.asDiagonal();
  h.data_at = std::min(at, text.size());
  if (!dimension) throw InputError(file, 0, "the MetaImage header has no NDims");
  if (h.size[0] == 0) throw InputError(file, 0, "the MetaImage header has no DimSize");
  if (!h.number) throw InputError(file, 0, "the MetaImage header has no ElementType");
  if (!data) throw InputError(file, 0, "the MetaImage header has no ElementDataFile");
  return h;
}

}  // namespace limberg::imaging
