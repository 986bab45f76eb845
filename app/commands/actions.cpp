#include "sim/commands/actions.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/commands/commands.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

int print_actions(const std::string& action, bool markdown) {
  const std::string text = markdown ? actions_markdown() : actions_text(action);
  if (text.empty())
    throw InputError("", 0, "actions: there is no action \"" + action + "\"; expected one that limberg actions lists");
  std::fputs(text.c_str(), stdout);
  return kDone;
}

}  // namespace

void add_actions(CLI::App& app, Chosen& chosen) {
  auto action = std::make_shared<std::string>();
  auto markdown = std::make_shared<bool>(false);
  CLI::App* c = app.add_subcommand(
      "actions", "What an operation script may say: every action, its fields with units, limits and defaults");
  c->add_option("ACTION", *action, "This one only");
  c->add_flag("--markdown", *markdown, "All of them as Markdown, as docs/ has them");
  c->footer("Example: limberg actions suture_row");
  c->callback([action, markdown, &chosen] { chosen = [=] { return print_actions(*action, *markdown); }; });
}

}  // namespace limberg
