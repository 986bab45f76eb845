#include "app/assembly/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/result/verdict_words.h"
#include "app/words/words.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/measure/table.h"

namespace limberg {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kAtRest = 1e-4;  // relative residual
constexpr double kMet_mm = 0.5;   // edges of which 95 % are nearer have met: an aim, of no publication
// Overlap: warned of where it is more than what counts as met (kSutureGap_mm), bad where tissue lies in tissue by more
// than half of the skin: then edges lie through one another.
constexpr double kOverlapOfSkin = 0.5;
// 23 operations that lie as they should show at most a twentieth of this (2026-11-28).
constexpr double kRawWarn_mm2 = 1;
// At a lag of 75 ms a hand begins to be slower, at 225 ms it is 64 % slower, with three times the errors (MacKenzie and
// Ware 1993, INTERCHI, 488).
constexpr double kBehindWarn_ms = 75, kBehindBad_ms = 225;
constexpr const char* kBehindSource =
    english("MacKenzie and Ware 1993: at 225 ms errors trebled, at 75 ms they begin to rise");
constexpr double kSkippedShare = 0.01;  // as the lag, which 99 % of the ticks do not exceed

std::string on_chart(const Body& body, const Vec3& X_mm) {
  const ChartPoint p = body.to_chart(X_mm);
  return fmt::format(english("({:.1f}, {:.1f}) mm"), p.x() + 0.0, p.y() + 0.0);
}

std::string numbers_of(std::vector<int> ids, const char* one, const char* several) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  if (ids.empty()) return "";
  std::string s = ids.size() == 1 ? one : several;
  for (size_t i = 0; i < ids.size() && i < 12; ++i) s += (i ? ", " : " ") + std::to_string(ids[i]);
  return ids.size() > 12 ? s + ", ..." : s;
}

/// Lines as they come; a lesson's tolerance takes the place of the limit that a line has by itself.
class Lines {
 public:
  explicit Lines(std::span<const Judgement> judged) : judged_(judged), used_(judged.size(), false) {}

  std::vector<ResultVerdict> all;

  void add(std::string what, double value, std::string unit, double limit, std::string place, const char* light,
           std::string source) {
    all.push_back({std::move(what), value, std::move(unit), limit, std::move(place), light, std::move(source)});
  }
  /// Bad above `bad`, worth a look above `warn`; `tolerance`: the name by which a lesson may ask for the same.
  void limited(std::string what, double value, std::string unit, MeasureLimits limits, std::string place,
               const char* tolerance = nullptr) {
    double limit = limits.bad, warn = limits.warn;
    std::string source = limits.source;
    if (tolerance)
      for (size_t i = 0; i < judged_.size(); ++i)
        if (judged_[i].name == tolerance)
          limit = warn = judged_[i].limit, source = english("the lesson"), used_[i] = judged_[i].value.has_value();
    add(std::move(what), value, std::move(unit), limit, std::move(place),
        value > limit  ? light_names::bad
        : value > warn ? light_names::warn
                       : light_names::good,
        source);
  }
  bool asked(const char* tolerance) const {
    return std::any_of(judged_.begin(), judged_.end(), [&](const Judgement& j) { return j.name == tolerance; });
  }
  /// What else the lesson asks.
  void rest_of_lesson() {
    for (size_t i = 0; i < judged_.size(); ++i)
      if (const Judgement& j = judged_[i]; !used_[i])
        add(fmt::format(english("lesson: {}"), j.name), j.value.value_or(kNone), j.unit, j.limit, j.value ? "" : j.why,
            j.met ? light_names::good : light_names::bad, english("the lesson"));
  }

 private:
  std::span<const Judgement> judged_;
  std::vector<bool> used_;
};

void look_at_shape(Lines& lines, const VerdictOf& of) {
  const Metrics& m = *of.metrics;
  // Skin is bent by no less than a cell of the lattice: a face of one is what it cannot tell from none.
  const double wound_cell_mm = of.cell_mm / double(1 << of.wound_level), face_mm2 = wound_cell_mm * wound_cell_mm;
  lines.limited(english("skin on its face or inside out"), m.turned.area_mm2, "mm²",
                {0.5 * face_mm2, face_mm2,
                 english("one face of a cell of the lattice at the wound, which bends skin no sharper")},
                m.turned.area_mm2 > 0 ? on_chart(*of.body, m.turned.at_mm) : "");
  lines.limited(
      english("tissue inside out"), m.inverted_mm3, "mm³",
      {0, kLeastFraction * of.cell_mm * of.cell_mm * of.cell_mm,
       english(
           "tissue cannot be turned inside out; a hundredth of a cell is what the lattice does not tell from none")},
      m.inverted_cells > 0 ? on_chart(*of.body, m.inverted_at_mm) : "");
  lines.limited(english("dog-ear"), m.dog_ear_mm, "mm", kDogEar_mm,
                m.dog_ear_mm > 0 ? on_chart(*of.body, m.dog_ear_at_mm) : "", "dog_ear_mm");
  const double skin_mm = of.body->layers.empty() ? 1 : of.body->layers[0].thickness_mm;
  lines.limited(english("tissue in tissue, 99 % of the wound"), m.penetration.p99_mm, "mm",
                {kSutureGap_mm.bad, std::max(kSutureGap_mm.bad, kOverlapOfSkin * skin_mm),
                 english("half of the skin's thickness: edges that lie through one another")},
                "");
  if (m.beyond_law_mm2 > 0)
    lines.add(english("skin stretched beyond what skin bears, without a stress"), m.beyond_law_mm2, "mm²", kNone, "",
              light_names::warn,
              english("Ni Annaidh et al. 2012: excised skin tore at a stretch of 1.54; its law ends there"));
}

void look_at_wound(Lines& lines, const VerdictOf& of) {
  const Metrics& m = *of.metrics;
  const WoundGape& g = m.gape;
  if (!(g.rim_length_mm > 0)) return;
  const std::string widest = on_chart(*of.body, g.widest_at_mm);
  if (m.sutures.empty() && !lines.asked("wound_gape_mm")) {
    if (g.open_mm > 0)
      lines.add(english("open wound, nothing is sewn"), g.widest_mm, "mm", kNone, widest, light_names::told, "");
    return;
  }
  const size_t before = lines.all.size();
  lines.limited(english("wound gape, 95 % of the edge"), g.gape_mm, "mm", kWoundGape_mm,
                on_chart(*of.body, g.gape_at_mm), "wound_gape_mm");
  lines.limited(english("wound gape, widest"), g.widest_mm, "mm", kWoundGape_mm, widest);
  lines.limited(
      english("edge of the wound that is open"), g.open_mm, "mm",
      {0, 0, english("closed is a wound whose edges are all within 2 mm of each other (Hollander et al. 1995)")},
      g.open_mm > 0 ? widest : "");
  lines.limited(
      english("edge of the wound that lies over or under skin"), g.over_mm, "mm",
      {0, kOpen_mm,
       english("an inverted edge is a fault (Hollander et al. 1995); more of it than edges may be apart is bad")},
      g.over_mm > 0 ? on_chart(*of.body, g.over_at_mm) : "");
  lines.limited("raw tissue above the skin", m.raw.area_mm2, "mm²",
                {kRawWarn_mm2, kOpen_mm * kOpen_mm,
                 "as much as a wound shows that counts as closed: a hole of 2 by 2 mm (Hollander et al. 1995)"},
                m.raw.area_mm2 > 0 ? on_chart(*of.body, m.raw.at_mm) : "");
  const bool closed = std::all_of(lines.all.begin() + std::ptrdiff_t(before), lines.all.end(),
                                  [](const ResultVerdict& l) { return l.light != light_names::bad; });
  if (closed && !m.sutures.empty())
    lines.add(kClosedWhole, m.scar_length_mm, "mm", kNone,
              fmt::format(english("gapes by at most {:.2g} mm"), g.widest_mm), light_names::good, "");
  // A wound may count as closed, all of it within 2 mm, and still want stitches.
  if (closed && !m.sutures.empty() && g.gape_mm > kMet_mm)
    lines.add(
        english("edges apart between stitches: it needs more of them, nearer to each other and to the ends"), g.gape_mm,
        "mm", kMet_mm, on_chart(*of.body, g.gape_at_mm), light_names::warn,
        english("95 % of the edge within half a millimetre is what the library's cases aim at; of no publication"));
  if (lines.asked("step_off_mm"))
    lines.limited(english("step-off, 95 % of the edge"), m.step_off_mm, "mm", {}, "", "step_off_mm");
}

void look_at_stitches(Lines& lines, const VerdictOf& of) {
  const Metrics& m = *of.metrics;
  if (m.sutures.empty()) return;
  std::vector<int> slack;  // of which the bank says nothing already
  for (const int id : m.slack)
    if (std::find(m.one_bank.begin(), m.one_bank.end(), id) == m.one_bank.end()) slack.push_back(id);
  lines.limited(english("stitches that hold nothing: both bites in one bank"), double(m.one_bank.size()), "",
                {0, 0, english("a stitch joins two edges")},
                numbers_of(m.one_bank, english("stitch"), english("stitches")));
  if (!slack.empty())
    lines.add(english("stitches that hold nothing: slack"), double(slack.size()), "", 0,
              numbers_of(slack, english("stitch"), english("stitches")), light_names::warn,
              english("pulls with less than 0.001 N"));
  lines.limited(english("bites of a stitch apart"), m.suture_gap_max_mm, "mm", kSutureGap_mm, "", "gap_mm");
  const std::string most = "stitch " + std::to_string(m.suture_force_max_id);
  lines.limited(english("largest force of a stitch"), m.suture_force_max_N, "N", kSutureForce_N, most, "suture_N");
  if (lines.asked("suture_peak_N"))
    lines.limited(english("largest force of a stitch so far"), m.suture_force_peak_N, "N", kSutureForce_N, "",
                  "suture_peak_N");
  lines.limited(english("closure force"), m.closure_force_N, "N", kClosureForce_N, "", "closure_N");
}

void look_at_pace(Lines& lines, const Pace& p) {
  const double least = kSkippedShare * double(p.steps + p.skipped);
  lines.add(english("solver steps skipped"), double(p.skipped), "", std::floor(least), "",
            double(p.skipped) > least ? light_names::warn : light_names::good,
            english("a hundredth of all, as the lag, which 99 % of the time do not exceed"));
  lines.limited(english("patient behind the hand, 99 % of the time"), p.behind_p99_ms, "ms",
                {kBehindWarn_ms, kBehindBad_ms, kBehindSource},
                fmt::format(english("{:.0f} ms at most"), p.behind_max_ms));
  if (!p.slowed) return;
  const double bearable_s = kSkippedShare * p.slowed->session_s;
  lines.add(english("time added by slow motion"), p.slowed->added_s, "s", bearable_s,
            fmt::format(english("slowest second: {:.2f} of real time"), p.slowed->slowest),
            p.slowed->added_s > bearable_s ? light_names::warn : light_names::good,
            english("a hundredth of the session, as of steps: a hand that is timed has had longer than its times say"));
}

}  // namespace

std::vector<ResultVerdict> verdict_of(const VerdictOf& of) {
  Lines lines(of.judged);
  if (of.metrics) look_at_shape(lines, of), look_at_wound(lines, of), look_at_stitches(lines, of);
  if (of.bone)
    lines.limited(english("bone outside the skin"), of.bone->depth_mm, "mm", {0, 0, english("bone lies under skin")},
                  of.bone->depth_mm > 0
                      ? fmt::format(english("({:.1f}, {:.1f}, {:.1f}) mm, fragment {}, {:.0f} mm²"), of.bone->at_mm.x(),
                                    of.bone->at_mm.y(), of.bone->at_mm.z(), of.bone->object, of.bone->area_mm2)
                      : "",
                  "bone_outside_mm");
  if (of.pace) look_at_pace(lines, *of.pace);
  if (!(of.residual <= kAtRest))
    lines.add(english("not at rest: relative residual"), of.residual, "", kAtRest,
              of.stalled ? english("the solver stalls: more iterations gain nothing") : "",
              of.cut_short ? light_names::warn : light_names::bad, english("what is measured is not settled yet"));
  lines.rest_of_lesson();
  worst_first(lines.all);
  return std::move(lines.all);
}

void worst_first(std::vector<ResultVerdict>& verdict) {
  const auto rank = [](const ResultVerdict& v) {
    return v.light == light_names::bad ? 0 : v.light == light_names::warn ? 1 : v.light == light_names::told ? 2 : 3;
  };
  std::stable_sort(verdict.begin(), verdict.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
}

bool is_bad(std::span<const ResultVerdict> verdict) {
  return std::any_of(verdict.begin(), verdict.end(), [](const auto& v) { return v.light == light_names::bad; });
}

void print_verdict(std::span<const ResultVerdict> verdict) {
  for (const ResultVerdict& v : verdict)
    if (v.light != light_names::good || v.what == kClosedWhole)
      fmt::print("verdict     {:<5} {}\n", v.light, in_words(v));
}

}  // namespace limberg
