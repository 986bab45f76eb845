#pragma once
// Counts what the calling thread may not do on a device thread:
// locks taken, bytes written to files, terminals and logs. They
// are counted on their way to the system, whoever calls them.
#include <cstdint>

namespace limberg::call_counter {

bool works();       // false under a sanitizer, which has these calls for itself
uint64_t locks();   // of this thread so far: pthread_mutex_lock, and condition variables waited for
uint64_t writes();  // write, writev, fwrite, printf and the like

}  // namespace limberg::call_counter
