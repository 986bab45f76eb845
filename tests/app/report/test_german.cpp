// A page in German: nothing in it that the table knows in English, numbers with their comma, and the result itself as
// it was.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/program/places.h"
#include "app/report/compare.h"
#include "app/report/report.h"
#include "app/words/chosen_words.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_german {

const char* const kResult = R"({
"limberg": {"version": "0.1.0", "commit": "abc1234"}, "command": "replay", "scene": "rhomboid", "ok": true,
"scene_note": "Two-layer block: 1.5 mm of skin under tension over 8.5 mm of fat, held at its sides and its base.",
"machine": {"cpu": "Some CPU", "cores": 2}, "mode": "lockstep", "duration_s": 60.5, "state_hash": "00ff00ff00ff00ff",
"parts": ["cutter"], "memory_mb": 300, "reproduce": "limberg replay recordings/rhomboid.lcm --lockstep", "interrupted": true,
"device": {"ticks": 60500, "late_ticks": 3, "events_lost": 0, "wake_us": {"p50": 20, "p99": 80, "p999": 300, "max": 5000}},
"solver": {"steps": 3630, "step_ms": {"p50": 8.5, "p95": 10, "p99": 12, "max": 40}, "residual": 3.2e-5, "distance_mm": 0.0123},
"render": {"frames": 900, "frame_ms": {"p50": 20, "p95": 28, "p99": 35, "max": 70}},
"metrics": {"pieces": 1, "volume_mm3": 900, "removed_volume_mm3": 100, "initial_volume_mm3": 1000, "closure_force_N": 7.25,
            "suture_force_max_N": 2.75, "suture_gap_max_mm": 0.12, "dog_ear_mm": 1.9, "undermined_mm2": 210.5,
            "sutures": [{"id": 1, "force_N": 2.75, "gap_mm": 0.12}, {"id": 2, "force_N": 0.4, "gap_mm": 0.01}]},
"verdict": [{"what": "wound gape, widest", "value": 2.5, "unit": "mm", "limit": 2, "place": "(3.4, -18.1) mm", "light": "bad",
             "source": "Hollander et al. 1995: wound margin separation above 2 mm is a fault of a closure"},
            {"what": "closed along its whole edge", "value": 91.5, "unit": "mm", "place": "gapes by at most 1.1 mm", "light": "good"},
            {"what": "largest force of a stitch", "value": 2.75, "unit": "N", "limit": 5, "place": "stitch 4", "light": "warn"}],
"stages": [{"name": "defect", "t_s": 10}, {"name": "closed", "t_s": 50, "sutures": 2, "residual": 3.2e-5}],
"series": {"t_s": [0, 1, 2, 3], "residual": [0.1, null, 1e-3, 3.2e-5], "distance_mm": [1, 0.5, 0.2, 0.1]},
"balance": {"hooks_N": [0.1, 0, 0], "supports_N": [-0.1, 0.001, 0], "sum_N": [0, 0.001, 0], "relative": 0.005},
"convergence": [{"cell_mm": 5, "closure_force_N": 6.5, "dog_ear_mm": 1.6}, {"cell_mm": 3.5, "closure_force_N": 7.25, "dog_ear_mm": 1.9}],
"exercise": {"time_s": 61.5, "path_mm": 1465, "movements": 58, "undos": 1},
"lesson": {"title": "Limberg's rhomboid flap", "goal": "Close a rhombic defect with 20 mm sides by a flap whose donor site closes across the tension lines, flat and without strong pull.",
  "tolerances": [{"name": "corner_mm", "unit": "mm", "limit": 2, "value": 1.25, "met": true},
                 {"name": "closure_N", "unit": "N", "limit": 15, "met": false, "why": "stitches were looked for at the end; there is none"}],
  "hints": ["Undermine widely before you lift the flap."]},
"script": ["{\"action\":\"excise\",\"outline\":[[0,0],[20,0],[20,10],[0,10]],\"depth_mm\":4.5}", "{\"action\":\"stage\",\"name\":\"defect\"}",
           "{\"action\":\"hook\",\"id\":1,\"at\":[1,1]}", "{\"action\":\"hook\",\"id\":2,\"at\":[3,1]}",
           "{\"action\":\"suture\",\"a\":[0,-0.7],\"b\":[0,0.7]}", "{\"action\":\"stage\",\"name\":\"closed\"}"]
})";

/// The words of a page: what stands between tags, and what pictures and figures say of themselves.
std::string words_in(std::string page) {
  for (const char* name : {"script", "style", "pre", "code", "footer"}) {
    const std::string open = std::string("<") + name, close = std::string("</") + name + ">";
    for (size_t at = 0; (at = page.find(open, at)) != page.npos;) page.erase(at, page.find(close, at) - at);
  }
  std::string words;
  for (size_t at = 0; at < page.size();) {
    const size_t tag = page.find('<', at);
    words += page.substr(at, tag - at) + "\n";
    if (tag == page.npos) break;
    const size_t end = page.find('>', tag);
    for (const char* name : {"alt=\"", "title=\"", "aria-label=\""})
      if (const size_t a = page.find(name, tag); a < end) {
        const size_t from = a + std::string(name).size();
        words += page.substr(from, page.find('"', from) - from) + "\n";
      }
    at = end + 1;
  }
  return words;
}

/// Entries of the table that stand in the words in English.
std::string left_in_english(const std::string& words) {
  std::string all;
  for (const PoEntry& e : known_texts().entries) {
    // What is the same in both, and short words that are part of others, say nothing.
    const size_t place = e.english.find('{');
    const std::string begins = e.english.substr(0, place);
    if (std::count(begins.begin(), begins.end(), ' ') < 1 || begins.size() < 10) continue;
    if (words.find(begins) != words.npos) all += begins + "\n";
  }
  return all;
}

Words german() { return chosen_words({"de", ""}); }

TEST(German, NoTextOfAReportIsLeftInEnglish) {
  const std::string page = report_html(kResult, "nowhere", german()), words = words_in(page);
  EXPECT_EQ(test::xml_fault(page), "");
  EXPECT_NE(page.find("lang=\"de\""), std::string::npos);
  EXPECT_EQ(left_in_english(words), "");
  for (const char* said :
       {"Klaffen der Wunde, weiteste Stelle", "Exzision von 200\u202fmm², 4,5\u202fmm tief.", "2 Haken gesetzt",
        "Eine Haltenaht", "Auf ganzer Länge geschlossen (klafft höchstens 1,1\u202fmm) mit 2 Nähten", "7,25\u202fN",
        "Lektion: Limbergs Rhomboidlappen", "am Ende wurden Nähte gesucht; es gibt keine", "Naht 4", "(3,4; -18,1) mm",
        "Exzision und Nähte", "60,5\u202fs", "letzte durchlaufene Abschnitt ist „geschlossen“"})
    EXPECT_NE(words.find(said), std::string::npos) << said;
  for (const char* kept : {"limberg replay recordings/rhomboid.lcm --lockstep", "closure_force_N", "limberg 0.1.0"})
    EXPECT_NE(page.find(kept), std::string::npos) << kept;
}

TEST(German, NoTextOfAComparisonIsLeftInEnglish) {
  std::string other = kResult;
  other.replace(other.find("\"closure_force_N\": 7.25"), 23, "\"closure_force_N\": 9.5 ");
  const std::string page = comparison_html(kResult, "a", other, "b", german());
  EXPECT_EQ(test::xml_fault(page), "");
  EXPECT_EQ(left_in_english(words_in(page)), "");
  EXPECT_NE(page.find("Die Nähte zusammen ziehen mit 7,25\u202fN in A und 9,5\u202fN in B, 31\u202f% mehr"),
            std::string::npos);
}

TEST(German, AnEnglishPageIsFoundOut) {
  const std::string page = report_html(kResult, "nowhere");
  const std::string left = left_in_english(words_in(page));
  EXPECT_GT(std::count(left.begin(), left.end(), '\n'), 40) << "the looking itself sees English";
  EXPECT_NE(page.find("lang=\"en\""), std::string::npos);
  EXPECT_NE(page.find("7.25\u202fN"), std::string::npos);
}

}  // namespace test_german
}  // namespace limberg
