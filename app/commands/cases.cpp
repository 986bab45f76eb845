#include "app/assembly/cases.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "app/commands/commands.h"
#include "app/report/elements.h"
#include "app/report/page.h"
#include "app/result/output.h"
#include "sim/base/whole_file.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/plan_drawing.h"

namespace limberg {
namespace {

using namespace html;

/// How each is begun.
std::string run_line(const Case& c) { return "limberg run --case " + c.name; }
std::string operate_line(const Case& c) { return fmt::format("limberg operate --case {0} --out out/{0}", c.name); }

void tell(const Case& c) {
  const Lesson& l = c.lesson;
  std::printf("case        %s\n            %s\n            %s\nscene       %s\nlesson      %s\nscript      %s\n",
              c.name.c_str(), l.title.c_str(), l.goal.c_str(), l.scene.c_str(), l.file.c_str(), c.script.c_str());
  if (!c.recording.empty()) std::printf("recording   %s\n", c.recording.c_str());
  int n = 0;
  for (const std::string& step : l.steps) std::printf("step %-2d     %s\n", ++n, step.c_str());
  std::printf("learn it    %s\nwatch it    %s\n", run_line(c).c_str(), operate_line(c).c_str());
}

/// The plan as it is drawn on paper; nothing for bones, whose plan is in space.
Markup plan_of_case(const Lesson& l, const Words& w) {
  if (!l.plan) return {};
  const Procedure& p = find_procedure(l.plan->procedure);
  std::vector<std::string> settings;
  for (const auto& [name, value] : l.plan->values) settings.push_back(fmt::format("{}={}", name, value));
  return chart(plan_svg(p.figure(procedure_values(p, settings)), w(l.title)));
}

Markup part_of_page(const Case& c, const Words& w) {
  const Lesson& l = c.lesson;
  Markup body = paragraph(w.said(l.goal));
  body += plan_of_case(l, w);
  std::vector<Markup> steps, hints;
  for (const std::string& s : l.steps) steps.emplace_back(w.said(s));
  for (const std::string& h : l.hints) hints.emplace_back(w.said(h));
  if (!steps.empty()) body += list(steps);
  if (!hints.empty()) body += list(hints);
  body += paragraph(Markup(w("Scene:")) + " " + bold(l.scene) + ". " + w("Learn it:") + " " + code(run_line(c)) + ". " +
                    w("Watch it:") + " " + code(operate_line(c)));
  return section(w(l.title), body);
}

int list_cases(const std::string& name, const CommonOptions& common) {
  common.prepare();
  if (!name.empty()) {
    tell(open_case(name));
    return kDone;
  }
  const std::vector<Case> all = shipped_cases();
  size_t wide = 0;
  for (const Case& c : all) wide = std::max(wide, c.name.size());
  for (const Case& c : all)
    std::printf("%-*s  %s  (scene %s, lesson %s)\n", int(wide), c.name.c_str(), c.lesson.title.c_str(),
                c.lesson.scene.c_str(), std::filesystem::path(c.lesson.file).stem().c_str());
  if (common.out_dir.empty()) return kDone;
  const Words w = common.words();
  Page page;
  page.w = w, page.title = w("Cases"), page.heading = page.title;
  page.opening = paragraph(w("{} operations, each with a lesson and a script.", all.size()));
  for (const Case& c : all) page.sections += part_of_page(c, w);
  const std::string file = common.out_dir + "/cases.html";
  write_whole_file(file, text_of(page));
  std::printf("page        %s\n", file.c_str());
  return kDone;
}

}  // namespace

void add_cases(CLI::App& app, Chosen& chosen) {
  auto name = std::make_shared<std::string>();
  auto common = std::make_shared<CommonOptions>();
  CLI::App* c = app.add_subcommand("cases", "The library of operations: name, title, scene and lesson of each");
  c->add_option("--case", *name, "This one only: its goal, steps and files, and how to begin")->type_name("NAME");
  common->add_out(*c), common->add_words(*c);
  c->footer("Example: limberg cases --case cheek-rhomboid");
  c->callback([name, common, &chosen] { chosen = [=] { return list_cases(*name, *common); }; });
}

}  // namespace limberg
