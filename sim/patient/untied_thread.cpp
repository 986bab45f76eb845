// A thread that its hand has let go untied: what slips, and how it is taken up again (sutures.h tells the law).
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/fem/forces/spring_forces.h"
#include "sim/patient/sutures.h"
#include "sim/patient/thread_friction.h"

namespace limberg {
namespace {

constexpr double kSlips_N = 2e-3;       // a thread slips that is off by more than this, and by a hundredth
constexpr double kSlip_N_per_mm = 0.5;  // ... so far that tissue of this stiffness follows; skin is softer

}  // namespace

double Sutures::held_by_friction_N(int between) {
  return kFreeEnd_N * elementary::exp(kThreadFriction * elementary::pi * (1 + 2 * between));
}

// From the free end inwards. What a used-up span could hold is what goes through it.
void Sutures::slip(Thread& t) {
  const double k = tissue_.spec().suture_k_N_per_mm, pull_mm = tissue_.spec().suture_pull_mm_per_step;
  std::vector<Stitch*> spans;  // the last first
  for (Stitch& s : holding_.stitches)
    if (s.thread == t.id && s.across()) spans.push_back(&s);
  std::reverse(spans.begin(), spans.end());
  const auto take = [&](size_t inner, double mm) {  // out of the spans between it and the end, and out of the end
    for (size_t i = inner; i-- > 0 && mm > 0;) {
      const double some = std::min(mm, spans[i]->own_mm);
      spans[i]->own_mm -= some, mm -= some;
    }
  };
  t.closing = false;
  double outer_N = kFreeEnd_N;
  for (size_t i = 0; i < spans.size(); ++i) {
    Stitch& s = *spans[i];
    const double ratio = elementary::exp(kThreadFriction * elementary::pi * (i == 0 ? 1 : 2));
    const double tension_N = k * std::max(0.0, (tissue_.held_mm(s.a) - tissue_.held_mm(s.b)).norm() - s.own_mm);
    const double most_N = outer_N * ratio, least_N = outer_N / ratio;
    if (const double off_N = tension_N - most_N; off_N > kSlips_N + 0.01 * most_N) {
      const double mm = std::min(pull_mm, off_N / kSlip_N_per_mm);
      take(i, mm);
      s.own_mm += mm, t.closing = true;
    } else if (i > 0 && least_N - tension_N > kSlips_N + 0.01 * least_N && s.own_mm > 0) {
      const double mm = std::min({pull_mm, (least_N - tension_N) / k, s.own_mm});
      s.own_mm -= mm, spans[i - 1]->own_mm += mm, t.closing = true;
    }
    outer_N = s.own_mm > 0 ? std::min(tension_N, most_N) : most_N;
  }
}

void Sutures::take_up(Thread& t) {
  if (!t.let_go) return;
  t.let_go = false, t.closing = true, t.length_mm = 0;
  for (Stitch& s : holding_.stitches)
    if (s.thread == t.id) t.length_mm += std::exchange(s.own_mm, -1);
}

Outcome Sutures::act(const LetThreadGo&) {
  Thread* t = sewn_thread();
  if (!t) return {false, "no thread is being sewn; a bite of a running suture was expected before its end is let go"};
  if (t->let_go) return {false, "the thread has been let go already; a bite or its knot was expected"};
  std::vector<Stitch*> spans;
  std::vector<double> length_mm;  // that the thread can take from (spring_forces.h)
  double kept_mm = 0;
  for (Stitch& s : holding_.stitches) {
    if (s.thread != t->id) continue;
    spans.push_back(&s);
    kept_mm += s.slack_mm.norm();
    length_mm.push_back(std::max(0.0, (tissue_.held_mm(s.a) - tissue_.held_mm(s.b)).norm() - s.slack_mm.norm()));
  }
  std::vector<double> sorted = length_mm;
  const double stretch_mm = fem::SpringForces::thread_stretch_mm(sorted, std::max(0.0, t->length_mm - kept_mm));
  for (size_t i = 0; i < spans.size(); ++i)
    spans[i]->own_mm = spans[i]->slack_mm.norm() + std::max(0.0, length_mm[i] - stretch_mm);
  t->let_go = t->closing = true;
  return {true, "it is not tied, and the edges part again"};
}

}  // namespace limberg
