#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/commands/commands.h"
#include "sim/measure/table.h"

namespace limberg {

namespace {

std::string described(const Measure& m) {
  std::string s = fmt::format("{}{}\n    {}: {}\n    error: {}\n", m.name,
                              m.unit[0] ? fmt::format(" [{}]", m.unit) : std::string(), m.words, m.definition, m.error);
  if (m.limits)
    s += m.limits->warn < m.limits->bad
             ? fmt::format("    limits: {:g} and {:g} {} ({})\n", m.limits->warn, m.limits->bad, m.unit,
                           m.limits->source)
             : fmt::format("    limit: {:g} {} ({})\n", m.limits->bad, m.unit, m.limits->source);
  return s;
}

}  // namespace

void add_measures(CLI::App& app, Chosen& chosen) {
  CLI::App* c =
      app.add_subcommand("measures", "Every figure of result.json's metrics: unit, definition, error, limits");
  c->footer(
      "`--cells` as an error: operate --cells with more than one size estimates the lattice's share of it.\n"
      "Example: limberg measures");
  c->callback([&chosen] {
    chosen = [] {
      for (const Measure& m : measure_table()) std::fputs(described(m).c_str(), stdout);
      return int(kDone);
    };
  });
}

}  // namespace limberg
