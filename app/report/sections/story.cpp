// The operation, or the members of a study, picture by picture.
#include <algorithm>
#include <filesystem>

#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"

namespace limberg::sections {

namespace {

/// Those of the result; where it has none, the pictures that lie in its folder, in order of their names.
std::vector<ResultStage> stages_of(const ReportSource& source) {
  if (!source.d.stages.empty()) return source.d.stages;
  namespace fs = std::filesystem;
  std::vector<ResultStage> stages;
  std::error_code none;
  for (const auto& e : fs::directory_iterator(fs::path(source.dir) / report_names::stages_dir, none))
    if (e.path().extension() == ".png") {
      ResultStage stage;
      stage.name = e.path().stem().string();
      stage.picture = std::string(report_names::stages_dir) + "/" + e.path().filename().string();
      stages.push_back(stage);
    }
  std::sort(stages.begin(), stages.end(), [](const auto& a, const auto& b) { return a.picture < b.picture; });
  for (ResultStage& stage : stages) {  // "03-flap-cut" is the flap cut
    std::string& n = stage.name;
    if (n.size() > 3 && n[2] == '-') n = n.substr(3);
    std::replace(n.begin(), n.end(), '-', ' ');
  }
  return stages;
}

std::string facts_of(const ResultStage& stage, bool of_bones, const Words& w) {
  std::vector<std::string> facts;
  if (stage.t_s) facts.push_back(html::quantity(stage.t_s, "s"));
  if (stage.sutures && *stage.sutures > 0)
    facts.push_back(w.counted(*stage.sutures, "{} suture", "{} sutures", *stage.sutures));
  if (stage.residual && (!of_bones || *stage.residual > 0))
    facts.push_back(w("residual {}", html::number(*stage.residual, 2)));
  return joined(facts, " · ");
}

}  // namespace

html::Markup story(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  html::Markup figures;
  int k = 0;
  for (const ResultStage& stage : stages_of(source)) {
    const std::string number = std::to_string(++k), url = picture_url(source.dir, stage.picture, 960);
    if (url.empty() && stage.name.empty()) continue;
    const std::string name = w(stage.name);
    html::Markup caption = html::bold(number + ". " + capital(name));
    for (const std::string& line : {w.said(stage.caption), facts_of(stage, d.of_bones(), w)})
      if (!line.empty()) caption += html::line_break() + line;
    figures += html::figure(url, w("Stage {}: {}", number, name), caption);
  }
  return figures.empty() ? figures
                         : html::section(w(d.study_rows.empty() ? english("The operation, step by step")
                                                                : english("The members, each at rest")),
                                         html::story(figures));
}

}  // namespace limberg::sections
