// `limberg import` as a user calls it: from a peer's files to a scene that is checked and an operation that runs.
#include <nlohmann/json.hpp>

#include "tests/app/cli.h"
#include "tests/app/import/peer_fixture.h"

using nlohmann::json;
using F = limberg::test::PeerFixture;

namespace {

using limberg::Vec3;

/// Excises a square, cuts and undermines a flap beside it, and draws it over.
std::string flap_over_defect() {
  return F::history(
      {F::incision({{12, 14}, {22, 14}, {22, 26}, {12, 26}}, false, true), F::excise(17, 20),
       F::incision({{22, 14}, {34, 14}}, true), F::incision({{22, 26}, {34, 26}}, true),
       F::undermine({{24, 14}, {34, 14}, {34, 26}, {24, 26}}, true, true), F::hook(0, F::place(24, 20)),
       R"({"moveHook":[0,1.6,2,1.6]})",
       F::suture(0, F::place(23, 16, Vec3(-1, 0, 0), 2, "0"), F::place(11, 16, Vec3(1, 0, 0), 2, "1"), false),
       F::suture(1, F::place(23, 24, Vec3(-1, 0, 0), 2, "0"), F::place(11, 24, Vec3(1, 0, 0), 2, "1"), true),
       R"({"deleteHook":0})"});
}

}  // namespace

class CliImport : public Cli {
 protected:
  CliImport() {
    fs::create_directory(dir_ / "models");
    file("models/slab.obj", fixture_.obj), file("models/slab.bed", fixture_.bed);
    file("models/SLAB.smd", F::scene());  // names differ in case where they come from
  }
  std::string call(const std::string& history, const std::string& more = "") const {
    return "import " + history + " --models " + path("models") + " --unit-mm 10 --out " + path("out") + more;
  }
  F fixture_;
};

// What the peer keeps tissue out of lies beside the scene and is named in it; what is missing or not closed is said.
TEST_F(CliImport, CollidersAreCarriedOrLeftOutInWords) {
  const std::string history = file("flap.hst", flap_over_defect());
  ASSERT_EQ(run(call(history)).status, 0);
  EXPECT_NE(slurp(path("out/flap.html")).find("teeth.obj&#39;: is not there"), std::string::npos);
  const std::string tooth = "v 1 1 -3\nv 2 1 -3\nv 1 2 -3\nv 1 1 -2\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  file("models/teeth.obj", tooth);
  ASSERT_EQ(run(call(history, " --replace")).status, 0);
  EXPECT_NE(slurp(path("out/flap.html")).find("the collider is open"), std::string::npos);
  file("models/teeth.obj", tooth + "f 3 1 4\n");
  ASSERT_EQ(run(call(history, " --replace")).status, 0);
  EXPECT_EQ(slurp(path("out/flap.html")).find("Nothing keeps tissue out"), std::string::npos);
  EXPECT_NE(slurp(path("out/flap.toml")).find("mesh = \"flap-collider-1.obj\""), std::string::npos);
  EXPECT_NE(slurp(path("out/flap-collider-1.obj")).find("v 20.00000 10.00000 -30.00000"), std::string::npos);
  EXPECT_EQ(run("check " + path("out/flap.toml")).status, 0);
}

// Tissue that the peer weighs otherwise is a region of its own, so many times as stiff; what cannot be used is said.
TEST_F(CliImport, VolumesOfOtherTissueAreRegions) {
  std::string scene = F::scene();
  scene.insert(scene.find("\"minStrain\""), "\"lowTetWeight\":500,");
  scene.insert(scene.rfind("\"fixedCollisionSets\""),
               R"("tetrahedralSubsets":{"cartilage.obj":{"lowTetWeight":4000},"septum.obj":{"lowTetWeight":250},)"
               R"("blank.obj":{}},)");
  file("models/SLAB.smd", scene);
  const std::string solid = "v 1 1 .3\nv 2 1 .3\nv 1 2 .3\nv 1 1 .9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  file("models/cartilage.obj", solid), file("models/blank.obj", solid);
  const std::string history = file("flap.hst", flap_over_defect());
  const Outcome o = run(call(history));
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string toml = slurp(path("out/flap.toml")), page = slurp(path("out/flap.html"));
  EXPECT_NE(toml.find("name = \"cartilage\"\nvolume = \"flap-region-1.obj\"\nyoung_kPa = 120\n"), std::string::npos)
      << toml;
  EXPECT_NE(slurp(path("out/flap-region-1.obj")).find("v 20.00000 10.00000 3.00000"), std::string::npos);
  EXPECT_NE(page.find("septum.obj&#39; is as soft as the rest: it is not there"), std::string::npos);
  EXPECT_NE(page.find("blank.obj&#39; is as soft as the rest: it has no weight"), std::string::npos);
  const Outcome checked = run("check " + path("out/flap.toml"));
  EXPECT_NE(checked.out.find("region      cartilage, 120 kPa"), std::string::npos) << checked.out;
  EXPECT_NE(run("operate " + path("out/flap.toml") + " " + path("out/flap.jsonl") + " --cell-mm 4").status, 2);
}

TEST_F(CliImport, AnOperationIsCheckedAndRunsWithNothingRefused) {
  const std::string history = file("flap.hst", flap_over_defect());
  const Outcome o = run(call(history));
  ASSERT_EQ(o.status, 0) << o.err;
  const json account = json::parse(slurp(path("out/flap.json")));
  EXPECT_EQ(account["command"], "import");
  EXPECT_EQ(account["refused"], 0);
  EXPECT_EQ(account["acts"].size(), 11u);
  EXPECT_NEAR(account["skin_mm"].get<double>(), 2, 1e-6);
  EXPECT_NE(slurp(path("out/flap.html")).find("makeIncision"), std::string::npos);
  const Outcome checked = run("check " + path("out/flap.toml"));
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_NE(checked.out.find("closed"), std::string::npos) << checked.out;
  EXPECT_EQ(run("check " + path("out/flap.jsonl")).status, 0);

  const Outcome operated = run("operate " + path("out/flap.toml") + " " + path("out/flap.jsonl") +
                               " --cell-mm 4 --json " + path("operated.json"));
  EXPECT_NE(operated.status, 2) << operated.err;
  const json r = json::parse(slurp(path("operated.json")));
  EXPECT_TRUE(!r.contains("refused") || r["refused"].empty()) << r["refused"].dump();
  EXPECT_GT(r["metrics"]["sutures"].size(), 2u);
  for (const json& s : r["metrics"]["sutures"]) EXPECT_LT(s["gap_mm"].get<double>(), 1) << s.dump();
}

TEST_F(CliImport, RefusedActsAreNamedWithTheirLineAndTheRestIsThere) {
  const std::string history = file("some.hst", F::history({F::incision({{10, 20}, {40, 20}}), F::excise(20, 800)}));
  const Outcome o = run(call(history));
  EXPECT_EQ(o.status, 3) << o.err;
  EXPECT_NE(o.err.find("some.hst:4: excision refused"), std::string::npos) << o.err;
  EXPECT_NE(slurp(path("out/some.jsonl")).find("incise"), std::string::npos);
}

TEST_F(CliImport, ASceneAloneIsOneThatRuns) {
  const Outcome o = run("import " + path("models/SLAB.smd") + " --unit-mm 10 --out " + path("out"));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(run("check " + path("out/SLAB.toml")).status, 0);
}

TEST_F(CliImport, WhatIsBrokenOrNotThereIsSaidInALine) {
  expect_refused(call(path("none.hst")), {"none.hst", "no such file"});
  expect_refused(call(file("a.hst", "[\n{\"loadSceneFile\":\"slab.smd\"},\n{]")), {"a.hst:3:", "broken JSON"});
  expect_refused(call(file("b.hst", "[]")), {"b.hst", "loadSceneFile"});
  expect_refused(call(file("c.hst", "{}")), {"c.hst:1:", "expected a list"});
  expect_refused(call(file("d.hst", "[\n\n{\"loadSceneFile\":\"../x.smd\"}]")), {"d.hst:3:", "x.smd", "--models"});
  expect_refused(call(file("e.txt", "[]")), {"e.txt", ".hst"});
  const std::string good = file("f.hst", F::history({F::incision({{10, 20}, {40, 20}})}));
  fs::remove(dir_ / "models" / "slab.obj");
  expect_refused(call(good), {"SLAB.smd:1:", "slab.obj", "is not there"});
  file("models/slab.obj", "v 0 0 nan\n");
  expect_refused(call(good), {"slab.obj:1:"});
  file("models/slab.obj", fixture_.obj.substr(0, fixture_.obj.find("usemtl 7")));  // open below
  expect_refused(call(good), {"f.obj"});
}

TEST_F(CliImport, NothingOfAnotherIsReplaced) {
  const std::string history = file("g.hst", F::history({F::incision({{10, 20}, {40, 20}})}));
  ASSERT_EQ(run(call(history)).status, 0);
  file("out/g.toml", "mine");
  expect_refused(call(history), {"g.toml", "exists already"});
  EXPECT_EQ(slurp(path("out/g.toml")), "mine");
  EXPECT_EQ(run(call(history, " --replace")).status, 0);
}
