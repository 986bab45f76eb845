#include "app/bench/head_face.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/bench/cpu_clock.h"
#include "sim/error.h"
#include "sim/imaging/synthetic_head.h"
#include "sim/simplex/face_model.h"

namespace limberg::bench {
namespace {

using namespace simplex;

std::string text(const char* format, auto... value) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, value...);
  return buffer;
}

struct Scene {
  HeadModel head;
  Mesh bones, advanced;  // as they are, and with the mandible 8 mm forwards
  std::vector<int32_t> front, scalp;

  explicit Scene(Workers& w) : head(make_head({}, w)), bones(head.cranium) {
    const int32_t first = append(bones, head.mandible);
    advanced = bones;
    for (size_t v = size_t(first); v < advanced.x_mm.size(); ++v) advanced.x_mm[v].y() += 8;
    front = region_around(head.face, at("sto"), 80);
    scalp = region_around(head.face, at("v'"), 125);
    std::vector<uint8_t> in(head.face.nbr.size(), 0);
    for (int32_t v : front) in[size_t(v)] = 1;
    std::erase_if(scalp, [&](int32_t v) { return in[size_t(v)]; });
  }
  int32_t at(const std::string& name) const {
    Vec3 p = Vec3::Zero();
    for (const auto& [n, x] : head.landmarks)
      if (n == name) p = x;
    int32_t best = 0;
    for (int32_t v = 0; v < head.face.slots(); ++v)
      if ((head.face.x_mm[size_t(v)] - p).norm() < (head.face.x_mm[size_t(best)] - p).norm()) best = v;
    return best;
  }
  void tie(FaceModel& f, const char* name, const std::vector<int32_t>& region, int layers, FaceMode mode) const {
    const limberg::Outcome o = f.connect(bones, {name, region, {}, layers, 10, mode});
    if (!o.done) throw InputError("", 0, std::string(name) + ": " + o.reason);
  }
};

struct Error {
  double rms = 0, p95 = 0, max = 0;
};
/// Over the vertices of the region.
Error against(const Mesh& face, const std::vector<Vec3>& truth, const std::vector<int32_t>& region) {
  Error e;
  std::vector<double> d;
  for (int32_t v : region) d.push_back((face.x_mm[size_t(v)] - truth[size_t(v)]).norm());
  std::sort(d.begin(), d.end());
  for (double x : d) e.rms += x * x / double(d.size());
  e.rms = std::sqrt(e.rms), e.p95 = d[d.size() * 95 / 100], e.max = d.back();
  return e;
}

void modes(Result& out, const Scene& s, const HeadSettings& settings, Workers& w) {
  FaceModel truth(s.head.face, w);
  s.tie(truth, "front", s.front, 3, FaceMode::finite_elements);
  truth.follow(s.advanced);
  for (int i = 0; i < 100 && !truth.at_rest(); ++i) truth.step(80);
  const std::vector<Vec3> X = truth.face().x_mm;
  const Error still = against(s.head.face, X, s.front);
  out.notes.push_back(text("Truth: the mandible 8 mm forwards moves the region of %zu vertices by %.2f mm rms, %.2f mm at most.", s.front.size(), still.rms, still.max));
  for (FaceMode mode : {FaceMode::finite_elements, FaceMode::shape, FaceMode::springs}) {
    if (settings.progress) settings.progress(name_of(mode));
    FaceModel f(s.head.face, w);
    s.tie(f, "front", s.front, 3, mode);
    f.follow(s.advanced);
    double ms = 0;
    Error e, best{1e300, 0, 0};
    int done = 0;
    for (int target : {8, 20, 40, 80, 160, 320, 640, 1280, 2560}) {
      if (settings.quick && target > 320) break;
      const double t0 = cpu_ms();
      while (done < target && !f.at_rest()) {
        f.step(std::min(20, target - done));
        done += std::min(20, target - done);
      }
      ms += cpu_ms() - t0;
      e = against(f.face(), X, s.front);
      if (e.rms < best.rms) best = e;
      Row r;
      r.name = text("mandible 8 mm, %d iterations", target), r.method = name_of(mode);
      r.time_ms = ms, r.error = e.rms, r.error_unit = "mm rms", r.reference = "finite elements at equilibrium";
      r.settings = text("p95 %.2f, max %.2f mm%s", e.p95, e.max, f.at_rest() ? "; at rest" : "");
      out.rows.push_back(r);
      if (f.at_rest()) break;
    }
    out.bars.push_back({text("%s: distance from the finite elements when it ends (mm rms)", name_of(mode)), e.rms, false, 1, false, e.rms <= 1, "issue 7: the aim is 1 mm"});
    out.notes.push_back(text("%s: ends at %.2f mm rms, %.2f p95, %.2f max; best on the way %.2f rms.", name_of(mode), e.rms, e.p95, e.max, best.rms));
  }
}

void update(Result& out, const Scene& s, const HeadSettings& settings, Workers& w) {
  for (FaceMode mode : {FaceMode::finite_elements, FaceMode::shape}) {
    if (settings.progress) settings.progress(std::string("updates, ") + name_of(mode));
    FaceModel f(s.head.face, w);
    s.tie(f, "front", s.front, 3, mode);
    try {
      s.tie(f, "scalp", s.scalp, 4, mode);
    } catch (const InputError& e) {
      out.notes.push_back(std::string("Without the scalp: ") + e.what());
    }
    size_t tissue = 0;
    for (const Tissue* t : f.tissues()) tissue += size_t(t->vertices());
    Mesh now = s.bones;
    const int frames = settings.quick ? 5 : 20;
    double ms = 0, worst = 0;
    for (int i = 1; i <= frames; ++i) {
      const double t = 8. * i / frames / 8;
      for (size_t v = 0; v < now.x_mm.size(); ++v) now.x_mm[v] = (1 - t) * s.bones.x_mm[v] + t * s.advanced.x_mm[v];
      const double t0 = cpu_ms();
      f.follow(now), f.step(8);
      const double d = cpu_ms() - t0;
      if (i > 1) ms += d / (frames - 1), worst = std::max(worst, d);
    }
    Row r;
    r.name = "an update while a fragment moves", r.method = name_of(mode), r.time_ms = ms, r.error = worst, r.error_unit = "ms, the slowest";
    r.settings = text("face %d, tissue %zu, bones %d vertices; follow and 8 iterations, one core", f.face().vertices(), tissue, now.vertices());
    out.rows.push_back(r);
    out.bars.push_back({text("%s: an update at %zu vertices of tissue (ms, one core)", name_of(mode), tissue), ms, false, 33, false, ms <= 33, "30 updates a second"});
  }
}

}  // namespace

Result head_suite(const HeadSettings& settings) {
  Result out;
  InlineWorkers w;
  if (settings.progress) settings.progress("head");
  const double t0 = cpu_ms();
  const Scene s(w);
  Row r;
  r.name = "synthetic head", r.method = "limberg", r.time_ms = cpu_ms() - t0, r.error = s.head.cranium_report.face_rms_mm, r.error_unit = "mm rms";
  r.settings = text("cranium %d, mandible %d, face %d vertices; distance of face centres", s.head.cranium.vertices(), s.head.mandible.vertices(), s.head.face.vertices());
  out.rows.push_back(r);
  modes(out, s, settings, w);
  update(out, s, settings, w);
  return out;
}

}  // namespace limberg::bench
