#include "sim/fem/solver/engine.h"

#include <atomic>
#include <cmath>
#include <cstdlib>

#include "sim/base/error.h"

namespace limberg::fem {

namespace plain {
extern const Kernels kernels;
}
#ifdef LIMBERG_X86_KERNELS
namespace avx2 {
extern const Kernels kernels;
}
namespace avx512 {
extern const Kernels kernels;
}
#endif

namespace {

constexpr size_t nodes_per_block = 128;  // as in kernels/vectors.cpp
constexpr size_t blocks_per_chunk = 32;  // 4096 nodes

size_t blocks(size_t nodes) { return (nodes + nodes_per_block - 1) / nodes_per_block; }

}  // namespace

std::vector<const Kernels*> available_kernels() {
  std::vector<const Kernels*> list{&plain::kernels};
#ifdef LIMBERG_X86_KERNELS
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) list.push_back(&avx2::kernels);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
    list.push_back(&avx512::kernels);
#endif
  return list;
}

const Kernels* find_kernels(const std::string& name) {
  for (const Kernels* k : available_kernels())
    if (name == k->name) return k;
  return nullptr;
}

const Kernels& default_kernels() {
  static const Kernels& chosen = []() -> const Kernels& {
    const char* wanted = std::getenv("LIMBERG_SIMD");
    if (!wanted || !*wanted) return *available_kernels().back();
    const Kernels* k = find_kernels(wanted);
    const std::string name = wanted;
    if (!k && name != "plain" && name != "avx2" && name != "avx512")
      throw InputError("", 0, "LIMBERG_SIMD or --simd is '" + name + "'; expected plain, avx2 or avx512");
    if (!k)
      throw InputError(
          "", 0,
          "this machine does not have the instructions of '" + name + "'; it has " + available_kernels().back()->name);
    return *k;
  }();
  return chosen;
}

template <class Body>
double Engine::sum_blocks(size_t nodes, const Body& body) const {
  const size_t n = blocks(nodes);
  if (sums_.size() < n) sums_.resize(n);
  run(n, blocks_per_chunk, [&](size_t first, size_t last) { body(first, last, sums_.data()); });
  double total = 0;
  for (size_t i = 0; i < n; ++i) total += sums_[i];
  return total;
}

double Engine::dot(const NodeArray& a, const NodeArray& b) const {
  return sum_blocks(a.size(), [&](size_t first, size_t last, double* s) {
    kernels_.dot(a.data(), b.data(), a.size(), first, last, s);
  });
}

void Engine::add_scaled(NodeArray& y, double s, const NodeArray& x) const {
  run(blocks(y.size()), blocks_per_chunk,
      [&](size_t first, size_t last) { kernels_.add_scaled(y.data(), float(s), x.data(), y.size(), first, last); });
}

double Engine::add_scaled_dot(NodeArray& y, double s, const NodeArray& x, const NodeArray& z) const {
  return sum_blocks(y.size(), [&](size_t first, size_t last, double* sums) {
    kernels_.add_scaled_dot(y.data(), float(s), x.data(), z.data(), y.size(), first, last, sums);
  });
}

void Engine::combine(NodeArray& out, const NodeArray& a, double s, const NodeArray& b) const {
  run(blocks(out.size()), blocks_per_chunk, [&](size_t first, size_t last) {
    kernels_.combine(out.data(), a.data(), float(s), b.data(), out.size(), first, last);
  });
}

void Engine::subtract(NodeArray& out, const NodeArray& a, const NodeArray& b) const {
  run(blocks(out.size()), blocks_per_chunk,
      [&](size_t first, size_t last) { kernels_.subtract(out.data(), a.data(), b.data(), out.size(), first, last); });
}

void Engine::subtract_outer(NodeArray& y, const float* const* columns, const Node4* s, int count) const {
  run(blocks(y.size()), blocks_per_chunk,
      [&](size_t first, size_t last) { kernels_.subtract_outer(y.data(), columns, s, count, y.size(), first, last); });
}

double Engine::max_node(const NodeArray& a) const {
  const size_t n = blocks(a.size());
  if (sums_.size() < n) sums_.resize(n);
  run(n, blocks_per_chunk,
      [&](size_t first, size_t last) { kernels_.max_square(a.data(), a.size(), first, last, sums_.data()); });
  double m = 0;
  for (size_t i = 0; i < n; ++i) {
    if (sums_[i] != sums_[i]) return sums_[i];
    if (sums_[i] > m) m = sums_[i];
  }
  return std::sqrt(m);
}

bool Engine::all_finite(const NodeArray& a) const {
  std::atomic<bool> finite = true;
  run(blocks(a.size()), blocks_per_chunk, [&](size_t first, size_t last) {
    if (!kernels_.all_finite(a.data(), a.size(), first, last)) finite = false;
  });
  return finite;
}

}  // namespace limberg::fem
