// What is written as text: TOML, JSON, scripts, tables.
#include <cmath>
#include <filesystem>

#include "app/assembly/desk_memory.h"
#include "app/assembly/lesson.h"
#include "app/assembly/repro.h"
#include "app/class/class_page.h"
#include "app/export/achieved.h"
#include "app/export/glb.h"
#include "app/export/operated.h"
#include "app/head/cache.h"
#include "app/import/carried_acts.h"
#include "app/import/peer_files.h"
#include "app/operating_point/kept_trials.h"
#include "app/operating_point/operating_point.h"
#include "app/program/shown.h"
#include "app/program/temporary_folder.h"
#include "app/report/compare.h"
#include "app/report/report.h"
#include "app/report/viewer.h"
#include "app/result/result.h"
#include "app/room/hands.h"
#include "app/scene/scene.h"
#include "app/scene/tissues.h"
#include "app/study/member_file.h"
#include "app/study/ranges.h"
#include "app/study/slurm_words.h"
#include "app/study/task_file.h"
#include "app/words/word_table.h"
#include "app/words/words.h"
#include "calibration/calibration.h"
#include "calibration/points_file.h"
#include "sim/base/error.h"
#include "sim/body/tension_lines.h"
#include "sim/body/thickness.h"
#include "sim/commands/script.h"
#include "sim/imaging/register/landmark_pairs.h"
#include "tests/app/import/peer_fixture.h"
#include "tests/app/report/xml_check.h"
#include "tests/fuzz/entry_parts.h"

namespace limberg::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSmallScene = R"([body]
source = "block"
size_mm = [40, 40, 10]
skin_cell_mm = 2
[[layer]]
name = "skin"
thickness_mm = 10
young_kPa = 60
poisson = 0.45
[lattice]
cell_mm = 5
)";

constexpr const char* kResult = R"json({"limberg": {"version": "0.1.0", "commit": "abc"}, "command": "replay",
"scene": "rhomboid", "ok": false, "machine": {"cpu": "Some CPU", "cores": 2}, "mode": "lockstep", "duration_s": 60.5,
"state_hash": "00ff", "parts": ["cutter"], "memory_mb": 300, "reproduce": "limberg replay x.lcm",
"verdict": [{"what": "gape", "value": 3, "unit": "mm", "limit": 1, "place": "(1, 2)", "bad": true}],
"device": {"ticks": 605, "late_ticks": 3, "wake_us": {"p50": 20, "max": 5000}, "work_us": {"p50": 10}},
"solver": {"steps": 3630, "step_ms": {"p50": 8}, "residual": 3.2e-5}, "render": {"frames": 9, "frame_ms": {"p50": 20}},
"metrics": {"pieces": 1, "closure_force_N": 7.25, "sutures": [{"id": 1, "force_N": 2.75, "gap_mm": 0.12}, {"id": 3}]},
"stages": [{"name": "cut", "picture": "stages/00.png", "t_s": 10, "caption": "Out.", "sutures": 2}],
"series": {"t_s": [0, 1, 2], "residual": [0.1, null, 1e-3]}, "balance": {"sum_N": [0, 0.001, 0], "relative": 0.005},
"convergence": [{"cell_mm": 5, "dog_ear_mm": 1.6}, {"cell_mm": 3.5, "dog_ear_mm": 1.9}],
"discretisation": {"dog_ear_mm": {"value": 1.9, "error": 0.9, "order": 1.4, "asymptotic": false, "says": "swings"}},
"bars": [{"name": "b", "value": 1, "bar": 2, "pass": true}], "lesson": {"title": "t", "goal": "g"},
"tables": [{"title": "t", "about": "a", "columns": ["x", "y"], "rows": [["1", "2"]]}],
"charts": [{"title": "c", "x": "mm", "y": "N", "series": [{"name": "s", "x": [1, 2], "y": [3, 4]}]}],
"gallery": [{"picture": "a.png", "caption": "b"}], "exercise": {"time_s": 3},
"script": [{"action": "excise", "depth_mm": 4}, "{\"action\":\"stage\",\"name\":\"cut\"}"]})json";

Entry script_entry() {
  return text_entry(
      "script", {"sim/commands/script.cpp", "sim/commands/script_reader.cpp"},
      {shipped("recordings/rhomboid.jsonl"), shipped("recordings/craniofacial.jsonl")},
      [](const std::string& text) -> std::string {
        const std::string again = to_text(parse_script(text, kNamed));
        return to_text(parse_script(again, "written")) == again ? "" : "a script differs when it is written and read";
      });
}

Entry calibration_entry() {
  return text_entry("calibration", {"calibration/calibration.cpp"},
                    {shipped("calibration/identity.toml"), R"(limberg_calibration = 1
name = "metal"
[glove]
closed_mm = 12
[world]
from_tracker_quat = [0, 1, 0, 0]
[distortion]
nodes = [2, 2, 2]
low_mm = [0, 0, 0]
high_mm = [100, 100, 100]
add_mm = [0,0,0, 1,0,0, 0,1,0, 0,0,1, 1,1,0, 0,0,0, 0,0,0, 2,0,0]
)"},
                    [](const std::string& text) -> std::string {
                      const Calibration c = parse_calibration(text, kNamed);
                      const Calibration again = parse_calibration(to_toml(c), "written");
                      if (calibration_hash(c) != calibration_hash(again)) return "it differs when written and read";
                      return c.distortion.at({50, 20, 1e9}).allFinite() ? "" : "a correction that is no number";
                    });
}

Entry repro_entry() {
  Repro r;
  r.program = "limberg", r.scene = "small", r.reason = "why", r.cell_mm = 3.5;
  r.commands = {SetHook{1, {3, 4}}};
  r.refused = Incise{{{0.1, 0}, {1.0 / 3, 20}}, 4, 70};
  return text_entry("repro", {"app/assembly/repro.cpp"}, {to_text(r)}, [](const std::string& text) -> std::string {
    const Repro got = parse_repro(text, kNamed);
    const std::string again = to_text(got);
    if (to_text(parse_repro(again, "written")) != again) return "it differs when it is written and read";
    return script_of(got, kNamed).lines.size() == got.commands.size() + 1 ? "" : "commands are missing";
  });
}

Entry operating_point_entry(const Folder& folder) {
  const auto scene = std::make_shared<Scene>(parse_scene(kSmallScene, "small.toml"));
  const std::string sound =
      R"({"operating_point": {"cell_mm": 3.5, "iterations": 10, "frame_ms": 1, "error_mm": 1, "budget_ms": 8,
"fits": true, "scene_hash": ")" +
      hex(scene->hash) + "\"}}";
  return path_entry("operating_point", folder, "result.json", {"app/operating_point/operating_point.cpp"}, {sound},
                    [scene](const std::string& path) -> std::string {
                      const bench::OperatingPoint p = read_operating_point(path, *scene);
                      try {
                        const Scene s = at_operating_point(*scene, p.cell_mm, p.iterations);
                        return s.iterations_per_step == p.iterations ? "" : "another number of iterations";
                      } catch (const InputError&) {
                        return "";  // cells that do not fit into this body
                      }
                    });
}

/// A model is packed, or refused; what lies in it is not looked at.
Entry model_entry() {
  std::string json =
      R"({"asset":{"version":"2.0","extras":{"limberg_page_model":1}},"buffers":[{"byteLength":12}],"bufferViews":[)"
      R"({"buffer":0,"byteOffset":0,"byteLength":8,"byteStride":4},{"buffer":0,"byteOffset":8,"byteLength":4}]})";
  return text_entry("model", {"app/report/viewer.cpp"}, {glb_bytes(json, "abcdefghijkl")},
                    [](const std::string& text) -> std::string {
                      return packed_model(text, kNamed).compare(0, 2, "\x1f\x8b") == 0 ? ""
                                                                                       : "what is packed is no gzip";
                    });
}

/// A page is well formed whatever the words and numbers of its result are.
Entry result_entry(const Folder& folder) {
  return text_entry("result",
                    {"app/report/report.cpp", "app/report/report_data.cpp", "app/report/sections/closing.cpp"},
                    {kResult}, [folder](const std::string& text) {
                      return test::xml_fault(report_html(text, (folder->path() / kNamed).string()));
                    });
}

/// One of a class, whatever its numbers are: the page stays well formed, and the table has its row.
Entry class_entry() {
  const std::string more =
      R"(,"class":{"kind":"recording","whole":true,"act_s":[1,2],"path":{"x_mm":[1,null,3],"y_mm":[1,null,2],)"
      R"("tool":[0,null,1]},"missed":{"why":["no skin"],"x_mm":[1],"y_mm":[2]},"stitches":{"x_mm":[1],"y_mm":[1]}}})";
  const std::string whole(kResult);
  return text_entry("class_member", {"app/class/member.cpp"}, {kResult, whole.substr(0, whole.rfind('}')) + more},
                    [](const std::string& text) -> std::string {
                      ClassPage page;
                      ClassRow r;
                      r.member = read_member(text, kNamed);
                      r.walk = walk_of(page.plan, r.member);
                      r.findings = findings_of(r.member, r.walk);
                      page.rows.push_back(std::move(r));
                      for (const ClassColumn& c : class_columns(page.rows))
                        if (c.value.size() != 1) return "a column without its value";
                      return test::xml_fault(class_html(page));
                    });
}

void add_room_entries(std::vector<Entry>& all) {
  all.push_back(text_entry("room", {"app/room/room_file.cpp"},
                           {"limberg_room = 1\ndate = \"2026-11-28\"\ndevices = [\"lcm\"]\ncalibrated = true\n"
                            "[[check]]\nstep = \"rest\"\nwhat = \"noise\"\nvalue = 0.2\nlimit = 1\nat_most = true\n"},
                           [](const std::string& text) -> std::string {
                             const std::string again = to_toml(parse_room(text, kNamed, "dir"));
                             return to_toml(parse_room(again, "written", "dir")) == again
                                        ? ""
                                        : "a room differs when it is written and read";
                           }));
  all.push_back(text_entry("room_hand", {"app/room/hands.cpp"},
                           {"limberg_hand = 1\nseed = 3\nglove = false\ncone_deg = [10, 50]\nlost = 0.1\n"},
                           [](const std::string& text) -> std::string {
                             const EmulatedHand h = parse_emulated_hand(text, kNamed);
                             return h.cone_deg.empty() || h.grabs.empty() ? "a figure without a value" : "";
                           }));
}

Entry comparison_entry(const Folder& folder) {
  return text_entry("comparison", {"app/report/compare.cpp", "app/report/report_data.cpp"}, {kResult},
                    [folder](const std::string& text) {
                      const std::string dir = (folder->path() / kNamed).string();
                      return test::xml_fault(comparison_html(text, dir, kResult, dir));
                    });
}

/// What replay takes from another result (--convergence) and writes into its own.
Entry convergence_entry(const Folder& folder) {
  return path_entry("convergence", folder, "other.json", {"app/result/result.cpp"}, {kResult},
                    [](const std::string& path) -> std::string {
                      Result r("replay", "small");
                      r.take("/convergence", path), r.take("/discretisation", path);
                      return test::xml_fault(report_html(r.text(), fs::path(path).parent_path().string()));
                    });
}

Entry member_entry(const Folder& folder) {
  const study::Family& family = study::find_family("disc");
  study::Values values;
  for (const study::Parameter& p : family.parameters) values.push_back(p.values.front());
  study::MemberResult m;
  m.row.figures = {{"a", 0.1}, {"none", std::nan("")}};
  m.row.title = "title", m.row.profile = {"curve", {1, 2}, {0.1, 4}, true}, m.seconds = 1, m.program = 7;
  study::MemberResult failed;
  failed.failure = "did not come to rest";
  return path_entry("member", folder, "member.json", {"app/study/member_file.cpp"},
                    {member_text(family, values, m), member_text(family, values, failed)},
                    [&family, values](const std::string& path) -> std::string {
                      const auto r = study::read_member(path, family, values);
                      if (!r) return "there is a file, and no member";
                      if (r->row.profile.x.size() != r->row.profile.y.size())
                        return "a curve without half of its places";
                      return std::isfinite(r->seconds) ? "" : "a time that is no number";
                    });
}

/// What a cluster is given to run, and what Slurm says of it.
void add_cluster_entries(std::vector<Entry>& all, const Folder& folder) {
  const study::Family& disc = study::find_family("disc");
  std::vector<study::Job> jobs;
  for (const study::Values& v : study::members(disc, {"along=1.1,1.2"})) jobs.push_back({&disc, v});
  all.push_back(path_entry("task", folder, "task", {"app/study/task_file.cpp"}, {study::task_text(jobs)},
                           [](const std::string& path) -> std::string {
                             for (const study::Job& job : study::read_task(path))
                               if (!job.family || job.values.size() != job.family->parameters.size())
                                 return "a member without all its values";
                             return "";
                           }));
  all.push_back(text_entry("ranges", {"app/study/ranges.cpp"}, {shipped("app/study/ranges/facial-skin.toml")},
                           [](const std::string& text) -> std::string {
                             const study::Family& family = study::find_family("tissue");
                             for (const study::Distribution& d : study::parse_ranges(text, kNamed, family).parameters)
                               if (!(d.quantile(0.2) <= d.quantile(0.8))) return "a distribution that falls";
                             return "";
                           }));
  all.push_back(
      text_entry("slurm", {"app/study/slurm_words.cpp"},
                 {"R|None\nPD|Resources\nPD|JobHeldAdmin\n", "MaxArraySize            = 1001\n", "12;cluster\n"},
                 [](const std::string& text) -> std::string {
                   const study::Queue q = study::read_queue(text);
                   if (q.running + q.waiting > text.size()) return "more tasks than lines";
                   if (study::read_job(text).find_first_not_of("0123456789") != std::string::npos)
                     return "a job without number";
                   return study::read_max_array(text) > 0 ? "" : "arrays of no size";
                 }));
}

Entry window_memory_entry(const Folder& folder) {
  return path_entry(
      "window_memory", folder, "window.toml", {"app/assembly/desk_memory.cpp"},
      {"toured = true\nletters_percent = 125\ncolours = \"light\"\n", "colours = \"dark\"\n"},
      [](const std::string& path) -> std::string {
        const DeskMemory m = read_desk_memory(path);
        return m.letters_percent >= 75 && m.letters_percent <= DeskMemory::kLargest_percent ? "" : "letters of no size";
      });
}

Entry words_entry() {
  return text_entry(
      "words", {"app/words/po_file.cpp"},
      {"msgid \"\"\nmsgstr \"\"\n\"Language: de\\n\"\n\"Plural-Forms: nplurals=2; plural=(n != 1);\\n\"\n\n"
       "msgctxt \"tool\"\nmsgid \"{:.1f} mm of {}\"\nmsgstr \"von {1} {0:.1f} mm\"\n\n#, fuzzy\nmsgid \"{} act\"\n"
       "msgid_plural \"{} acts\"\nmsgstr[0] \"{} Tat\"\nmsgstr[1] \"{} Taten\"\n",
       "msgid \"{} and {}\"\nmsgstr \"{} und {}\"\n"},
      [](const std::string& text) -> std::string {
        std::vector<WordsFault> faults;
        const PoFile po = parse_po(text, kNamed);
        const Words w(std::make_shared<WordTable>(table_of(po, nullptr, faults)));
        for (const PoEntry& e : po.entries) w(e.english.c_str()), w.said(e.english), w.said(text);
        return w.language().empty() ? "a table of no language" : "";
      });
}

Entry trials_entry() {
  bench::AccuracyTrial t;
  t.cell_mm = 3.5, t.iterations = 8, t.nodes = 100, t.frame_ms = 1.25;
  return text_entry("trials", {"app/operating_point/kept_trials.cpp"},
                    {"sweep\n" + kept_line(t) + kept_line(t) + "4\thexa"}, [](const std::string& text) -> std::string {
                      std::string again = "sweep\n";
                      for (const bench::AccuracyTrial& k : bench::parse_kept_trials(text, "sweep")) {
                        if (!(k.cell_mm > 0) || !std::isfinite(k.error_mm)) return "a trial without sense";
                        again += kept_line(k);
                      }
                      // What is no sweep, or no trial, is left out; never refused.
                      if (again == "sweep\n" && !text.starts_with("sweep\n"))
                        throw InputError(kNamed, 0, "holds no sweep");
                      return "";
                    });
}

/// Of a peer: history, scene, deep points and model, by themselves and as what becomes of them.
void add_peer_entries(std::vector<Entry>& all) {
  static const test::PeerFixture fixture;
  static const PeerModel model = fixture.model();
  using F = test::PeerFixture;
  const std::string sound = F::history(
      {F::incision({{10, 14}, {22, 14}, {22, 26}, {10, 26}}, false, true), F::excise(16, 20),
       F::incision({{23, 20}, {34, 20}}, true), F::undermine({{23, 16}, {38, 16}, {38, 30}}, true, true),
       F::deep_cut({{50, 10}, {50, 30}}, true, true), F::hook(0, F::place(30, 22)), R"({"moveHook":[0,3,2.5,2]})",
       F::suture(0, F::place(24, 20.4, Vec3::Zero(), 2, "0"), F::place(24, 19.6, Vec3::Zero(), 2, "1"), true)});
  const std::vector<std::string> reads{"app/import/import.cpp"};
  all.push_back(text_entry("peer_history", reads, {sound}, [](const std::string& text) -> std::string {
    std::string script = "{\"limberg_script\":1,\"scene\":\"slab\"}\n";
    for (const std::string& l : carry(parse_peer_history(text, kNamed), model, {}).script) script += l + "\n";
    parse_script(script, "carried");  // a refusal of it is taken for one of the history: see test_carried_acts
    return "";
  }));
  all.push_back(text_entry("peer_scene", reads, {F::scene()}, [](const std::string& text) -> std::string {
    return parse_peer_scene(text, kNamed).object.empty() ? "a scene without tissue" : "";
  }));
  all.push_back(text_entry("peer_bed", reads, {fixture.bed.substr(0, fixture.bed.rfind('\n', 400) + 1)},
                           [](const std::string& text) -> std::string {
                             const PeerBed bed = parse_peer_bed(text, kNamed);
                             return bed.vertex.size() == bed.deep.size() ? "" : "a vertex without its deep point";
                           }));
  all.push_back(text_entry("peer_model", reads, {fixture.obj}, [](const std::string& text) -> std::string {
    const PeerModel m = parse_peer_model(text, kNamed, parse_peer_scene(F::scene(), "s"), nullptr, "", 10);
    return m.material.size() == m.mesh.tri.size() ? "" : "a triangle without material";
  }));
}

}  // namespace

std::vector<Entry> text_entries(const Folder& folder) {
  const auto laws = shipped_laws();
  std::vector<Entry> all;
  add_peer_entries(all);
  all.push_back(text_entry("thickness", {"sim/body/thickness.cpp"}, {"# a face\n1 2 3 1.5\n-4, 5.5, 6, 2 # chin\n"},
                           [](const std::string& text) -> std::string {
                             for (const PlaceThickness& t : parse_thickness(text, kNamed))
                               if (!t.at_mm.allFinite() || !(t.thickness_mm > 0)) return "a place without thickness";
                             return "";
                           }));
  all.push_back(text_entry("tension_lines", {"sim/body/tension_lines.cpp"},
                           {"# a face\n1 2 3 0 0 1\n-4, 5.5, 6, 1, -1, 0 # chin\n"},
                           [](const std::string& text) -> std::string {
                             for (const TensionPlace& t : parse_tension_lines(text, kNamed))
                               if (!t.at_mm.allFinite() || !(std::abs(t.along.norm() - 1) < 1e-9))
                                 return "a place whose lines run nowhere";
                             return "";
                           }));
  all.push_back(text_entry("tissues", {"app/scene/tissues.cpp"}, {shipped("app/scene/tissues.toml")},
                           [laws](const std::string& text) -> std::string {
                             for (const NamedTissue& t : parse_tissues(text, kNamed, *laws).tissues)
                               if (!std::isfinite(t.material.young_kPa) || t.source.empty())
                                 return "a tissue without sense";
                             return "";
                           }));
  all.push_back(text_entry("lesson", {"app/assembly/lesson.cpp"},
                           {shipped("app/lessons/rhomboid.toml"), shipped("app/lessons/zplasty.toml")},
                           [](const std::string& text) -> std::string {
                             return parse_lesson(text, kNamed).tolerances.empty() ? "a lesson that asks nothing" : "";
                           }));
  all.push_back(script_entry());
  all.push_back(calibration_entry());
  all.push_back(repro_entry());
  all.push_back(operating_point_entry(folder));
  all.push_back(window_memory_entry(folder));
  all.push_back(model_entry());
  all.push_back(result_entry(folder));
  all.push_back(comparison_entry(folder));
  all.push_back(class_entry());
  add_room_entries(all);
  all.push_back(convergence_entry(folder));
  all.push_back(member_entry(folder));
  add_cluster_entries(all, folder);
  all.push_back(trials_entry());
  all.push_back(words_entry());
  all.push_back(text_entry("points", {"calibration/points_file.cpp", "app/commands/calibrate.cpp"},
                           {"# touched\n0 0 1\n1,2;3 # corner\n\n-4e1 5 6\n"},
                           [](const std::string& text) -> std::string {
                             for (const Vec3& p : parse_points(text, kNamed))
                               if (!p.allFinite()) return "a place that is none";
                             return "";
                           }));
  all.push_back(text_entry("landmark_pairs", {"sim/imaging/register/landmark_pairs.cpp", "app/commands/superpose.cpp"},
                           {"# a b\nnasion 0 0 1 2 3 4\nmenton 1 2 3 -4 5e0 6\n"},
                           [](const std::string& text) -> std::string {
                             const LandmarkPairs p = parse_landmark_pairs(text, kNamed);
                             return p.a_mm.size() == p.b_mm.size() ? "" : "a pair of one";
                           }));
  all.push_back(text_entry("operated", {"app/export/operated.cpp", "app/commands/export.cpp"},
                           {R"({"command":"operate","scene_path":"a.toml","lattice":{"cell_mm":5},)"
                            R"("script":["{\"action\":\"stage\",\"name\":\"before\"}"]})"},
                           [](const std::string& text) -> std::string {
                             return operated_call(text, kNamed).script.lines.empty() ? "a script of nothing" : "";
                           }));
  all.push_back(path_entry("plan", folder, "plan.json", {"app/export/achieved.cpp"},
                           {R"({"frames":{"files":"head"},"fragments":[{"name":"skull","fixed":true,)"
                            R"("centre_moved_mm":[0,0,0],"turned_deg":0,"files":["skull.obj"]}]})"},
                           [](const std::string& path) -> std::string {
                             for (const PlannedFragment& f : read_plan(fs::path(path).parent_path().string()))
                               if (!f.planned_mm.allFinite()) return "a move that is none";
                             return "";
                           }));
  write_file((folder->path() / "plan" / "skull.obj").string(), "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n");
  all.push_back(text_entry("kept_landmarks", {"app/head/cache.cpp"}, {"nasion 0 0.25 1\nmenton 1 -2e1 3\n"},
                           [](const std::string& text) -> std::string {
                             const auto all_of = parse_kept_landmarks(text);
                             if (!all_of) throw InputError(kNamed, 0, "is no list of landmarks");
                             for (const auto& [name, at] : *all_of)
                               if (name.empty() || !at.allFinite()) return "a landmark that is none";
                             return "";
                           }));
  all.push_back(text_entry(
      "shown", {"app/program/shown.cpp"}, {"a name\tof\nlines \xC3\xA4"}, [](const std::string& text) -> std::string {
        const std::string s = shown(text);
        for (size_t i = 0; i < s.size(); ++i) {
          const auto c = uint8_t(s[i]);
          if ((c < ' ' && c != '\n' && c != '\t') || c == 127) return "a command for a terminal";
          if (c == 0xC2 && i + 1 < s.size() && uint8_t(s[i + 1]) >= 0x80 && uint8_t(s[i + 1]) < 0xA0)
            return "a command of two bytes for a terminal";
        }
        if (shown(s) != s) return "what is shown changes when it is shown again";
        if (s != text) throw InputError(kNamed, 0, "held commands for a terminal");
        return "";
      }));
  return all;
}

}  // namespace limberg::fuzz
