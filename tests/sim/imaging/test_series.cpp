// A patient's disc: folders in folders, several series, damaged files; what was done to a volume is said.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "sim/base/error.h"
#include "sim/imaging/io/dicom.h"
#include "tests/bench/fuzz/sound_files.h"

namespace limberg {
namespace test_series {

namespace fs = std::filesystem;
using fuzz::Slice;
using imaging::choose_series;
using imaging::list_series;
using imaging::SeriesAbout;
using imaging::SeriesChoice;

class Series : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() /
           ("limberg_series_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(dir_);
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  std::string write(const std::string& name, const std::string& content) const {
    const fs::path path = dir_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  /// n slices `gap` mm apart, from z = 0 up; `change` may alter one, or leave it out (columns = 0).
  void series(const std::string& folder, int n, double gap, const std::function<void(int, Slice&)>& change) const {
    for (int k = 0; k < n; ++k) {
      Slice s;
      s.at.z() = gap * k;
      change(k, s);
      char name[32];
      std::snprintf(name, sizeof name, "/s%03d", k);
      if (s.columns > 0) write(folder + name, dicom(s));
    }
  }
  LoadedVolume load(const std::string& folder, bool bridge = false, const std::string& name = "") const {
    return load_volume(dir_ / folder, LoadSettings{name, bridge});
  }
  std::string refused(const std::string& folder, bool bridge = false) const {
    try {
      load(folder, bridge);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path dir_;
};

/// The note that holds these words; empty: none does.
std::string note(const LoadedVolume& v, const std::string& words) {
  for (const std::string& n : v.notes)
    if (n.find(words) != std::string::npos) return n;
  return "";
}
bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST_F(Series, TiltsOfBothSignsAreEvenedOutAndSaid) {
  for (const double degrees : {-20., 12., 30.}) {
    const std::string folder = "tilt" + std::to_string(int(degrees));
    const double shift = std::tan(degrees * M_PI / 180);
    // f = 2 x + 3 y + 5 z + 100, linear in space: interpolation is exact.
    series(folder, 9, 3, [&](int, Slice& s) {
      const double z = s.at.z(), y0 = shift * z;
      s.at.y() = y0, s.columns = 8, s.rows = 40, s.slope = 0.1;
      s.value = [=](int i, int j) { return int16_t(std::lround(10 * (4. * i + 3 * (2. * j + y0) + 5 * z + 100))); };
    });
    const LoadedVolume v = load(folder);
    char said[64];
    std::snprintf(said, sizeof said, "tilted by %.1f degrees", degrees);
    EXPECT_NE(note(v, said), "") << (v.notes.empty() ? "no notes" : v.notes.front());
    EXPECT_EQ(v.notes.size(), 1u);
    EXPECT_NEAR(list_series(dir_ / folder).front().tilt_deg, degrees, 0.01);
    int seen = 0;
    for (int k = 0; k < v.volume.size[2]; ++k)
      for (int j = 0; j < v.volume.size[1]; ++j) {
        const Vec3 x = v.volume.place(Vec3(4, j, k));
        if (x.y() < shift * x.z() + 0.1 || x.y() > shift * x.z() + 77.9) continue;
        EXPECT_NEAR(double(v.volume.value[v.volume.index(4, j, k)]), 2 * x.x() + 3 * x.y() + 5 * x.z() + 100, 0.11);
        ++seen;
      }
    EXPECT_GT(seen, 300);
  }
}

TEST_F(Series, GapsOfEverySizeAreReadAndUnevenOnesSaid) {
  for (int gap = 1; gap <= 8; ++gap) {
    const std::string folder = "even" + std::to_string(gap);
    series(folder, 6, gap, [](int, Slice&) {});
    const LoadedVolume v = load(folder);
    EXPECT_TRUE(v.notes.empty()) << v.notes.front();
    EXPECT_EQ(v.volume.size[2], 6);
    EXPECT_NEAR(v.volume.step_mm(2, 2), gap, 1e-9);
  }
  // Thin slices at the base, thick ones above.
  series("mixed", 12, 1, [](int k, Slice& s) { s.at.z() = k < 6 ? 2.5 * k : 12.5 + 5 * (k - 5); });
  const LoadedVolume v = load("mixed");
  EXPECT_TRUE(has(note(v, "uneven"), "2.5 to 5 mm: slices are every 2.5 mm now")) << note(v, "uneven");
  EXPECT_EQ(v.volume.size[2], 18);
  EXPECT_EQ(note(v, "missing"), "");
}

TEST_F(Series, SlicesThatAnEvenSeriesLacksAreRefusedOrBridged) {
  const auto lacking = [](double gap, int first, int last) {
    return [=](int k, Slice& s) {
      if (k >= first && k <= last) s.columns = 0;
      s.value = [z = gap * k](int i, int) { return int16_t(10 * z + i); };
    };
  };
  series("one", 16, 2, lacking(2, 5, 5));
  EXPECT_TRUE(has(refused("one"), "1 slice is missing between")) << refused("one");
  const LoadedVolume v = load("one", true);
  EXPECT_TRUE(has(note(v, "missing"), "1 slice is missing, from 8 to 12 mm")) << note(v, "missing");
  EXPECT_EQ(note(v, "uneven"), "");
  ASSERT_EQ(v.volume.size[2], 16);
  EXPECT_NEAR(v.volume.step_mm(2, 2), 2, 1e-9);
  for (int k = 0; k < 16; ++k) EXPECT_NEAR(double(v.volume.value[v.volume.index(3, 2, k)]), 20 * k + 3, 1e-3);
  series("ten", 24, 2, lacking(2, 5, 8));
  EXPECT_TRUE(has(note(load("ten", true), "missing"), "4 slices are missing"));
  series("twelve", 24, 2, lacking(2, 5, 9));
  EXPECT_TRUE(has(refused("twelve", true), "at most 10 mm")) << refused("twelve", true);
  // A damaged file is such a slice: the refusal names it.
  series("damaged", 16, 2, [](int, Slice&) {});
  write("damaged/s007", std::string(128, 0) + "DICM\x02\x00\x10\x00UI");
  EXPECT_TRUE(has(refused("damaged"), "s007: ")) << refused("damaged");
  EXPECT_NE(note(load("damaged", true), "s007"), "");
}

TEST_F(Series, ASliceThatAnUnevenSeriesMayLackIsSaid) {
  const double z[] = {0, 3, 5, 8, 10, 16, 19, 21, 24.5, 27};
  series("uneven", 10, 0, [&](int k, Slice& s) { s.at.z() = z[k]; });
  const LoadedVolume v = load("uneven");
  EXPECT_TRUE(has(note(v, "may be missing"), "from 10 to 16 mm")) << note(v, "may be missing");
  const double plain[] = {0, 3, 5, 8, 10, 14, 17, 19, 22.5, 25};
  series("plain", 10, 0, [&](int k, Slice& s) { s.at.z() = plain[k]; });
  EXPECT_EQ(note(load("plain"), "may be missing"), "");
  // Where gaps of one size follow gaps of another none is missing, whichever comes first.
  for (const bool thick_first : {true, false}) {
    const std::string folder = thick_first ? "down" : "up";
    series(folder, 10, 0, [&](int k, Slice& s) {
      const int n = thick_first ? k : 9 - k;
      s.at.z() = (thick_first ? 1 : -1) * (n <= 3 ? 4.2 * n : 12.6 + 2 * (n - 3));
    });
    EXPECT_EQ(note(load(folder), "may be missing"), "") << folder;
    EXPECT_NE(note(load(folder), "uneven, 2 to 4.2 mm"), "") << folder;
  }
}

TEST_F(Series, PaddingIsAirAndSaid) {
  series("padded", 4, 2, [](int, Slice& s) {
    s.padding = -2000;
    s.value = [](int i, int j) { return int16_t(j == 0 ? -2000 : i); };
  });
  const LoadedVolume v = load("padded");
  EXPECT_TRUE(has(note(v, "padding"), "20 % of the pixels")) << note(v, "padding");
  EXPECT_EQ(v.volume.value[0], 0);  // the least other number, above -1000
}

TEST_F(Series, FoldersOfADisc) {
  // DICOM/PAT0/SER1/..., a second series, files of a viewer, a directory of the medium, a file without pixels.
  series("disc/DICOM/PAT0/SER1", 6, 2, [](int, Slice& s) { s.description = "thin"; });
  series("disc/DICOM/PAT0/SER2", 4, 3, [](int, Slice& s) { s.description = "thick", s.series = "1.2.9"; });
  write("disc/VIEWER/README.TXT", "a viewer");
  write("disc/DICOMDIR", std::string(128, 0) + "DICM and what a directory says");
  write("disc/DICOM/REPORT", std::string(128, 0) + "DICM");
  for (const char* path : {"disc", "disc/DICOMDIR"}) {
    const std::vector<SeriesAbout> list = list_series(dir_ / path);
    ASSERT_EQ(list.size(), 2u) << path;
    EXPECT_EQ(list[0].description, "thin");
    EXPECT_EQ(list[0].slices, 6);
    EXPECT_EQ(list[1].slices, 4);
    const LoadedVolume v = load(path, false, "thick");
    EXPECT_EQ(v.volume.size[2], 4);
    EXPECT_EQ(note(v, "no DICOM"), "1 file is no DICOM: passed over");
    EXPECT_EQ(note(v, "no pixels"), "1 DICOM file has no pixels: passed over");
  }
  // A slice stands for its series among the files beside it, not for what lies deeper.
  EXPECT_EQ(load("disc/DICOM/PAT0/SER1/s002").volume.size[2], 6);
  fs::copy(dir_ / "disc/DICOM/PAT0/SER2", dir_ / "disc/DICOM/PAT0/SER1/deeper");
  EXPECT_EQ(list_series(dir_ / "disc/DICOM/PAT0/SER1/s002").size(), 1u);
  EXPECT_EQ(list_series(dir_ / "disc/DICOM/PAT0/SER1").size(), 2u);
  fs::remove_all(dir_ / "disc/DICOM/PAT0/SER1/deeper");
  // The same slices again in another folder are read once; a link that leads back is not followed.
  fs::copy(dir_ / "disc/DICOM/PAT0/SER1", dir_ / "disc/COPY");
  fs::create_directory_symlink(dir_ / "disc", dir_ / "disc/DICOM/back");
  EXPECT_EQ(list_series(dir_ / "disc")[0].slices, 6);
  EXPECT_EQ(note(load("disc", false, "thin"), "two folders"), "6 slices are in two folders: read once");
}

TEST_F(Series, FoldersAreWalkedEightDeep) {
  series("deep/1/2/3/4/5/6/7/8", 3, 2, [](int, Slice&) {});
  series("deep/1/2/3/4/5/6/7/8/9", 3, 2, [](int, Slice& s) { s.series = "1.2.9"; });
  EXPECT_EQ(list_series(dir_ / "deep").size(), 1u);
  EXPECT_NE(note(load("deep"), "more than 8 deep"), "");
}

TEST_F(Series, AFolderOfTooManyFilesIsRefused) {
  series("many", 3, 2, [](int, Slice&) {});
  for (int i = 0; i < 20'000; ++i) std::ofstream(dir_ / "many" / ("x" + std::to_string(i)));
  EXPECT_TRUE(has(refused("many"), "more than 20000 files and folders")) << refused("many");
}

TEST_F(Series, HeadersOfAnyLengthAreRead) {
  // A private element of 100,000 bytes before the pixels.
  series("long", 3, 2, [](int, Slice&) {});
  const std::string pixels("\xe0\x7f\x10\x00OW", 6), element("\x29\x00\x10\x10OB\0\0\xa0\x86\x01\x00", 12);
  Slice s;
  s.at.z() = 6;
  std::string file = dicom(s);
  const size_t at = file.find(pixels);
  ASSERT_NE(at, std::string::npos);
  file.insert(at, element + std::string(100'000, 'x'));
  write("long/s004", file);
  EXPECT_EQ(load("long").volume.size[2], 4);
  // Pixels that are cut short are seen without reading them.
  write("long/s004", file.substr(0, file.size() - 1));
  EXPECT_TRUE(has(list_series(dir_ / "long").front().refused, "cut short"));
  EXPECT_TRUE(has(refused("long"), "cut short")) << refused("long");
}

TEST_F(Series, OneBadFileHidesNoOtherSeries) {
  series("d", 4, 2, [](int, Slice&) {});
  Slice s;
  s.syntax = "1.2.840.10008.1.2.2", s.series = "1.2.9";
  write("d/a-big-endian", dicom(s));
  write("d/b-cut", dicom(Slice()).substr(0, 190));
  const LoadedVolume v = load("d");
  EXPECT_EQ(v.volume.size[2], 4);
  EXPECT_TRUE(has(note(v, "a-big-endian"), "big endian"));
  EXPECT_TRUE(has(note(v, "b-cut"), "cut short")) << note(v, "b-cut");
  // Nothing else there: refused with the reason.
  write("e/only", dicom(s));
  EXPECT_TRUE(has(refused("e"), "big endian")) << refused("e");
}

TEST_F(Series, AListSaysWhatEachSeriesIs) {
  series("d", 60, 1.5, [](int, Slice& s) {
    s.body_part = "HEAD", s.kernel = "H60s", s.image_type = "ORIGINAL\\PRIMARY\\AXIAL", s.spacing = 0.5;
    s.patient = "17";
  });
  series("s", 2, 0, [](int k, Slice& s) {
    s.series = "1.2.9", s.description = "scout", s.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
    s.across = k ? Vec3::UnitX() : Vec3::UnitY(), s.down = -Vec3::UnitZ(), s.patient = "17";
  });
  series("m", 1, 0, [](int, Slice& s) { s.series = "1.2.10", s.frames = 30, s.patient = "17"; });
  const std::vector<SeriesAbout> list = list_series(dir_);
  ASSERT_EQ(list.size(), 3u);
  const SeriesAbout& a = list[0];
  EXPECT_EQ(a.number, 1);
  EXPECT_EQ(a.uid + a.description + a.modality + a.body_part + a.kernel, "1.2.3headCTHEADH60s");
  EXPECT_EQ(a.patient, "17");
  EXPECT_EQ(a.slices, 60);
  EXPECT_EQ(a.columns, 6);
  EXPECT_EQ(a.rows, 5);
  EXPECT_NEAR(a.column_step_mm, 0.5, 1e-9);
  EXPECT_NEAR(a.gap_mm, 1.5, 1e-9);
  EXPECT_TRUE(a.extent_mm.isApprox(Vec3(3, 2.5, 88.5), 1e-9));
  EXPECT_NEAR(a.height_mm, 88.5, 1e-9);
  EXPECT_EQ(a.tilt_deg, 0);
  EXPECT_TRUE(a.axial);
  EXPECT_EQ(a.refused, "");
  EXPECT_TRUE(has(list[1].refused, "holds 30 frames and does not say where each of them lies")) << list[1].refused;
  EXPECT_FALSE(list[2].axial);
  EXPECT_TRUE(has(list[2].refused, "another direction")) << list[2].refused;
  const SeriesChoice c = choose_series(list);
  EXPECT_EQ(c.index, 0);
  ASSERT_EQ(c.rejected.size(), 2u);
  EXPECT_TRUE(has(c.rejected[1], "localizer")) << c.rejected[1];
}

SeriesAbout head(int number, double height_mm, double gap_mm) {
  SeriesAbout s;
  s.number = number, s.description = "head", s.modality = "CT", s.slices = int(height_mm / gap_mm) + 1;
  s.height_mm = height_mm, s.gap_mm = gap_mm, s.patient = "a", s.axial = true;
  return s;
}

TEST(SeriesChoice, CoverageThenFineness) {
  // As much of the head in finer slices; half a head, however fine, is none.
  EXPECT_EQ(choose_series({head(1, 200, 5), head(2, 196, 0.625), head(3, 100, 0.5)}).index, 1);
  EXPECT_EQ(choose_series({head(1, 200, 1), head(2, 200, 1)}).index, 0);
  // A whole body covers no more of a head.
  EXPECT_EQ(choose_series({head(1, 1500, 5), head(2, 250, 1)}).index, 1);
  const SeriesChoice c = choose_series({head(1, 200, 5), head(2, 196, 0.625)});
  EXPECT_TRUE(has(c.why, "Series 2") && has(c.why, "196 mm") && has(c.why, "0.625 mm")) << c.why;
}

TEST(SeriesChoice, WhatWillNotDoIsRejectedWithItsReason) {
  const auto rejected = [](const std::function<void(SeriesAbout&)>& change) {
    SeriesAbout s = head(1, 200, 0.5);
    change(s);
    const SeriesChoice c = choose_series({s, head(2, 100, 5)});
    EXPECT_EQ(c.index, 1);
    return c.rejected.size() == 1 ? c.rejected.front() : "";
  };
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER"; }), "localizer"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.description = "Topogram 0.6"; }), "localizer"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.image_type = "DERIVED\\PRIMARY\\MPR"; }), "derived"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.image_type = "ORIGINAL\\SECONDARY"; }), "secondary"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.slices = 11; }), "11 slices; at least 12"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.height_mm = 79; }), "79 mm"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.refused = "a/b: cut short"; }), "cut short"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.modality = "SC"; }), "no CT or MR"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.modality = "MR"; }), "there is CT"));
  EXPECT_TRUE(has(rejected([](SeriesAbout& s) { s.body_part = "CHEST"; }), "another part"));
  SeriesAbout mr = head(1, 200, 1);
  mr.modality = "MR";
  EXPECT_EQ(choose_series({mr}).index, 0);  // where there is nothing better
  SeriesAbout scout = head(1, 200, 1);
  scout.description = "SCOUT";
  const SeriesChoice none = choose_series({scout});
  EXPECT_EQ(none.index, -1);
  EXPECT_TRUE(has(none.why, "localizer")) << none.why;
  EXPECT_EQ(choose_series({}).index, -1);
}

/// Slices of a tilted, unevenly spaced series, each with an intercept of its own, in another order than they lie.
std::vector<Slice> frames_of_a_head(bool explicit_vr, bool run_length) {
  std::vector<Slice> out;
  for (const int k : {3, 0, 1, 2, 4}) {
    Slice s;
    s.explicit_vr = explicit_vr, s.run_length = run_length, s.series = "1.2.77", s.stack = "1";
    s.at = {5, .5 * k, 2. * k + (k > 2 ? .5 : 0)}, s.slope = 2, s.intercept = -24 - k;
    s.across = {0, 1, 0}, s.down = {0, 0, 1}, s.at = {s.at.z(), s.at.y(), 5}, s.kernel = "H30s";
    s.value = [k](int i, int j) { return int16_t(i + 10 * j + 100 * k); };
    out.push_back(s);
  }
  return out;
}

TEST_F(Series, FramesOfOneFileAreReadAsSlicesInFiles) {
  for (const bool explicit_vr : {true, false})
    for (const bool run_length : {false, true})
      for (const bool with_lengths : {false, true}) {
        if (run_length && !explicit_vr) continue;  // (compressed files are explicit: PS3.5 A.4)
        const std::vector<Slice> frames = frames_of_a_head(explicit_vr, run_length);
        const std::string name =
            std::to_string(explicit_vr) + std::to_string(run_length) + std::to_string(with_lengths);
        for (size_t k = 0; k < frames.size(); ++k) write(name + "/single/s" + std::to_string(k), dicom(frames[k]));
        write(name + "/multi/all.dcm", enhanced_dicom(frames, with_lengths));
        const LoadedVolume single = load(name + "/single"), multi = load(name + "/multi");
        EXPECT_EQ(multi.volume.size, single.volume.size) << name;
        EXPECT_TRUE(multi.volume.value == single.volume.value) << name;
        EXPECT_EQ(multi.volume.origin_mm, single.volume.origin_mm) << name;
        EXPECT_EQ(multi.volume.step_mm, single.volume.step_mm) << name;
        EXPECT_EQ(multi.notes, single.notes) << name;
        const std::vector<SeriesAbout> list = list_series(dir_ / name / "multi");
        ASSERT_EQ(list.size(), 1u);
        EXPECT_EQ(list[0].slices, 5);
        EXPECT_EQ(list[0].refused, "");
      }
}

TEST_F(Series, StacksOfOneFileAreToldApart) {
  std::vector<Slice> frames = frames_of_a_head(true, false);
  for (int k = 0; k < 12; ++k) {
    Slice s;
    s.stack = "second", s.at.x() = 3 * k;
    frames.push_back(s);
  }
  write("d/all.dcm", enhanced_dicom(frames, true));
  const std::vector<SeriesAbout> list = list_series(dir_ / "d");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_TRUE(has(line_of(list[0]), "stack 1\", 5 slices")) << line_of(list[0]);
  EXPECT_TRUE(has(line_of(list[1]), "stack second\", 12 slices")) << line_of(list[1]);
  EXPECT_TRUE(has(refused("d"), "holds 2 series")) << refused("d");
  EXPECT_TRUE(has(refused("d/all.dcm"), "holds 2 stacks of frames")) << refused("d/all.dcm");
  EXPECT_EQ(load("d", false, "second").volume.size[2], 12);
}

TEST_F(Series, FramesThatCannotBeAreRefusedByName) {
  const auto said = [&](const std::string& bytes) { return write("f/all.dcm", bytes), refused("f"); };
  std::vector<Slice> frames = frames_of_a_head(true, false);
  const std::string good = enhanced_dicom(frames, true);
  EXPECT_EQ(said(good), "accepted");
  // The last frame's pixels are cut short.
  EXPECT_TRUE(has(said(good.substr(0, good.size() - 8)), "all.dcm, frame 5: the pixels are cut short"));
  // Another number of frames than of groups.
  for (const auto& [n, words] : {std::pair("4 ", "groups that describe more"), {"6 ", "groups that describe fewer"}}) {
    std::string bad = good;
    bad.replace(bad.find("IS\2\0"
                         "5 ",
                         0, 6) +
                    4,
                2, n);
    EXPECT_TRUE(has(said(bad), words)) << said(bad);
  }
  // A text as long as a header may be is not kept for every frame.
  Slice wordy = frames[0];
  wordy.description = std::string(60'000, 'a');
  write("w/all.dcm", fuzz::enhanced_dicom({wordy, frames[1]}, true));
  EXPECT_EQ(list_series(dir_ / "w").at(0).description.size(), 256u);
  // Two at one place.
  frames[2].at = frames[4].at;
  EXPECT_TRUE(has(said(enhanced_dicom(frames, true)), "frame 5: lies where")) << said(enhanced_dicom(frames, true));
  EXPECT_TRUE(has(said(enhanced_dicom(frames, true)), "all.dcm, frame 3 lies")) << said(enhanced_dicom(frames, true));
  // Fewer packed frames than there are.
  frames = frames_of_a_head(true, true);
  std::string packed = enhanced_dicom(frames, true);
  packed.erase(packed.rfind(std::string("\xfe\xff\x00\xe0", 4)));
  packed += std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  EXPECT_TRUE(has(said(packed), "all.dcm, frame 5: its run lengths are damaged: there are fewer")) << said(packed);
}

TEST_F(Series, TwoPatientsInOneFolderAreToldApart) {
  // Even with one UID, as programs that take names out of files have left it.
  series("a", 50, 2, [](int, Slice& s) { s.patient = "17"; });
  series("b", 50, 1.9, [](int, Slice& s) { s.patient = "18"; });
  const std::vector<SeriesAbout> list = list_series(dir_);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].patient + list[1].patient, "1718");
  const SeriesChoice c = choose_series(list);
  EXPECT_EQ(c.index, 1);
  EXPECT_TRUE(has(c.why, "Series of 2 patients lie here (17, 18); this one is of 18")) << c.why;
  const std::string both = refused(".");
  EXPECT_TRUE(has(both, "2 series") && has(both, "patient 17") && has(both, "patient 18")) << both;
  EXPECT_TRUE(has(refused("a/s001"), "accepted"));
}

}  // namespace test_series
}  // namespace limberg
