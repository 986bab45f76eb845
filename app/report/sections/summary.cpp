// What a result came to, before all sections: a verdict of one line, the picture at the end, the key figures.
#include <algorithm>

#include "app/report/html.h"
#include "app/report/sections.h"
#include "app/result/verdict_words.h"

namespace limberg::sections {

using html::Light;
using html::number;
using html::quantity;

namespace {

Maybe largest(const ReportData& d, Maybe ResultSuture::*what) {
  Maybe m;
  for (const ResultSuture& s : d.sutures())
    if (s.*what && (!m || *(s.*what) > *m)) m = s.*what;
  return m;
}

Maybe largest_gap(const ReportData& d) {
  const Maybe m = d.metric("suture_gap_max_mm");
  return m ? m : largest(d, &ResultSuture::gap_mm);
}

Maybe largest_force(const ReportData& d) {
  const Maybe m = d.metric("suture_force_max_N");
  return m ? m : largest(d, &ResultSuture::force_N);
}

/// What there is of it: bones alone leave none, and the face after them is solved with each step.
Maybe residual_of(const ReportData& d) { return d.of_bones() && d.residual && *d.residual == 0 ? Maybe() : d.residual; }

std::string bones_moved(const ReportData& d) {
  const double pieces = d.metric("fragments").value_or(0), far = d.metric("fragment_moved_max_mm").value_or(0),
               face = d.metric("face_moved_max_mm").value_or(0);
  const std::string of = pieces == 1 ? "one piece of bone" : number(pieces) + " pieces of bone";
  if (far < 0.005) return of + (pieces == 1 ? ", where it was" : ", all where they were");
  return of + (pieces == 1 ? ", carried " : ", the farthest carried ") + quantity(far, "mm", 2) +
         (face < 0.005 ? "" : "; the face follows by up to " + quantity(face, "mm", 2));
}

std::string bars_met(const ReportData& d, size_t met) {
  const size_t all = d.bars.size();
  if (met == all) return all == 1 ? "The one bar is met" : "All " + std::to_string(all) + " bars are met";
  return std::to_string(met) + " of " + std::to_string(all) + " bars are met, " + std::to_string(all - met) + " missed";
}

/// One line: what is closed, how hard it pulls, whether it has come to rest; and the worst of these.
struct Summary {
  std::vector<std::string> says;
  Light light = Light::good;

  void say(const std::string& words, Light l) {
    says.push_back(words);
    light = std::max(light, l);
  }
};

Summary summary_of(const ReportData& d) {
  Summary v;
  const Maybe gap = largest_gap(d), force = largest_force(d);
  if (!d.bars.empty()) {
    const auto met = std::count_if(d.bars.begin(), d.bars.end(), [](const Bar& b) { return b.pass; });
    v.say(bars_met(d, size_t(met)), size_t(met) < d.bars.size() ? Light::bad : Light::good);
  }
  if (!d.sutures().empty() && gap) {
    // Whether the wound is closed only its whole edge can say, and stitches whose bites have met say nothing of it.
    const bool looked = !d.verdict.empty(), met = *gap <= kSutureGap_mm.bad;
    const auto whole = std::find_if(d.verdict.begin(), d.verdict.end(),
                                    [](const ResultVerdict& line) { return line.what == kClosedWhole; });
    const bool closed = whole != d.verdict.end();
    const std::string gapes = closed && !whole->place.empty() ? " (" + whole->place + ")" : "";
    v.say((closed   ? "Closed along its whole edge" + gapes + " with "
           : looked ? "Not closed, with "
                    : "Sewn with ") +
              std::to_string(d.sutures().size()) + (d.sutures().size() == 1 ? " suture" : " sutures") +
              ", bites up to " + quantity(gap, "mm", 2) + " apart",
          (closed || !looked) && met ? Light::good : Light::warn);
  }
  if (!d.sutures().empty() && force) v.say("largest suture force " + quantity(force, "N"), light_of_force(*force));
  if (d.of_bones()) v.say(bones_moved(d), Light::good);
  if (residual_of(d)) {
    const bool rest = *d.residual <= kAtRest;
    v.say(std::string(rest ? "in equilibrium" : "not yet in equilibrium") + " (relative residual " +
              number(*d.residual, 2) + ")",
          rest ? Light::good : Light::warn);
  }
  return v;
}

html::Markup verdict_line(const ReportData& d) {
  Summary v = summary_of(d);
  std::string line = joined(v.says, "; ");
  if (d.ok && !*d.ok) {
    v.light = Light::bad;
    if (d.bars.empty()) line = joined({"The run did not reach its goal", line}, ": ");
  }
  return line.empty() ? html::Markup() : html::verdict(v.light, capital(line) + ".");
}

/// What is wrong, then what is worth a look: a page begins with it.
html::Markup faults(const ReportData& d) {
  html::Markup all;
  for (const auto& [name, light, title] : {std::tuple(light_names::bad, Light::bad, "What is wrong"),
                                           std::tuple(light_names::warn, Light::warn, "Worth a look")}) {
    std::vector<html::Markup> lines;
    for (const ResultVerdict& l : d.verdict)
      if (l.light == name) lines.push_back(capital(in_words(l)));
    if (!lines.empty()) all += html::verdict(light, html::bold(title) + html::list(lines));
  }
  return all;
}

html::Markup damage(const ReportData& d) {
  if (d.damage.empty()) return {};
  std::vector<std::string> lost;
  for (const auto& [name, value] : d.damage) lost.push_back(name + " " + value);
  return html::notice(html::bold("The recording was damaged.") + " What was whole was replayed: " + joined(lost, "; ") +
                      ".");
}

/// Of a run that a person ended: how far it came.
html::Markup interrupted(const ReportData& d) {
  if (!d.interrupted.value_or(false)) return {};
  std::vector<std::string> where;
  if (d.duration_s) where.push_back("after " + quantity(d.duration_s, "s"));
  if (d.commands) where.push_back("after " + number(double(*d.commands)) + (*d.commands == 1 ? " act" : " acts"));
  if (!d.stages.empty()) where.push_back("the last stage that was passed is \u201c" + d.stages.back().name + "\u201d");
  return html::notice(html::bold("Interrupted.") + " What was done by then is told and drawn" +
                      (where.empty() ? "" : ": " + joined(where, ", ")) + ".");
}

html::Markup last_picture(const ReportSource& source) {
  const std::string url = picture_url(source.dir, source.d.pictures.overview);
  const char* alt =
      source.d.gallery.empty() ? "The skin at the end of the operation" : "The head at the end of the operation";
  return url.empty() ? html::Markup() : html::hero(html::figure(url, alt, {}));
}

/// "lattice ± 0.2 N" beside the figure that it qualifies; empty when it is not known.
std::string lattice_error(const ReportData& d, const char* name, std::string_view unit) {
  const auto e = d.errors.find(name);
  if (e == d.errors.end() || !e->second.error) return {};
  return "lattice ± " + quantity(e->second.error, unit, 2) +
         (e->second.asymptotic && e->second.order ? ", order " + number(*e->second.order, 2) : ", not yet settled");
}

/// A card of a figure of `metrics`, with what qualifies it; none where the result has no such figure.
struct KeyFigures {
  const ReportData& d;
  std::vector<html::Card> cards = {};

  void add(const char* metric, const Maybe& value, const char* unit, int digits, const char* name,
           const std::string& why, Light light = Light::none) {
    if (!value) return;
    const std::string_view of_error = std::string_view(unit) == "×" ? "" : unit;  // of a ratio: a number
    cards.push_back(
        {quantity(value, unit, digits), name, joined({why, lattice_error(d, metric, of_error)}, "; "), light});
  }
};

html::Markup key_figures(const ReportData& d) {
  const Maybe closure = d.metric("closure_force_N"), force = largest_force(d), gap = largest_gap(d),
              ear_volume = d.metric("dog_ear_volume_mm3"), stretch_max = d.metric("stretch_max");
  KeyFigures k{d};
  k.add("closure_force_N", closure, "N", 3, "closure force",
        "sum over all sutures; clinical limit " + quantity(kClosureForce_N.bad, "N"),
        closure && *closure > kClosureForce_N.bad ? Light::bad : Light::none);
  k.add("suture_force_max_N", force, "N", 3, "largest suture force", "one thread",
        force ? light_of_force(*force) : Light::none);
  k.add("suture_gap_max_mm", gap, "mm", 2, "bites apart, at most",
        "met up to " + quantity(kSutureGap_mm.bad, "mm") + "; it is not the wound's gape",
        gap && *gap <= kSutureGap_mm.bad ? Light::good : Light::warn);
  k.add("dog_ear_mm", d.metric("dog_ear_mm"), "mm", 3, "dog-ear height",
        ear_volume ? quantity(ear_volume, "mm³") + " above the skin" : "standing cone above the skin");
  const Maybe widest = d.metric("wound_gape_max_mm");
  k.add("wound_gape_mm", d.metric("wound_gape_mm"), "mm", 2, "wound gape",
        "95 % of the edge gapes less" + (widest ? ", at most " + quantity(widest, "mm", 2) : ""));
  k.add("flap_area_mm2", d.metric("flap_area_mm2"), "mm²", 3, "flap area", "");
  k.add("elongation", d.metric("elongation"), "×", 3, "elongation", "of the central limb's line");
  k.add("stretch_p99", d.metric("stretch_p99"), "×", 3, "stretch, 99th percentile",
        stretch_max ? "largest but for 1 mm² " + quantity(stretch_max, "×") : "");
  std::vector<html::Card>& cards = k.cards;
  if (d.of_bones()) {
    cards.push_back({number(d.metric("fragments").value_or(0)), "pieces of bone", "what was cut out counts"});
    if (const Maybe v = d.metric("fragment_moved_max_mm"))
      cards.push_back({quantity(v, "mm"), "farthest piece", "of its middle from where it was"});
    if (const Maybe v = d.metric("face_moved_max_mm"))
      cards.push_back({quantity(v, "mm"), "face moved, at most", "the place of the skin that moved most"});
  }
  if (residual_of(d))
    cards.push_back({number(*d.residual, 2), "relative residual", "goal " + number(kAtRest),
                     *d.residual <= kAtRest ? Light::good : Light::warn});
  if (d.distance_mm && !(d.of_bones() && *d.distance_mm == 0))
    cards.push_back({quantity(d.distance_mm, "mm", 2), "from equilibrium",
                     "estimated by the last frame: the node that is farthest off"});
  return html::cards(cards);
}

}  // namespace

html::Markup summary(const ReportSource& source) {
  const ReportData& d = source.d;
  return interrupted(d) + faults(d) + verdict_line(d) + damage(d) + last_picture(source) + key_figures(d);
}

}  // namespace limberg::sections
