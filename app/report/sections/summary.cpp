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
  const Words& w = d.w;
  const auto n = int64_t(pieces);
  if (far < 0.005) return w.counted(n, "one piece of bone, where it was", "{} pieces of bone, all where they were", n);
  return w.counted(n, "one piece of bone, carried {1}", "{0} pieces of bone, the farthest carried {1}", n,
                   quantity(far, "mm", 2)) +
         (face < 0.005 ? "" : "; " + w("the face follows by up to {}", quantity(face, "mm", 2)));
}

std::string bars_met(const ReportData& d, size_t met) {
  const size_t all = d.bars.size();
  if (met == all) return d.w.counted(int64_t(all), "The one bar is met", "All {} bars are met", all);
  return d.w("{} of {} bars are met, {} missed", met, all, all - met);
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
  const Words& w = d.w;
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
    const std::string gapes = closed && !whole->place.empty() ? " (" + w.said(whole->place) + ")" : "";
    const size_t sewn = d.sutures().size();
    const std::string sutures = w.counted(int64_t(sewn), "with {} suture", "with {} sutures", sewn);
    const std::string apart = quantity(gap, "mm", 2);
    v.say(closed   ? w("Closed along its whole edge{} {}, bites up to {} apart", gapes, sutures, apart)
          : looked ? w("Not closed, {}, bites up to {} apart", sutures, apart)
                   : w("Sewn {}, bites up to {} apart", sutures, apart),
          (closed || !looked) && met ? Light::good : Light::warn);
  }
  if (!d.sutures().empty() && force) v.say(w("largest suture force {}", quantity(force, "N")), light_of_force(*force));
  if (d.of_bones()) v.say(bones_moved(d), Light::good);
  if (residual_of(d)) {
    const bool rest = *d.residual <= kAtRest;
    const std::string left = number(*d.residual, 2);
    v.say(rest ? w("in equilibrium (relative residual {})", left)
               : w("not yet in equilibrium (relative residual {})", left),
          rest ? Light::good : Light::warn);
  }
  return v;
}

html::Markup verdict_line(const ReportData& d) {
  Summary v = summary_of(d);
  std::string line = joined(v.says, "; ");
  if (d.ok && !*d.ok) {
    v.light = Light::bad;
    if (d.bars.empty()) line = joined({d.w("The run did not reach its goal"), line}, ": ");
  }
  return line.empty() ? html::Markup() : html::verdict(v.light, capital(line) + ".");
}

/// What is wrong, then what is worth a look: a page begins with it.
html::Markup faults(const ReportData& d) {
  html::Markup all;
  for (const auto& [name, light, title] : {std::tuple(light_names::bad, Light::bad, english("What is wrong")),
                                           std::tuple(light_names::warn, Light::warn, english("Worth a look"))}) {
    std::vector<html::Markup> lines;
    for (const ResultVerdict& l : d.verdict)
      if (l.light == name) lines.push_back(capital(in_words(l, d.w)));
    if (!lines.empty()) all += html::verdict(light, html::bold(d.w(title)) + html::list(lines));
  }
  return all;
}

html::Markup damage(const ReportData& d) {
  if (d.damage.empty()) return {};
  std::vector<std::string> lost;
  for (const auto& [name, value] : d.damage) lost.push_back(d.w.said(name) + " " + value);
  return html::notice(html::bold(d.w("The recording was damaged.")) + " " +
                      d.w("What was whole was replayed: {}.", joined(lost, "; ")));
}

/// Of a run that a person ended: how far it came.
html::Markup interrupted(const ReportData& d) {
  if (!d.interrupted.value_or(false)) return {};
  const Words& w = d.w;
  std::vector<std::string> where;
  if (d.duration_s) where.push_back(w("after {}", quantity(d.duration_s, "s")));
  if (d.commands) where.push_back(w.counted(*d.commands, "after {} act", "after {} acts", *d.commands));
  if (!d.stages.empty())
    where.push_back(w("the last stage that was passed is \u201c{}\u201d", w(d.stages.back().name)));
  return html::notice(html::bold(w("Interrupted.")) + " " +
                      (where.empty() ? std::string(w("What was done by then is told and drawn."))
                                     : w("What was done by then is told and drawn: {}.", joined(where, ", "))));
}

html::Markup last_picture(const ReportSource& source) {
  const std::string url = picture_url(source.dir, source.d.pictures.overview);
  const char* alt = source.d.w(source.d.gallery.empty() ? english("The skin at the end of the operation")
                                                        : english("The head at the end of the operation"));
  return url.empty() ? html::Markup() : html::hero(html::figure(url, alt, {}));
}

/// "lattice ± 0.2 N" beside the figure that it qualifies; empty when it is not known.
std::string lattice_error(const ReportData& d, const char* name, std::string_view unit) {
  const auto e = d.errors.find(name);
  if (e == d.errors.end() || !e->second.error) return {};
  const std::string error = quantity(e->second.error, unit, 2);
  return e->second.asymptotic && e->second.order ? d.w("lattice ± {}, order {}", error, number(*e->second.order, 2))
                                                 : d.w("lattice ± {}, not yet settled", error);
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
        {quantity(value, unit, digits), d.w(name), joined({why, lattice_error(d, metric, of_error)}, "; "), light});
  }
};

html::Markup key_figures(const ReportData& d) {
  const Maybe closure = d.metric("closure_force_N"), force = largest_force(d), gap = largest_gap(d),
              ear_volume = d.metric("dog_ear_volume_mm3"), stretch_max = d.metric("stretch_max");
  const Words& w = d.w;
  KeyFigures k{d};
  k.add("closure_force_N", closure, "N", 3, english("closure force"),
        w("sum over all sutures; clinical limit {}", quantity(kClosureForce_N.bad, "N")),
        closure && *closure > kClosureForce_N.bad ? Light::bad : Light::none);
  k.add("suture_force_max_N", force, "N", 3, english("largest suture force"), w("one thread"),
        force ? light_of_force(*force) : Light::none);
  k.add("suture_gap_max_mm", gap, "mm", 2, english("bites apart, at most"),
        w("met up to {}; it is not the wound's gape", quantity(kSutureGap_mm.bad, "mm")),
        gap && *gap <= kSutureGap_mm.bad ? Light::good : Light::warn);
  k.add("dog_ear_mm", d.metric("dog_ear_mm"), "mm", 3, english("dog-ear height"),
        ear_volume ? w("{} above the skin", quantity(ear_volume, "mm³")) : w("standing cone above the skin"));
  const Maybe widest = d.metric("wound_gape_max_mm");
  k.add("wound_gape_mm", d.metric("wound_gape_mm"), "mm", 2, english("wound gape"),
        widest ? w("95 % of the edge gapes less, at most {}", quantity(widest, "mm", 2))
               : std::string(w("95 % of the edge gapes less")));
  k.add("flap_area_mm2", d.metric("flap_area_mm2"), "mm²", 3, english("flap area"), "");
  k.add("elongation", d.metric("elongation"), "×", 3, english("elongation"), w("of the central limb's line"));
  k.add("stretch_p99", d.metric("stretch_p99"), "×", 3, english("stretch, 99th percentile"),
        stretch_max ? w("largest but for 1 mm² {}", quantity(stretch_max, "×")) : "");
  std::vector<html::Card>& cards = k.cards;
  if (d.of_bones()) {
    cards.push_back({number(d.metric("fragments").value_or(0)), w("pieces of bone"), w("what was cut out counts")});
    if (const Maybe v = d.metric("fragment_moved_max_mm"))
      cards.push_back({quantity(v, "mm"), w("farthest piece"), w("of its middle from where it was")});
    if (const Maybe v = d.metric("face_moved_max_mm"))
      cards.push_back({quantity(v, "mm"), w("face moved, at most"), w("the place of the skin that moved most")});
  }
  if (residual_of(d))
    cards.push_back({number(*d.residual, 2), w("relative residual"), w("goal {}", number(kAtRest)),
                     *d.residual <= kAtRest ? Light::good : Light::warn});
  if (d.distance_mm && !(d.of_bones() && *d.distance_mm == 0))
    cards.push_back({quantity(d.distance_mm, "mm", 2), w("from equilibrium"),
                     w("estimated by the last frame: the node that is farthest off")});
  return html::cards(cards);
}

}  // namespace

html::Markup summary(const ReportSource& source) {
  const ReportData& d = source.d;
  return interrupted(d) + faults(d) + verdict_line(d) + damage(d) + last_picture(source) + key_figures(d);
}

}  // namespace limberg::sections
