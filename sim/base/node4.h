#pragma once
// A node's vector in 16 bytes, and four floats as one value. No templates and nothing of the standard library's: the
// kernels (fem/kernels/) are compiled for several instruction sets and may share no function with the program's rest.
#include <cstddef>
#include <cstdint>

namespace limberg {

typedef float v4 __attribute__((vector_size(16)));
typedef int32_t v4i __attribute__((vector_size(16)));

/// w is zero unless a function says what it keeps there.
struct alignas(16) Node4 {
  float x = 0, y = 0, z = 0, w = 0;
};

[[gnu::always_inline]] inline v4 load(const Node4& a) { return *reinterpret_cast<const v4*>(&a); }
[[gnu::always_inline]] inline void store(Node4& a, v4 v) { *reinterpret_cast<v4*>(&a) = v; }

}  // namespace limberg
