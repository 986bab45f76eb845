#include "tests/app/malloc_counter.h"

#include <cstddef>

namespace {
thread_local uint64_t calls = 0, freed = 0;
}

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

// glibc keeps its allocator under these names; ours stands before it.
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void __libc_free(void*);
void* malloc(size_t n) { return ++calls, __libc_malloc(n); }
void* calloc(size_t n, size_t m) { return ++calls, __libc_calloc(n, m); }
void* realloc(void* p, size_t n) { return ++calls, __libc_realloc(p, n); }
void* aligned_alloc(size_t a, size_t n) { return ++calls, __libc_memalign(a, n); }
void* memalign(size_t a, size_t n) { return ++calls, __libc_memalign(a, n); }
void free(void* p) {
  freed += p != nullptr;
  __libc_free(p);
}
}

bool limberg::malloc_counter::works() { return true; }
#else
bool limberg::malloc_counter::works() { return false; }
#endif

uint64_t limberg::malloc_counter::count() { return calls; }
uint64_t limberg::malloc_counter::frees() { return freed; }
