// Repro files: written when a cut is refused, never over an existing file, read back to the same commands.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/assembly/repro.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_repro {

namespace fs = std::filesystem;

class ReproFiles : public testing::Test {
 protected:
  ReproFiles() {
    std::string name = (fs::temp_directory_path() / "limberg-repro-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~ReproFiles() override { fs::remove_all(dir_); }
  std::string text(const std::string& file) const {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream s;
    s << in.rdbuf();
    return s.str();
  }
  std::string dir_;
};

Repro blank() {
  Repro r;
  r.program = "limberg test";
  r.scene = "small \"one\"";
  r.scene_hash = 0x0123456789abcdefull;
  r.cell_mm = 3.5;
  r.seed = ~uint64_t(0);
  return r;
}

const Incise kCut{{{0.1, 0}, {1.0 / 3, 20}}, 4, 70};

TEST_F(ReproFiles, RoundTrip) {
  ReproWriter w(dir_, blank());
  w.done(kCut);
  w.done(Stage{"not kept"});
  w.done(SetHook{1, {3, 4}});
  w.done(MoveHook{1, {3, 4, 5}, 1});
  w.done(InciseMore{2, {{1, 2}, {9, 9}}, 4, 90, false});
  const std::string file = w.refused(Excise{{{0, 0}, {5, 0}, {5, 5}}, 3}, "why \"not\"\n", 42);
  ASSERT_EQ(file, dir_ + "/repro-1.json");
  ASSERT_TRUE(looks_like_repro(text(file)));
  const Repro r = parse_repro(text(file), file);
  EXPECT_EQ(r.scene, blank().scene);
  EXPECT_EQ(r.scene_hash, blank().scene_hash);
  EXPECT_EQ(r.seed, blank().seed);
  EXPECT_EQ(r.cell_mm, 3.5);
  EXPECT_EQ(r.topology_hash, 42u);
  EXPECT_EQ(r.reason, "why \"not\"\n");
  ASSERT_EQ(r.commands.size(), 4u);
  EXPECT_EQ(std::get<Incise>(r.commands[0]).path, kCut.path);
  EXPECT_FALSE(std::get<InciseMore>(r.commands[3]).last);
  EXPECT_TRUE(std::holds_alternative<Excise>(r.refused));
  EXPECT_EQ(to_text(r), text(file));
  const Script s = script_of(r, file);
  ASSERT_EQ(s.lines.size(), 5u);
  EXPECT_TRUE(std::holds_alternative<Excise>(s.lines.back().command));
}

TEST_F(ReproFiles, NothingIsOverwritten) {
  std::ofstream(dir_ + "/repro-1.json") << "mine";
  ReproWriter w(dir_, blank());
  EXPECT_EQ(w.refused(kCut, "a", 1), dir_ + "/repro-2.json");
  EXPECT_EQ(w.refused(kCut, "b", 1), dir_ + "/repro-3.json");
  EXPECT_EQ(text(dir_ + "/repro-1.json"), "mine");
}

TEST_F(ReproFiles, OnlyCutsAndNotTooMany) {
  ReproWriter w(dir_, blank());
  EXPECT_EQ(w.refused(Suture{{0, 0}, {0, 0}}, "a", 1), "");
  EXPECT_EQ(w.refused(Undo{}, "a", 1), "");
  EXPECT_NE(w.refused(InciseMore{3, {{0, 0}}, 4, 90, false}, "a", 1), "");
  EXPECT_EQ(w.refused(InciseMore{3, {{1, 0}}, 4, 90, false}, "it has stopped", 1), "") << "the rest of the same stroke";
  for (int i = 0; i < 50; ++i) w.refused(kCut, "a", 1);
  EXPECT_EQ(int(w.files().size()), ReproWriter::kMost);
  ReproWriter nowhere("", blank());
  EXPECT_EQ(nowhere.refused(kCut, "a", 1), "");
  ReproWriter gone(dir_ + "/none", blank());
  EXPECT_EQ(gone.refused(kCut, "a", 1), "");
  EXPECT_NE(gone.error(), "");
}

TEST_F(ReproFiles, BrokenOnesAreRefused) {
  ReproWriter w(dir_, blank());
  w.done(kCut);
  const std::string good = text(w.refused(kCut, "a", 1));
  EXPECT_NO_THROW(parse_repro(good, "r"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string s = good;
    const size_t at = s.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return s.replace(at, from.size(), to);
  };
  for (const std::string& bad :
       {std::string("{\"limberg_repro\":1}"), std::string("{\"limberg_repro\":1"),
        std::string("{\"limberg_repro\":[[[[[[[[[[[[[[[[[[1]]"), changed(": 1,", ": 2,"),
        changed("\"seed\": 18446744073709551615", "\"seed\": -1"), changed("\"cell_mm\": 3.5", "\"cell_mm\": 1e999"),
        changed("\"cell_mm\": 3.5", "\"cell_mm\": 0"), changed("0123456789abcdef", "0123456789abcdeX"),
        changed("\"incise\"", "\"inzise\""), changed("\"reason\"", "\"raison\""),
        changed("\"refused\": {", "\"refused\": [{")})
    EXPECT_THROW(parse_repro(bad, "r"), InputError) << bad;
  for (size_t n = 0; n + 2 < good.size(); n += 7) {
    const std::string cut = good.substr(0, n);
    EXPECT_THROW(parse_repro(cut, "r"), InputError) << n;
  }
  EXPECT_FALSE(looks_like_repro("{\"limberg_script\":1,\"scene\":\"x\"}"));
  EXPECT_FALSE(looks_like_repro(""));
}

}  // namespace test_repro
}  // namespace limberg
