#include "sim/testing/direct_factor.h"

#include <algorithm>
#include <stdexcept>

#include "sim/fem/preconditioner/cholmod_view.h"

extern "C" void openblas_set_num_threads(int) __attribute__((weak));
extern "C" void omp_set_max_active_levels(int) __attribute__((weak));  // CHOLMOD 3 has loops for four OpenMP threads

namespace limberg::fem {

void keep_single_threaded() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);  // of the calling thread
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
  cholmod_sparse S = cholmod_view(A);
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
