#include "app/report/sections.h"

namespace limberg::sections {

html::Markup all(const ReportSource& source) {
  html::Markup m;
#define X(name) m += name(source);
  LIMBERG_REPORT_SECTIONS(X)
#undef X
  return m;
}

}  // namespace limberg::sections
