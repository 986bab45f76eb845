// Compressed DICOM slices, packed by another program: what loses nothing gives the same numbers, and what a build lacks
// is said. (Run lengths are this program's own, and need nothing.)
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "sim/imaging/io/dicom.h"
#include "sim/imaging/io/dicom_pixels.h"
#include "tests/bench/fuzz/sound_files.h"

namespace limberg {
namespace test_compressed {

namespace fs = std::filesystem;

class Compressed : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() /
           ("limberg_compressed_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(dir_);
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  /// False: gdcmconv has failed.
  bool pack(const std::string& how, const fs::path& from, const fs::path& to) const {
    const std::string command = "gdcmconv " + how + " '" + from.string() + "' '" + to.string() + "' > /dev/null 2>&1";
    return std::system(command.c_str()) == 0;
  }
  fs::path dir_;
};

bool has_gdcmconv() { return std::system("gdcmconv --version > /dev/null 2>&1") == 0; }

bool says(const LoadedVolume& v, const std::string& words) {
  for (const std::string& n : v.notes)
    if (n.find(words) != std::string::npos) return true;
  return false;
}

struct Way {
  const char *option, *name;
  bool own;  // read without GDCM
};
constexpr Way kWays[] = {{"--jpeg", "JPEG lossless", false},
                         {"--jpegls", "JPEG-LS lossless", false},
                         {"--j2k", "JPEG 2000 lossless", false},
                         {"--rle", "run lengths", true}};

void expect_same(const Way& w, const fs::path& packed, const Volume& whole) {
#if !LIMBERG_WITH_GDCM
  if (!w.own) {
    try {
      load_volume(packed, LoadSettings{});
      ADD_FAILURE() << w.name << " was read without GDCM";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(w.name), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("libgdcm-dev"), std::string::npos) << e.what();
    }
    return;
  }
#endif
  const LoadedVolume v = load_volume(packed, LoadSettings{});
  EXPECT_EQ(v.volume.size, whole.size) << w.name;
  EXPECT_TRUE(v.volume.value == whole.value) << w.name;
  EXPECT_TRUE(says(v, std::string("compressed (") + w.name)) << w.name;
}

TEST_F(Compressed, ThePartIsThereWhereItWasBuilt) {
  const std::string why = imaging::why_no_gdcm();
#if LIMBERG_WITH_GDCM
  EXPECT_EQ(why, "");
#else
  EXPECT_NE(why.find("limberg-gdcm.so is not beside the program"), std::string::npos) << why;
  EXPECT_NE(why.find("libgdcm-dev"), std::string::npos) << why;
#endif
}

TEST_F(Compressed, WhatLosesNothingGivesTheSameNumbers) {
  if (!has_gdcmconv()) GTEST_SKIP() << "gdcmconv is not installed (Debian: libgdcm-tools)";
  fs::create_directories(dir_ / "whole");
  for (int k = 0; k < 4; ++k) {
    fuzz::Slice s;
    s.sequence = false, s.columns = 24, s.rows = 20, s.at.z() = 2 * k, s.intercept = -24;
    s.value = [k](int i, int j) { return int16_t(i * j + 10 * j + 100 * k - 300); };
    std::ofstream(dir_ / "whole" / ("s" + std::to_string(k)), std::ios::binary) << dicom(s);
  }
  const Volume whole = load_volume(dir_ / "whole");
  EXPECT_EQ(whole.value[whole.index(3, 2, 1)], 6 + 20 + 100 - 300 - 24);
  for (const Way& w : kWays) {
    const fs::path to = dir_ / w.option;
    fs::create_directories(to);
    for (int k = 0; k < 4; ++k) {
      const std::string name = "s" + std::to_string(k);
      ASSERT_TRUE(pack(w.option, dir_ / "whole" / name, to / name)) << w.option;
    }
    expect_same(w, to, whole);
  }
}

TEST_F(Compressed, FramesOfOneFileAreTheSame) {
  if (!has_gdcmconv()) GTEST_SKIP() << "gdcmconv is not installed (Debian: libgdcm-tools)";
  std::vector<fuzz::Slice> frames(6);
  for (int k = 0; k < 6; ++k) {
    fuzz::Slice& s = frames[size_t(k)];
    s.sequence = false, s.columns = 24, s.rows = 20, s.at.z() = 2 * k, s.intercept = -24;
    s.value = [k](int i, int j) { return int16_t(i * j + 10 * j + 100 * k - 300); };
  }
  fs::create_directories(dir_ / "whole");
  std::ofstream(dir_ / "whole/all", std::ios::binary) << enhanced_dicom(frames, true);
  const Volume whole = load_volume(dir_ / "whole");
  EXPECT_EQ(whole.value[whole.index(3, 2, 4)], 6 + 20 + 400 - 300 - 24);
  for (const Way& w : kWays) {
    fs::create_directories(dir_ / w.option);
    ASSERT_TRUE(pack(w.option, dir_ / "whole/all", dir_ / w.option / "all")) << w.option;
    expect_same(w, dir_ / w.option, whole);
  }
}

TEST_F(Compressed, DamagedOnesAreRefusedInWords) {
  // GDCM 3.0.21 ends its process on one of ten such files: this one must go on.
  if (const std::string why = imaging::why_no_gdcm(); !why.empty()) GTEST_SKIP() << why;
  if (!has_gdcmconv()) GTEST_SKIP() << "gdcmconv is not installed (Debian: libgdcm-tools)";
  fs::create_directories(dir_ / "d");
  for (int k = 0; k < 3; ++k) {
    fuzz::Slice s;
    s.sequence = false, s.columns = 64, s.rows = 64, s.at.z() = 2 * k;
    s.value = [k](int i, int j) { return int16_t((i * i + 3 * j * j * k + 17 * i * j) % 2000); };
    const std::string name = "s" + std::to_string(k);
    std::ofstream(dir_ / name, std::ios::binary) << dicom(s);
    ASSERT_TRUE(pack("--j2k", dir_ / name, dir_ / "d" / name));
  }
  std::string good(size_t(fs::file_size(dir_ / "d/s1")), '\0');
  std::ifstream(dir_ / "d/s1", std::ios::binary).read(good.data(), std::streamsize(good.size()));
  const size_t pixels = good.find(std::string("\xe0\x7f\x10\x00", 4)) + 20;
  ASSERT_LT(pixels + 500, good.size());
  uint32_t random = 12345;
  int refused = 0;
  for (int n = 0; n < 40; ++n) {
    std::string bad = good;
    for (int hits = 0; hits < 3; ++hits) {
      random = random * 1664525 + 1013904223;
      bad[pixels + (random >> 8) % (hits == 0 ? 200 : bad.size() - pixels)] = char(random >> 24);
    }
    std::ofstream(dir_ / "d/s1", std::ios::binary) << bad;
    try {
      load_volume(dir_ / "d");
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("d/s1: "), std::string::npos) << e.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 5);
}

TEST_F(Compressed, ARealHeadIsTheSame) {
  const char* path = std::getenv("LIMBERG_CT_HEAD");  // its .nhdr; the series lies in dicom/ beside it
  const fs::path real = path ? fs::path(path).parent_path() / "dicom" : fs::path();
  if (!path || !fs::is_directory(real)) GTEST_SKIP() << "LIMBERG_CT_HEAD is not set, or has no dicom folder beside it";
  if (!has_gdcmconv()) GTEST_SKIP() << "gdcmconv is not installed (Debian: libgdcm-tools)";
  const fs::path some = dir_ / "some";  // slices of the upper jaw
  fs::create_directories(some);
  for (int k = 40; k < 56; ++k) {
    const std::string name = "CTHead" + std::to_string(k) + ".dcm";
    fs::copy_file(real / name, some / name);
  }
  const LoadedVolume whole = load_volume(some, LoadSettings{});
  EXPECT_TRUE(whole.notes.empty()) << whole.notes.front();
  for (const Way& w : kWays) {
    const fs::path to = dir_ / w.option;
    fs::create_directories(to);
    for (const auto& e : fs::directory_iterator(some))
      ASSERT_TRUE(pack(w.option, e.path(), to / e.path().filename())) << w.option;
    expect_same(w, to, whole.volume);
  }
}

}  // namespace test_compressed
}  // namespace limberg
