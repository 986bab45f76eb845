#include "app/report/sections.h"

namespace limberg::sections {

html::Markup gallery(const ReportSource& source) {
  const Words& w = source.d.w;
  html::Markup figures;
  for (const auto& [picture, caption] : source.d.gallery)
    if (const std::string url = picture_url(source.dir, picture, 720); !url.empty())
      figures += html::figure(url, w.said(caption), w.said(caption));
  return figures.empty()
             ? figures
             : html::section(w(source.d.command == "fit"       ? english("The mesh from its sides")
                               : source.d.command == "patient" ? english("Slices, with what was made of them")
                                                               : english("Before and after")),
                             html::story(figures));
}

}  // namespace limberg::sections
