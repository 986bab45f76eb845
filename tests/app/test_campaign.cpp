// What becomes of members that an engine loses, cuts short or is still busy with.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>

#include "app/result/output.h"
#include "app/study/campaign.h"
#include "app/study/member_file.h"
#include "app/study/slurm_words.h"
#include "app/study/task_file.h"
#include "sim/base/error.h"

namespace limberg::study {
namespace test_campaign {

namespace fs = std::filesystem;

class Campaigns : public ::testing::Test {
 protected:
  Campaigns() {
    std::string name = (fs::temp_directory_path() / "limberg-campaign-XXXXXX").string();
    dir_ = mkdtemp(name.data());
    prepare_folder(dir_ + "/members");
    for (const Values& v : members(disc_, {"along=1.1,1.2,1.3", "across=1.05", "cell_mm=6"}))
      jobs_.push_back({&disc_, v});
  }
  ~Campaigns() override { fs::remove_all(dir_); }

  void leave(const Job& job, const std::string& failure = "", bool cut_short = false, uint64_t program = 0) const {
    MemberResult m;
    m.row.figures = {{"error", 1}};
    m.program = program ? program : program_hash(), m.failure = failure, m.cut_short = cut_short;
    write_whole_file(member_file(dir_, disc_, job.values, ".json"), member_text(disc_, job.values, m));
  }

  Counts run(Engine& engine, int retries = 2) {
    CampaignSettings set;
    set.dir = dir_, set.retries = retries;
    set.interrupted = [this] { return interrupted_; };
    set.ended = [this](size_t i, bool done, const std::string& why) { ended_[i] = done ? "done" : why; };
    return run_campaign(jobs_, engine, set);
  }

  std::string dir_;
  const Family& disc_ = find_family("disc");
  std::vector<Job> jobs_;
  std::map<size_t, std::string> ended_;
  bool interrupted_ = false;
};

/// Does with each job that is submitted what the test says, `round` counting from 1.
struct Scripted : Engine {
  std::function<void(const Job& job, int round)> act;
  int rounds = 0, busy = 0;
  size_t submitted = 0;
  bool stopped = false;
  void submit(const std::vector<Job>& jobs) override {
    ++rounds, submitted += jobs.size(), busy = 2;
    for (const Job& job : jobs) act(job, rounds);
  }
  EngineState poll() override { return {size_t(busy > 0), busy-- <= 0, {}}; }
  bool stop() override { return !(stopped = true); }
  double poll_every_s() const override { return 0.001; }
};

TEST_F(Campaigns, WhatANodeLostIsRunAgainAndNothingElse) {
  Scripted engine;
  engine.act = [&](const Job& job, int round) {
    if (round > 1 || job.values[0] != 1.2) leave(job);
  };
  const Counts c = run(engine);
  EXPECT_EQ(c.done, 3u);
  EXPECT_EQ(c.lost, 1u);
  EXPECT_EQ(c.retried, 1u);
  EXPECT_EQ(engine.submitted, 4u);
}

TEST_F(Campaigns, WhatWasCutShortIsTriedAgainWhatFailedInWordsIsNot) {
  Scripted engine;
  engine.act = [&](const Job& job, int round) {
    if (job.values[0] == 1.1)
      leave(job, "the solver stalled");
    else if (job.values[0] == 1.2)
      leave(job, "took longer than 3 s", true);
    else
      leave(job, round < 3 ? "ended by signal 9" : "", round < 3);
  };
  const Counts c = run(engine);
  EXPECT_EQ(ended_[0], "the solver stalled");
  EXPECT_EQ(ended_[1], "took longer than 3 s");
  EXPECT_EQ(ended_[2], "done");
  EXPECT_EQ(engine.submitted, 3u + 2 + 2);
  EXPECT_EQ(c.failed, 2u);
  EXPECT_EQ(c.done, 1u);
}

TEST_F(Campaigns, EndsWhenAMemberIsLostEachTime) {
  Scripted engine;
  engine.act = [&](const Job& job, int) {
    if (job.values[0] != 1.2) leave(job);
  };
  const Counts c = run(engine, 1);
  EXPECT_EQ(engine.rounds, 2);
  EXPECT_EQ(c.failed, 1u);
  EXPECT_EQ(ended_[1], "left no result, tried 2 times");
}

TEST_F(Campaigns, AnotherProgramsMembersAreNone) {
  Scripted engine;
  engine.act = [&](const Job& job, int) { leave(job, "", false, 7); };
  EXPECT_EQ(run(engine, 1).failed, 3u);
  EXPECT_NE(ended_[0].find("another program"), std::string::npos);
}

// A program before this one has submitted; its tasks are in the queue and leave their files by and by.
TEST_F(Campaigns, WhatIsUnderWayIsWaitedForAndNotSubmittedAgain) {
  Scripted engine;
  engine.busy = 5;
  for (const Job& job : jobs_)
    if (job.values[0] != 1.3) leave(job);
  engine.act = [&](const Job& job, int) { leave(job); };
  EXPECT_EQ(run(engine).done, 3u);
  EXPECT_EQ(engine.submitted, 1u);  // the one that nobody had
}

TEST_F(Campaigns, AnInterruptEndsItWithWhatIsThere) {
  Scripted engine;
  engine.act = [&](const Job& job, int) {
    if (job.values[0] == 1.1) leave(job);
    interrupted_ = true;
  };
  const Counts c = run(engine);
  EXPECT_TRUE(engine.stopped);
  EXPECT_EQ(c.done, 1u);
  EXPECT_EQ(c.failed, 0u);
}

TEST_F(Campaigns, WordsCountAndSayWhatIsLeft) {
  Counts c;
  c.all = 2048, c.done = 612, c.running = 2, c.failed = 3, c.left_s = 240;
  EXPECT_EQ(in_words(c), "612 of 2048 done, 2 running, 3 failed, about 4 min left");
  c.retried = 5, c.note = "Slurm does not answer";
  EXPECT_NE(in_words(c).find("5 tried again"), std::string::npos);
  EXPECT_NE(in_words(c).find("(Slurm does not answer)"), std::string::npos);
}

TEST_F(Campaigns, ATasksFileNamesMembersToTheLastBit) {
  jobs_[0].values[0] = 1.1 + 1e-15;
  write_whole_file(dir_ + "/task", task_text(jobs_));
  const std::vector<Job> again = read_task(dir_ + "/task");
  ASSERT_EQ(again.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(again[i].values, jobs_[i].values);
  for (const char* bad : {"none a=1\n", "disc along=1.1,1.2\n", "disc along=x\n", "disc\n"}) {
    write_whole_file(dir_ + "/task", bad);
    EXPECT_THROW(read_task(dir_ + "/task"), InputError) << bad;
  }
}

TEST(SlurmWords, AreRead) {
  const Queue q = read_queue("R|None\nCG|None\nPD|Resources\nPD|JobHeldAdmin\nwarning: nothing\n");
  EXPECT_EQ(q.running, 2u);
  EXPECT_EQ(q.waiting, 2u);
  EXPECT_EQ(q.held, "JobHeldAdmin");
  EXPECT_EQ(read_queue("").running + read_queue("").waiting, 0u);
  EXPECT_EQ(read_max_array("MaxArraySize            = 77\nMaxDBDMsgs = 3\n"), 77);
  EXPECT_EQ(read_max_array("nothing"), 1001);
  EXPECT_EQ(read_job("123;cluster\n"), "123");
  EXPECT_EQ(read_job("sbatch: error"), "");
}

}  // namespace test_campaign
}  // namespace limberg::study
