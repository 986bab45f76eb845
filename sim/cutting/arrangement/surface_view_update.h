#pragma once
// The parts that surface_view.cpp is put together from.
#include <stdexcept>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

/// How sided faces stand in the view: those on the positive side in the order 0, 2, 1 of their corners (seen from
/// outside the material the stored order runs clockwise).
class ViewReader {
 public:
  ViewReader(const ArrangementStore& s, const Arrangement& a) : s_(s), a_(a) {}

  static bool turned(int32_t sided) { return sided % 2 == 0; }
  static int corner_in_view(int32_t sided, int corner) { return turned(sided) && corner > 0 ? 3 - corner : corner; }
  /// Edge k runs from corner k to the next of the face; in the view from its corner of this number to the next.
  static int edge_in_view(int32_t sided, int edge) { return turned(sided) ? 2 - edge : edge; }
  template <class T>
  static std::array<T, 3> in_view(int32_t sided, std::array<T, 3> of_corner) {
    if (turned(sided)) std::swap(of_corner[1], of_corner[2]);
    return of_corner;
  }

  FaceKind kind(int32_t orig) const { return a_.kind_of_orig(orig); }
  int32_t origin(int32_t orig) const { return s_.orig[orig].op == 0 ? orig : s_.orig[orig].op; }
  std::array<Eigen::Vector2f, 3> uv(const Face& face) const;
  uint8_t rim(int32_t sided) const;

  /// Visits all corners (3 * sided face + corner) of an orbit: turns around the point through mates until back at the
  /// start; the surface is closed, so it ends.
  template <class Visit>
  void orbit(int32_t corner, Visit&& visit) const {
    const int32_t point = s_.face[corner / 6].v[size_t(corner % 3)];
    int32_t at = corner;
    int out = corner % 3;  // the edge through which the current face is left
    do {
      visit(at);
      const int32_t m = s_.mate[at / 6][size_t(at % 6 - at % 3 + out)];
      const Face& f = s_.face[m / 6];
      const int k = m % 3;
      const int c = f.v[size_t(k)] == point ? k : (k + 1) % 3;
      out = c == k ? (k + 2) % 3 : c;
      at = m - k + c;
    } while (at != corner);
  }

 private:
  const ArrangementStore& s_;
  const Arrangement& a_;
};

/// The view that follows `before` after cuts, at the cost of what they have changed (surface_view_update.cpp). False
/// when more has gone than come: then numbers would be left without an owner.
bool follow_view(const ArrangementStore& s, const Arrangement& a, const SurfaceView& before, int32_t operations_then,
                 SurfaceView& view, ViewChange& change);

}  // namespace limberg
