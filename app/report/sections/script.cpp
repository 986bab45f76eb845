// What was done, as a script that does it again.
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup script(const ReportSource& source) {
  const ReportData& d = source.d;
  if (d.script.empty()) return {};
  std::string text;
  for (const std::string& line : d.script) text += line + "\n";
  const Words& w = d.w;
  return html::section(
      w("The script of the operation"),
      html::note(w(d.of_bones()
                       ? english("One action a line; points are millimetres in the frame of the scan. The command "
                                 "limberg operate does it again.")
                       : english("One action a line; points are millimetres on the skin. The command limberg "
                                 "operate runs it at any resolution."))) +
          html::lines(text));
}

}  // namespace limberg::sections
