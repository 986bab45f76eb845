#include "sim/fem/preconditioner/cholesky.h"

#include <metis.h>

#include <new>
#include <stdexcept>
#include <type_traits>

#include "sim/fem/preconditioner/cholmod_view.h"

namespace limberg::fem {

namespace {

// What CHOLMOD has asked for goes back, also when there is no memory for what is read from it.
struct Analysis {
  cholmod_common common;
  cholmod_factor* L = nullptr;
  Analysis() { cholmod_start(&common); }
  ~Analysis() { cholmod_free_factor(&L, &common), cholmod_finish(&common); }
  Analysis(const Analysis&) = delete;
  Analysis& operator=(const Analysis&) = delete;
};

}  // namespace

// METIS is asked here and not by CHOLMOD, which takes for an order whatever METIS leaves when memory fails in it.
std::vector<int32_t> nested_dissection(const ScalarMatrix& A, Workers& workers) {
  static_assert(std::is_same_v<idx_t, int32_t>);
  int32_t n = A.n();
  std::vector<int32_t> first(size_t(n) + 1, 0), order(static_cast<size_t>(n)), place(static_cast<size_t>(n));
  for (int32_t j = 0; j < n; ++j)
    for (int32_t k = A.begin[size_t(j)] + 1; k < A.begin[size_t(j) + 1]; ++k)  // (the diagonal comes first)
      ++first[size_t(j) + 1], ++first[size_t(A.row[size_t(k)]) + 1];
  for (size_t j = 0; j < size_t(n); ++j) first[j + 1] += first[j];
  if (first.back() == 0) {  // METIS wants an edge
    for (int32_t j = 0; j < n; ++j) order[size_t(j)] = j;
    return order;
  }
  std::vector<int32_t> next(first.begin(), first.end() - 1), neighbour(size_t(first.back()));
  for (int32_t j = 0; j < n; ++j)  // each node's neighbours in ascending order
    for (int32_t k = A.begin[size_t(j)] + 1; k < A.begin[size_t(j) + 1]; ++k) {
      const int32_t i = A.row[size_t(k)];
      neighbour[size_t(next[size_t(j)]++)] = i, neighbour[size_t(next[size_t(i)]++)] = j;
    }
  int status = METIS_OK;
  workers.alone([&] {  // its random numbers are the process's rand(), which it seeds at its beginning
    status = METIS_NodeND(&n, first.data(), neighbour.data(), nullptr, nullptr, order.data(), place.data());
  });
  if (status == METIS_ERROR_MEMORY) throw std::bad_alloc();
  if (status != METIS_OK) throw std::runtime_error("the order of elimination could not be found");
  return order;
}

SupernodalShape analyze(const ScalarMatrix& A, std::span<const int32_t> order) {
  if (order.size() != size_t(A.n())) throw std::invalid_argument("the order of elimination has not one entry per row");
  std::vector<int32_t> given(order.begin(), order.end());
  Analysis analysis;
  cholmod_common& common = analysis.common;
  common.print = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  cholmod_sparse S = cholmod_view(A);
  const cholmod_factor* L = analysis.L = cholmod_analyze_p(&S, given.data(), nullptr, 0, &common);
  SupernodalShape shape;
  const bool ok = L && common.status == CHOLMOD_OK && L->is_super;
  if (ok) {
    const auto list = [](const void* p, size_t count) {
      const int32_t* first = static_cast<const int32_t*>(p);
      return std::vector<int32_t>(first, first + count);
    };
    shape.order = list(L->Perm, size_t(A.n()));
    shape.super = list(L->super, L->nsuper + 1), shape.rows_begin = list(L->pi, L->nsuper + 1);
    shape.rows = list(L->s, size_t(shape.rows_begin.back()));
  }
  if (!ok && common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (!ok) throw std::runtime_error("the scalar stiffness matrix could not be analysed");
  return shape;
}

ScalarFactor factorize(const ScalarMatrix& A, std::span<const int32_t> order) {
  ScalarFactor out;
  if (A.n() == 0) return out;
  const SupernodalShape shape = analyze(A, order);
  const SupernodalFactor L = factorize(A, shape, default_kernels());
  SupernodalView view;
  view.n = A.n(), view.supernodes = shape.supernodes();
  view.super = shape.super.data(), view.rows_begin = shape.rows_begin.data(), view.rows = shape.rows.data();
  view.values_begin = L.begin.data(), view.values = L.values.data();
  out.panels = PanelFactor(view);
  out.node_order.resize(size_t(A.n()));
  for (size_t k = 0; k < out.node_order.size(); ++k) out.node_order[k] = A.node_of_row[size_t(shape.order[k])];
  return out;
}

}  // namespace limberg::fem
