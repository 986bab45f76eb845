#include "app/report/sections.h"

namespace limberg::sections {

html::Markup gallery(const ReportSource& source) {
  html::Markup figures;
  for (const auto& [picture, caption] : source.d.gallery)
    if (const std::string url = picture_url(source.dir, picture, 720); !url.empty())
      figures += html::figure(url, caption, caption);
  return figures.empty() ? figures
                         : html::section(source.d.command == "fit"       ? "The mesh from its sides"
                                         : source.d.command == "patient" ? "Slices, with what was made of them"
                                                                         : "Before and after",
                                         html::story(figures));
}

}  // namespace limberg::sections
