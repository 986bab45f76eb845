// The library of cases from the command line.
#include <sstream>

#include "tests/app/cli.h"

static void closes_and_meets_its_lesson(const Outcome& o) {
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("closed along its whole edge"), std::string::npos) << o.out;
  EXPECT_EQ(o.out.find("not met"), std::string::npos) << o.out;
}

TEST_F(Cli, CasesAreListedOneALineAndTold) {
  const Outcome list = run("cases");
  ASSERT_EQ(list.status, 0) << list.err;
  std::istringstream lines(list.out);
  int n = 0;
  for (std::string line; std::getline(lines, line); ++n) {
    const std::string name = line.substr(0, line.find(' '));
    EXPECT_TRUE(fs::exists(kSource + "/app/lessons/" + name + ".toml")) << line;
    EXPECT_TRUE(fs::exists(kSource + "/recordings/" + name + ".jsonl")) << line;
    const Outcome one = run("cases --case " + name);
    EXPECT_EQ(one.status, 0) << one.err;
    EXPECT_NE(one.out.find("limberg run --case " + name), std::string::npos) << one.out;
    EXPECT_EQ(run("check " + kSource + "/app/lessons/" + name + ".toml").status, 0) << name;  // its plan lies on skin
  }
  EXPECT_GE(n, 32);
}

TEST_F(Cli, ThePageOfCasesHasEachWithItsPlan) {
  const Outcome o = run("cases --out " + path("page"));
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string page = slurp(path("page/cases.html"));
  for (const char* word : {"Rhomboid flap on the cheek", "V-Y advancement on the cheek", "Le Fort I", "<svg"})
    EXPECT_NE(page.find(word), std::string::npos) << word;
}

TEST_F(Cli, ACaseThatIsNoneIsRefusedWithTheNames) {
  for (const char* call : {"cases --case nose", "run --headless --seconds 1 --case nose", "operate --case nose"}) {
    const Outcome o = run(call);
    EXPECT_EQ(o.status, 2) << call;
    EXPECT_NE(o.err.find("expected one of: autorotation, bicoronal"), std::string::npos) << o.err;
  }
  EXPECT_EQ(run("operate").status, 2);
  EXPECT_EQ(run("operate rhomboid").status, 2);
  EXPECT_EQ(run("operate rhomboid x.jsonl --case rhomboid").status, 2);
}

TEST_F(Cli, AFlapOnTheCheekClosesAndMeetsItsLesson) {
  const Outcome o = run("operate --case cheek-v-y --json " + path("r.json"));
  closes_and_meets_its_lesson(o);
}

// Through both skins of a thin fold: the piece is free, comes out, and edges meet in front and behind.
TEST_F(Cli, AWedgeOfTheEarClosesAndMeetsItsLesson) {
  const Outcome o = run("operate --case ear-wedge --json " + path("r.json"));
  closes_and_meets_its_lesson(o);
  EXPECT_EQ(o.out.find("tissue inside out"), std::string::npos) << o.out;
}

// Through skin, muscle and mucosa from a free margin: the lip lies before the teeth, and its edges meet.
TEST_F(Cli, AWedgeOfTheLipClosesBeforeTheTeethAndMeetsItsLesson) {
  const Outcome o = run("operate --case lip-wedge --json " + path("r.json"));
  closes_and_meets_its_lesson(o);
  EXPECT_EQ(o.out.find("verdict     bad"), std::string::npos) << o.out;
}

// Through skin, muscle and conjunctiva from a free margin: the lid lies before the globe, and its edges meet.
TEST_F(Cli, OperationsOnALidCloseBeforeTheGlobeAndMeetTheirLessons) {
  for (const std::string name : {"lid-wedge", "lid-tenzel"}) {
    const Outcome o = run("operate --case " + name + " --json " + path("r.json"));
    SCOPED_TRACE(name);
    closes_and_meets_its_lesson(o);
    EXPECT_EQ(o.out.find("verdict     bad"), std::string::npos) << o.out;
  }
}

// A lip that a cleft divides: pared, rotated, advanced, sewn in front and behind.
TEST_F(Cli, ACleftOfTheLipClosesAndMeetsItsLesson) {
  const Outcome o = run("operate --case lip-cleft --json " + path("r.json"));
  closes_and_meets_its_lesson(o);
  EXPECT_EQ(o.out.find("verdict     bad"), std::string::npos) << o.out;
}
