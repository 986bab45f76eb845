// Questions and answers about stiffness pass between two threads without waiting, whole and in order.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "app/session/press_line.h"

namespace limberg {
namespace test_press_buffers {

TEST(PressLine, NeitherSideWaitsAndNothingIsTorn) {
  PressLine line;
  constexpr int kQuestions = 100'000;
  int asked = 0, torn = 0, back = 0, last = -1;
  int torn_questions = 0, questions_back = 0;  // the solver thread's own
  std::thread solver([&] {
    for (int newest = 0; newest < kQuestions;) {
      const PressQuestion* q = line.asked();
      if (!q) {
        std::this_thread::yield();
        continue;
      }
      torn_questions += q->depth_mm != double(q->triangle) || q->normal.x() != double(q->triangle);
      questions_back += q->triangle < newest;
      newest = q->triangle;
      line.answer({uint64_t(newest), newest, double(newest), double(newest), 0, newest});
      ++asked;
    }
  });
  for (int i = 1; i <= kQuestions; ++i) {
    line.ask({uint64_t(i), i, {double(i), 0, 0}, Vec3(i, 0, 0), 1, double(i)});
    const PressAnswer& a = line.newest();
    torn += a.triangle > 0 && (a.stiffness_N_mm != double(a.triangle) || a.iterations != a.triangle);
    back += a.triangle < last;
    last = std::max(last, a.triangle);
    if (i % 64 == 0) std::this_thread::yield();
  }
  solver.join();
  EXPECT_EQ(torn + torn_questions, 0);
  EXPECT_EQ(back + questions_back, 0);
  EXPECT_GT(asked, 0);
  EXPECT_EQ(line.newest().triangle, kQuestions);
}

}  // namespace test_press_buffers
}  // namespace limberg
