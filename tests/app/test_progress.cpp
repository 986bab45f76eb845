// How far work has come: a line in a log now and then, nothing in a pipe. And pictures that a person has had enough of.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/pictures/pictures_drawn.h"
#include "app/program/interrupt.h"
#include "app/result/progress.h"

namespace limberg {
namespace test_progress {

std::string slurp(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Progress, WritesWholeLinesIntoALogAndNotTooMany) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("limberg-progress-" + std::to_string(getpid()))).string();
  const auto log_of = [&](int64_t every_ns) {
    const int log = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    Progress p("3.5 mm cells", log, every_ns);
    for (int k = 0; k <= 17; ++k) p.show(k, 17, "actions");
    p.note("picture 3 of 12");
    p.clear();
    close(log);
    return slurp(file);
  };
  const std::string all = log_of(0);
  EXPECT_NE(all.find("limberg: 3.5 mm cells: 3 of 17 actions   18 %\n"), std::string::npos) << all;
  EXPECT_NE(all.find("limberg: 3.5 mm cells: picture 3 of 12\n"), std::string::npos);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 19);
  EXPECT_EQ(all.find_first_of("\r\033"), std::string::npos) << "nothing that a terminal obeys";
  EXPECT_EQ(log_of(Progress::kLogEvery_ns), "") << "work that takes less than ten seconds says nothing";
  std::filesystem::remove(file);
}

TEST(Progress, SaysNothingInAPipe) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  {
    Progress p("work", ends[1], 0);
    p.show(1, 2, "actions"), p.note("words");
  }
  close(ends[1]);
  char byte;
  EXPECT_EQ(read(ends[0], &byte, 1), 0);
  close(ends[0]);
}

void draw_and_be_interrupted(int before, int after) {
  catch_interrupts();
  if (before) raise(SIGINT);
  PicturesDrawn drawn(3);
  const int first = drawn.next();
  if (after) raise(SIGINT);
  const int second = drawn.next(), third = drawn.next();
  _exit(first + 2 * second + 4 * third + 8 * drawn.all());
}

TEST(PicturesDrawn, EndAtTheNextPictureOfWhoHadEnough) {
  EXPECT_EXIT(draw_and_be_interrupted(0, 0), ::testing::ExitedWithCode(15), "");
  EXPECT_EXIT(draw_and_be_interrupted(0, 1), ::testing::ExitedWithCode(1), "interrupted; 1 of 3 pictures are drawn");
  // Who was interrupted at work gets the pictures of what was done.
  EXPECT_EXIT(draw_and_be_interrupted(1, 0), ::testing::ExitedWithCode(15), "");
}

}  // namespace test_progress
}  // namespace limberg
