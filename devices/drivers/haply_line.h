#pragma once
// What the board of a Haply 2DIY says, and where its linkage is then (haply_2diy.cpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace haply {

constexpr uint8_t kDevice = 5;
constexpr double kRad = M_PI / 180;
constexpr double kMostTurn_deg = 30;  // of an answer that counts, from the one before
constexpr int64_t kLongAgoNs = 200'000'000;

struct Linkage {
  double a_mm = 50, b_mm = 70, apart_mm = 20;  // upper and lower bars, distance of the motors
  double x_mm = 0, y_mm = 0;                   // of the effector, from the first motor; y away from the motors
  double jacobian[2][2] = {};                  // mm per rad: dx and dy by each angle; zeros where it is stretched out

  /// False: no such linkage closes.
  bool move(double angle1_deg, double angle2_deg) {
    const double t1 = angle1_deg * kRad, t2 = angle2_deg * kRad;
    const double ax = a_mm * std::cos(t1), ay = a_mm * std::sin(t1);
    const double bx = apart_mm + a_mm * std::cos(t2), by = a_mm * std::sin(t2);
    const double dx = bx - ax, dy = by - ay, apart = std::hypot(dx, dy);
    if (!(apart > 1e-6) || apart >= 2 * b_mm) return false;
    // On the middle of the elbows' line, away from the motors.
    const double height = std::sqrt(b_mm * b_mm - apart * apart / 4);
    const double side = dx >= 0 ? 1 : -1;
    x_mm = (ax + bx) / 2 - side * height * dy / apart, y_mm = (ay + by) / 2 + side * height * dx / apart;
    const double eax = x_mm - ax, eay = y_mm - ay, ebx = x_mm - bx, eby = y_mm - by;
    const double det = eax * eby - eay * ebx, ra = eax * -ay + eay * ax,
                 rb = ebx * -by + eby * (bx - apart_mm);  // (E - A) . dA / d angle
    const bool stretched = std::abs(det) < 1e-2 * b_mm * b_mm;
    jacobian[0][0] = stretched ? 0 : eby * ra / det, jacobian[0][1] = stretched ? 0 : -eay * rb / det;
    jacobian[1][0] = stretched ? 0 : -ebx * ra / det, jacobian[1][1] = stretched ? 0 : eax * rb / det;
    return true;
  }
};

/// Answers out of the bytes of a line: the device's number, then two angles.
class Answers {
 public:
  Linkage linkage;

  /// True: an answer is whole, and can be; the linkage has moved there.
  bool take(uint8_t byte, int64_t now_ns) {
    if (n_ == 0 && byte != kDevice) return false;
    byte_[n_++] = byte;
    if (n_ < byte_.size()) return false;
    n_ = 0;
    float got[2];  // of a little-endian machine
    std::memcpy(got, byte_.data() + 1, sizeof got);
    const bool lately = known_ && now_ns - known_ns_ < kLongAgoNs;
    for (int i = 0; i < 2; ++i)
      if (!std::isfinite(got[i]) || std::abs(got[i]) > 720 || (lately && std::abs(got[i] - angle_[i]) > kMostTurn_deg))
        return resync(), false;
    Linkage moved = linkage;
    if (!moved.move(double(got[0]), double(got[1]))) return resync(), false;
    linkage = moved;
    angle_[0] = got[0], angle_[1] = got[1];
    known_ = true, known_ns_ = now_ns;
    return true;
  }

 private:
  /// The answer was none: one may begin within its bytes.
  void resync() {
    const auto from = std::find(byte_.begin() + 1, byte_.end(), kDevice);
    n_ = size_t(byte_.end() - from);
    std::copy(from, byte_.end(), byte_.begin());
  }
  std::array<uint8_t, 9> byte_{};
  size_t n_ = 0;
  bool known_ = false;
  int64_t known_ns_ = 0;
  float angle_[2] = {};
};

}  // namespace haply
