// Of a study whose members were drawn from what is not known of a tissue: between what each figure lies, and what it
// owes to whom.
#include <cmath>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::number;

namespace {

/// "closure force" and "N" of closure_force_N.
std::pair<std::string, std::string> figure_and_unit(const std::string& figure) {
  const std::string words = spoken(figure);
  const size_t at = words.rfind(" (");
  if (at == std::string::npos || !words.ends_with(")")) return {words, ""};
  return {words.substr(0, at), words.substr(at + 2, words.size() - at - 3)};
}

/// Two digits that count.
std::string brief(double v) {
  if (v == 0 || !std::isfinite(v)) return number(v);
  const double unit = std::pow(10, std::floor(std::log10(std::abs(v))) - 1);
  return number(unit * std::round(v / unit));
}

/// "1.9 N, 1.2 to 3.1 for facial skin".
html::Card card_of(const ResultBand& b, const std::string& of_whom) {
  const auto [name, unit] = figure_and_unit(b.figure);
  const bool near_one = *b.low > 0.5 && *b.high < 2 && unit.empty();  // a stretch: what is above 1 counts
  const auto words = [&](double v) -> std::string { return near_one ? html::quantity(v, "", 3) : brief(v); };
  html::Card card;
  card.value = words(*b.median) + (unit.empty() ? "" : "\u202f" + unit);
  card.name = capital(name);
  card.why = words(*b.low) + " to " + words(*b.high) + " for " + of_whom;
  return card;
}

html::Markup chart_of_shares(const ResultBand& b) {
  ShareChart chart;
  chart.description = "Shares of the variance of " + b.figure + " that each parameter makes";
  chart.first = "alone (first order)", chart.second = "with all others (total)";
  chart.x.title = "share of the variance";
  for (const ResultShare& s : b.shares) {
    const auto bar = [](const Maybe& v, const Maybe& low, const Maybe& high) {
      return ShareBar{v.value_or(0), low.value_or(0), high.value_or(0)};
    };
    chart.rows.push_back(
        {spoken(s.parameter), bar(s.first, s.first_low, s.first_high), bar(s.total, s.total_low, s.total_high)});
  }
  return html::titled(capital(figure_and_unit(b.figure).first) + ": what makes it differ", html::chart(svg(chart)));
}

html::Markup case_of(const ResultCase& c, const std::string& of_whom) {
  std::vector<html::Card> cards;
  html::Markup charts;
  std::vector<html::Row> rows;
  for (const ResultBand& b : c.figures) {
    if (!b.low || !b.median || !b.high) continue;
    cards.push_back(card_of(b, of_whom));
    rows.push_back({spoken(b.figure), html::quantity(b.median, "", 4), html::quantity(b.low, "", 4),
                    html::quantity(b.high, "", 4), std::to_string(b.members.value_or(0))});
    if (!b.shares.empty()) charts += chart_of_shares(b);
  }
  const html::Markup body =
      html::cards(cards) + html::table({"Figure", "Median", "5 % below", "95 % below", "Members"}, rows) + charts;
  return c.setting.empty() ? body : html::titled(capital(spoken(c.setting)), body);
}

}  // namespace

html::Markup uncertainty(const ReportSource& source) {
  const ResultUncertainty& u = source.d.uncertainty;
  if (u.cases.empty()) return {};
  const bool shares = !u.cases[0].figures.empty() && !u.cases[0].figures[0].shares.empty();
  html::Markup body = html::paragraph(
      "Large: half of the members lie below. Below it: nine of ten lie between the two numbers, with the tissue drawn "
      "as the table at the end says" +
      std::string(shares ? ". Bars: what would go from the variance if that parameter alone were known (alone), and "
                           "what would stay if it alone were not (with all others); the thin line holds 95 % of "
                           "bootstrap draws."
                         : "."));
  for (const ResultCase& c : u.cases) body += case_of(c, u.ranges);
  std::vector<html::Row> rows;
  for (const ResultSampled& s : u.sampled) rows.push_back({spoken(s.parameter), s.distribution, s.source});
  body += html::titled(
      "What was drawn: " + u.ranges,
      html::soft_paragraph(u.note) + html::table_of_words({"Parameter", "Distribution", "Where it comes from"}, rows) +
          html::note((u.sample == "sobol"   ? "Sobol's sequence"
                      : u.sample == "latin" ? "Latin hypercube"
                                            : u.sample) +
                     ", " + std::to_string(u.base.value_or(0)) + " points, " + std::to_string(u.points.value_or(0)) +
                     " members in each case, seed " + std::to_string(u.seed.value_or(0)) + "."));
  return html::section("How sure it is", body);
}

}  // namespace limberg::sections
