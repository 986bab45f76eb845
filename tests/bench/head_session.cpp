#include <algorithm>

#include "app/operating_point/cpu_clock.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/patient/world.h"
#include "sim/skull/head/head.h"
#include "tests/bench/head_cases.h"
#include "tests/bench/head_face.h"

namespace limberg::bench {
namespace {

constexpr double kFrame_ms = 1000. / 30;  // 30 updates a second
constexpr double kAtOnce_ms = 100;        // what an act may take and still seem immediate (Miller 1968)

}  // namespace

void head_session(Result& out, const HeadModel& model, const HeadSettings& settings, Workers& w) {
  for (const TissueKind kind : {TissueKind::finite_elements, TissueKind::shape, TissueKind::springs}) {
    const char* name = kTissueKinds[size_t(kind)];
    if (settings.progress) settings.progress(std::string("session, ") + name);
    HeadParts parts;
    parts.bones = {{"cranium", model.cranium, true}, {"mandible", model.mandible, false}};
    parts.face = model.face;
    for (const auto& [n, x] : model.landmarks) parts.landmarks.push_back({n, x, n[0] >= 'a' && n[0] <= 'z'});
    const auto tie = [&](const char* what, const Vec3& at, double radius, int layers) {
      ConnectTissue t;
      t.name = what, t.face_mm = at, t.face_radius_mm = radius, t.layers = layers, t.mode = kind;
      parts.tissues.push_back(t);
    };
    tie("forehead", {0, 100, 58}, 78, 8),
        tie("jaw", landmark_of(model, "pog'"), 48, 8);  // more layers than any tissue needs: for its size
    World patient(std::move(parts), w);
    const Head& head = *patient.head();
    size_t tissue = 0;
    for (const simplex::Tissue* t : head.face_model().tissues()) tissue += size_t(t->vertices());
    const auto act = [&](const HeadCommand& c) {
      const double t0 = cpu_ms();
      const Outcome o = patient.apply(c);
      if (!o.done) throw InputError("", 0, "bench head: " + o.reason);
      return cpu_ms() - t0;
    };
    Snapshot shown;
    const auto step = [&] {
      const double t0 = cpu_ms();
      patient.step({});
      patient.fill(shown);
      return cpu_ms() - t0;
    };
    step();
    CutBone cut;
    cut.contour_mm = drawn_in_front(model.cranium, 62, 33, 19);
    const double cut_ms = act(cut) + step();
    const Vec3 middle = head.bones().fragments().back().centre_mm;
    const int32_t id = head.bones().fragments().back().id;
    const double grab_ms = act(GrabFragment{{id, middle}, 0});
    Times drag, rest;
    const int frames = settings.quick ? 20 : 90;
    for (int i = 1; i <= frames; ++i) {
      DragFragment d;
      d.to.translation_mm = {0, 8. * i / frames, 0};
      const double ms = act(d);
      drag.add(ms + step());
    }
    const double let_go_ms = act(LetGo{});
    int until = 0;
    for (; until < 600 && patient.step({}).residual > 0; ++until) rest.add(step());
    const double undo_t0 = cpu_ms();
    patient.apply(Undo{}), patient.apply(Undo{});
    const double undo_ms = cpu_ms() - undo_t0;
    const std::string size = text("face %d, tissue %zu, bones %d vertices; one core", head.face().vertices(), tissue,
                                  head.bones_now().vertices());
    const auto row = [&](const char* what, double ms, double worst, const char* unit) {
      Row r;
      r.name = what, r.method = name, r.time_ms = ms, r.error = worst, r.error_unit = unit, r.settings = size;
      out.rows.push_back(r);
    };
    row("a cut, and the step after it", cut_ms, grab_ms, "ms, the grab");
    row("a step while a fragment is carried, median", drag.percentile(0.5), drag.percentile(0.95), "ms, p95");
    if (!rest.empty()) row("a step while the face comes to rest, median", rest.percentile(0.5), double(until), "steps");
    row("taking both back", undo_ms, let_go_ms, "ms, letting go");
    out.bars.push_back(
        {text("%s: a step while a fragment is carried, p95 of %d at %zu vertices of tissue (ms, one core)", name,
              frames, tissue),
         drag.percentile(0.95), false, kFrame_ms, false, drag.percentile(0.95) <= kFrame_ms, "30 updates a second"});
    out.bars.push_back({text("%s: a cut and the step after it (ms, one core)", name), cut_ms, false, kAtOnce_ms, false,
                        cut_ms <= kAtOnce_ms, "0.1 s seems immediate (Miller 1968)"});
  }
}

}  // namespace limberg::bench
