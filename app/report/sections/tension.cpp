// Maps that lie on the skin.
#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup tension(const ReportSource& source) {
  const ReportData& d = source.d;
  const std::string url = picture_url(source.dir, d.pictures.tension);
  if (url.empty()) return {};
  const Words& w = d.w;
  std::string words =
      w("How far the skin is stretched: the largest principal stretch less one. The tension that it carried before the "
        "operation is included. Lines part the steps of the scale.");
  if (const Maybe v = d.metric("stress_p95_kPa")) {
    words += " " + w("Stress: 95th percentile {}", html::quantity(v, "kPa"));
    if (const Maybe most = d.metric("stress_max_kPa"))
      words += ", " + w("largest {} (but for 1 mm², and for skin beyond its law)", html::quantity(most, "kPa"));
    if (const Maybe beyond = d.metric("beyond_law_mm2"); beyond && *beyond > 0)
      words +=
          "; " + w("{} are stretched by more than 1.54, at which excised skin tears (Ni Annaidh 2012): no law tells "
                   "their stress",
                   html::quantity(beyond, "mm²"));
    words += ".";
  }
  html::Markup more;
  const auto also = [&](const char* name, const char* alt, const char* what, const char* caption) {
    if (const std::string u = picture_url(source.dir, name, 720); !u.empty())
      more += html::figure(u, w(alt), html::bold(w(what)) + " " + w(caption));
  };
  also(report_names::height, english("Map of the skin's height"), english("What stands up."),
       english("Height over where the skin's surface was before: red above it (dog-ears), blue below."));
  also(report_names::moved, english("Map of the skin's displacement"), english("How far skin was moved."),
       english("From where the same skin was before."));
  also(report_names::risk, english("Map of the perfusion index"), english("Perfusion risk."),
       english("Of undermined skin, by its way to skin that is still attached: dark is far. It orders places and "
               "foretells nothing."));
  return html::section(w("Tension map"), html::figure(url, w("Map of the skin's stretch"), words) +
                                             (more.empty() ? more : html::titled(w("More maps"), html::story(more))));
}

}  // namespace limberg::sections
