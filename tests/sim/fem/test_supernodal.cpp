// The factor's own numbers: L L^T is the matrix, from every instruction set the same bits.
#include <gtest/gtest.h>

#include <cstring>

#include "models.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/preconditioner/supernodal.h"

namespace limberg {
namespace test_supernodal {

using fem::ScalarMatrix;
using fem::SupernodalFactor;
using fem::SupernodalShape;

ScalarMatrix matrix() {
  BoxSpec b;
  b.cells = {14, 13, 4}, b.size_mm = {60, 60, 10}, b.young_bottom_kPa = 18, b.poisson = 0.45, b.fix_sides = true;
  return fem::assemble_scalar(box_model(b), {}, 0);
}

/// Entry (i, j), i >= j in elimination order, of L; 0 where it has none.
struct Dense {
  Dense(const SupernodalShape& s, const SupernodalFactor& L) : n(s.order.size()), value(n * n) {
    for (size_t k = 0; k + 1 < s.super.size(); ++k) {
      const int32_t* rows = s.rows.data() + s.rows_begin[k];
      const size_t count = size_t(s.rows_begin[k + 1] - s.rows_begin[k]);
      for (int32_t j = s.super[k]; j < s.super[k + 1]; ++j)
        for (size_t i = size_t(j - s.super[k]); i < count; ++i)
          value[size_t(rows[i]) * n + size_t(j)] =
              L.values[L.begin[k] + size_t(j - s.super[k]) * fem::SupernodalView::leading(count) + i];
    }
  }
  size_t n;
  std::vector<double> value;
};

TEST(Supernodal, IsTheFactorOfTheMatrixFromEverySet) {
  const ScalarMatrix A = matrix();
  const SupernodalShape shape = fem::analyze(A, fem::nested_dissection(A, test::engine().workers()));
  ASSERT_GT(shape.supernodes(), 20);
  SupernodalFactor first;
  for (const fem::Kernels* k : fem::available_kernels()) {
    SCOPED_TRACE(k->name);
    const SupernodalFactor L = fem::factorize(A, shape, *k);
    const Dense l(shape, L);
    std::vector<int32_t> place(l.n);
    for (size_t i = 0; i < l.n; ++i) place[size_t(shape.order[i])] = int32_t(i);
    double largest = 0, wrong = 0;
    for (int32_t j = 0; j < A.n(); ++j)
      for (int32_t e = A.begin[size_t(j)]; e < A.begin[size_t(j) + 1]; ++e) {
        const size_t a = size_t(place[size_t(j)]), b = size_t(place[size_t(A.row[size_t(e)])]);
        double sum = 0;
        for (size_t c = 0; c <= std::min(a, b); ++c) sum += l.value[a * l.n + c] * l.value[b * l.n + c];
        largest = std::max(largest, std::abs(A.value[size_t(e)]));
        wrong = std::max(wrong, std::abs(sum - A.value[size_t(e)]));
      }
    EXPECT_LT(wrong, 1e-13 * largest);  // n u = 1e-13 of the largest entry
    if (first.values.empty()) {
      first = L;
      continue;
    }
    // Lower parts only: what is above a diagonal is nobody's.
    const Dense was(shape, first);
    EXPECT_EQ(std::memcmp(was.value.data(), l.value.data(), l.value.size() * sizeof(double)), 0);
  }
}

TEST(Supernodal, AnIndefiniteMatrixIsRefusedWhateverTheSet) {
  ScalarMatrix A = matrix();
  A.value[size_t(A.begin[200])] *= -1;
  const SupernodalShape shape = fem::analyze(A, fem::nested_dissection(A, test::engine().workers()));
  for (const fem::Kernels* k : fem::available_kernels())
    EXPECT_THROW((void)fem::factorize(A, shape, *k), std::runtime_error) << k->name;
}

}  // namespace test_supernodal
}  // namespace limberg
