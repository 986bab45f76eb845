#include "tests/bench/fuzz/sound_files.h"

#include <zlib.h>

namespace limberg::fuzz {

namespace {

const std::vector<Vec3> kCorner{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
const std::vector<Tri> kTriangle{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

std::string deflated(const std::string& in, bool gzip) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, gzip ? 31 : 15, 8, Z_DEFAULT_STRATEGY);
  std::string out(in.size() + 100, 0);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data())), z.avail_in = uInt(in.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

std::string voxels() {
  std::string s(120, 0);
  for (int n = 0; n < 60; ++n) put(s, 2 * size_t(n), int16_t(7 * n - 200), false);
  return s;
}

/// Bytes run length encoded: each a literal, or a run where there is one (a length of -(n - 1), then the byte n times).
std::string run_lengths(const std::string& in) {
  std::string out;
  for (size_t i = 0; i < in.size();) {
    size_t n = 1;
    while (n < 128 && i + n < in.size() && in[i + n] == in[i]) ++n;
    out += n > 1 ? char(1 - int(n)) : char(0);
    out += in[i], i += n;
  }
  if (out.size() % 2) out += char(0);
  return out;
}

}  // namespace

std::string nifti(bool big, int form, float slope, float intercept) {
  std::string s(352, 0);
  put<int32_t>(s, 0, 348, big);
  const int16_t dim[8] = {3, 3, 4, 5, 1, 1, 1, 1};
  for (size_t k = 0; k < 8; ++k) put(s, 40 + 2 * k, dim[k], big);
  put<int16_t>(s, 70, 4, big), put<int16_t>(s, 72, 16, big);
  const float pixdim[4] = {1, 2, 3, 4};
  for (size_t k = 0; k < 4; ++k) put(s, 76 + 4 * k, pixdim[k], big);
  put<float>(s, 108, 352, big), put(s, 112, slope, big), put(s, 116, intercept, big);
  s[123] = 2;
  if (form == 1) {
    put<int16_t>(s, 252, 1, big);
    const float q[3] = {-10, -20, 30};
    for (size_t k = 0; k < 3; ++k) put(s, 268 + 4 * k, q[k], big);
  }
  if (form == 2) {
    put<int16_t>(s, 254, 1, big);
    const float m[12] = {2, 0, 0, -10, 0, 3, 0, -20, 0, 0, 4, 30};
    for (size_t k = 0; k < 12; ++k) put(s, 280 + 4 * k, m[k], big);
  }
  std::memcpy(s.data() + 344, "n+1", 4);
  s.resize(352 + 120);
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i) put(s, 352 + 2 * size_t(i + 3 * (j + 4 * k)), int16_t(nifti_voxel(i, j, k)), big);
  return s;
}

std::string nrrd(bool packed) {
  return std::string(
             "NRRD0004\n# made for tests\ndimension: 3\nsizes: 3 4 5\nspace: left-posterior-superior\nspace "
             "directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (-1,5,2)\ntype: short\nendian: little\nencoding: ") +
         (packed ? "gzip" : "raw") + "\n\n" + (packed ? deflated(voxels(), true) : voxels());
}

std::string meta_image(bool packed) {
  return std::string(
             "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementSpacing = 2 3 4\nOffset = 1 2 "
             "3\nElementByteOrderMSB = False\nElementType = MET_SHORT\nCompressedData = ") +
         (packed ? "True" : "False") + "\nElementDataFile = LOCAL\n" + (packed ? deflated(voxels(), false) : voxels());
}

namespace {

std::string number(int v) { return {char(v & 255), char(v >> 8)}; }
std::string text(std::initializer_list<double> x) {
  std::string t;
  for (const double v : x) t += (t.empty() ? "" : "\\") + std::to_string(v);
  return t;
}

/// Elements of a DICOM file, one behind the other.
struct Elements {
  bool explicit_vr = true;
  std::string bytes;

  void head(uint32_t tag, const char* vr, uint32_t length) {
    for (const uint32_t half : {tag >> 16, tag & 0xffff}) bytes += char(half & 255), bytes += char(half >> 8);
    const std::string type = vr;
    const bool wide = type == "OW" || type == "OB" || type == "SQ";
    const bool typed = explicit_vr && tag >> 16 != 0xfffe;
    if (typed) bytes += type + (wide ? std::string(2, 0) : "");
    for (int b = 0; b < (typed && !wide ? 2 : 4); ++b, length >>= 8) bytes += char(length & 255);
  }
  void element(uint32_t tag, const char* vr, std::string v) {
    if (v.size() % 2) v += vr[0] == 'U' && vr[1] == 'I' ? '\0' : ' ';
    head(tag, vr, uint32_t(v.size()));
    bytes += v;
  }
  /// A sequence with these items, with their lengths or without.
  void sequence(uint32_t tag, const std::vector<Elements>& items, bool with_lengths) {
    Elements all;
    for (const Elements& item : items) {
      all.head(0xfffee000, "", with_lengths ? uint32_t(item.bytes.size()) : ~0u);
      all.bytes += item.bytes;
      if (!with_lengths) all.head(0xfffee00d, "", 0);
    }
    if (!with_lengths) all.head(0xfffee0dd, "", 0);
    head(tag, "SQ", with_lengths ? uint32_t(all.bytes.size()) : ~0u);
    bytes += all.bytes;
  }
};

std::string plain_pixels(const Slice& s) {
  std::string pixels;
  for (int j = 0; j < s.rows; ++j)
    for (int i = 0; i < s.columns; ++i) pixels += number(uint16_t(s.value(i, j)));
  return pixels;
}
/// A header of 64 bytes, the high bytes, the low bytes.
std::string run_length_pixels(const Slice& s) {
  const std::string pixels = plain_pixels(s);
  std::string plane[2];
  for (size_t i = 0; i < pixels.size(); ++i) plane[1 - i % 2] += pixels[i];
  for (std::string& p : plane) p = run_lengths(p);
  std::string header(64, 0);
  put<uint32_t>(header, 0, 2, false), put<uint32_t>(header, 4, 64, false),
      put<uint32_t>(header, 8, uint32_t(64 + plane[0].size()), false);
  return header + plane[0] + plane[1];
}

/// From DICM to the pixels, and these: of one slice, or of several frames with these groups.
std::string dicom_of(const Slice& s, const std::vector<Slice>& frames, const Elements& groups) {
  Elements meta;
  meta.bytes = std::string(128, 0) + "DICM";
  const std::string plain = s.run_length    ? "1.2.840.10008.1.2.5"
                            : s.explicit_vr ? "1.2.840.10008.1.2.1"
                                            : "1.2.840.10008.1.2";
  meta.element(0x00020010, "UI", s.syntax.empty() ? plain : s.syntax);
  Elements e{s.explicit_vr, meta.bytes};
  const bool grouped = !groups.bytes.empty();
  if (!s.image_type.empty()) e.element(0x00080008, "CS", s.image_type);
  e.element(0x00080016, "UI", std::string("1.2.840.10008.5.1.4.1.1.2") + (grouped ? ".1" : ""));
  e.element(0x00080018, "UI", s.series + ".7." + std::to_string(int(s.at.z() * 10) + 5000));
  e.element(0x00080060, "CS", s.modality);
  e.element(0x0008103e, "LO", s.description);
  if (s.sequence) {
    Elements item{s.explicit_vr, ""};
    item.element(0x00081150, "UI", "1.2");
    e.sequence(0x00082112, {item}, false);
  }
  if (!s.patient.empty()) e.element(0x00100020, "LO", s.patient);
  if (!s.body_part.empty()) e.element(0x00180015, "CS", s.body_part);
  if (!s.kernel.empty()) e.element(0x00181210, "SH", s.kernel);
  e.element(0x0020000e, "UI", s.series);
  if (!grouped) {
    e.element(0x00200032, "DS", text({s.at.x(), s.at.y(), s.at.z()}));
    e.element(0x00200037, "DS", text({s.across.x(), s.across.y(), s.across.z(), s.down.x(), s.down.y(), s.down.z()}));
  }
  e.element(0x00280002, "US", number(1)), e.element(0x00280004, "CS", "MONOCHROME2");
  if (grouped)
    e.element(0x00280008, "IS", std::to_string(frames.size()));
  else if (s.frames > 1)
    e.element(0x00280008, "IS", std::to_string(s.frames));
  e.element(0x00280010, "US", number(s.rows)), e.element(0x00280011, "US", number(s.columns));
  if (!grouped) e.element(0x00280030, "DS", text({s.spacing, s.spacing}));
  e.element(0x00280100, "US", number(16)), e.element(0x00280101, "US", number(16));
  e.element(0x00280102, "US", number(15)), e.element(0x00280103, "US", number(1));
  if (s.padding != 0) e.element(0x00280120, "SS", number(s.padding));
  if (!grouped) e.element(0x00281052, "DS", text({s.intercept})), e.element(0x00281053, "DS", text({s.slope}));
  e.bytes += groups.bytes;
  std::string pixels;
  if (!s.run_length) {
    for (const Slice& f : frames) pixels += plain_pixels(f);
    e.element(0x7fe00010, "OW", pixels);
    return e.bytes;
  }
  // An empty table of offsets, then one fragment for each frame.
  std::vector<Elements> fragments(1);
  for (const Slice& f : frames) fragments.push_back({false, run_length_pixels(f)});
  Elements packed;
  for (const Elements& f : fragments) packed.element(0xfffee000, "", f.bytes);
  packed.head(0xfffee0dd, "", 0);
  e.head(0x7fe00010, "OB", ~0u);
  return e.bytes + packed.bytes;
}

}  // namespace

std::string dicom(const Slice& s) { return dicom_of(s, {s}, {}); }

std::string enhanced_dicom(const std::vector<Slice>& frames, bool with_lengths) {
  const Slice& s = frames.front();
  const auto group = [&](Elements& of, uint32_t tag, const Elements& holds) {
    of.sequence(tag, {holds}, with_lengths);
  };
  const auto plane = [](const Slice& f) {
    Elements e{f.explicit_vr, ""};
    e.element(0x00200032, "DS", text({f.at.x(), f.at.y(), f.at.z()}));
    return e;
  };
  Elements direction{s.explicit_vr, ""}, spacing = direction, shared = direction, groups = direction;
  direction.element(0x00200037, "DS",
                    text({s.across.x(), s.across.y(), s.across.z(), s.down.x(), s.down.y(), s.down.z()}));
  spacing.element(0x00280030, "DS", text({s.spacing, s.spacing}));
  group(shared, 0x00209116, direction), group(shared, 0x00289110, spacing);
  std::vector<Elements> per_frame;
  for (const Slice& f : frames) {
    Elements item{s.explicit_vr, ""}, values = item, content = item;
    Slice elsewhere = f;
    elsewhere.at += Vec3(1, 2, 3);
    content.element(0x00209056, "SH", f.stack);
    group(item, 0x00209111, content), group(item, 0x00209113, plane(f));
    group(item, 0x00211001, plane(elsewhere));  // a maker's own: another place
    values.element(0x00281052, "DS", text({f.intercept})), values.element(0x00281053, "DS", text({f.slope}));
    group(item, 0x00289145, values);
    per_frame.push_back(item);
  }
  groups.sequence(0x52009229, {shared}, with_lengths);
  groups.sequence(0x52009230, per_frame, with_lengths);
  return dicom_of(s, frames, groups);
}

std::string obj_file() {
  std::string s = "# a comment\n";
  for (const Vec3& p : kCorner)
    s += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const Tri& q : kTriangle)
    s += "f " + std::to_string(q[0] + 1) + "/1 " + std::to_string(q[1] - 4) + " " + std::to_string(q[2] + 1) + "//2\n";
  return s;
}

std::string stl_file(bool binary) {
  std::string s = binary ? std::string(84, ' ') : "solid a\n";
  if (binary) put<uint32_t>(s, 80, uint32_t(kTriangle.size()), false);
  for (const Tri& q : kTriangle) {
    const size_t at = s.size();
    if (binary)
      s.resize(at + 50);
    else
      s += "facet normal 0 0 0\nouter loop\n";
    for (size_t c = 0; c < 3; ++c) {
      const Vec3& p = kCorner[size_t(q[c])];
      if (binary)
        for (size_t k = 0; k < 3; ++k) put(s, at + 12 + 12 * c + 4 * k, float(p[int(k)]), false);
      else
        s += "vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    }
    if (!binary) s += "endloop\nendfacet\n";
  }
  return binary ? s : s + "endsolid a\n";
}

std::string ply_file(Ply form) {
  const char* name = form == Ply::text ? "ascii" : form == Ply::little ? "binary_little_endian" : "binary_big_endian";
  std::string s = std::string("ply\nformat ") + name +
                  " 1.0\ncomment by hand\nelement vertex 4\nproperty double x\nproperty float y\nproperty short "
                  "z\nproperty uchar red\nelement face 4\nproperty list uchar uint vertex_index\nend_header\n";
  if (form == Ply::text) {
    for (const Vec3& p : kCorner)
      s += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(int(p.z())) + " 7\n";
    for (const Tri& q : kTriangle)
      s += "3 " + std::to_string(q[0]) + " " + std::to_string(q[1]) + " " + std::to_string(q[2]) + "\n";
    return s;
  }
  const bool big = form == Ply::big;
  size_t at = s.size();
  s.resize(at + kCorner.size() * 15 + kTriangle.size() * 13);
  for (const Vec3& p : kCorner)
    put(s, at, p.x(), big), put(s, at + 8, float(p.y()), big), put(s, at + 12, int16_t(p.z()), big), s[at + 14] = 7,
                                                                                                            at += 15;
  for (const Tri& q : kTriangle) {
    s[at++] = 3;
    for (const int32_t c : q) put(s, at, uint32_t(c), big), at += 4;
  }
  return s;
}

}  // namespace limberg::fuzz
