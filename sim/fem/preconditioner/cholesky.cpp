#include "sim/fem/preconditioner/cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <stdexcept>

extern "C" void openblas_set_num_threads(int) __attribute__((weak));
extern "C" void omp_set_max_active_levels(int) __attribute__((weak));  // CHOLMOD 3 has loops for four OpenMP threads

namespace limberg::fem {

void keep_single_threaded() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);  // of the calling thread
}

namespace {

/// The lower triangle as CHOLMOD sees it; shares A's arrays.
cholmod_sparse view_of(const ScalarMatrix& A) {
  cholmod_sparse S{};
  S.nrow = S.ncol = size_t(A.n());
  S.nzmax = A.row.size();
  S.p = const_cast<int32_t*>(A.begin.data());
  S.i = const_cast<int32_t*>(A.row.data());
  S.x = const_cast<double*>(A.value.data());
  S.stype = -1;
  S.itype = CHOLMOD_INT, S.xtype = CHOLMOD_REAL, S.dtype = CHOLMOD_DOUBLE;
  S.sorted = 1, S.packed = 1;
  return S;
}

}  // namespace

SupernodalShape analyze(const ScalarMatrix& A, std::span<const int32_t> order) {
  keep_single_threaded();
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = order.empty() ? CHOLMOD_METIS : CHOLMOD_GIVEN;
  common.postorder = 1;
  cholmod_sparse S = view_of(A);
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

struct DirectFactor::Impl {
  cholmod_common common;
  cholmod_factor* L = nullptr;
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;
  int32_t n = 0;
  Impl() { cholmod_start(&common), common.print = 0; }
  ~Impl() {
    for (cholmod_dense** d : {&x, &y, &e}) cholmod_free_dense(d, &common);
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }
};

DirectFactor::DirectFactor(const ScalarMatrix& A, bool supernodal) : impl_(std::make_unique<Impl>()) {
  keep_single_threaded();
  cholmod_common& c = impl_->common;
  c.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL, c.final_ll = 1, c.nmethods = 1,
  c.method[0].ordering = CHOLMOD_METIS, c.postorder = 1;
  cholmod_sparse S = view_of(A);
  impl_->n = A.n();
  impl_->L = cholmod_analyze(&S, &c);
  if (!impl_->L || !cholmod_factorize(&S, impl_->L, &c) || c.status != CHOLMOD_OK)
    throw std::runtime_error("the scalar stiffness matrix is not positive definite");
}
DirectFactor::~DirectFactor() = default;
size_t DirectFactor::numbers() const { return impl_->L->is_super ? impl_->L->xsize : impl_->L->nzmax; }

void DirectFactor::solve(std::span<double> columns) {
  Impl& m = *impl_;
  cholmod_dense b{};
  b.nrow = b.d = size_t(m.n), b.ncol = 3, b.nzmax = columns.size(), b.x = columns.data(), b.xtype = CHOLMOD_REAL,
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, m.L, &b, nullptr, &m.x, nullptr, &m.y, &m.e, &m.common);
  const double* x = static_cast<const double*>(m.x->x);
  std::copy(x, x + columns.size(), columns.begin());
}

}  // namespace limberg::fem
