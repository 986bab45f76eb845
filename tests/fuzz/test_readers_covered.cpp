// Whatever reads bytes from outside has an entry for fuzzers: a new reader without one fails here.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "app/program/places.h"
#include "tests/fuzz/entries.h"

namespace limberg {
namespace test_readers_covered {

namespace fs = std::filesystem;

/// What only readers of bytes have in them.
constexpr const char* kSigns[] = {"read_whole_file", "OpenedFile",  "read_beginning(", "std::ifstream",
                                  "::parse(",        "parse_toml(", "inflate(",        "png_create_read_struct(",
                                  "decode_message(", "::recvfrom(", "::recv(",         " ::read(",
                                  "port.read(",      "std::fread(", "std::fgets("};

/// What reads nothing from outside that could be formed by another, or hands all of it to readers that have entries.
const std::map<std::string, std::string> kNone{
    {"sim/base/whole_file.h", "opens files for all readers, and looks at none of their bytes"},
    {"app/scene/toml_table.h", "parses TOML for scenes, tissues and lessons"},
    {"app/commands/check.cpp", "gives a file to the reader of its kind"},
    {"app/class/gather.cpp", "gives a file to the reader of its kind"},
    {"app/commands/class.cpp", "gives a result to its reader, and hashes a lesson"},
    {"app/commands/words.cpp", "prints the list of texts as it stands"},
    {"app/commands/rooms.cpp", "gives an emulated hand to its reader"},
    {"app/commands/operate.cpp", "gives a script to its reader"},
    {"app/commands/this_call.cpp", "the words of this call"},
    {"app/result/output.cpp", "compares the first bytes of a file that would be replaced"},
    {"app/head/face_look.cpp", "gives a surface to its reader, and a picture to its"},
    {"app/scene/surface_picture.cpp", "gives a surface and its material to their readers"},
    {"app/study/place.cpp", "the hash of a file"},
    {"app/study/processes.cpp", "gives what a program says to the reader of its words"},
    {"app/study/study_result.cpp", "copies pictures"},
    {"devices/lcm_log_writer.cpp", "copies what it has written itself"},
    {"devices/unfinished.cpp", "gives the ends of a log to its reader"},
};

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}

bool reads(const fs::path& path) {
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.find("//"), line.size()));
    for (const char* sign : kSigns)
      if (line.find(sign) != std::string::npos) return true;
  }
  return false;
}

std::set<std::string> named_by_entries() {
  std::set<std::string> all;
  for (const fuzz::Entry& e : fuzz::entries()) all.insert(e.reads.begin(), e.reads.end());
  return all;
}

TEST(ReadersCovered, EachReaderOfBytesHasAnEntry) {
  const std::set<std::string> named = named_by_entries();
  const fs::path root = source_dir();
  int readers = 0;
  for (const char* wing : {"app", "calibration", "devices", "render", "sim"})
    for (const auto& e : fs::recursive_directory_iterator(root / wing)) {
      if (!e.is_regular_file() || (e.path().extension() != ".h" && e.path().extension() != ".cpp")) continue;
      const std::string name = fs::relative(e.path(), root).generic_string();
      if (!reads(e.path())) {
        EXPECT_FALSE(kNone.contains(name)) << name << " reads nothing and needs no excuse";
        continue;
      }
      ++readers;
      EXPECT_TRUE(named.contains(name) || kNone.contains(name))
          << name << " reads bytes from outside; expected an entry in tests/fuzz that names it";
    }
  EXPECT_GT(readers, 25);
}

TEST(ReadersCovered, EntriesNameFilesThatAreThere) {
  for (const fuzz::Entry& e : fuzz::entries()) {
    EXPECT_FALSE(e.reads.empty()) << e.name;
    for (const std::string& file : e.reads)
      EXPECT_TRUE(fs::exists(fs::path(source_dir()) / file)) << e.name << " names " << file;
  }
}

TEST(ReadersCovered, EachMessageHasAnEntry) {
  std::set<std::string> names;
  for (const fuzz::Entry& e : fuzz::entries()) names.insert(e.name);
  int messages = 0;
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / "devices/messages")) {
    std::string name = e.path().stem().string();  // stylus_t
    name.resize(name.size() - 2);
    EXPECT_TRUE(names.contains("packet_" + name)) << name << " has no entry in tests/fuzz";
    ++messages;
  }
  EXPECT_GE(messages, 11);
}

TEST(ReadersCovered, EachCorpusIsOfAnEntry) {
  std::set<std::string> names;
  for (const fuzz::Entry& e : fuzz::entries()) names.insert(e.name);
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / "tests/fuzz/corpus"))
    EXPECT_TRUE(names.contains(e.path().filename().string())) << e.path() << " is of no entry";
}

}  // namespace test_readers_covered
}  // namespace limberg
