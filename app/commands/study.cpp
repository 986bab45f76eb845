#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/commands/session_command.h"
#include "app/interrupt.h"
#include "app/output.h"
#include "app/pictures.h"
#include "app/progress.h"
#include "app/report/report_names.h"
#include "app/session/workers_pool.h"
#include "app/study/study.h"
#include "sim/error.h"

namespace limberg {

namespace {

struct Options {
  std::string name;
  std::vector<std::string> settings;
  CommonOptions common;
};

std::string plain(double v) {
  char t[40];
  std::snprintf(t, sizeof t, "%.6g", v);
  return t;
}

Result result_of(const study::Family& f, const std::vector<study::Row>& rows, size_t members) {
  Result r("study", "");
  r.set("/study", f.name);
  r.set("/about", f.about);
  r.set("/members", uint64_t(members));
  r.set("/complete", rows.size() == members);
  r.set_empty_list("/rows");
  r.set_empty_list("/bars");
  if (rows.empty()) return r;
  int n = 0;
  for (const auto& [name, v] : rows[0].figures) r.set("/columns/" + std::to_string(n++), name);
  for (size_t i = 0; i < rows.size(); ++i)
    for (const auto& [name, v] : rows[i].figures) r.set("/rows/" + std::to_string(i) + "/" + name, v);
  for (size_t i = 0; i < rows.size(); ++i)
    if (!rows[i].title.empty()) {
      const std::string p = "/stages/" + std::to_string(i);
      r.set(p + "/name", rows[i].title);
      r.set(p + "/picture", report_names::stage_picture(int(i) + 1, rows[i].title));
    }
  const auto bars = f.bars(rows);
  bool ok = rows.size() == members;
  for (size_t i = 0; i < bars.size(); ++i) {
    const std::string p = "/bars/" + std::to_string(i);
    r.set(p + "/name", bars[i].name);
    r.set(p + "/value", bars[i].value);
    r.set(p + "/bar", bars[i].bar);
    r.set(p + "/larger_is_better", bars[i].larger_is_better);
    r.set(p + "/pass", bars[i].pass);
    r.set(p + "/source", bars[i].source);
    ok &= bars[i].pass;
  }
  const auto charts = f.charts(rows);
  for (size_t i = 0; i < charts.size(); ++i) {
    const std::string p = "/charts/" + std::to_string(i);
    r.set(p + "/title", charts[i].title);
    r.set(p + "/description", charts[i].chart.description);
    r.set(p + "/x", charts[i].chart.x.title);
    r.set(p + "/y", charts[i].chart.y.title);
    for (size_t k = 0; k < charts[i].chart.series.size(); ++k) {
      const ChartSeries& s = charts[i].chart.series[k];
      const std::string q = p + "/series/" + std::to_string(k);
      const std::vector<float> x(s.x.begin(), s.x.end()), y(s.y.begin(), s.y.end());
      r.set(q + "/name", s.name);
      r.set(q + "/markers", s.markers);
      r.set(q + "/x", std::span<const float>(x));
      r.set(q + "/y", std::span<const float>(y));
    }
  }
  r.set_ok(ok);
  return r;
}

/// Everything of the rows so far, each file whole or not at all.
void leave_files(const study::Family& f, const std::vector<study::Row>& rows, const std::string& dir) {
  write_whole_file(dir + "/rows.csv", study::csv(rows));
  for (const study::NamedChart& c : f.charts(rows)) write_whole_file(dir + "/" + c.name + ".svg", svg(c.chart));
}

void print_row(const study::Row& r, bool head) {
  if (head) {
    for (const auto& [name, v] : r.figures) std::printf("%*s ", std::max(9, int(name.size())), name.c_str());
    std::printf("\n");
  }
  for (const auto& [name, v] : r.figures) std::printf("%*s ", std::max(9, int(name.size())), plain(v).c_str());
  std::printf("\n");
  std::fflush(stdout);
}

int run(const Options& o) {
  const study::Family& f = study::find_family(o.name);
  const std::vector<study::Values> members = study::members(f, o.settings);
  o.common.prepare();
  WorkersPool workers(o.common.worker_count());
  std::vector<study::Row> rows;
  for (const study::Values& v : members) {
    std::string label = "study " + f.name;
    Progress progress(label);
    progress.show(double(rows.size()), double(members.size()), "members");
    study::Row row = f.run(v, {workers, interrupted});
    progress.clear();
    if (interrupted()) break;
    rows.push_back(std::move(row));
    print_row(rows.back(), rows.size() == 1);
    if (!o.common.out_dir.empty()) {  // as they finish
      result_of(f, rows, members.size()).write(o.common.out_dir + "/result.json");
      leave_files(f, rows, o.common.out_dir);
      if (rows.back().shown) draw_member_picture(o.common.out_dir, int(rows.size()), rows.back().title, *rows.back().shown);
    }
    rows.back().shown.reset();  // drawn
  }
  if (rows.empty()) {
    say("interrupted; nothing was written");
    return kGoalMissed;
  }
  const Result result = result_of(f, rows, members.size());
  leave_result(result, o.common);
  bool ok = true;
  std::printf("\n%-66s %10s %10s\n", "bar", "value", "bar");
  for (const study::Bar& b : f.bars(rows)) {
    std::printf("%-66s %10.4g %s%9.4g  %s\n", b.name.c_str(), b.value, b.larger_is_better ? ">" : "<", b.bar, b.pass ? "pass" : "FAIL");
    ok &= b.pass;
  }
  if (rows.size() < members.size()) {
    say("interrupted after " + std::to_string(rows.size()) + " of " + std::to_string(members.size()) + " members; their rows are kept");
    return kGoalMissed;
  }
  return ok ? kDone : kGoalMissed;
}

std::string footer() {
  std::string text;
  for (const study::Family& f : study::families()) {
    text += f.name + ": " + f.about + "\n";
    for (const study::Parameter& p : f.parameters) {
      std::string values;
      for (const double v : p.values) values += (values.empty() ? "" : ",") + plain(v);
      char line[200];
      std::snprintf(line, sizeof line, "  %-20s %s, %g to %g (by itself %s)\n", p.name.c_str(), p.help.c_str(), p.lo, p.hi, values.c_str());
      text += line;
    }
  }
  return text +
         "Leaves rows.csv, charts as SVG, result.json and report.html in DIR, renewed after every member.\n"
         "Exit status 3: a bar is missed.\n"
         "Example: limberg study gape --set angle_deg=90,45 --set prestretch_percent=5,10,20 --out out/gape";
}

}  // namespace

void add_study(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand("study", "A family of operations, each brought to rest: table, charts and bars");
  c->add_option("NAME", o->name, "Which (see below)")->required();
  c->add_option("--set", o->settings, "Values of a setting instead of its own; once per setting")->type_name("KEY=V1,V2,...")->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  o->common.add_out(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(footer());
  c->callback([o, &chosen] { chosen = [o] { return run(*o); }; });
}

}  // namespace limberg
