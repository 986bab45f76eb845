#include "app/report/report.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/report/compare.h"

namespace limberg {

namespace {

/// A folder stands for compare.html in it.
std::string page_of(const std::string& out) {
  std::error_code none;
  return std::filesystem::is_directory(out, none) ? (std::filesystem::path(out) / "compare.html").string() : out;
}

}  // namespace

void add_report(CLI::App& app, Chosen& chosen) {
  struct Options {
    std::string dir, out;
    CommonOptions common;
    std::vector<std::string> compare;
  };
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand(
      "report", "Make report.html again from a folder's result.json and pictures, or compare two folders");
  CLI::Option* dir = c->add_option("DIR", o->dir, "Folder that holds result.json");
  CLI::Option* compare =
      c->add_option("--compare", o->compare, "Two folders on one page: figures, stitches, pictures, timing, script")
          ->type_name("A B")
          ->expected(2)
          ->excludes(dir);
  c->add_option("--out", o->out, "The page of the comparison (default: compare.html in B)")
      ->type_name("FILE|DIR")
      ->needs(compare);
  o->common.add_words(*c);
  c->footer(
      "Example: limberg report out/demo\n"
      "         limberg report out/demo --language de\n"
      "         limberg report --compare out/mine out/demo --out compare.html");
  c->callback([o, &chosen] {
    if (o->dir.empty() && o->compare.empty()) throw CLI::RequiredError("DIR, or --compare A B,");
    chosen = [o] {
      const std::string page =
          o->compare.empty() ? write_report(o->dir, o->common.words())
                             : write_comparison(o->compare[0], o->compare[1],
                                                page_of(o->out.empty() ? o->compare[1] : o->out), o->common.words());
      std::printf("%s\n", page.c_str());
      return int(kDone);
    };
  });
}

}  // namespace limberg
