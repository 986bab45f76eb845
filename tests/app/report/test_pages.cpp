// Pages are made of Markup: whatever a result holds, its text stays text, and every page has the one skeleton.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/program/places.h"
#include "app/report/compare.h"
#include "app/report/elements.h"
#include "app/report/report.h"
#include "app/report/sections.h"
#include "render/image.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_pages {

using Json = nlohmann::ordered_json;
using html::Markup;
using test::xml_fault;

// A result in which every field that a page shows has a value.
const char* const kEverything = R"({
"limberg": {"version": "v", "commit": "c"}, "command": "study", "scene": "s", "scene_title": "t", "scene_note": "n",
"machine": {"cpu": "p", "cores": 2}, "ok": true, "mode": "m", "duration_s": 60.5, "state_hash": "h", "parts": ["a", "b"],
"memory_mb": 300, "reproduce": "r", "damage": {"missing": "d"}, "study": "u", "about": "a", "columns": ["x", "y"],
"uncertainty": {"ranges": "an", "note": "ao", "sample": "sobol", "base": 8, "seed": 1, "points": 64,
  "sampled": [{"parameter": "ap", "distribution": "aq", "source": "ar"}],
  "cases": [{"setting": "as", "figures": [{"figure": "at", "low": 1.2, "median": 1.9, "high": 3.1, "members": 16,
    "shares": [{"parameter": "au", "first": 0.5, "first_low": 0.4, "first_high": 0.6, "total": 0.7}]}]}]},
"rows": [{"x": 1, "y": 2}], "bars": [{"name": "b", "value": 1, "bar": 2, "pass": true, "source": "q"}],
"device": {"ticks": 60500, "late_ticks": 3, "events_lost": 0, "wake_us": {"p50": 20, "p99": 80, "max": 5000}},
"solver": {"steps": 3630, "residual": 3.2e-5, "distance_mm": 0.0123}, "render": {"frames": 900}, "solve_ms": 4,
"lattice": {"cells": 7},
"metrics": {"closure_force_N": 7.25, "volume_mm3": 900, "undermined_mm2": 4, "own_figure": 3,
  "sutures": [{"id": 1, "force_N": 2.75, "gap_mm": 0.12}],
  "predicted": [{"x_mm": 1, "y_mm": 2, "charge_deg": 3}], "landmarks": [{"name": "l", "displacement_mm": 1}]},
"stages": [{"name": "one", "caption": "two", "t_s": 1, "picture": "p.png"}],
"gallery": [{"picture": "p.png", "caption": "an"}],
"series": {"t_s": [0, 1, 2], "residual": [0.1, 0.01, 1e-3], "closure_N": [0, 1, 2]},
"balance": {"hooks_N": [0.1, 0, 0]}, "convergence": [{"cell_mm": 5, "closure_force_N": 6.5}],
"discretisation": {"closure_force_N": {"value": 7.25, "error": 0.3, "asymptotic": true, "says": "e"}},
"charts": [{"title": "f", "description": "g", "x": "i", "y": "j", "y_marks": [{"value": 1, "label": "k"}],
  "series": [{"name": "o", "x": [1, 2], "y": [0.5, 2]}, {"name": "w", "x": [1, 2], "y": [1, 2]}]}],
"tables": [{"title": "z", "about": "ab", "columns": ["ac"], "rows": [["ad"]]}],
"exercise": {"cuts": 3}, "lesson": {"title": "ae", "goal": "af", "hints": ["ag"],
  "tolerances": [{"name": "ah", "unit": "ai", "limit": 1, "value": 2, "met": false},
                 {"name": "aj", "unit": "ak", "limit": 1, "met": false, "why": "al"}]},
"script": ["am"]
})";

// Every text below `j` gets a tag of its own, and every name that the format leaves open.
void poison(Json& j, int& n) {
  const auto bad = [&] { return "<i class=\"x" + std::to_string(n++) + "x\">'&amp;"; };
  if (j.is_string()) j = bad();
  if (j.is_structured())
    for (auto& [name, child] : j.items())
      if (name != "picture") poison(child, n);
}
void poison_names(Json& j, int& n) {
  Json out = Json::object();
  for (const auto& [name, value] : j.items())
    out[value.is_array() ? name : "<i class=\"x" + std::to_string(n++) + "x\">'&amp;"] = value;
  j = out;
}

TEST(Pages, EveryTextOfAResultStaysText) {
  const std::filesystem::path folder = std::filesystem::path(binary_dir()) / "test_pages_files";
  std::filesystem::create_directories(folder);
  write_png(folder / "p.png", Image(8, 6, {200, 150, 140}));  // its caption is an attribute too
  Json j = Json::parse(kEverything);
  int n = 0;
  for (auto& [name, value] : j.items())
    if (name != "command" && name != "columns" && name != "study") poison(value, n);
  for (const char* open : {"damage", "lattice", "metrics", "exercise", "discretisation"}) poison_names(j[open], n);
  Json study_row = Json::object();
  for (Json& column : j["columns"]) poison(column, n), study_row[column.get<std::string>()] = 1;
  j["rows"] = Json::array({study_row});
  ASSERT_GT(n, 45);

  Json other = j;  // a comparison shows both, and the lines of both scripts
  other["command"] = "replay", other["script"] = {"<i class=\"other\">"};
  const std::string study = report_html(j.dump(), folder.string()),
                    session = report_html(other.dump(), folder.string()),
                    compared = comparison_html(j.dump(), "<i class=\"dir\">", other.dump(), "nowhere");
  for (const std::string& page : {study, session, compared}) {
    EXPECT_EQ(xml_fault(page), "");
    EXPECT_EQ(page.find("<i "), std::string::npos) << page.substr(page.find("<i "), 80);
  }
  EXPECT_NE(compared.find("&lt;i class=&quot;dir&quot;&gt;"), std::string::npos);
  EXPECT_NE(compared.find("&lt;i class=&quot;other&quot;&gt;"), std::string::npos);
  // Each is shown somewhere, as it was written.
  std::string missing;
  for (int k = 0; k < n; ++k) {
    const std::string shown = "&lt;i class=&quot;x" + std::to_string(k) + "x&quot;&gt;&#39;&amp;amp;";
    if ((study + session + compared).find(shown) == std::string::npos) missing += std::to_string(k) + " ";
  }
  EXPECT_EQ(missing, "");
}

TEST(Pages, SayBetweenWhatAFigureLies) {
  Json j = Json::parse(kEverything);
  Json& band = j["uncertainty"]["cases"][0]["figures"][0];
  band["figure"] = "closure_force_N", j["uncertainty"]["ranges"] = "facial skin";
  const auto page = [&] { return report_html(j.dump(), "nowhere"); };
  EXPECT_NE(page().find("1.9\u202fN"), std::string::npos);
  EXPECT_NE(page().find("1.2 to 3.1 for facial skin"), std::string::npos);
  EXPECT_NE(page().find("Closure force: what makes it differ"), std::string::npos);
  band.erase("shares");
  EXPECT_EQ(page().find("what makes it differ"), std::string::npos);
  EXPECT_EQ(page().find("bootstrap"), std::string::npos);
  band.erase("median");  // no member was done
  EXPECT_EQ(page().find("for facial skin"), std::string::npos);
  EXPECT_EQ(xml_fault(page()), "");
}

TEST(Pages, LeaveTheRowsOfALargeStudyToItsTable) {
  Json j = Json::parse(kEverything);
  for (int i = 0; i < 300; ++i) j["rows"].push_back({{"x", 1000 + i}, {"y", 2}});
  const std::string page = report_html(j.dump(), "nowhere");
  EXPECT_NE(page.find("1198"), std::string::npos);
  EXPECT_EQ(page.find("1250"), std::string::npos);
  EXPECT_NE(page.find("200 of 301 members"), std::string::npos);
}

TEST(Pages, HaveOneSkeleton) {
  const auto skeleton = [](const std::string& page) {
    return page.substr(0, page.find("<title>")) +
           page.substr(page.find("<style>"), page.find("<h1>") - page.find("<style>"));
  };
  const std::string report = report_html(kEverything, "nowhere"), compared = comparison_html("{}", "a", "{}", "b");
  EXPECT_EQ(skeleton(report), skeleton(compared));
  EXPECT_NE(report.find("default-src 'none'"), std::string::npos);
  for (const std::string& page : {report, compared})
    for (const char* part : {"<header>", "<main>", "<footer>"}) EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(Pages, SectionsStandInTheOrderOfTheirTable) {
  const std::string page = report_html(kEverything, "nowhere");
  size_t at = 0;
  for (const char* title :
       {"How sure it is", "What it came to", "The members, each at rest", "Sutures", "The closure", "Lesson: ae",
        "Does it add up?", "Finer cells", "Three lanes", "How close", "All figures", "The script", "Make it again"}) {
    const size_t here = page.find("<h2>" + std::string(title), at);
    ASSERT_NE(here, std::string::npos) << title;
    at = here;
  }
}

TEST(Elements, HoldTextAndLeaveOutWhatIsEmpty) {
  const Markup text = "a < b & \"c\"";
  EXPECT_EQ(text.tags(), "a &lt; b &amp; &quot;c&quot;");
  EXPECT_EQ((html::bold("x", html::Light::bad) + " & y").tags(), "<b class=\"bad\">x</b> &amp; y");
  EXPECT_EQ(html::figure("u\"", "a\"", "c").tags(),
            "<figure><img src=\"u&quot;\" alt=\"a&quot;\"/><figcaption>c</figcaption></figure>\n");
  EXPECT_EQ(html::figure("", "a", "c").tags(), "<figure><figcaption>c</figcaption></figure>\n");
  EXPECT_TRUE(html::section("title", {}).empty());
  EXPECT_TRUE(html::cards({}).empty());
  const std::string table = html::table({"h<"}, {{{"1 < 2", html::Light::warn}},
                                                 {html::meter(0.256, html::Light::good)},
                                                 {html::meter({}, html::Light::none)}})
                                .tags();
  EXPECT_EQ(xml_fault(table), "");
  EXPECT_NE(table.find("<th>h&lt;</th>"), std::string::npos) << table;
  EXPECT_NE(table.find("<td class=\"warn\">1 &lt; 2</td>"), std::string::npos) << table;
  EXPECT_NE(table.find("<td class=\"bar good\"><span class=\"meter\" style=\"width:26%\"></span></td>"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("<td class=\"bar\"></td>"), std::string::npos) << table;
  EXPECT_EQ(html::table({}, {{"1"}}).tags().find("thead"), std::string::npos);
}

}  // namespace test_pages
}  // namespace limberg
