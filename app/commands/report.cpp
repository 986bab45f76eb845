#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "app/commands/commands.h"
#include "app/report/report.h"

namespace limberg {

void add_report(CLI::App& app, Chosen& chosen) {
  auto dir = std::make_shared<std::string>();
  CLI::App* c = app.add_subcommand("report", "Make report.html again from the result.json and pictures in a folder");
  c->add_option("DIR", *dir, "Folder that holds result.json")->required();
  c->footer("Example: limberg report out/demo");
  c->callback([dir, &chosen] {
    chosen = [dir] {
      std::printf("%s\n", write_report(*dir).c_str());
      return int(kDone);
    };
  });
}

}  // namespace limberg
