#include "app/teaching/bite_words.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

constexpr double kTears_mm = 1;   // nearer to the edge a thread cuts through
constexpr double kUneven_mm = 1;  // bites of one stitch
constexpr double kRegular = 0.5;  // of the spacing before: so much more or less is irregular

/// On the chart, at rest, where both edges of a cut lie in one place.
std::optional<double> from_edge_mm(const SurfaceTopology& t, const ChartPoint& p) {
  std::optional<double> best;
  for (size_t i = 0; i < t.view.rim.size(); ++i)
    for (size_t k = 0; t.view.rim[i] != 0 && k < 3; ++k) {
      if (!(t.view.rim[i] >> k & 1)) continue;
      const double d = distance_to_segment(p, t.to_chart(t.view.X_mm[size_t(t.view.tri[i][k])]),
                                           t.to_chart(t.view.X_mm[size_t(t.view.tri[i][(k + 1) % 3])]));
      if (!best || d < *best) best = d;
    }
  return best;
}

}  // namespace

double bites_apart_mm(const SutureBite& a, const SutureBite& b) {
  return 0.5 * std::min((a.a - b.a).norm() + (a.b - b.b).norm(), (a.a - b.b).norm() + (a.b - b.a).norm());
}

BiteWord bite_word(const Snapshot& s, int number, const SutureBite& bite, const SutureBite* before, double spacing_mm,
                   const Words& w) {
  if (!has_surface(s)) return {};
  const auto a = from_edge_mm(*s.topology, bite.a), b = from_edge_mm(*s.topology, bite.b);
  if (!a || !b) return {};
  const double on = before ? bites_apart_mm(*before, bite) : 0;
  const std::string words = before
                                ? w("Bite {}: {:.1f} and {:.1f} mm from the edges, {:.1f} mm on.", number, *a, *b, on)
                                : w("Bite {}: {:.1f} and {:.1f} mm from the edges.", number, *a, *b);
  std::string off;
  if (std::min(*a, *b) < kTears_mm)
    off = w("So near to the edge a thread cuts through: take 2 mm.");
  else if (std::abs(*a - *b) > kUneven_mm)
    off = w("Take as much on both sides, or one edge comes to lie higher.");
  else if (before && spacing_mm > 0 && std::abs(on - spacing_mm) > kRegular * spacing_mm)
    off = w("The one before was {:.1f} mm on: even bites share the pull.", spacing_mm);
  if (!off.empty()) return {words + " " + off + " " + std::string(w("Ctrl+Z takes it back.")), false};
  return {words + (number == 1 ? " " + std::string(w("Go on with the next one; Shift+0 ties the thread.")) : ""), true};
}

}  // namespace limberg
