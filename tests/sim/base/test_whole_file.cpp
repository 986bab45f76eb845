// What is opened for reading: regular files of a stated size, and nothing waits for anything else.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "sim/base/whole_file.h"

namespace limberg {
namespace test_whole_file {

namespace fs = std::filesystem;

class WholeFile : public ::testing::Test {
 protected:
  WholeFile() {
    std::string name = (fs::temp_directory_path() / "limberg-files-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~WholeFile() override { fs::remove_all(dir_); }
  std::string at(const std::string& name) const { return (dir_ / name).string(); }
  static std::string refusal(const std::string& file, size_t limit = 100) {
    try {
      read_whole_file(file, limit, "a scene");
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  fs::path dir_;
};

TEST_F(WholeFile, WhatIsNoRegularFileIsRefusedAtOnce) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  fs::create_symlink("loop2", at("loop1"));
  fs::create_symlink("loop1", at("loop2"));
  std::ofstream(at("file")) << "text";
  for (const auto& [file, word] : {std::pair{at("pipe"), "is not a regular file; expected a scene"},
                                   {std::string("/dev/zero"), "is not a regular file; expected a scene"},
                                   {at(""), "is a folder; expected a scene"},
                                   {at("none"), "no such file; expected a scene"},
                                   {at("loop1"), "cannot be opened"},
                                   {at("file/below"), "cannot be opened"},
                                   {at(std::string(5000, 'a')), "cannot be opened"}}) {
    EXPECT_NE(refusal(file).find(word), std::string::npos) << file << ": " << refusal(file);
    EXPECT_THROW(read_beginning(file, 10), InputError) << file;
  }
}

TEST_F(WholeFile, NoMoreIsReadThanTheLimit) {
  std::ofstream(at("file")) << "0123456789";
  EXPECT_EQ(read_whole_file(at("file"), 10), "0123456789");
  EXPECT_EQ(read_whole_file<std::vector<uint8_t>>(at("file"), 10).size(), 10u);
  EXPECT_NE(refusal(at("file"), 9).find("is too large (10 bytes); expected at most 9 bytes"), std::string::npos);
  EXPECT_EQ(read_beginning(at("file"), 4), "0123");
  // A file with a hole takes no room on the disk; it is refused before a byte is read.
  std::ofstream(at("hole")) << "x";
  fs::resize_file(at("hole"), uintmax_t(1) << 40);
  EXPECT_NE(refusal(at("hole"), size_t(1) << 30).find("is too large (1048576 MB)"), std::string::npos);
  EXPECT_EQ(read_beginning(at("hole"), 100).size(), 100u);
  // Files of the kernel do not tell their size.
  EXPECT_GT(read_whole_file("/proc/cpuinfo", size_t(1) << 24).size(), 100u);
  EXPECT_THROW(read_whole_file("/proc/cpuinfo", 10), InputError);
}

}  // namespace test_whole_file
}  // namespace limberg
