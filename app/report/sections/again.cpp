#include "app/report/sections.h"

namespace limberg::sections {

html::Markup again(const ReportSource& source) {
  const ReportData& d = source.d;
  if (d.reproduce.empty()) return {};
  html::Markup body = html::lines(d.reproduce);
  if (!said(d.state_hash).empty())
    body += html::note(html::Markup(d.w("State hash:")) + " " + html::code(said(d.state_hash)));
  return html::section(d.w("Make it again"), body);
}

}  // namespace limberg::sections
