#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "app/program/places.h"
#include "render/image.h"
#include "render/image_compare.h"
#include "sim/base/error.h"
#include "tests/render/jpeg_bytes.h"
#include "tests/small_files.h"

namespace limberg {
namespace test_image {

namespace fs = std::filesystem;

// A picture with every kind of content that PNG filters treat differently: ramps, edges and noise from a counter.
Image sample(int w = 97, int h = 61) {
  Image im(w, h);
  uint32_t state = 12345;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      state = state * 1664525u + 1013904223u;
      im.set(x, y, {uint8_t(x * 255 / w), uint8_t((y / 7) % 2 ? 255 : 20), uint8_t(state >> 24)});
    }
  return im;
}

fs::path scratch(const std::string& name) {
  const fs::path dir = fs::path(binary_dir()) / "test_image_files" / name;
  fs::remove_all(dir);
  fs::create_directories(dir);
  return dir;
}

TEST(Image, PngRoundTripKeepsEveryByte) {
  const fs::path dir = scratch("round_trip");
  const Image a = sample();
  write_png(dir / "a.png", a);
  EXPECT_EQ(read_png(dir / "a.png"), a);
  EXPECT_EQ(std::distance(fs::directory_iterator(dir), fs::directory_iterator()), 1);  // nothing is left beside it
}

TEST(Image, SamePictureGivesSameFile) {
  const fs::path dir = scratch("same_file");
  write_png(dir / "a.png", sample());
  write_png(dir / "b.png", sample());
  std::ifstream a(dir / "a.png", std::ios::binary), b(dir / "b.png", std::ios::binary);
  const std::string sa((std::istreambuf_iterator<char>(a)), {}), sb((std::istreambuf_iterator<char>(b)), {});
  EXPECT_FALSE(sa.empty());
  EXPECT_EQ(sa, sb);
}

TEST(Image, BadFilesAreInputErrors) {
  const fs::path dir = scratch("bad");
  EXPECT_THROW(read_png(dir / "missing.png"), InputError);
  std::ofstream(dir / "empty.png").flush();
  EXPECT_THROW(read_png(dir / "empty.png"), InputError);
  std::ofstream(dir / "text.png") << "this is no picture at all";
  EXPECT_THROW(read_png(dir / "text.png"), InputError);
  EXPECT_THROW(read_png(dir), InputError);
  // Every cut-off length of a true file is refused, none crashes.
  write_png(dir / "whole.png", sample(40, 30));
  std::ifstream in(dir / "whole.png", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  for (size_t n = 0; n + 12 < bytes.size(); n += 97) {
    std::ofstream(dir / "cut.png", std::ios::binary) << bytes.substr(0, n);
    EXPECT_THROW(read_png(dir / "cut.png"), InputError) << n << " of " << bytes.size() << " bytes";
  }
}

/// A header that promises much costs nothing until it is believed: 16,000 x 16,000 pixels would be 768 MB.
TEST(Image, APictureThatPromisesTooMuchIsRefused) {
  const auto promised = [](uint32_t wide, uint32_t high) {
    std::string bytes = encode_png(sample(40, 30));
    for (size_t k = 0; k < 4; ++k)
      bytes[16 + k] = char(wide >> (24 - 8 * k) & 255), bytes[20 + k] = char(high >> (24 - 8 * k) & 255);
    const uLong crc = crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + 12), 17);
    for (size_t k = 0; k < 4; ++k) bytes[29 + k] = char(crc >> (24 - 8 * k) & 255);
    return bytes;
  };
  const auto why = [](auto&& read) -> std::string {
    try {
      read();
    } catch (const InputError& e) {
      return e.what();
    }
    return "taken";
  };
  const auto refusal = [&](uint32_t wide, uint32_t high) {
    return why([&] { decode_png(promised(wide, high), "big.png"); });
  };
  EXPECT_NE(refusal(3000, 3000).find("is a damaged PNG picture"), std::string::npos) << refusal(3000, 3000);
  for (const auto& [wide, high] :
       {std::pair{9000u, 9000u}, {16'000u, 16'000u}, {60'000u, 60'000u}, {20'000u, 10u}, {10u, 20'000u}})
    EXPECT_NE(
        refusal(wide, high).find("larger picture than is read; expected at most 67108864 pixels and 16384 a side"),
        std::string::npos)
        << wide << " x " << high << ": " << refusal(wide, high);
  // A file with a hole is refused for its size before it is read.
  const std::string hole = scratch("hole") / "a.png";
  std::ofstream(hole, std::ios::binary) << promised(40, 30);
  fs::resize_file(hole, kMostPng + 1);
  const std::string large = why([&] { read_png(hole); });
  EXPECT_NE(large.find("is too large"), std::string::npos) << large;
}

/// Nor does a chunk: libpng 1.6.39 clears as many bytes as a palette claims, here 1.8 GB, before it looks for them.
TEST(Image, AChunkThatClaimsMoreThanTheFileTakesNoMemory) {
  std::string bytes = encode_png(sample(40, 30));
  bytes.insert(33, std::string("\x6e\x70\x75\x74sPLT", 8));  // behind the header
  rusage before{}, after{};
  ASSERT_EQ(getrusage(RUSAGE_SELF, &before), 0);
  EXPECT_THROW(decode_png(bytes, "chunk.png"), InputError);
  ASSERT_EQ(getrusage(RUSAGE_SELF, &after), 0);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 200'000) << "KB more at most than before; the largest file is 32 MB";
}

/// Smooth, as photographs of skin are.
Image slope(int w, int h) {
  Image im(w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) im.set(x, y, {uint8_t(120 + 2 * x), uint8_t(90 + y), uint8_t(60 + x + y)});
  return im;
}

int farthest(const Image& a, const Image& b) {
  int most = a.width == b.width && a.height == b.height ? 0 : 999;
  for (size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); ++i)
    most = std::max(most, std::abs(int(a.rgb[i]) - int(b.rgb[i])));
  return most;
}

TEST(Jpeg, IsReadAsItWasWritten) {
  const Image a = slope(50, 34);  // no multiple of a block
  // The least step of the tables at quality 95 is 2 (ITU T.81, Annex K): a few of 255 in each colour.
  EXPECT_LE(farthest(decode_jpeg(test::jpeg_bytes(a), "a.jpg"), a), 4);
  EXPECT_LE(farthest(decode_jpeg(test::jpeg_bytes(a, test::JpegKind::progressive), "a.jpg"), a), 4);
  const Image grey = decode_jpeg(test::jpeg_bytes(a, test::JpegKind::grey), "a.jpg");
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const Rgb8 p = grey.at(x, y);
      ASSERT_TRUE(p.r == p.g && p.g == p.b);
      ASSERT_NEAR(p.r, a.at(x, y).r, 4);
    }
}

/// What the program writes for its pages is as near, and a line of one pixel keeps its colour, which pictures whose
/// colours are thinned out (4:2:0) halve.
TEST(Jpeg, IsWrittenWithAllItsColours) {
  const Image a = slope(50, 34);
  EXPECT_LE(farthest(decode_jpeg(encode_jpeg(a, 95), "a.jpg"), a), 4);
  Image line(64, 48, {200, 200, 200});
  for (int y = 0; y < 48; ++y) line.set(31, y, {220, 40, 40});
  const Image back = decode_jpeg(encode_jpeg(line, 92), "line.jpg");
  for (int y = 0; y < 48; ++y) EXPECT_NEAR(back.at(31, y).r - back.at(31, y).g, 180, 25) << y;
  EXPECT_LT(encode_jpeg(a, 60).size(), encode_jpeg(a, 95).size());
  EXPECT_EQ(encode_jpeg(Image(), 92), "");
  EXPECT_EQ(encode_jpeg(Image(66000, 1), 92), "");
}

TEST(Jpeg, IsKnownByItsFirstBytesWhateverItsName) {
  const fs::path dir = scratch("jpeg");
  const Image a = slope(20, 20);
  std::ofstream(dir / "a.png", std::ios::binary) << test::jpeg_bytes(a);
  std::ofstream(dir / "b.jpg", std::ios::binary) << encode_png(a);
  std::ofstream(dir / "c.jpg") << "GIF89a";
  EXPECT_LE(farthest(read_picture(dir / "a.png"), a), 4);
  EXPECT_EQ(read_picture(dir / "b.jpg"), a);
  EXPECT_THROW(read_picture(dir / "c.jpg"), InputError);
}

TEST(Jpeg, BadFilesAreInputErrors) {
  const auto why = [](std::string_view bytes) -> std::string {
    try {
      decode_jpeg(bytes, "x.jpg");
    } catch (const InputError& e) {
      return e.what();
    }
    return "taken";
  };
  for (const test::JpegKind kind : {test::JpegKind::baseline, test::JpegKind::progressive}) {
    const std::string bytes = test::jpeg_bytes(slope(80, 60), kind);
    for (size_t n = 0; n + 2 < bytes.size(); n += 29)
      EXPECT_NE(why(bytes.substr(0, n)).find("x.jpg: is "), std::string::npos) << n << " of " << bytes.size();
  }
  EXPECT_NE(why(test::jpeg_bytes(slope(9, 9), test::JpegKind::four_inks)).find("four inks"), std::string::npos);
  // Height and width stand behind the mark of a frame, in two bytes each: 65,000 lines of 65,000 would be 12 GB.
  std::string large = test::jpeg_bytes(slope(8, 8));
  const size_t frame = large.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (const size_t k : {5u, 7u}) large[frame + k] = char(0xfd), large[frame + k + 1] = char(0xe8);
  EXPECT_NE(why(large).find("larger picture than is read"), std::string::npos) << why(large);
}

TEST(Image, FailedWriteLeavesTheOldFile) {
  const fs::path dir = scratch("old");
  write_png(dir / "a.png", sample());
  {
    const SmallFiles no_room(16);
    EXPECT_THROW(write_png(dir / "a.png", Image(3, 3)), InputError);
  }
  EXPECT_EQ(read_png(dir / "a.png"), sample());
  EXPECT_THROW(write_png(dir / "nowhere" / "a.png", sample()), InputError);
  EXPECT_THROW(write_png(dir / "b.png", Image()), InputError);
}

TEST(Image, ShrinkKeepsTheMean) {
  Image im(8, 4, {10, 20, 30});
  im.set(0, 0, {110, 20, 30});
  const Image s = shrink(im, 2);
  ASSERT_EQ(s.width, 4);
  ASSERT_EQ(s.height, 2);
  EXPECT_EQ(s.at(0, 0), (Rgb8{35, 20, 30}));
  EXPECT_EQ(s.at(3, 1), (Rgb8{10, 20, 30}));
}

// The measure must fail on what a reader would miss or mind, and pass on what nobody can see.
TEST(ImageCompare, CatchesPlantedDefects) {
  Image base(320, 240, {180, 150, 140});
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x)
      if (x % 20 == 0 || y % 20 == 0) base.set(x, y, {120, 90, 80});
  EXPECT_EQ(block_mean_difference(base, base), 0);

  Image hole = base;  // 8 x 8 pixels lost
  for (int y = 100; y < 108; ++y)
    for (int x = 201; x < 209; ++x) hole.set(x, y, {40, 60, 70});
  EXPECT_GT(block_mean_difference(base, hole), 4);

  Image thread = base;  // a lost suture line, 40 x 2 pixels
  for (int x = 100; x < 140; ++x)
    for (int y = 55; y < 57; ++y) thread.set(x, y, {20, 30, 120});
  EXPECT_GT(block_mean_difference(base, thread), 4);

  Image darker = base;
  for (uint8_t& v : darker.rgb) v = uint8_t(v * 97 / 100);
  EXPECT_GT(block_mean_difference(base, darker), 4);

  Image swapped = base;
  for (size_t i = 0; i < swapped.rgb.size(); i += 3) std::swap(swapped.rgb[i], swapped.rgb[i + 2]);
  EXPECT_GT(block_mean_difference(base, swapped), 4);

  Image dither = base;  // one grey level up and down, pixel by pixel
  for (size_t i = 0; i < dither.rgb.size(); ++i) dither.rgb[i] = uint8_t(dither.rgb[i] + (i / 3 % 2 ? 1 : -1));
  EXPECT_LT(block_mean_difference(base, dither), 4);

  EXPECT_EQ(block_mean_difference(base, Image(319, 240)), 255);
}

}  // namespace test_image
}  // namespace limberg
