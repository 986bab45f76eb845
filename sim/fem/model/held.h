#pragma once
// Which components of a node's displacement are held (Dirichlet): all of them, or some axes.
//
// A node that is held along one axis slides in the plane across it, as on a roller or in a plane of symmetry. Axes are
// those of the model, so a plane that lies askew cannot be said.
#include <cstdint>

namespace limberg {

/// One bit per axis. As a bool is given, so is the node: all of it held, or nothing of it.
class Held {
 public:
  constexpr Held() = default;
  constexpr Held(bool whole) : axes_(whole ? kAll : 0) {}
  /// Bit 0: x, bit 1: y, bit 2: z; other bits count for nothing.
  static constexpr Held axes(unsigned bits) {
    Held h;
    h.axes_ = uint8_t(bits & kAll);
    return h;
  }
  static constexpr Held axis(int a) { return axes(1u << a); }

  constexpr unsigned axes() const { return axes_; }
  constexpr bool along(int axis) const { return axes_ >> axis & 1; }
  constexpr bool any() const { return axes_ != 0; }
  constexpr bool all() const { return axes_ == kAll; }
  constexpr bool some() const { return any() && !all(); }  // it slides
  constexpr explicit operator bool() const { return any(); }
  constexpr Held& operator|=(Held other) {
    axes_ |= other.axes_;
    return *this;
  }
  constexpr bool operator==(const Held&) const = default;

 private:
  static constexpr uint8_t kAll = 7;
  uint8_t axes_ = 0;
};

}  // namespace limberg
