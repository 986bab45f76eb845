// What stands round the sections: what the result is of, and what made it.
#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup opening(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  const std::string of = joined({said(d.command).empty() ? "" : "limberg " + said(d.command),
                                 said(d.scene).empty() ? "" : w("scene {}", said(d.scene)), w(said(d.mode))},
                                " · ");
  html::Markup m;
  if (!of.empty()) m += html::soft_paragraph(of + (d.duration_s ? " · " + html::quantity(d.duration_s, "s") : ""));
  if (!said(d.scene_note).empty()) m += html::paragraph(w.said(said(d.scene_note)));
  return m;
}

html::Markup footer(const ReportSource& source) {
  const ReportData& d = source.d;
  std::vector<std::string> facts;
  const std::string version = said(d.limberg.version), commit = said(d.limberg.commit), cpu = said(d.machine.cpu);
  if (!version.empty()) facts.push_back("limberg " + version + (commit.empty() ? "" : " (" + commit + ")"));
  if (!cpu.empty())
    facts.push_back(cpu + (d.machine.cores
                               ? ", " + d.w.counted(*d.machine.cores, "{} core", "{} cores", *d.machine.cores)
                               : std::string()));
  if (const std::string parts = joined(entries(d.parts), ", "); !parts.empty())
    facts.push_back(d.w("built: {}", parts));
  if (d.reproduce.empty() && !said(d.state_hash).empty()) facts.push_back(d.w("state {}", said(d.state_hash)));
  return joined(facts, " · ");
}

}  // namespace limberg::sections
