// Force and gap of each stitch, beside the limits of both.
#include <algorithm>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::Light;
using html::quantity;

html::Markup sutures(const ReportSource& source) {
  const ReportData& d = source.d;
  if (d.sutures().empty()) return {};
  const Words& w = d.w;
  double most = 1e-9;
  for (const ResultSuture& s : d.sutures()) most = std::max(most, s.force_N.value_or(0));
  std::vector<html::Row> rows;
  for (const ResultSuture& s : d.sutures()) {
    const Light light = s.force_N ? light_of_force(*s.force_N) : Light::none;
    rows.push_back(
        {html::dot(light) + (s.id ? std::to_string(*s.id) : "–"),
         quantity(s.force_N, "N"),
         html::meter(s.force_N ? Maybe(*s.force_N / most) : Maybe(), light),
         quantity(s.tied_N, "N"),
         quantity(s.peak_N, "N"),
         {quantity(s.gap_mm, "mm", 2), s.gap_mm && *s.gap_mm > kSutureGap_mm.bad ? Light::warn : Light::none}});
  }
  html::Markup body = html::table(
      {w("Suture"), w("Force"), html::meter({}, Light::none), w("when tied"), w("largest ever"), w("Gap")}, rows);
  if (const Maybe v = d.metric("closure_force_N"))
    body += html::paragraph(html::Markup(w("Closure force, summed over all sutures:")) + " " +
                            html::bold(quantity(v, "N")));
  const std::string warn = html::number(kSutureForce_N.warn), bad = quantity(kSutureForce_N.bad, "N");
  body += html::note(
      html::dot(Light::good) + w("below {} N.", warn) + " " + html::dot(Light::warn) + w("{} to {}.", warn, bad) + " " +
      html::dot(Light::bad) + w("above {}.", bad) + " " +
      w("Closing tension above 250 g (2.45 N) significantly raised necrosis in flaps with impaired supply (Larrabee, "
        "Holloway and Sutton 1984, 27 flaps in piglets). 5 N lies between the knot-pull strengths of USP 5-0 and 4-0 "
        "thread (3.9 and 5.9 N). A closure force of 15 N was the largest found acceptable on the scalp (Lear 2019, 14 "
        "wounds). These limits are for orientation: they come from animals and from other regions, and the tissue "
        "constants of a scene are no patient's."));
  return html::section(w("Sutures"), body);
}

}  // namespace limberg::sections
