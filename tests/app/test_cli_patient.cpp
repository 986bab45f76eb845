// `limberg patient` as a user calls it: from a CT to a scene that runs, and to an operation on it.
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/imaging/synthetic/synthetic_head.h"
#include "tests/app/cli.h"
#include "tests/bench/fuzz/sound_files.h"

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

// Faces that a curve crosses are fans about other centres then (osteotomy.h): at most .1 % here (2026-11-27).
constexpr double kPartsOfWhole = 3e-3;

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
  for (const char* name : {"cranium.simplex", "mandible.simplex", "face.simplex", "patient.toml", "flesh.obj",
                           "patient_skin.toml", "report.html"})
    EXPECT_TRUE(fs::exists(path("p") + "/" + name)) << name;
  EXPECT_EQ(run("check " + path("p/patient.toml")).status, 0);

  // The same patient's skin carries a flap.
  const std::string skin = path("p/patient_skin.toml"), flap = path("flap.jsonl");
  o = run("procedure rhomboid --scene " + skin + " --set side_mm=10 --at=42,-8 --out " + flap);
  ASSERT_EQ(o.status, 0) << o.err;
  o = run("operate " + skin + " " + flap + " --json " + path("flap.json"));
  ASSERT_TRUE(o.status == 0 || o.status == 3) << o.err;  // 3: the verdict is not asked for here
  const json closed = json::parse(slurp(path("flap.json")));
  EXPECT_TRUE(closed["refused"].empty()) << closed["refused"];
  EXPECT_LT(closed["residual"].get<double>(), 1e-4);
  EXPECT_EQ(closed["head"]["fragments"].size(), 2u);
  bool edges_meet = false;
  for (const json& row : closed["verdict"])
    edges_meet |= row["what"].get<std::string>().find("closed along its whole edge") != std::string::npos;
  EXPECT_TRUE(edges_meet) << closed["verdict"];

  // The chin goes where the script says: forwards is forwards.
  o = run("operate " + path("p/patient.toml") + " " + path("p/genioplasty.jsonl") + " --json " + path("chin.json"));
  EXPECT_NE(o.out.find("0.00 mm right, 6.00 forward, "), std::string::npos) << o.out << o.err;
  EXPECT_NE(o.out.find("mandible piece"), std::string::npos) << o.out;
  EXPECT_TRUE(o.status == 0 || o.status == 3) << o.err;  // 3: the verdict may find bone outside the skin
  EXPECT_TRUE(json::parse(slurp(path("chin.json")))["refused"].empty());

  // Every operation is there, and does to bone and bite what it is for.
  std::map<std::string, double> whole;
  for (const json& b : r["bones"]) whole[b["name"]] = 1e3 * b["volume_cm3"].get<double>();
  ASSERT_EQ(r["operations"].size(), 6u);
  struct Expected {
    const char* name;
    size_t fragments;
    double overjet_mm;
  };
  for (const Expected& e :
       {Expected{"le_fort_1", 3, 6}, Expected{"le_fort_3", 3, 8}, Expected{"sagittal_split", 4, -6},
        Expected{"genioplasty", 3, 0}, Expected{"fronto_orbital", 3, 0}, Expected{"autorotation", 2, NAN}}) {
    SCOPED_TRACE(e.name);
    const std::string file = path(std::string(e.name) + ".json");
    o = run("operate " + path("p/patient.toml") + " " + path("p/" + std::string(e.name) + ".jsonl") + " --json " +
            file);
    ASSERT_TRUE(o.status == 0 || o.status == 3) << o.err;
    const json head = json::parse(slurp(file))["head"];
    EXPECT_EQ(head["fragments"].size(), e.fragments);
    std::map<std::string, double> sum;
    for (const json& f : head["fragments"]) {
      const std::string name = f["name"];
      sum[name.substr(0, name.find(" piece"))] += f["volume_mm3"].get<double>();
    }
    for (const auto& [bone, mm3] : whole) EXPECT_NEAR(sum[bone], mm3, kPartsOfWhole * mm3) << bone;
    for (const json& c : head["cephalometry"])
      if (c["name"] == "overjet") {
        const double change = c["after"].get<double>() - c["before"].get<double>();
        if (std::isnan(e.overjet_mm))
          EXPECT_GT(change, 5);  // the mouth opens: the chin goes down and back
        else
          EXPECT_NEAR(change, e.overjet_mm, 0.01);
      }
    ASSERT_EQ(head["bone_outside"].size(), 1u);
    EXPECT_LT(head["bone_outside"][0]["depth_mm"], 3);
    // Skin goes along with what was moved, and no farther than a little beyond it.
    std::map<std::string, double> ratio;
    for (const json& k : head.value("soft_to_hard", json::array())) {
      ratio[k["soft"].get<std::string>() + " " + k["bone"].get<std::string>()] = k["ratio"];
      if (std::isfinite(e.overjet_mm) && e.overjet_mm != 0) {
        EXPECT_NEAR(k["bone_mm"], std::abs(e.overjet_mm), 0.01) << k;
      }
      EXPECT_NEAR(k["ratio"], k["soft_mm"].get<double>() / k["bone_mm"].get<double>(), 1e-4);
    }
    const std::map<std::string, std::vector<const char*>> expected{{"le_fort_1", {"ls Is", "sn A"}},
                                                                   {"sagittal_split", {"pog' Pog", "li Ii"}},
                                                                   {"genioplasty", {"pog' Pog", "me' Me"}},
                                                                   {"fronto_orbital", {"g' G"}}};
    if (const auto it = expected.find(e.name); it != expected.end())
      for (const char* pair : it->second) {
        ASSERT_TRUE(ratio.count(pair)) << pair;
        EXPECT_GT(ratio[pair], 0.25) << pair;
        EXPECT_LT(ratio[pair], 1.3) << pair;
      }
    if (e.name == std::string("le_fort_1"))
      for (const json& k : head["soft_to_hard"])
        if (k["soft"] == "ls") {
          EXPECT_EQ(k["known_low"], 0.5);
          EXPECT_EQ(k["known_high"], 0.62);
        }
  }

  // Without tissue the skin stays: soft to hard is nothing, and a chin that goes 20 mm forwards stands out by that less
  // the soft tissue before it.
  std::string bare = slurp(path("p/patient.toml"));
  const size_t tissue = bare.find("[[head.tissue]]");
  ASSERT_NE(tissue, std::string::npos);
  bare.erase(tissue, bare.find("[head.landmarks]") - tissue);
  std::ofstream(path("p/bare.toml")) << bare;
  std::string far = slurp(path("p/genioplasty.jsonl"));
  const size_t six = far.find("[0.0,6.0,");
  ASSERT_NE(six, std::string::npos) << far;
  std::ofstream(path("p/far.jsonl")) << far.replace(six, 9, "[0.0,20.0,");
  o = run("operate " + path("p/bare.toml") + " " + path("p/far.jsonl") + " --json " + path("far.json"));
  EXPECT_EQ(o.status, 3) << o.err;  // bone outside the skin
  const json head = json::parse(slurp(path("far.json")))["head"];
  for (const json& k : head["soft_to_hard"]) EXPECT_NEAR(k["soft_mm"], 0, 1e-6) << k;
  std::map<std::string, Vec3> place;
  for (const json& l : r["landmarks"])
    place[l["name"]] = Vec3(l["at_mm"][0].get<double>(), l["at_mm"][1].get<double>(), l["at_mm"][2].get<double>());
  const double soft = place.at("pog'").y() - place.at("Pog").y();
  const json& outside = head["bone_outside"][0];
  EXPECT_NEAR(outside["depth_mm"].get<double>(), 20 - soft, 4);  // the nearest skin is not straight ahead
  EXPECT_GT(outside["area_mm2"], 100);
  EXPECT_GT(outside["at_mm"][1].get<double>(), place.at("pog'").y());
}

/// Every edge of a binary STL is passed once each way; what is inside, mm3. Read here anew, corners told by their bits.
void expect_closed_stl(const std::string& bytes, double* volume_mm3) {
  ASSERT_GE(bytes.size(), 84u);
  uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, 4);
  ASSERT_EQ(bytes.size(), 84 + size_t(n) * 50);
  using Corner = std::array<float, 3>;
  std::map<std::pair<Corner, Corner>, int> passed;
  double six = 0;
  for (uint32_t t = 0; t < n; ++t) {
    std::array<Corner, 3> c;
    std::memcpy(c.data(), bytes.data() + 84 + size_t(t) * 50 + 12, 36);
    for (size_t k = 0; k < 3; ++k) ++passed[{c[k], c[(k + 1) % 3]}];
    const auto v = [&](size_t k) { return Vec3(double(c[k][0]), double(c[k][1]), double(c[k][2])); };
    six += v(0).dot(v(1).cross(v(2)));
  }
  for (const auto& [edge, times] : passed) {
    const auto back = passed.find({edge.second, edge.first});
    ASSERT_TRUE(times == 1 && back != passed.end() && back->second == 1) << "edge passed " << times << " times";
  }
  *volume_mm3 = six / 6;
  EXPECT_GT(six, 0);
}

TEST_F(Cli, WhatWasPlannedIsTakenAway) {
  InlineWorkers w;
  // Turned and shifted in the picture, so that its frame is another than the head's.
  Volume v = head_ct({}, 3, w);
  const Mat3 R = Eigen::AngleAxisd(0.12, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  v.step_mm = R * v.step_mm, v.origin_mm = R * v.origin_mm + Vec3(15, -80, 300);
  const std::string p = path("p");
  ::Outcome o = run("patient " + file("head.nrrd", nrrd(v)) + " --out " + p);
  ASSERT_EQ(o.status, 0) << o.err;
  o = run("operate " + p + "/patient.toml " + p + "/le_fort_1.jsonl --out " + path("op"));
  ASSERT_TRUE(o.status == 0 || o.status == 3) << o.err;
  expect_refused("export " + path("op") + " --at nowhere --out " + path("no"), {"nowhere", "maxilla forwards"});
  o = run("export " + path("op") + " --at \"maxilla forwards\" --out " + path("print") + " --json " + path("x.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  const json x = json::parse(slurp(path("x.json")));
  ASSERT_EQ(x["moments"].size(), 1u);
  const json plan = json::parse(slurp(path("print/plan.json")));
  std::map<std::string, bool> there;
  for (const json& f : x["moments"][0]["files"]) {
    const std::string name = f["file"];
    there[name] = true;
    EXPECT_TRUE(fs::exists(path("print/" + name + ".ply"))) << name;
    if (!f["closed"].get<bool>()) {
      EXPECT_EQ(name, "face");
      continue;
    }
    SCOPED_TRACE(name);
    double mm3 = 0;
    expect_closed_stl(slurp(path("print/" + name + ".stl")), &mm3);
    EXPECT_NEAR(mm3, f["volume_mm3"].get<double>(), 1e-3 * mm3 + 1);
  }
  for (const char* name :
       {"cranium", "cranium-piece-2", "mandible", "face", "guide-cranium-piece-2-1", "splint", "mirror-mandible"})
    EXPECT_TRUE(there[name]) << name << " " << x["moments"][0].dump(1);
  // The map of the maxilla: 6 mm forwards in the head, the same turned into the picture's frame.
  const auto matrix = [](const json& j) {
    Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 3; ++i) {
      m.translation()[i] = j["translation_mm"][size_t(i)];
      for (int k = 0; k < 3; ++k) m.linear()(i, k) = j["rotation"][size_t(i)][size_t(k)];
    }
    return m;
  };
  const Eigen::Isometry3d to_picture = matrix(plan["picture_from_head"]);
  int moved = 0;
  for (const json& f : plan["fragments"]) {
    const Eigen::Isometry3d head = matrix(f["head"]), picture = matrix(f["picture"]);
    EXPECT_TRUE((picture * to_picture).matrix().isApprox((to_picture * head).matrix(), 1e-9));
    if (head.translation().norm() < 1e-9) continue;
    ++moved;
    EXPECT_LT((head.translation() - Vec3(0, 6, 0)).norm(), 1e-9);
    // The scanner's table is turned by R; the head's own tilt is within 3 degrees of the phantom's.
    const Vec3 expected = 6 * (R * Vec3(0, -1, 0));
    EXPECT_LT((picture.translation() - expected).norm(), 6 * 0.06) << picture.translation().transpose();
  }
  EXPECT_EQ(moved, 1);
  // In the picture's frame a fixed bone lies on the CT's bone: bright voxels under nearly all of its corners.
  o = run("export " + path("op") +
          " --at before --frame picture --without-guides --without-splint --without-mirror --out " + path("ct"));
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string jaw = slurp(path("ct/mandible.stl"));
  const Mat3 back = v.step_mm.inverse();
  int64_t bright = 0, all = 0;
  for (size_t at = 84; at + 50 <= jaw.size(); at += 500) {
    std::array<float, 3> c;
    std::memcpy(c.data(), jaw.data() + at + 12, 12);
    const Vec3 ijk = back * (Vec3(double(c[0]), double(c[1]), double(c[2])) - v.origin_mm);
    float most = -2000;
    for (int k = 0; k < 8; ++k) {
      const auto i = int64_t(std::floor(ijk.x())) + (k & 1), j = int64_t(std::floor(ijk.y())) + (k >> 1 & 1),
                 l = int64_t(std::floor(ijk.z())) + (k >> 2);
      most = std::max(most, v.value[size_t((l * v.size[1] + j) * v.size[0] + i)]);
    }
    bright += most > 300, ++all;
  }
  EXPECT_GT(all, 100);
  EXPECT_GT(double(bright), 0.9 * double(all));  // 95 % of 485 in voxels of 3 mm (2026-11-27)
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
  fs::create_directories(path("mri"));
  for (int k = 0; k < 30; ++k) {
    fuzz::Slice s;
    s.modality = "MR", s.at = {0, 0, 5. * k}, s.number = k;
    file("mri/" + std::to_string(k) + ".dcm", fuzz::dicom(s));
  }
  for (const std::string series : {"", " --series 1"})
    expect_refused("patient " + path("mri") + series + out, {"mri", "series 1 is an MRI", "expected a CT", "--iso"});
  fs::create_directories(path("empty"));
  expect_refused("patient " + path("empty") + out, {"empty"});
}

}  // namespace test_cli_patient
}  // namespace limberg
