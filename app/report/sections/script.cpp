// What was done, as a script that does it again.
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup script(const ReportSource& source) {
  const ReportData& d = source.d;
  if (d.script.empty()) return {};
  std::string text;
  for (const std::string& line : d.script) text += line + "\n";
  const html::Markup operate = html::code("limberg operate");
  return html::section("The script of the operation",
                       html::note("One action a line; points are millimetres " +
                                  (d.of_bones() ? "in the frame of the scan. " + operate + " does it again."
                                                : "on the skin. " + operate + " runs it at any resolution.")) +
                           html::lines(text));
}

}  // namespace limberg::sections
