#include "sim/fem/preconditioner/supernodal.h"

#include <algorithm>
#include <stdexcept>

namespace limberg::fem {
namespace {

/// The entries of P A P^T on and below the diagonal, by columns.
struct Columns {
  std::vector<int32_t> begin, row;
  std::vector<double> value;
};

Columns permuted(const ScalarMatrix& A, const std::vector<int32_t>& order) {
  const size_t n = size_t(A.n());
  std::vector<int32_t> place(n);
  for (size_t k = 0; k < n; ++k) place[size_t(order[k])] = int32_t(k);
  Columns out;
  out.begin.assign(n + 1, 0);
  const auto for_each = [&](const auto& visit) {
    for (size_t j = 0; j < n; ++j)
      for (int32_t e = A.begin[j]; e < A.begin[j + 1]; ++e) {
        const int32_t a = place[j], b = place[size_t(A.row[size_t(e)])];
        visit(size_t(std::min(a, b)), std::max(a, b), A.value[size_t(e)]);
      }
  };
  for_each([&](size_t column, int32_t, double) { ++out.begin[column + 1]; });
  for (size_t j = 0; j < n; ++j) out.begin[j + 1] += out.begin[j];
  out.row.resize(size_t(out.begin[n])), out.value.resize(size_t(out.begin[n]));
  std::vector<int32_t> next(out.begin.begin(), out.begin.end() - 1);
  for_each([&](size_t column, int32_t row, double value) {
    const size_t at = size_t(next[column]++);
    out.row[at] = row, out.value[at] = value;
  });
  return out;
}

}  // namespace

SupernodalFactor factorize(const ScalarMatrix& A, const SupernodalShape& shape, const Kernels& kernels) {
  const size_t n = size_t(A.n()), supernodes = size_t(shape.supernodes());
  const auto rows_of = [&](size_t s) { return shape.rows.data() + shape.rows_begin[s]; };
  const auto row_count = [&](size_t s) { return shape.rows_begin[s + 1] - shape.rows_begin[s]; };
  const auto column_count = [&](size_t s) { return shape.super[s + 1] - shape.super[s]; };

  SupernodalFactor L;
  std::vector<int32_t> supernode_of(n);
  size_t most_columns = 0, most_rows = 0;
  for (size_t s = 0; s < supernodes; ++s) {
    L.begin.push_back(L.begin.empty() ? 0 : L.begin.back());
    if (s > 0) L.begin[s] += SupernodalView::leading(size_t(row_count(s - 1))) * size_t(column_count(s - 1));
    std::fill(supernode_of.begin() + shape.super[s], supernode_of.begin() + shape.super[s + 1], int32_t(s));
    most_columns = std::max(most_columns, size_t(column_count(s))),
    most_rows = std::max(most_rows, size_t(row_count(s)));
  }
  if (supernodes > 0)
    L.begin.push_back(L.begin.back() + SupernodalView::leading(size_t(row_count(supernodes - 1))) *
                                           size_t(column_count(supernodes - 1)));
  L.values.resize((L.begin.empty() ? 0 : L.begin.back()) + leading_step);  // kernels read some rows more

  const Columns entries = permuted(A, shape.order);
  const size_t update_leading = SupernodalView::leading(most_rows);
  AlignedArray<double> update(update_leading * most_columns);
  std::vector<int32_t> place(n, -1);                                // of a row in the supernode at hand
  std::vector<int32_t> head(supernodes, -1), next(supernodes, -1);  // supernodes whose next rows are columns of s
  std::vector<int32_t> done(supernodes, 0);                         // rows of a supernode that later ones have had
  for (size_t s = 0; s < supernodes; ++s) {
    const int32_t first = shape.super[s], last = shape.super[s + 1], rows = row_count(s);
    const size_t leading = SupernodalView::leading(size_t(rows));
    double* l = L.values.data() + L.begin[s];
    for (int32_t i = 0; i < rows; ++i) place[size_t(rows_of(s)[i])] = i;
    for (int32_t j = first; j < last; ++j)
      for (int32_t e = entries.begin[size_t(j)]; e < entries.begin[size_t(j) + 1]; ++e)
        l[size_t(place[size_t(entries.row[size_t(e)])]) + size_t(j - first) * leading] += entries.value[size_t(e)];

    for (int32_t d = head[s], following; d >= 0; d = following) {
      following = next[size_t(d)];
      const int32_t* list = rows_of(size_t(d)) + done[size_t(d)];
      const int32_t left = row_count(size_t(d)) - done[size_t(d)];
      const int32_t mine = int32_t(std::lower_bound(list, list + left, last) - list);
      kernels.multiply_transposed(L.values.data() + L.begin[size_t(d)] + done[size_t(d)],
                                  SupernodalView::leading(size_t(row_count(size_t(d)))), left, mine,
                                  column_count(size_t(d)), update.data(), update_leading);
      for (int32_t j = 0; j < mine; ++j) {
        double* column = l + size_t(list[j] - first) * leading;
        const double* from = update.data() + size_t(j) * update_leading;
        for (int32_t i = j; i < left; ++i) column[place[size_t(list[i])]] -= from[i];
      }
      done[size_t(d)] += mine;
      if (left > mine) {
        const size_t up = size_t(supernode_of[size_t(list[mine])]);
        next[size_t(d)] = head[up], head[up] = d;
      }
    }
    if (!kernels.factor_panel(l, leading, rows, last - first))
      throw std::runtime_error("the scalar stiffness matrix is not positive definite");
    if (rows > last - first) {
      done[s] = last - first;
      const size_t up = size_t(supernode_of[size_t(rows_of(s)[last - first])]);
      next[s] = head[up], head[up] = int32_t(s);
    }
  }
  return L;
}

}  // namespace limberg::fem
