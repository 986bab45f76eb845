// Everything that was looked at, with its limit and where that comes from.
#include "app/report/html.h"
#include "app/report/sections.h"
#include "app/result/verdict_words.h"

namespace limberg::sections {

html::Markup verdict(const ReportSource& source) {
  using html::Light;
  const Words& w = source.d.w;
  constexpr std::string_view kLesson = "lesson: ";
  std::vector<html::Row> rows;
  for (const ResultVerdict& v : source.d.verdict) {
    const Light light = v.light == light_names::bad    ? Light::bad
                        : v.light == light_names::warn ? Light::warn
                        : v.light == light_names::good ? Light::good
                                                       : Light::none;
    const Maybe value = std::isfinite(v.value) ? Maybe(v.value) : Maybe(),
                limit = std::isfinite(v.limit) ? Maybe(v.limit) : Maybe();
    rows.push_back(
        {html::dot(light) + capital(v.what.starts_with(kLesson) ? w("lesson: {}", name_in_words(v.what.substr(8), w))
                                                                : w.said(v.what)),
         value ? html::Markup(html::quantity(value, v.unit)) : html::Markup(w("not measured")),
         limit ? html::Markup("≤ " + html::quantity(limit, v.unit)) : html::Markup(), w.said(v.place),
         w.said(v.source)});
  }
  if (rows.empty()) return {};
  return html::section(
      w("What was looked at"),
      html::table_of_words({"", w("Value"), w("Limit"), w("Place"), w("Where the limit comes from")}, rows));
}

}  // namespace limberg::sections
