#pragma once
// Counts the calling thread's allocations in this program.
#include <cstdint>

namespace limberg::malloc_counter {

bool works();      // false under a sanitizer, which has malloc for itself
uint64_t count();  // of malloc, calloc, realloc and aligned_alloc by this thread so far
uint64_t frees();  // of memory that was there, by this thread so far

}  // namespace limberg::malloc_counter
