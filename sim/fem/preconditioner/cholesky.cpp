#include "sim/fem/preconditioner/cholesky.h"

#include <algorithm>
#include <new>
#include <stdexcept>

#include "sim/fem/preconditioner/cholmod_view.h"

namespace limberg::fem {

SupernodalShape analyze(const ScalarMatrix& A, std::span<const int32_t> order) {
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = order.empty() ? CHOLMOD_METIS : CHOLMOD_GIVEN;
  common.postorder = 1;
  cholmod_sparse S = cholmod_view(A);
  std::vector<int32_t> given(order.begin(), order.end());
  cholmod_factor* L =
      order.empty() ? cholmod_analyze(&S, &common) : cholmod_analyze_p(&S, given.data(), nullptr, 0, &common);
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
  const bool no_memory = common.status == CHOLMOD_OUT_OF_MEMORY;
  cholmod_free_factor(&L, &common);
  cholmod_finish(&common);
  if (!ok && no_memory) throw std::bad_alloc();
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
