// NIfTI, DICOM series and surfaces from files: every way of writing the same, every way of breaking it, and bytes changed at random.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include "sim/error.h"
#include "sim/imaging/dicom.h"
#include "sim/imaging/surface_file.h"
#include "sim/imaging/volume.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

class Readers : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() / ("limberg_readers_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(dir_);
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  std::string write(const std::string& name, const std::string& content) {
    const fs::path path = dir_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string message(const std::function<void()>& f) {
    try {
      f();
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path dir_;
};

template <class T>
void put(std::string& s, size_t at, T v, bool big) {
  char b[sizeof(T)];
  std::memcpy(b, &v, sizeof(T));
  if (big) std::reverse(b, b + sizeof(T));
  std::memcpy(s.data() + at, b, sizeof(T));
}

double expected(int i, int j, int k) { return 100 + i + 10 * j - 7 * k; }

/// 3 x 4 x 5 of int16, spacing 2, 3, 4.
std::string nifti(bool big, int form, float slope = 1, float inter = 0) {
  std::string s(352, 0);
  put<int32_t>(s, 0, 348, big);
  const int16_t dim[8] = {3, 3, 4, 5, 1, 1, 1, 1};
  for (size_t k = 0; k < 8; ++k) put(s, 40 + 2 * k, dim[k], big);
  put<int16_t>(s, 70, 4, big), put<int16_t>(s, 72, 16, big);
  const float pixdim[4] = {1, 2, 3, 4};
  for (size_t k = 0; k < 4; ++k) put(s, 76 + 4 * k, pixdim[k], big);
  put<float>(s, 108, 352, big), put(s, 112, slope, big), put(s, 116, inter, big);
  s[123] = 2;
  if (form == 1) {  // qform: no turn
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
      for (int i = 0; i < 3; ++i) put(s, 352 + 2 * size_t(i + 3 * (j + 4 * k)), int16_t(expected(i, j, k)), big);
  return s;
}

TEST_F(Readers, Nifti) {
  for (const bool big : {false, true})
    for (const int form : {1, 2}) {
      const Volume v = load_volume(write("a.nii", nifti(big, form, 2, 5)));
      ASSERT_EQ(v.size, (std::array<int32_t, 3>{3, 4, 5}));
      // Right, anterior, superior turned to left, posterior, superior.
      EXPECT_TRUE(v.step_mm.isApprox(Mat3(Vec3(-2, -3, 4).asDiagonal()), 1e-6));
      EXPECT_TRUE(v.origin_mm.isApprox(Vec3(10, 20, 30), 1e-6));
      for (int k = 0; k < 5; ++k)
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 3; ++i) EXPECT_EQ(v.value[v.index(i, j, k)], float(2 * expected(i, j, k) + 5));
    }
  const std::string good = nifti(false, 2);
  const auto broken = [&](const std::function<void(std::string&)>& change) {
    std::string s = good;
    change(s);
    return message([&] { load_volume(write("b.nii", s)); });
  };
  EXPECT_EQ(broken([](std::string&) {}), "accepted");
  EXPECT_NE(broken([](std::string& s) { put<int16_t>(s, 40, 2, false); }).find("3 were expected"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<int16_t>(s, 70, 128, false); }).find("type 128"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<int16_t>(s, 42, 0, false); }).find("voxels"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<int16_t>(s, 42, 2000, false), put<int16_t>(s, 44, 2000, false), put<int16_t>(s, 46, 2000, false); }).find("voxels"), std::string::npos);  // 16 GB
  EXPECT_NE(broken([](std::string& s) { put<int16_t>(s, 42, 700, false), put<int16_t>(s, 44, 700, false), put<int16_t>(s, 46, 700, false); }).find("cut short"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { s.pop_back(); }).find("cut short"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<float>(s, 280, 1e9f, false); }).find("mm long"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<float>(s, 112, NAN, false); }).find("finite"), std::string::npos);
  EXPECT_NE(broken([](std::string& s) { put<float>(s, 108, 4, false); }).find("vox_offset"), std::string::npos);
}

struct Slice {
  bool explicit_vr = true, sequence = true;
  std::string series = "1.2.3", description = "head", syntax;
  Vec3 at = Vec3::Zero();
  int columns = 6, rows = 5, number = 0;
  double slope = 1, intercept = 0, spacing = 2;
  std::function<int16_t(int, int)> value = [](int i, int j) { return int16_t(i + 10 * j); };
};

std::string dicom(const Slice& s) {
  std::string out(128, 0);
  out += "DICM";
  const auto element = [&](uint32_t tag, const char* vr, std::string v, bool with_vr) {
    if (v.size() % 2) v += vr[0] == 'U' && vr[1] == 'I' ? '\0' : ' ';
    for (const uint32_t half : {tag >> 16, tag & 0xffff}) out += char(half & 255), out += char(half >> 8);
    uint32_t n = uint32_t(v.size());
    const bool wide = std::string(vr) == "OW" || std::string(vr) == "OB";
    if (with_vr) {
      out += vr;
      if (wide) out += std::string(2, 0);
    }
    for (int b = 0; b < (with_vr && !wide ? 2 : 4); ++b, n >>= 8) out += char(n & 255);
    out += v;
  };
  const auto number = [](int v) { return std::string{char(v & 255), char(v >> 8)}; };
  const auto text = [](std::initializer_list<double> x) {
    std::string t;
    for (const double v : x) t += (t.empty() ? "" : "\\") + std::to_string(v);
    return t;
  };
  element(0x00020010, "UI", !s.syntax.empty() ? s.syntax : s.explicit_vr ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2", true);
  const bool e = s.explicit_vr;
  element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2", e), element(0x00080018, "UI", s.series + ".7." + std::to_string(int(s.at.z() * 10) + 5000), e);
  element(0x00080060, "CS", "CT", e);
  element(0x0008103e, "LO", s.description, e);
  if (s.sequence) {  // of undefined length, an item of undefined length with an element in it
    out += std::string("\x08\x00\x12\x21", 4) + (e ? std::string("SQ\0\0", 4) : "") + std::string(4, char(255));
    out += std::string("\xfe\xff\x00\xe0", 4) + std::string(4, char(255));
    element(0x00081150, "UI", "1.2", e);
    out += std::string("\xfe\xff\x0d\xe0\0\0\0\0", 8) + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  }
  element(0x0020000e, "UI", s.series, e);
  element(0x00200032, "DS", text({s.at.x(), s.at.y(), s.at.z()}), e);
  element(0x00200037, "DS", text({1, 0, 0, 0, 1, 0}), e);
  element(0x00280002, "US", number(1), e), element(0x00280004, "CS", "MONOCHROME2", e);
  element(0x00280010, "US", number(s.rows), e), element(0x00280011, "US", number(s.columns), e);
  element(0x00280030, "DS", text({s.spacing, s.spacing}), e);
  element(0x00280100, "US", number(16), e), element(0x00280101, "US", number(16), e), element(0x00280102, "US", number(15), e), element(0x00280103, "US", number(1), e);
  element(0x00281052, "DS", text({s.intercept}), e), element(0x00281053, "DS", text({s.slope}), e);
  std::string pixels;
  for (int j = 0; j < s.rows; ++j)
    for (int i = 0; i < s.columns; ++i) pixels += number(uint16_t(s.value(i, j)));
  element(0x7fe00010, "OW", pixels, e);
  return out;
}

TEST_F(Readers, DicomSeriesInAnyOrder) {
  for (const bool explicit_vr : {true, false}) {
    for (int k = 0; k < 7; ++k) {
      Slice s;
      s.explicit_vr = explicit_vr, s.at = {1, 2, 30. - 4 * k}, s.slope = 2, s.intercept = -24;
      s.value = [k](int i, int j) { return int16_t(i + 10 * j + 100 * k); };
      write("d/s" + std::to_string(k), dicom(s));
    }
    write("d/readme.txt", "no slice");
    for (const char* path : {"d", "d/s3"}) {
      const Volume v = load_volume(dir_ / path);
      ASSERT_EQ(v.size, (std::array<int32_t, 3>{6, 5, 7}));
      EXPECT_TRUE(v.step_mm.isApprox(Mat3(Vec3(2, 2, 4).asDiagonal()), 1e-9));
      EXPECT_TRUE(v.origin_mm.isApprox(Vec3(1, 2, 6), 1e-9));
      EXPECT_EQ(v.value[v.index(3, 2, 0)], float(2 * (3 + 20 + 600) - 24));
      EXPECT_EQ(v.value[v.index(5, 4, 6)], float(2 * (5 + 40) - 24));
    }
  }
}

TEST_F(Readers, TiltAndUnevenGapsAreEvenedOut) {
  // A field linear in space, so that interpolation is exact: f = 2 x + 3 y + 5 z + 100.
  const double z[] = {0, 3, 5, 9, 10.5, 14, 16};
  for (const double tilt : {0., 0.25})
    for (int k = 0; k < 7; ++k) {
      Slice s;
      s.columns = 16, s.rows = 20, s.at = {0, tilt * z[k], z[k]};
      s.value = [&](int i, int j) { return int16_t(std::lround(10 * (2 * (2. * i) + 3 * (2. * j + tilt * z[k]) + 5 * z[k] + 100))); };
      s.slope = 0.1;
      write("t" + std::to_string(int(tilt * 100)) + "/" + std::to_string(k), dicom(s));
    }
  for (const char* d : {"t0", "t25"}) {
    const Volume v = load_volume(dir_ / d);
    EXPECT_NEAR(v.step_mm.col(0).dot(v.step_mm.col(2)), 0, 1e-9);
    EXPECT_NEAR(v.step_mm.col(1).dot(v.step_mm.col(2)), 0, 1e-9);
    EXPECT_NEAR(v.step_mm(2, 2), 1.5, 1e-9);  // the smallest gap
    int seen = 0;
    for (int k = 0; k < v.size[2]; ++k)
      for (int j = 4; j < 16; ++j)
        for (int i = 0; i < 16; ++i, ++seen) {
          const Vec3 x = v.place(Vec3(i, j, k));
          EXPECT_NEAR(double(v.value[v.index(i, j, k)]), 2 * x.x() + 3 * x.y() + 5 * x.z() + 100, 0.11);
        }
    EXPECT_GT(seen, 1000);
  }
}

TEST_F(Readers, BrokenSeriesAreRefusedByName) {
  const auto series = [&](const std::string& d, const std::function<void(int, Slice&)>& change, int n = 8) {
    for (int k = 0; k < n; ++k) {
      Slice s;
      s.at.z() = 2 * k;
      change(k, s);
      if (s.columns > 0) write(d + "/s" + std::to_string(k), dicom(s));
    }
    return message([&] { load_volume(dir_ / d); });
  };
  EXPECT_EQ(series("good", [](int, Slice&) {}), "accepted");
  EXPECT_NE(series("missing", [](int k, Slice& s) { if (k == 3 || k == 4) s.columns = 0; }).find("2 slices are missing"), std::string::npos);
  EXPECT_NE(series("twice", [](int k, Slice& s) { if (k == 3) s.at.z() = 4; }).find("lies where"), std::string::npos);
  EXPECT_NE(series("sizes", [](int k, Slice& s) { if (k == 3) s.columns = 7; }).find("one size"), std::string::npos);
  EXPECT_NE(series("far", [](int k, Slice& s) { s.at.z() = k < 4 ? k : 20.7 + 1.7 * k; }).find("at most 10 mm"), std::string::npos);
  EXPECT_NE(series("spacing", [](int, Slice& s) { s.spacing = 1e7; }).find("mm long"), std::string::npos);
  EXPECT_NE(series("nan", [](int, Slice& s) { s.intercept = NAN; }).find("finite"), std::string::npos);
  EXPECT_NE(series("big", [](int, Slice& s) { s.syntax = "1.2.840.10008.1.2.2"; }).find("big endian"), std::string::npos);
  // Plain numbers under a compressed syntax: GDCM, where it is built in, sees through that.
  const std::string packed = series("packed", [](int, Slice& s) { s.syntax = "1.2.840.10008.1.2.4.70"; });
  EXPECT_TRUE(packed == "accepted" || packed.find("compressed") != std::string::npos) << packed;
  EXPECT_NE(series("strange", [](int, Slice& s) { s.syntax = "1.9"; }).find("not known"), std::string::npos);
  EXPECT_NE(series("one", [](int, Slice&) {}, 1).find("at least 2"), std::string::npos);
  fs::create_directories(dir_ / "empty");
  EXPECT_NE(message([&] { load_volume(dir_ / "empty"); }).find("no DICOM"), std::string::npos);
  // Two series in one folder: listed; the one asked for is taken.
  const std::string both = series("both", [](int k, Slice& s) { if (k % 2) s.series = "1.2.4", s.description = "thorax"; });
  EXPECT_NE(both.find("2 series"), std::string::npos);
  EXPECT_NE(both.find("thorax"), std::string::npos);
  for (const char* name : {"2", "1.2.4", "thorax"}) EXPECT_EQ(load_volume(dir_ / "both", name).size[2], 4);
  EXPECT_NE(message([&] { load_volume(dir_ / "both", "knee"); }).find("no series"), std::string::npos);
  // Sixteen GB are claimed by a file of two hundred bytes.
  Slice s;
  std::string huge = dicom(s);
  const size_t rows = huge.find(std::string("\x28\x00\x10\x00US\x02\x00", 8));
  ASSERT_NE(rows, std::string::npos);
  huge[rows + 8] = huge[rows + 9] = char(0xff), huge[rows + 18] = huge[rows + 19] = char(0xff);
  write("huge/a", huge), s.at.z() = 1;
  write("huge/b", huge);
  EXPECT_NE(message([&] { load_volume(dir_ / "huge"); }), "accepted");
}

TEST_F(Readers, CompressedSlicesThroughGdcm) {
  // Packed by another program, where it is installed and this build has GDCM; all of these lose nothing.
  if (std::system("gdcmconv --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "gdcmconv is not installed";
  for (const char* how : {"--jpeg", "--jpegls", "--j2k", "--rle"}) {
    const std::string to = std::string("packed") + how;
    fs::create_directories(dir_ / to);
    for (int k = 0; k < 4; ++k) {
      Slice s;
      s.sequence = false, s.columns = 24, s.rows = 20, s.at.z() = 2 * k, s.intercept = -24;
      s.value = [k](int i, int j) { return int16_t(i * j + 10 * j + 100 * k); };
      const std::string from = write("whole/s" + std::to_string(k), dicom(s));
      const std::string command = std::string("gdcmconv ") + how + " '" + from + "' '" + (dir_ / to / ("s" + std::to_string(k))).string() + "' > /dev/null 2>&1";
      ASSERT_EQ(std::system(command.c_str()), 0) << command;
    }
    try {
      const Volume v = load_volume(dir_ / to), whole = load_volume(dir_ / "whole");
      EXPECT_EQ(v.size, whole.size) << how;
      EXPECT_TRUE(v.value == whole.value) << how;
    } catch (const InputError& e) {
      if (std::string(e.what()).find("GDCM") == std::string::npos || std::string(e.what()).find("damaged") != std::string::npos) throw;
      GTEST_SKIP() << e.what();
    }
  }
}

TEST_F(Readers, SurfacesFromEveryFormat) {
  // A tetrahedron.
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  const std::vector<Tri> t{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const auto same = [&](const Surface& s) {
    ASSERT_EQ(s.x_mm.size(), 4u);
    ASSERT_EQ(s.tri.size(), 4u);
    double volume = 0;
    for (const Tri& q : s.tri) volume += s.x_mm[size_t(q[0])].dot(s.x_mm[size_t(q[1])].cross(s.x_mm[size_t(q[2])])) / 6;
    EXPECT_NEAR(volume, 1, 1e-6);
  };
  std::string obj = "# a comment\n", ascii = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                                            "element face 4\nproperty list uchar int vertex_indices\nend_header\n",
              stl = "solid a\n";
  for (const Vec3& p : x) obj += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n", ascii += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + " 7\n";
  for (const Tri& q : t) {
    obj += "f " + std::to_string(q[0] + 1) + "/1 " + std::to_string(q[1] - 4) + " " + std::to_string(q[2] + 1) + "//2\n";
    ascii += "3 " + std::to_string(q[0]) + " " + std::to_string(q[1]) + " " + std::to_string(q[2]) + "\n";
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const int32_t c : q) stl += "vertex " + std::to_string(x[size_t(c)].x()) + " " + std::to_string(x[size_t(c)].y()) + " " + std::to_string(x[size_t(c)].z()) + "\n";
    stl += "endloop\nendfacet\n";
  }
  same(load_surface(write("a.obj", obj)));
  same(load_surface(write("a.ply", ascii)));
  same(load_surface(write("a.stl", stl + "endsolid a\n")));
  for (const bool big : {false, true}) {
    std::string s = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty short z\nelement face 4\nproperty list uchar uint vertex_index\nend_header\n";
    size_t at = s.size();
    s.resize(at + 4 * 14 + 4 * 13);
    for (const Vec3& p : x) put(s, at, p.x(), big), put(s, at + 8, float(p.y()), big), put(s, at + 12, int16_t(p.z()), big), at += 14;
    for (const Tri& q : t) {
      s[at++] = 3;
      for (const int32_t c : q) put(s, at, uint32_t(c), big), at += 4;
    }
    same(load_surface(write("b.ply", s)));
    for (const size_t n : {s.size() - 1, s.size() - 30, s.size() - 60}) EXPECT_NE(message([&] { parse_surface(std::string_view(s).substr(0, n), "b.ply"); }).find("cut short"), std::string::npos);
  }
  std::string binary(84, ' ');
  put<uint32_t>(binary, 80, 4, false);
  for (const Tri& q : t) {
    size_t at = binary.size();
    binary.resize(at + 50);
    for (size_t c = 0; c < 3; ++c)
      for (size_t k = 0; k < 3; ++k) put(binary, at + 12 + 12 * c + 4 * k, float(x[size_t(q[c])][int(k)]), false);
  }
  same(load_surface(write("b.stl", binary)));
  EXPECT_NE(message([&] { parse_surface(binary.substr(0, 200), "b.stl"); }).find("cut short"), std::string::npos);
  const Surface cloud = load_surface(write("a.xyz", "# scan\n0 0 1\n1,2,3,255\n\n4 5 6 0.1 0.2\n"));
  EXPECT_EQ(cloud.x_mm.size(), 3u);
  EXPECT_TRUE(cloud.tri.empty());
  EXPECT_NE(message([] { parse_surface("v 0 0 0\nf 1 2 3\n", "a.obj"); }).find("a.obj:2"), std::string::npos);
  EXPECT_NE(message([] { parse_surface("v 0 0 inf\n", "a.obj"); }).find("finite"), std::string::npos);
  EXPECT_NE(message([] { parse_surface("1 2\n", "a.xyz"); }).find("three numbers"), std::string::npos);
  EXPECT_NE(message([] { parse_surface("ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nend_header\n", "a.ply"); }).find("more than the file"), std::string::npos);
  EXPECT_NE(message([] { parse_surface("hello\n", "a.obj"); }).find("no kind"), std::string::npos);
}

/// splitmix64
struct Random {
  uint64_t s;
  uint64_t next() {
    uint64_t z = s += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull, z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return z ^ z >> 31;
  }
  size_t below(size_t n) { return size_t(next() % n); }
};

std::string damaged(std::string s, Random& r) {
  for (size_t n = 1 + r.below(4); n-- > 0 && !s.empty();) {
    const size_t at = r.below(r.below(2) ? std::min<size_t>(s.size(), 400) : s.size());
    switch (r.below(6)) {
      case 0: s[at] = char(r.next()); break;
      case 1: s[at] = char(s[at] ^ 1 << r.below(8)); break;
      case 2: s.erase(at, 1 + r.below(8)); break;
      case 3: s.insert(at, std::string(1 + r.below(8), char(r.next()))); break;
      case 4: s.resize(at); break;
      default: for (size_t k = at; k < std::min(s.size(), at + 4); ++k) s[k] = char(0xff); break;
    }
  }
  return s;
}

TEST_F(Readers, DamagedFilesAreRefusedOrSound) {
  Random r{2026};
  int taken = 0, refused = 0;
  const auto volume = [&](const std::string& path) {
    try {
      const Volume v = load_volume(path);
      ++taken;
      ASSERT_EQ(v.value.size(), size_t(v.size[0]) * size_t(v.size[1]) * size_t(v.size[2]));
      ASSERT_TRUE(v.step_mm.allFinite() && v.origin_mm.allFinite());
      for (const float x : v.value) ASSERT_TRUE(std::isfinite(x));
    } catch (const InputError& e) {
      ++refused;
      ASSERT_NE(std::string(e.what()), "");
    }
  };
  const std::string data(120, 'a'), nrrd = "NRRD0004\ndimension: 3\nsizes: 3 4 5\nspace: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\ntype: short\nendian: little\nencoding: raw\n\n" + data,
              meta = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementSpacing = 2 3 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + data;
  for (int i = 0; i < 1500; ++i) {
    volume(write("f", damaged(nifti(i % 2, 1 + i % 2), r)));
    volume(write("f", damaged(i % 2 ? nrrd : meta, r)));
  }
  std::vector<std::string> slice;
  for (int k = 0; k < 3; ++k) {
    Slice s;
    s.explicit_vr = true, s.at.z() = k;
    slice.push_back(dicom(s)), s.explicit_vr = false, slice.push_back(dicom(s));
  }
  for (int i = 0; i < 1000; ++i) {
    const size_t hit = r.below(3);
    for (size_t k = 0; k < 3; ++k)
      if (k == hit || i == 0) write("series/" + std::to_string(k), k == hit ? damaged(slice[2 * k + size_t(i % 2)], r) : slice[2 * k]);
    volume(dir_ / "series");
    write("series/" + std::to_string(hit), slice[2 * hit]);
  }
  const std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n" +
                          std::string(36, 0) + std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13),
                    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (int i = 0; i < 3000; ++i) {
    const char* name[] = {"a.ply", "a.obj", "a.stl", "a.xyz"};
    try {
      const Surface s = parse_surface(damaged(i % 2 ? ply : text, r), name[i % 4]);
      ++taken;
      for (const Vec3& x : s.x_mm) ASSERT_TRUE(x.allFinite());
      for (const Tri& q : s.tri)
        for (const int32_t c : q) ASSERT_TRUE(c >= 0 && size_t(c) < s.x_mm.size());
    } catch (const InputError&) {
      ++refused;
    }
  }
  std::printf("%d taken, %d refused\n", taken, refused);
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 1000);
}

TEST_F(Readers, TheRealSeriesIsTheRealVolume) {
  const char* path = std::getenv("LIMBERG_CT_HEAD");  // its .nhdr; the series lies in dicom/ beside it
  if (!path || !fs::is_directory(fs::path(path).parent_path() / "dicom")) GTEST_SKIP() << "LIMBERG_CT_HEAD is not set, or has no dicom folder beside it";
  const Volume a = load_volume(path), b = load_volume(fs::path(path).parent_path() / "dicom");
  ASSERT_EQ(a.size, b.size);
  EXPECT_TRUE(a.value == b.value);
  EXPECT_TRUE(a.step_mm.isApprox(b.step_mm, 1e-6));
}

}  // namespace
}  // namespace limberg
