#include "app/study/study_result.h"

#include <filesystem>

#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/schema.h"
#include "app/result/tables.h"

namespace limberg::study {

std::vector<Bar> bars_of(const std::vector<Gathered>& parts) {
  std::vector<Bar> out;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].rows.empty()) continue;
    for (Bar b : parts[i].family->bars(parts[i].rows)) {
      if (i) b.name = parts[i].family->name + ": " + b.name;
      out.push_back(std::move(b));
    }
  }
  return out;
}

Result result_of(const std::vector<Gathered>& parts, const std::vector<Bar>& bars) {
  const Gathered& g = parts[0];
  Result r("study", "");
  r.set("/study", g.family->name);
  r.set("/about", g.family->about);
  r.set_empty_list("/rows");
  r.set_empty_list("/bars");
  size_t members = 0, done = 0, failures = 0;
  for (const Gathered& p : parts) {
    members += p.members.size(), done += p.rows.size();
    for (const auto& [name, why] : p.failed) {
      r.set("/failed/" + std::to_string(failures) + "/member", name);
      r.set("/failed/" + std::to_string(failures++) + "/why", why);
    }
  }
  r.set("/members", uint64_t(members));
  r.set("/complete", done == members);
  bool ok = done == members;
  int n = 0;
  if (!g.rows.empty())
    for (const auto& [name, v] : g.rows[0].figures) r.set("/columns/" + std::to_string(n++), name);
  for (size_t i = 0; i < g.rows.size(); ++i)
    for (const auto& [name, v] : g.rows[i].figures) r.set("/rows/" + std::to_string(i) + "/" + name, v);
  for (size_t i = 0; i < g.rows.size(); ++i)
    if (const std::string& title = g.rows[i].title; !title.empty())
      append(r, "/stages", ResultStage{title, report_names::stage_picture(int(i) + 1, title), {}, {}, {}, {}, {}});
  for (size_t i = 0; i < bars.size(); ++i) {
    const Bar& b = bars[i];
    append(r, "/bars", ResultBar{b.name, b.source, b.value, b.bar, false, b.larger_is_better, b.pass});
    ok &= bars[i].pass;
  }
  for (const Gathered& part : parts) {
    if (part.rows.empty()) continue;
    for (const NamedChart& c : part.family->charts(part.rows))
      add_chart(r, (&part == &g ? "" : part.family->name + ": ") + c.title, c.chart);
  }
  r.set_ok(ok);
  return r;
}

void leave_files(const std::vector<Gathered>& parts, const std::string& dir) {
  for (const Gathered& p : parts) {
    if (p.rows.empty()) continue;
    const std::string prefix = &p == &parts[0] ? "" : p.family->name;
    write_whole_file(dir + "/" + (prefix.empty() ? "rows" : prefix) + ".csv", csv(p.rows));
    for (const NamedChart& c : p.family->charts(p.rows))
      write_whole_file(dir + "/" + (prefix.empty() ? "" : prefix + "-") + c.name + ".svg", svg(c.chart));
  }
}

void leave_pictures(const Gathered& part, const std::vector<std::string>& picture_of_row, const std::string& dir) {
  namespace fs = std::filesystem;
  std::error_code ec;
  fs::remove_all(dir + "/" + report_names::stages_dir, ec);  // numbered anew
  for (size_t i = 0; i < part.rows.size(); ++i) {
    if (part.rows[i].title.empty() || !fs::is_regular_file(picture_of_row[i], ec)) continue;
    prepare_folder(dir + "/" + report_names::stages_dir);
    write_whole_file(dir + "/" + report_names::stage_picture(int(i) + 1, part.rows[i].title),
                     read_whole_file(picture_of_row[i]));
  }
}

}  // namespace limberg::study
