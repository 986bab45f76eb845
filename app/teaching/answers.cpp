#include "app/teaching/answers.h"

#include <cmath>

namespace limberg {

Answered judge_choice(const LessonQuestion& q, int number, const Words& w) {
  if (number == q.right) return {true, w("Right. {}", q.because)};
  return {false, w("Not quite: {}. {}", q.answers[size_t(q.right - 1)], q.because)};
}

Answered judge_place(const LessonQuestion& q, const ChartPoint& at, const Words& w) {
  const double far_mm = (at - *q.place).norm();
  if (far_mm <= q.within)
    return {true, w("Right, {:.0f} mm from it (the ring; {:g} mm count). {}", far_mm, q.within, q.because)};
  return {false, w("Not quite: it is {:.0f} mm from there, at the ring. {}", far_mm, q.because)};
}

Answered judge_number(const LessonQuestion& q, double value, const Words& w) {
  const std::string unit = q.unit.empty() ? "" : q.unit == "\u00b0" ? q.unit : " " + q.unit;
  const double off = std::abs(value - *q.number);
  if (off <= q.within) return {true, w("Right: {:g}{}. {}", *q.number, unit, q.because)};
  return {false, w("Not quite: {:g}{}, not {:g}. {}", *q.number, unit, value, q.because)};
}

}  // namespace limberg
