#include "tests/app/call_counter.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cstdarg>

namespace {
thread_local uint64_t lock_calls = 0, write_calls = 0;
}

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

namespace {
template <class F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}
}  // namespace

extern "C" {
int pthread_mutex_lock(pthread_mutex_t* m) {
  static const auto real = next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  ++lock_calls;
  return real(m);
}
int pthread_cond_wait(pthread_cond_t* c, pthread_mutex_t* m) {
  static const auto real = next<int (*)(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  ++lock_calls;
  return real(c, m);
}
ssize_t write(int fd, const void* p, size_t n) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  ++write_calls;
  return real(fd, p, n);
}
ssize_t writev(int fd, const iovec* v, int n) {
  static const auto real = next<ssize_t (*)(int, const iovec*, int)>("writev");
  ++write_calls;
  return real(fd, v, n);
}
size_t fwrite(const void* p, size_t size, size_t n, FILE* f) {
  static const auto real = next<size_t (*)(const void*, size_t, size_t, FILE*)>("fwrite");
  ++write_calls;
  return real(p, size, n, f);
}
int vfprintf(FILE* f, const char* format, va_list args) {
  static const auto real = next<int (*)(FILE*, const char*, va_list)>("vfprintf");
  ++write_calls;
  return real(f, format, args);
}
int puts(const char* s) {
  static const auto real = next<int (*)(const char*)>("puts");
  ++write_calls;
  return real(s);
}
int printf(const char* format, ...) {
  ++write_calls;
  va_list args;
  va_start(args, format);
  const int n = vfprintf(stdout, format, args);
  va_end(args);
  return n;
}
}

bool limberg::call_counter::works() { return true; }
#else
bool limberg::call_counter::works() { return false; }
#endif

uint64_t limberg::call_counter::locks() { return lock_calls; }
uint64_t limberg::call_counter::writes() { return write_calls; }
