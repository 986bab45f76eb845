#include "app/study/study_result.h"

#include <filesystem>

#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/schema.h"
#include "app/result/tables.h"

namespace limberg::study {

namespace {

/// failed
struct ResultFailedMember {
  MaybeText member, why;
};
void fields(ResultFailedMember& x, auto&& f) { f("member", x.member), f("why", x.why); }

/// Beside rows and bars.
struct ResultStudy {
  MaybeText study, about;
  MaybeList<ResultFailedMember> failed;
  int64_t members;
  bool complete;
  MaybeList<std::string> columns;
};
void fields(ResultStudy& x, auto&& f) {
  f("study", x.study), f("about", x.about), f("failed", x.failed), f("members", x.members);
  f("complete", x.complete), f("columns", x.columns);
}

}  // namespace

namespace {

std::vector<NamedChart> charts_of(const Gathered& part, const std::optional<SampledStudy>& sampled) {
  return sampled ? spread_charts(*sampled, *part.family, part.rows, part.row_of) : part.family->charts(part.rows);
}

}  // namespace

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

Result result_of(const std::vector<Gathered>& parts, const std::vector<Bar>& bars,
                 const std::optional<SampledStudy>& sampled) {
  const Gathered& g = parts[0];
  Result r("study", "");
  size_t members = 0, done = 0;
  std::vector<ResultFailedMember> failed;
  for (const Gathered& p : parts) {
    members += p.members.size(), done += p.rows.size();
    for (const auto& [name, why] : p.failed) failed.push_back({name, why});
  }
  bool ok = done == members;
  std::vector<std::string> columns;
  if (!g.rows.empty())
    for (const auto& [name, v] : g.rows[0].figures) columns.push_back(name);
  write_fields(r, "",
               ResultStudy{g.family->name, g.family->about, unless_empty(std::move(failed)), int64_t(members), ok,
                           unless_empty(std::move(columns))});
  r.set_empty_list("/rows");
  for (size_t i = 0; i < g.rows.size(); ++i)  // each family names its own figures
    for (const auto& [name, v] : g.rows[i].figures) r.set("/rows/" + std::to_string(i) + "/" + name, v);
  for (size_t i = 0; i < g.rows.size(); ++i)
    if (const std::string& title = g.rows[i].title; !title.empty()) {
      ResultStage stage;
      stage.name = title, stage.picture = report_names::stage_picture(int(i) + 1, title);
      append(r, "/stages", stage);
    }
  if (sampled) write_fields(r, "/uncertainty", uncertainty_of(*sampled, *g.family, g.rows, g.row_of));
  r.set_empty_list("/bars");
  for (const Bar& b : bars) {
    append(r, "/bars", b);
    ok &= b.pass;
  }
  for (const Gathered& part : parts) {
    if (part.rows.empty()) continue;
    for (const NamedChart& c : charts_of(part, sampled))
      add_chart(r, (&part == &g ? "" : part.family->name + ": ") + c.title, c.chart);
  }
  r.set_ok(ok);
  return r;
}

void leave_files(const std::vector<Gathered>& parts, const std::string& dir,
                 const std::optional<SampledStudy>& sampled) {
  for (const Gathered& p : parts) {
    if (p.rows.empty()) continue;
    const std::string prefix = &p == &parts[0] ? "" : p.family->name;
    write_whole_file(dir + "/" + (prefix.empty() ? "rows" : prefix) + ".csv", csv(p.rows));
    for (const NamedChart& c : charts_of(p, sampled))
      write_whole_file(dir + "/" + (prefix.empty() ? "" : prefix + "-") + c.name + ".svg",
                       in_plain_colours(svg(c.chart)));
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
