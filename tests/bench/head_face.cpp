#include "tests/bench/head_face.h"

#include <algorithm>
#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "app/report/svg_chart.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "tests/bench/head_cases.h"

namespace limberg::bench {
namespace {

using namespace simplex;

/// Distances of the face's vertices from where they should be, over the vertices measured.
HeadTrial against(const Mesh& face, const std::vector<Vec3>& truth, const std::vector<int32_t>& measured) {
  HeadTrial e;
  std::vector<double> d;
  for (int32_t v : measured) d.push_back((face.x_mm[size_t(v)] - truth[size_t(v)]).norm());
  std::sort(d.begin(), d.end());
  for (double x : d) e.rms_mm += x * x / double(d.size());
  e.rms_mm = std::sqrt(e.rms_mm), e.p95_mm = d[d.size() * 95 / 100], e.max_mm = d.back();
  return e;
}

struct Mode {
  const char* name;
  TissueKind mode;
  double hold;  // springs: share of the shape force; below 0: as FaceModelSettings has it
  bool aim;     // the bar applies
};
constexpr Mode kModes[] = {{"finite elements", TissueKind::finite_elements, -1, true},
                           {"shape", TissueKind::shape, -1, true},
                           {"springs", TissueKind::springs, -1, true},
                           {"springs alone (1994)", TissueKind::springs, 0, false}};

FaceModel tied(const HeadModel& head, const HeadCase& c, const Mode& mode, Workers& w) {
  FaceModelSettings s;
  if (mode.hold >= 0) s.hold = mode.hold;
  FaceModel f(head.face, w, s);
  for (const HeadCase::Tie& t : c.ties)
    if (const Outcome o = f.connect(c.bones, {t.name, t.face_region, {}, t.layers, t.young_kPa, mode.mode}); !o.done)
      throw InputError("", 0, c.name + ", " + t.name + ": " + o.reason);
  return f;
}

void compare(HeadReport& out, const HeadModel& head, const HeadCase& c, const HeadSettings& settings, Workers& w) {
  FaceModel truth = tied(head, c, kModes[0], w);
  truth.follow(c.moved);
  for (int i = 0; i < 100 && !truth.at_rest(); ++i) truth.step(80);
  const std::vector<Vec3> X = truth.face().x_mm;
  const HeadTrial still = against(head.face, X, c.measured);
  out.result.notes.push_back(
      text("%s: moves a region of %zu vertices by %.2f mm rms, %.2f mm at most.%s", c.name.c_str(), c.measured.size(),
           still.rms_mm, still.max_mm,
           c.fitted ? " The constants of the modes were chosen on this case." : " Unseen when constants were chosen."));
  for (const Mode& mode : kModes) {
    if (settings.progress) settings.progress(c.name + ", " + mode.name);
    FaceModel f = tied(head, c, mode, w);
    const double t0 = cpu_ms();
    f.follow(c.moved);
    double ms = cpu_ms() - t0;
    int done = 0;
    HeadTrial e;
    for (int target : {4, 8, 16, 32, 64, 128, 256, 512, 1024}) {
      if (settings.quick && target > 256) break;
      const double t1 = cpu_ms();
      for (; done < target && !f.at_rest(); done += std::min(16, target - done)) f.step(std::min(16, target - done));
      ms += cpu_ms() - t1;
      e = against(f.face(), X, c.measured);
      e.situation = c.name, e.mode = mode.name, e.iterations = done, e.cpu_ms = ms, e.at_rest = f.at_rest();
      out.trials.push_back(e);
      if (f.at_rest()) break;
    }
    Row r;
    r.name = c.name, r.method = mode.name, r.time_ms = ms, r.error = e.rms_mm, r.error_unit = "mm rms",
    r.reference = "finite elements at equilibrium";
    r.settings =
        text("%d iterations; p95 %.2f, max %.2f mm%s", e.iterations, e.p95_mm, e.max_mm, e.at_rest ? "; at rest" : "");
    out.result.rows.push_back(r);
    if (mode.aim && mode.mode != TissueKind::finite_elements)
      out.result.bars.push_back({text("%s, %s: distance from the finite elements (mm rms)", c.name.c_str(), mode.name),
                                 e.rms_mm, false, 1, false, e.rms_mm <= 1, "issue 7: the aim is 1 mm"});
  }
}

}  // namespace

std::vector<std::string> HeadReport::situations() const {
  std::vector<std::string> out;
  for (const HeadTrial& t : trials)
    if (std::find(out.begin(), out.end(), t.situation) == out.end()) out.push_back(t.situation);
  return out;
}

std::string HeadReport::csv() const {
  std::string s = "situation,mode,iterations,cpu_ms,rms_mm,p95_mm,max_mm,at_rest\n";
  for (const HeadTrial& t : trials)
    s += text("\"%s\",\"%s\",%d,%.3f,%.5f,%.5f,%.5f,%d\n", t.situation.c_str(), t.mode.c_str(), t.iterations, t.cpu_ms,
              t.rms_mm, t.p95_mm, t.max_mm, int(t.at_rest));
  return s;
}

LineChart HeadReport::chart(const std::string& situation) const {
  LineChart c;
  c.description =
      situation +
      ": distance of the face from the finite elements at equilibrium against run time, for each mode of the tissue";
  c.x = {"CPU time of one core, ms", true, {}, {}};
  c.y = {"error of the face, mm rms", true, 0.005, {}};
  c.y_marks.push_back({1, "aim 1 mm"});
  for (const Mode& m : kModes) {
    ChartSeries s;
    s.name = m.name, s.markers = true;
    for (const HeadTrial& t : trials)
      if (t.situation == situation && t.mode == m.name) s.x.push_back(t.cpu_ms), s.y.push_back(t.rms_mm);
    c.series.push_back(std::move(s));
  }
  return c;
}

HeadReport head_suite(const HeadSettings& settings) {
  HeadReport out;
  InlineWorkers w;
  if (settings.progress) settings.progress("head");
  const double t0 = cpu_ms();
  const HeadModel head = make_head({}, w);
  Row r;
  r.name = "synthetic head", r.method = "limberg", r.time_ms = cpu_ms() - t0, r.error = head.cranium_report.face_rms_mm,
  r.error_unit = "mm rms";
  r.settings = text("cranium %d, mandible %d, face %d vertices; distance of face centres", head.cranium.vertices(),
                    head.mandible.vertices(), head.face.vertices());
  out.result.rows.push_back(r);
  const auto wanted = [&](const char* part) { return std::string(part).find(settings.only) != std::string::npos; };
  if (wanted("modes")) {
    const std::vector<HeadCase> cases = head_cases(head, out.result.notes, w);
    for (const HeadCase& c : cases)
      if (!settings.quick || &c - cases.data() < 3) compare(out, head, c, settings, w);
  }
  if (wanted("session")) head_session(out.result, head, settings, w);
  return out;
}

}  // namespace limberg::bench
