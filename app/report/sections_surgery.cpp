// What was done and what came of it: pictures, stitches, balances.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"

namespace limberg::sections {

namespace fs = std::filesystem;
using html::escape;
using html::number;
using html::quantity;

std::string picture_url(const std::string& dir, const std::string& name, int widest) {
  const fs::path p(name);
  if (name.empty() || p.is_absolute() || name.find('\0') != std::string::npos) return {};
  for (const fs::path& part : p)
    if (part == "..") return {};
  return html::png_data_url((fs::path(dir) / p).string(), widest);
}

namespace {

std::string figure(const std::string& url, const std::string& alt, const std::string& caption) {
  return "<figure><img src=\"" + url + "\" alt=\"" + escape(alt) + "\"/>" +
         (caption.empty() ? "" : "<figcaption>" + caption + "</figcaption>") + "</figure>\n";
}

std::string card(const std::string& value, const std::string& name, const std::string& why,
                 const std::string& light = "") {
  return "<div class=\"card\"><b class=\"" + light + "\">" + value + "</b><span>" + name + "</span>" +
         (why.empty() ? "" : "<span class=\"why\">" + why + "</span>") + "</div>\n";
}

std::string capital(std::string s) {
  if (!s.empty() && s[0] >= 'a' && s[0] <= 'z') s[0] = char(s[0] - 'a' + 'A');
  return s;
}

Maybe largest(const ReportData& d, Maybe ResultSuture::*what) {
  Maybe m;
  for (const ResultSuture& s : d.sutures)
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

// The parts of one line: what is closed, how hard it pulls, whether it has come to rest.
std::string verdict(const ReportData& d, std::string& light) {
  light = "good";
  const auto worse = [&](const std::string& l) {
    if (l == "bad" || light == "good") light = l;
  };
  std::vector<std::string> says;
  const Maybe gap = largest_gap(d), force = largest_force(d);
  if (!d.sutures.empty() && gap) {
    const bool closed = *gap <= kSutureGap_mm.bad;
    if (!closed) worse("warn");
    says.push_back((closed ? "Closed with " : "Not fully closed with ") + std::to_string(d.sutures.size()) +
                   (d.sutures.size() == 1 ? " suture" : " sutures") + ", largest gap " + quantity(gap, "mm", 2));
  }
  if (!d.sutures.empty() && force) {
    worse(light_of_force(*force));
    says.push_back("largest suture force " + quantity(force, "N"));
  }
  if (d.of_bones()) says.push_back(bones_moved(d));
  if (residual_of(d)) {
    const bool rest = *d.residual <= kAtRest;
    if (!rest) worse("warn");
    says.push_back(std::string(rest ? "in equilibrium" : "not yet in equilibrium") + " (relative residual " +
                   number(*d.residual, 2) + ")");
  }
  if (d.ok && !*d.ok) {
    worse("bad");
    if (d.bars.empty()) says.insert(says.begin(), "The run did not reach its goal");
  }
  if (!d.bars.empty()) {
    const auto met = std::count_if(d.bars.begin(), d.bars.end(), [](const ResultBar& b) { return b.pass; });
    const auto all = std::ptrdiff_t(d.bars.size());
    if (met < all) worse("bad");
    says.insert(says.begin(), met == all && all == 1 ? "The one bar is met"
                              : met == all           ? "All " + std::to_string(all) + " bars are met"
                                           : std::to_string(met) + " of " + std::to_string(all) + " bars are met, " +
                                                 std::to_string(all - met) + " missed");
  }
  std::string line;
  for (size_t i = 0; i < says.size(); ++i)
    line += (i == 0 ? "" : i == 1 && d.bars.empty() && d.ok && !*d.ok ? ": " : "; ") + says[i];
  return line.empty() ? line : capital(line) + ".";
}

/// "lattice ± 0.2 N" beside the figure that it qualifies; empty when it is not known.
std::string lattice_error(const ReportData& d, const char* name, std::string_view unit) {
  const auto e = d.errors.find(name);
  if (e == d.errors.end() || !e->second.error) return {};
  return "lattice ± " + quantity(e->second.error, unit, 2) +
         (e->second.asymptotic && e->second.order ? ", order " + number(*e->second.order, 2) : ", not yet settled");
}
std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + "; " + b; }

std::string key_figures(const ReportData& d) {
  std::string c;
  const Maybe force = largest_force(d), gap = largest_gap(d);
  if (const Maybe v = d.metric("closure_force_N"))
    c += card(quantity(v, "N"), "closure force",
              joined("sum over all sutures; clinical limit " + number(kClosureForce_N.bad) + "\u202fN",
                     lattice_error(d, "closure_force_N", "N")),
              *v > kClosureForce_N.bad ? "bad" : "");
  if (force)
    c += card(quantity(force, "N"), "largest suture force",
              joined("one thread", lattice_error(d, "suture_force_max_N", "N")), light_of_force(*force));
  if (gap)
    c += card(
        quantity(gap, "mm", 2), "largest gap",
        joined("closed up to " + number(kSutureGap_mm.bad) + "\u202fmm", lattice_error(d, "suture_gap_max_mm", "mm")),
        *gap <= kSutureGap_mm.bad ? "good" : "warn");
  if (const Maybe v = d.metric("dog_ear_mm")) {
    const Maybe volume = d.metric("dog_ear_volume_mm3");
    c += card(quantity(v, "mm"), "dog-ear height",
              joined(volume ? quantity(volume, "mm³") + " above the skin" : "standing cone above the skin",
                     lattice_error(d, "dog_ear_mm", "mm")));
  }
  if (const Maybe v = d.metric("wound_gape_mm"))
    c += card(quantity(v, "mm", 2), "wound gape",
              joined("95 % of the edge gapes less", lattice_error(d, "wound_gape_mm", "mm")));
  if (const Maybe v = d.metric("flap_area_mm2"))
    c += card(quantity(v, "mm²"), "flap area", lattice_error(d, "flap_area_mm2", "mm²"));
  if (const Maybe v = d.metric("elongation"))
    c += card(quantity(v, "×"), "elongation", joined("of the central limb's line", lattice_error(d, "elongation", "")));
  if (const Maybe v = d.metric("stretch_p99")) {
    const Maybe most = d.metric("stretch_max");
    c += card(quantity(v, "×"), "stretch, 99th percentile",
              joined(most ? "largest " + quantity(most, "×") : "", lattice_error(d, "stretch_p99", "")));
  }
  if (d.of_bones()) {
    c += card(number(d.metric("fragments").value_or(0)), "pieces of bone", "what was cut out counts");
    if (const Maybe v = d.metric("fragment_moved_max_mm"))
      c += card(quantity(v, "mm", 3), "farthest piece", "of its middle from where it was");
    if (const Maybe v = d.metric("face_moved_max_mm"))
      c += card(quantity(v, "mm", 3), "face moved, at most", "the place of the skin that moved most");
  }
  if (residual_of(d))
    c += card(number(*d.residual, 2), "relative residual", "goal " + number(kAtRest),
              *d.residual <= kAtRest ? "good" : "warn");
  if (d.distance_mm)
    c += card(quantity(d.distance_mm, "mm", 2), "from equilibrium",
              "estimated by the last frame: the node that is farthest off");
  return c.empty() ? c : "<div class=\"cards\">\n" + c + "</div>\n";
}

}  // namespace

std::string light_of_force(double force_N) {
  return force_N < kSutureForce_N.warn ? "good" : force_N <= kSutureForce_N.bad ? "warn" : "bad";
}

std::string title(const ReportData& d) {
  return !d.scene_title.empty()     ? capital(d.scene_title)
         : !d.scene.empty()         ? capital(d.scene)
         : d.command == "superpose" ? "Superposition"
         : d.command == "fit"       ? "Fit of a mesh"
         : d.command == "bench"     ? "Benchmark"
         : d.study.empty()          ? "Operation"
                                    : "Study: " + d.study;
}

std::string heading(const ReportData& d, const std::string& dir) {
  std::string s = "<header>\n<h1>" + escape(title(d)) + "</h1>\n";
  std::string sub = d.command.empty() ? "" : "limberg " + d.command;
  if (!d.scene.empty()) sub += (sub.empty() ? "" : " · ") + ("scene " + d.scene);
  if (!d.mode.empty()) sub += " · " + d.mode;
  if (!sub.empty())
    s += "<p class=\"soft\">" + escape(sub) + (d.duration_s ? " · " + quantity(d.duration_s, "s") : "") + "</p>\n";
  if (!d.scene_note.empty()) s += "<p>" + escape(d.scene_note) + "</p>\n";
  s += "</header>\n";
  std::string light;
  if (const std::string line = verdict(d, light); !line.empty())
    s += "<div class=\"verdict " + light + "\"><div><span class=\"light " + light + "\"></span>" + line +
         "</div></div>\n";
  if (!d.damage.empty()) {
    s += "<div class=\"notice\"><b>The recording was damaged.</b> What was whole was replayed:";
    for (const auto& [name, value] : d.damage) s += " " + escape(name) + " " + escape(value) + ";";
    s.back() = '.';
    s += "</div>\n";
  }
  if (const std::string url = picture_url(dir, d.overview); !url.empty())
    s +=
        "<div class=\"hero\">" +
        figure(url, d.gallery.empty() ? "The skin at the end of the operation" : "The head at the end of the operation",
               "") +
        "</div>\n";
  return s + key_figures(d);
}

std::string story(const ReportData& d, const std::string& dir) {
  std::vector<ResultStage> stages = d.stages;
  if (stages.empty()) {  // the pictures alone, in order of their names
    std::error_code none;
    for (const auto& e : fs::directory_iterator(fs::path(dir) / report_names::stages_dir, none))
      if (e.path().extension() == ".png") {
        ResultStage stage;
        stage.name = e.path().stem().string();
        stage.picture = std::string(report_names::stages_dir) + "/" + e.path().filename().string();
        stages.push_back(stage);
      }
    std::sort(stages.begin(), stages.end(), [](const auto& a, const auto& b) { return a.picture < b.picture; });
    for (ResultStage& stage : stages) {  // "03-flap-cut" is the flap cut
      std::string& n = stage.name;
      if (n.size() > 3 && n[2] == '-') n = n.substr(3);
      std::replace(n.begin(), n.end(), '-', ' ');
    }
  }
  std::string s;
  int k = 0;
  for (const ResultStage& stage : stages) {
    ++k;
    std::string facts;
    const auto fact = [&](const std::string& f) { facts += (facts.empty() ? "" : " · ") + f; };
    if (stage.t_s) fact(quantity(stage.t_s, "s"));
    if (stage.sutures && *stage.sutures > 0)
      fact(std::to_string(*stage.sutures) + (*stage.sutures == 1 ? " suture" : " sutures"));
    if (stage.residual && (!d.of_bones() || *stage.residual > 0)) fact("residual " + number(*stage.residual, 2));
    const std::string caption = "<b>" + std::to_string(k) + ". " + escape(capital(stage.name)) + "</b>" +
                                (stage.caption.empty() ? "" : "<br/>" + escape(stage.caption)) +
                                (facts.empty() ? "" : "<br/>" + facts);
    const std::string url = picture_url(dir, stage.picture, 960);
    if (!url.empty())
      s += figure(url, "Stage " + std::to_string(k) + ": " + stage.name, caption);
    else if (!stage.name.empty())
      s += "<figure><figcaption>" + caption + "</figcaption></figure>\n";
  }
  return s.empty()
             ? s
             : "<section>\n<h2>" +
                   std::string(d.study_rows.empty() ? "The operation, step by step" : "The members, each at rest") +
                   "</h2>\n<div class=\"story\">\n" + s + "</div>\n</section>\n";
}

std::string gallery(const ReportData& d, const std::string& dir) {
  std::string s;
  for (const auto& [picture, caption] : d.gallery)
    if (const std::string url = picture_url(dir, picture, 720); !url.empty())
      s += figure(url, caption, escape(caption));
  return s.empty()
             ? s
             : "<section>\n<h2>" + std::string(d.command == "fit" ? "The mesh from its sides" : "Before and after") +
                   "</h2>\n<div class=\"story\">\n" + s + "</div>\n</section>\n";
}

std::string tension(const ReportData& d, const std::string& dir) {
  const std::string url = picture_url(dir, d.tension);
  if (url.empty()) return {};
  std::string words =
      "How far the skin is stretched: the largest principal stretch less one. The tension that it carried before the "
      "operation is included. Lines part the steps of the scale.";
  if (const Maybe v = d.metric("stress_p95_kPa")) {
    words += " Stress: 95th percentile " + quantity(v, "kPa");
    if (const Maybe most = d.metric("stress_max_kPa")) words += ", largest " + quantity(most, "kPa");
    words += ".";
  }
  std::string more;
  const auto also = [&](const char* name, const char* alt, const char* caption) {
    if (const std::string u = picture_url(dir, name, 720); !u.empty()) more += figure(u, alt, caption);
  };
  also(report_names::height, "Map of the skin's height",
       "<b>What stands up.</b> Height over where the skin's surface was before: red above it (dog-ears), blue below.");
  also(report_names::moved, "Map of the skin's displacement",
       "<b>How far skin was moved</b>, from where the same skin was before.");
  also(report_names::risk, "Map of the perfusion index",
       "<b>Perfusion risk</b> of undermined skin, by its way to skin that is still attached: dark is far. It orders "
       "places and foretells nothing.");
  return "<section>\n<h2>Tension map</h2>\n" + figure(url, "Map of the skin's stretch", words) +
         (more.empty() ? "" : "<h3>More maps</h3>\n<div class=\"story\">\n" + more + "</div>\n") + "</section>\n";
}

std::string sutures(const ReportData& d) {
  if (d.sutures.empty()) return {};
  double most = 1e-9;
  for (const ResultSuture& s : d.sutures) most = std::max(most, s.force_N.value_or(0));
  std::string t =
      "<section>\n<h2>Sutures</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>Suture</th><th>Force</th><th "
      "class=\"bar\"></th><th>when tied</th><th>largest ever</th><th>Gap</th></tr></thead>\n<tbody>\n";
  for (const ResultSuture& s : d.sutures) {
    const std::string light = s.force_N ? light_of_force(*s.force_N) : "";
    t += "<tr><td><span class=\"light " + light + "\"></span>" + (s.id ? std::to_string(*s.id) : "–") + "</td><td>" +
         quantity(s.force_N, "N") + "</td><td class=\"bar " + light + "\">";
    if (s.force_N)
      t += "<span class=\"meter\" style=\"width:" +
           std::to_string(int(std::lround(100 * std::clamp(*s.force_N / most, 0.0, 1.0)))) + "%\"></span>";
    t += "</td><td>" + quantity(s.tied_N, "N") + "</td><td>" + quantity(s.peak_N, "N");
    t += "</td><td class=\"" + std::string(s.gap_mm && *s.gap_mm > kSutureGap_mm.bad ? "warn" : "") + "\">" +
         quantity(s.gap_mm, "mm", 2) + "</td></tr>\n";
  }
  t += "</tbody></table></div>\n";
  if (const Maybe v = d.metric("closure_force_N"))
    t += "<p>Closure force, summed over all sutures: <b>" + quantity(v, "N") + "</b>.</p>\n";
  t += "<p class=\"note\"><span class=\"light good\"></span>below 2.5\u202fN. <span class=\"light warn\"></span>2.5 to "
       "5\u202fN. <span class=\"light bad\"></span>above "
       "5\u202fN. Closing tension above 250\u202fg (2.45\u202fN) significantly raised necrosis in flaps with impaired "
       "supply (Larrabee, Holloway and "
       "Sutton 1984, 27 flaps in piglets). 5\u202fN lies between the knot-pull strengths of USP 5-0 and 4-0 thread "
       "(3.9 and 5.9\u202fN). A closure force "
       "of 15\u202fN was the largest found acceptable on the scalp (Lear 2019, 14 wounds). These limits are for "
       "orientation: they come from animals and "
       "from other regions, and the tissue constants of a scene are no patient's.</p>\n</section>\n";
  return t;
}

std::string balance(const ReportData& d) {
  std::string rows;
  const auto row = [&](const std::string& name, const std::string& value) {
    rows += "<tr><td>" + name + "</td><td>" + value + "</td></tr>\n";
  };
  const Maybe left = d.metric("volume_mm3"), out = d.metric("removed_volume_mm3"),
              before = d.metric("initial_volume_mm3");
  if (before) row("volume before the operation", quantity(before, "mm³", 10));
  if (left) row("volume of what remains, at rest", quantity(left, "mm³", 10));
  if (out) row("volume of what was taken away", quantity(out, "mm³", 10));
  if (!d.metric("volume_change") && before && left && out && *before > 0)
    row("remainder + removed − before, relative", number((*left + *out - *before) / *before, 2));
  if (const Maybe v = d.metric("volume_change")) row("volume that cutting lost or made, relative", number(*v, 2));
  if (const Maybe v = d.metric("compression")) row("change of volume under load, relative", number(*v, 2));
  if (const Maybe v = d.metric("pieces")) row("pieces", number(*v));
  if (const Maybe v = d.metric("min_J")) row("smallest volume ratio J of a cell", number(*v, 3));
  if (const Maybe v = d.metric("inverted_cells")) row("inverted cells", number(*v));
  std::string s =
      rows.empty() ? "" : "<h3>Volume</h3>\n<div class=\"wide\"><table>\n<tbody>\n" + rows + "</tbody></table></div>\n";
  if (!d.balance.empty()) {
    s += "<h3>Forces on the tissue</h3>\n<div "
         "class=\"wide\"><table>\n<thead><tr><th></th><th>x</th><th>y</th><th>z</th><th>size</th></tr></"
         "thead>\n<tbody>\n";
    for (const auto& [name, f] : d.balance) {
      std::string label =
          name.size() > 2 && name.compare(name.size() - 2, 2, "_N") == 0 ? name.substr(0, name.size() - 2) : name;
      std::replace(label.begin(), label.end(), '_', ' ');
      s += "<tr><td>" + escape(label) + "</td>";
      for (const double v : f) s += "<td>" + quantity(v, "N") + "</td>";
      s += "<td>" + quantity(std::hypot(f[0], f[1], f[2]), "N") + "</td></tr>\n";
    }
    s += "</tbody></table></div>\n";
    if (d.balance_relative)
      s += "<p>What is left over is " + number(100 * *d.balance_relative, 2) +
           "\u202f% of the sum of the magnitudes (goal: below 1\u202f%).</p>\n";
  }
  return s.empty() ? s : "<section>\n<h2>Does it add up?</h2>\n" + s + "</section>\n";
}

}  // namespace limberg::sections
