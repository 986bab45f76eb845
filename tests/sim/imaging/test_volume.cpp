// Volumes from NRRD and MetaImage: every way of writing the same numbers, and every way of breaking them.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "sim/imaging/io/volume.h"

namespace limberg {
namespace test_volume {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() /
           ("limberg_imaging_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  std::string write(const std::string& name, const std::string& content) {
    const std::string path = dir_ / name;
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  std::string message(const std::string& content) {
    try {
      load_volume(write("broken", content));
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path dir_;
};

template <class T>
std::string numbers(bool big) {  // 3 x 4 x 5: 100 + i + 10 j - 7 k
  std::string s;
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i) {
        const T v = T(100 + i + 10 * j - 7 * k);
        char b[sizeof(T)];
        std::memcpy(b, &v, sizeof(T));
        if (big) std::reverse(b, b + sizeof(T));
        s.append(b, sizeof(T));
      }
  return s;
}

std::string gz(const std::string& s) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(s.size() + 1000, 0);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(s.data())), z.avail_in = uInt(s.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

const std::string kNrrd =
    "NRRD0004\n# by hand\ndimension: 3\nsizes: 3 4 5\nspace: left-posterior-superior\n"
    "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n";
const std::string kMeta = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementSpacing = 2 3 4\nOffset = 10 20 30\n";

void expect_good(const Volume& v) {
  ASSERT_EQ(v.value.size(), 60u);
  const VolumeSampler s(v);
  for (double i : {0., 0.5, 2.})
    for (double j : {0., 1.25, 3.})
      for (double k : {0., 2.75, 4.}) {
        const Vec3 x(10 + 2 * i, 20 + 3 * j, 30 + 4 * k);
        EXPECT_TRUE(s.inside(x));
        EXPECT_NEAR(s.value(x), 100 + i + 10 * j - 7 * k, 1e-5);
      }
  EXPECT_NEAR(s.gradient({12, 25, 38}).x(), 1 / 2., 1e-6);
  EXPECT_NEAR(s.gradient({12, 25, 38}).y(), 10 / 3., 1e-6);
  EXPECT_NEAR(s.gradient({12, 25, 38}).z(), -7 / 4., 1e-6);
  EXPECT_FALSE(s.inside({9.9, 20, 30}));
  EXPECT_NEAR(s.value({-100, 20, 30}), 100, 1e-6);
}

TEST_F(Files, EveryWayOfWritingTheSame) {
  const auto nrrd = [&](const char* type, bool big, const std::string& data) {
    const std::string head = kNrrd + "type: " + type + "\nendian: " + (big ? "big" : "little") + "\n";
    expect_good(load_volume(write("a.nrrd", head + "encoding: raw\n\n" + data)));
    expect_good(load_volume(write("a.nrrd", head + "encoding: gzip\n\n" + gz(data))));
    write("a.raw", data), write("a.raw.gz", gz(data)), write("padded", "xyz" + data);
    expect_good(load_volume(write("a.nhdr", head + "encoding: raw\ndata file: a.raw\n")));
    expect_good(load_volume(write("a.nhdr", head + "encoding: gzip\ndata file: a.raw.gz\n")));
    expect_good(load_volume(write("a.nhdr", head + "encoding: raw\nbyte skip: 3\ndata file: padded\n")));
    expect_good(load_volume(write("a.nhdr", head + "encoding: raw\nbyte skip: -1\ndata file: padded\n")));
  };
  const auto meta = [&](const char* type, bool big, const std::string& data) {
    const std::string head =
        kMeta + "ElementType = " + type + "\nBinaryDataByteOrderMSB = " + (big ? "True" : "False") + "\n";
    expect_good(load_volume(write("a.mha", head + "ElementDataFile = LOCAL\n" + data)));
    expect_good(load_volume(write("a.mha", head + "CompressedData = True\nElementDataFile = LOCAL\n" + gz(data))));
    write("a.raw", data);
    expect_good(load_volume(write("a.mhd", head + "ElementDataFile = a.raw\n")));
  };
  for (bool big : {false, true}) {
    nrrd("short", big, numbers<int16_t>(big)), meta("MET_SHORT", big, numbers<int16_t>(big));
    nrrd("ushort", big, numbers<uint16_t>(big)), meta("MET_USHORT", big, numbers<uint16_t>(big));
    nrrd("int", big, numbers<int32_t>(big)), meta("MET_INT", big, numbers<int32_t>(big));
    nrrd("float", big, numbers<float>(big)), meta("MET_FLOAT", big, numbers<float>(big));
    nrrd("double", big, numbers<double>(big)), meta("MET_DOUBLE", big, numbers<double>(big));
    nrrd("uchar", big, numbers<uint8_t>(big)), meta("MET_UCHAR", big, numbers<uint8_t>(big));
  }
}

TEST_F(Files, FramesAreTurnedIntoLeftPosteriorSuperior) {
  std::string head = kNrrd;
  head.replace(head.find("left-posterior"), 23, "right-anterior-superior");
  const Volume v = load_volume(write("a.nrrd", head + "type: uchar\nencoding: raw\n\n" + numbers<uint8_t>(false)));
  EXPECT_EQ(v.origin_mm, Vec3(-10, -20, 30));
  EXPECT_EQ(v.step_mm.col(0), Vec3(-2, 0, 0));
  const Volume m = load_volume(write(
      "a.mha", kMeta + "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                   numbers<uint8_t>(false)));
  EXPECT_EQ(m.place({1, 0, 0}), Vec3(10, 22, 30));
  EXPECT_NEAR(VolumeSampler(m).value(m.place({2, 3, 4})), 104, 1e-5);
}

/// Of this process, as the kernel counts it.
size_t most_address_space_kB() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmPeak:")) return std::stoul(line.substr(7));
  return 0;
}

// A header may say 600 x 600 x 600 over 120 bytes: no room is asked for before the bytes are there.
TEST_F(Files, APromiseOfMuchAsksForNoRoom) {
  const std::string data = numbers<int16_t>(false);
  for (const auto& [encoding, bytes] : {std::pair{"raw", data}, {"gzip", gz(data)}}) {
    std::string head = kNrrd + "type: short\nendian: little\nencoding: " + encoding + "\n\n";
    head.replace(head.find("3 4 5"), 5, "600 600 600");
    const size_t before_kB = most_address_space_kB();
    ASSERT_GT(before_kB, 0u);
    EXPECT_NE(message(head + bytes).find("cut short"), std::string::npos) << encoding;
    EXPECT_LT(most_address_space_kB() - before_kB, 100'000u) << encoding << ": the volume would have 864,000 kB";
  }
}

TEST_F(Files, BrokenFilesHaveAMessage) {
  const std::string data = numbers<int16_t>(false), head = kNrrd + "type: short\nendian: little\nencoding: raw\n\n";
  EXPECT_EQ(message(head + data), "accepted");
  EXPECT_NE(message("").find("no kind"), std::string::npos);
  EXPECT_NE(message("P5 3 3 255\n").find("no kind"), std::string::npos);
  EXPECT_NE(message(head + data.substr(1)).find("cut short"), std::string::npos);
  EXPECT_NE(message(kNrrd).find("no type"), std::string::npos);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string h = head;
    h.replace(h.find(from), from.size(), to);
    return message(h + data);
  };
  EXPECT_NE(with("dimension: 3", "dimension: 4").find("dimensions"), std::string::npos);
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 3 4").find("3 numbers"), std::string::npos);
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 3 -4 5").find("size"), std::string::npos);
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 3 4.5 5").find("size"), std::string::npos);
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 2000 2000 2000").find("voxels"), std::string::npos);  // 16 GB claimed
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 600 600 600").find("cut short"), std::string::npos);  // fits, but is not there
  EXPECT_NE(with("sizes: 3 4 5", "sizes: 1000000 1000000 1000000").find("voxels"), std::string::npos);
  EXPECT_NE(with("(2,0,0)", "(1e9,0,0)").find("mm long"), std::string::npos);
  EXPECT_NE(with("(2,0,0)", "(0,0,0)").find("mm long"), std::string::npos);
  EXPECT_NE(with("(2,0,0)", "(0,3,0)").find("plane"), std::string::npos);
  EXPECT_NE(with("(2,0,0)", "(nan,0,0)").find("finite"), std::string::npos);
  EXPECT_NE(with("type: short", "type: block").find("not read"), std::string::npos);
  EXPECT_NE(with("encoding: raw", "encoding: bzip2").find("encoding"), std::string::npos);
  EXPECT_NE(with("encoding: raw", "encoding: gzip").find("compressed"), std::string::npos);
  EXPECT_NE(with("endian: little\n", "").find("endian"), std::string::npos);
  EXPECT_NE(with("encoding: raw\n\n", "encoding: raw\ndata file: not_there\n\n").find("no such file"),
            std::string::npos);
  for (const char* outside : {"/etc/passwd", "../a.raw", "below/../../a.raw"})
    EXPECT_NE(with("encoding: raw\n\n", std::string("encoding: raw\ndata file: ") + outside + "\n\n")
                  .find("outside of the header's folder"),
              std::string::npos)
        << outside;
  EXPECT_NE(message(kMeta + "ElementType = MET_SHORT\nElementDataFile = ../a.raw\n").find("outside"),
            std::string::npos);
  EXPECT_NE(with("encoding: raw\n\n", "encoding: raw\nbyte skip: 99999\n\n").find("skip"), std::string::npos);
  // 400 bytes that promise a gigabyte: none of it is asked for.
  {
    std::string promise = kNrrd + "type: short\nendian: little\nencoding: gzip\n\n" + gz(data);
    promise.replace(promise.find("sizes:"), promise.find('\n', promise.find("sizes:")) - promise.find("sizes:"),
                    "sizes: 600 600 600");
    std::string said;
    try {
      load_volume(write("promise.nrrd", promise));
    } catch (const InputError& e) {
      said = e.what();
    }
    EXPECT_NE(said.find("bytes cannot hold the 432000000 that were expected"), std::string::npos) << said;
  }
  const std::string packed = gz(data), gzip = kNrrd + "type: short\nendian: little\nencoding: gzip\n\n";
  EXPECT_EQ(message(gzip + packed), "accepted");
  for (size_t n = 0; n + 12 < packed.size(); n += 3) EXPECT_NE(message(gzip + packed.substr(0, n)), "accepted");
  std::string nan = numbers<float>(false);
  const float bad = NAN;
  std::memcpy(nan.data() + 40, &bad, 4);
  EXPECT_NE(message(kNrrd + "type: float\nendian: little\nencoding: raw\n\n" + nan).find("finite"), std::string::npos);
  EXPECT_NE(message(kMeta).find("ElementType"), std::string::npos);
  EXPECT_NE(message(kMeta + "ElementType = MET_SHORT\n").find("ElementDataFile"), std::string::npos);
  EXPECT_NE(message(kMeta + "ElementType = MET_SHORT\nElementDataFile = LIST\n").find("list"), std::string::npos);
  EXPECT_NE(message(kMeta + "ElementNumberOfChannels = 3\n").find("one number"), std::string::npos);
  EXPECT_NE(message(kMeta + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + data.substr(7)).find("cut short"),
            std::string::npos);
  EXPECT_THROW(load_volume(dir_), InputError);
  EXPECT_THROW(load_volume(dir_ / "nothing"), InputError);
  // Every truncation of a header: a message or a volume, never anything else.
  for (size_t n = 0; n < head.size(); ++n) message(head.substr(0, n));
}

TEST(RealHead, IsReadWhereItIs) {
  // A head CT that is not part of this tree: LIMBERG_CT_HEAD names its .nhdr.
  const char* path = std::getenv("LIMBERG_CT_HEAD");
  if (!path) GTEST_SKIP() << "LIMBERG_CT_HEAD is not set";
  const Volume v = load_volume(path);
  EXPECT_EQ(v.size, (std::array<int32_t, 3>{64, 64, 93}));
  const auto [lo, hi] = std::minmax_element(v.value.begin(), v.value.end());
  EXPECT_GE(*lo, 0);
  EXPECT_GT(*hi, 3000);
}

}  // namespace test_volume
}  // namespace limberg
