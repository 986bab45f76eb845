// `limberg patient` as a user calls it: from a CT to a scene that runs, and to an operation on it.
#include <nlohmann/json.hpp>

#include "sim/imaging/synthetic/synthetic_head.h"
#include "tests/app/cli.h"

namespace limberg {
namespace test_cli_patient {

using nlohmann::json;

/// The volume as NRRD, 16 bits.
std::string nrrd(const Volume& v) {
  std::ostringstream s;
  s << "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: " << v.size[0] << ' ' << v.size[1]
    << ' ' << v.size[2] << "\nencoding: raw\nendian: little\nspace directions:";
  for (int k = 0; k < 3; ++k) s << " (" << v.step_mm(0, k) << ',' << v.step_mm(1, k) << ',' << v.step_mm(2, k) << ')';
  s << "\nspace origin: (" << v.origin_mm.x() << ',' << v.origin_mm.y() << ',' << v.origin_mm.z() << ")\n\n";
  for (const float x : v.value) {
    const auto n = int16_t(std::lround(x));
    s.write(reinterpret_cast<const char*>(&n), 2);
  }
  return s.str();
}

TEST_F(Cli, APatientFromACtIsASceneThatRuns) {
  InlineWorkers w;
  const std::string ct = file("head.nrrd", nrrd(head_ct({}, 3, w)));
  ::Outcome o = run("patient " + ct + " --out " + path("p") + " --json " + path("p.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  const json r = json::parse(slurp(path("p.json")));
  EXPECT_EQ(r["command"], "patient");
  EXPECT_EQ(r["ok"], true);
  EXPECT_EQ(r["offset_HU"], 0);
  ASSERT_EQ(r["bones"].size(), 2u);
  EXPECT_EQ(r["bones"][1]["name"], "mandible");
  EXPECT_GE(r["landmarks"].size(), 40u);
  ASSERT_EQ(r["distances"].size(), 4u);
  for (const json& d : r["distances"])
    if (d["way"] == "mesh to picture") {
      EXPECT_GT(d["reached"], 0.9) << d;
    }
  EXPECT_EQ(r["gallery"].size(), 12u);
  for (const json& p : r["gallery"]) EXPECT_TRUE(fs::exists(path("p") + "/" + p["picture"].get<std::string>())) << p;
  for (const char* name : {"cranium.simplex", "mandible.simplex", "face.simplex", "patient.toml", "report.html"})
    EXPECT_TRUE(fs::exists(path("p") + "/" + name)) << name;
  EXPECT_EQ(run("check " + path("p/patient.toml")).status, 0);

  // The chin goes where the script says: forwards is forwards.
  o = run("operate " + path("p/patient.toml") + " " + path("p/genioplasty.jsonl") + " --json " + path("chin.json"));
  EXPECT_NE(o.out.find("0.00 mm right, 6.00 forward, 0.00 up"), std::string::npos) << o.out << o.err;
  EXPECT_NE(o.out.find("mandible piece"), std::string::npos) << o.out;
  EXPECT_TRUE(o.status == 0 || o.status == 3) << o.err;  // 3: the verdict may find bone outside the skin
  EXPECT_FALSE(json::parse(slurp(path("chin.json"))).contains("refused"));
}

TEST_F(Cli, WhatIsNoCtOfAHeadIsRefusedInWords) {
  InlineWorkers w;
  Volume v;
  v.size = {40, 40, 40}, v.step_mm = 4 * Mat3::Identity();
  for (int i = 0; i < 64000; ++i) v.value.push_back(float(500 + i % 300));  // an MRI, say
  const std::string out = " --out " + path("p");
  expect_refused("patient " + file("mr.nrrd", nrrd(v)) + out,
                 {"mr.nrrd", "no numbers of a CT", "expected air at -1000"});
  // A box of bone in a box of flesh has no hollow for a brain.
  v.value.clear();
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        const int r = std::max({std::abs(i - 20), std::abs(j - 20), std::abs(k - 20)});
        v.value.push_back(r < 8 ? 1100.f : r < 12 ? 45.f : -1000.f);
      }
  expect_refused("patient " + file("box.nrrd", nrrd(v)) + out, {"box.nrrd", "no hollow for a brain"});
  expect_refused("patient " + path("absent.nrrd") + out, {"absent.nrrd"});
  expect_refused("patient " + file("box.nrrd", nrrd(v)), {"--out"});
  fs::create_directories(path("empty"));
  expect_refused("patient " + path("empty") + out, {"empty"});
}

}  // namespace test_cli_patient
}  // namespace limberg
