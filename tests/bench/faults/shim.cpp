// A library that is loaded before a program's own (LD_PRELOAD) and does to it what a machine can do: full and slow
// disks, no memory, no threads, clocks that stand and leap, an end at any moment. LIMBERG_FAULT says what and when
// (journal.h), LIMBERG_FAULT_ARM the name of the file whose opening begins the count, LIMBERG_FAULT_JOURNAL where the
// journal is, LIMBERG_FAULT_FOLDER what folder_removed removes.
//
// It allocates nothing, and its own file work goes past itself.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/bench/faults/journal.h"

using limberg::bench::faults::Journal;
using limberg::bench::faults::Kind;

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

Journal unused;
Journal* journal = &unused;
Kind kind = Kind::none;
int64_t at = 0, more = 0;
int thread_wanted = 0;
const char* arm_name = nullptr;
const char* folder = nullptr;
std::atomic<int> threads_begun{1};  // the main thread is number 0
thread_local int me = 0;
std::atomic<int64_t> stands_at{0}, leapt{0}, failures{0};
int recording = -1;

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

int64_t real_now(clockid_t id) {
  timespec t{};
  syscall(SYS_clock_gettime, id, &t);
  return int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

void sleep_ms(int64_t ms) {
  const timespec t{time_t(ms / 1000), long(ms % 1000 * 1'000'000)};
  syscall(SYS_nanosleep, &t, nullptr);
}

bool armed() { return journal->armed.load(std::memory_order_relaxed) != 0; }

void note_injection() {
  if (journal->injected.fetch_add(1) > 0) return;
  journal->readings_then = journal->readings.load();
  int64_t busiest = 0;
  for (const auto& w : journal->wakes) busiest = std::max(busiest, w.load());
  journal->wakes_then = busiest;
}

/// Whether the n-th call of its kind fails.
bool fails(Kind of, int64_t n) {
  if (kind != of || !armed() || n < at || n > at + more) return false;
  note_injection();
  return true;
}

void begin_count(const char* path) {
  if (armed() || !arm_name || !path) return;
  const size_t n = std::strlen(path), m = std::strlen(arm_name);
  if (n >= m && std::strcmp(path + n - m, arm_name) == 0) journal->armed = 1;
}

bool is_file(int fd) {
  struct stat st {};
  return fd > 2 && fstat(fd, &st) == 0 && S_ISREG(st.st_mode);
}

void remove_folder() {
  if (DIR* d = opendir(folder)) {
    while (const dirent* e = readdir(d)) unlinkat(dirfd(d), e->d_name, 0);
    closedir(d);
  }
  rmdir(folder);
}

void at_reading() {
  if (!armed()) return;
  const int64_t n = journal->readings.fetch_add(1) + 1;
  if (n != at) return;
  const auto end_by = [](int signal) {
    note_injection();
    ::signal(signal, SIG_DFL);
    raise(signal);
  };
  switch (kind) {
    case Kind::killed:
      return end_by(SIGKILL);
    case Kind::crashed:
    case Kind::plant_crash:
      return end_by(SIGSEGV);
    case Kind::aborted:
      return end_by(SIGABRT);
    case Kind::stopped:
      return note_injection(), void(raise(SIGSTOP));
    case Kind::folder_removed:
      return note_injection(), remove_folder();
    case Kind::clock_stands:
      return note_injection(), stands_at.store(real_now(CLOCK_MONOTONIC));
    case Kind::clock_leaps:
      return note_injection(), leapt.store(more * 1'000'000);
    case Kind::plant_hang:
      note_injection();
      for (;;) sleep_ms(1000);
    default:
      return;
  }
}

struct Begin {
  void* (*body)(void*);
  void* with;
};
void* begin(void* p) {
  const Begin b = *static_cast<Begin*>(p);
  std::free(p);
  me = std::min(threads_begun.fetch_add(1), Journal::kThreads - 1);
  return b.body(b.with);
}

thread_local bool exempt = false;

bool no_memory_now() {
  if (!armed() || exempt) return false;
  const int64_t n = journal->allocations[me].fetch_add(1) + 1;
  if (kind != Kind::no_memory) return false;
  const int64_t failed = failures.load();
  if (failed == 0 ? me == thread_wanted && n == at : failed <= more) {
    failures.fetch_add(1);
    note_injection();
    errno = ENOMEM;
    return true;
  }
  return false;
}

__attribute__((constructor)) void read_environment() {
  if (const char* path = std::getenv("LIMBERG_FAULT_JOURNAL")) {
    const int fd = int(syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC, 0));
    if (fd >= 0) {
      void* p = mmap(nullptr, sizeof(Journal), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
      if (p != MAP_FAILED) journal = static_cast<Journal*>(p);
      close(fd);
    }
  }
  arm_name = std::getenv("LIMBERG_FAULT_ARM");
  folder = std::getenv("LIMBERG_FAULT_FOLDER");
  if (const char* what = std::getenv("LIMBERG_FAULT")) {
    int k = 0;
    long long a = 0, m = 0;
    if (std::sscanf(what, "%d %lld %lld %d", &k, &a, &m, &thread_wanted) >= 3) kind = Kind(k), at = a, more = m;
  }
}

}  // namespace

extern "C" {

void* malloc(size_t n) { return no_memory_now() ? nullptr : __libc_malloc(n); }
void* calloc(size_t n, size_t m) { return no_memory_now() ? nullptr : __libc_calloc(n, m); }
void* realloc(void* p, size_t n) { return no_memory_now() ? nullptr : __libc_realloc(p, n); }
void* aligned_alloc(size_t a, size_t n) { return no_memory_now() ? nullptr : __libc_memalign(a, n); }
void* memalign(size_t a, size_t n) { return no_memory_now() ? nullptr : __libc_memalign(a, n); }
int posix_memalign(void** p, size_t a, size_t n) {
  if (no_memory_now()) return ENOMEM;
  *p = __libc_memalign(a, n);
  return *p ? 0 : ENOMEM;
}

// Where glibc has no memory for the destructor of a thread's own variable it ends the program, whoever asks: no fault
// that a program could survive.
int __cxa_thread_atexit_impl(void (*destroy)(void*), void* object, void* handle) {
  static const auto add = real<int (*)(void (*)(void*), void*, void*)>("__cxa_thread_atexit_impl");
  exempt = true;
  const int e = add(destroy, object, handle);
  exempt = false;
  return e;
}

int pthread_create(pthread_t* id, const pthread_attr_t* attr, void* (*body)(void*), void* with) {
  static const auto create =
      real<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
  if (fails(Kind::no_thread, journal->threads.fetch_add(armed()) + 1)) return EAGAIN;
  auto* b = static_cast<Begin*>(__libc_malloc(sizeof(Begin)));
  if (!b) return EAGAIN;
  *b = {body, with};
  const int e = create(id, attr, begin, b);
  if (e != 0) std::free(b);
  return e;
}

ssize_t write(int fd, const void* data, size_t size) {
  if (!is_file(fd) || !armed()) return syscall(SYS_write, fd, data, size);
  const int64_t n = journal->writes.fetch_add(1) + 1;
  if (fails(Kind::write_error, n)) return errno = ENOSPC, -1;
  if (size > 1 && fails(Kind::write_short, n)) size /= 2;
  if (kind == Kind::slow_disk && n >= at) note_injection(), sleep_ms(more);
  if (kind == Kind::plant_hold && fd == recording && n >= at) return note_injection(), ssize_t(size);
  return syscall(SYS_write, fd, data, size);
}

int fdatasync(int) {
  if (fails(Kind::sync_error, journal->syncs.fetch_add(armed()) + 1)) return errno = EIO, -1;
  return 0;  // a session under test is no reason to wait for the disk
}
int fsync(int fd) { return fdatasync(fd); }

static int open_any(const char* path, int flags, mode_t mode) {
  begin_count(path);
  if (fails(Kind::open_error, journal->opens.fetch_add(armed()) + 1)) return errno = EMFILE, -1;
  const int fd = int(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  const size_t n = std::strlen(path);
  if (n > 4 && std::strcmp(path + n - 4, ".lcm") == 0 && (flags & O_ACCMODE) != O_RDONLY) recording = fd;
  return fd;
}
int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_any(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_any(path, flags, mode);
}
int mkstemp(char* name) {
  static const auto make = real<int (*)(char*)>("mkstemp");
  if (fails(Kind::open_error, journal->opens.fetch_add(armed()) + 1)) return errno = EMFILE, -1;
  return make(name);
}
int mkstemp64(char* name) { return mkstemp(name); }

int rename(const char* from, const char* to) {
  if (fails(Kind::rename_error, journal->renames.fetch_add(armed()) + 1)) return errno = EACCES, -1;
  return int(syscall(SYS_rename, from, to));
}

int clock_gettime(clockid_t id, timespec* t) {
  if (id == CLOCK_MONOTONIC) at_reading();
  int64_t now = real_now(id);
  if (id == CLOCK_MONOTONIC) {
    const int64_t stood = stands_at.load(std::memory_order_relaxed);
    if (stood != 0 && now < stood + more * 1'000'000) now = stood;
    now += leapt.load(std::memory_order_relaxed);
  }
  *t = {time_t(now / 1'000'000'000), long(now % 1'000'000'000)};
  return 0;
}

int clock_nanosleep(clockid_t id, int flags, const timespec* until, timespec* rest) {
  timespec t = *until;
  if ((flags & TIMER_ABSTIME) != 0) {
    if (armed()) journal->wakes[me].fetch_add(1);
    const int64_t ns = int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec - leapt.load(std::memory_order_relaxed);
    t = {time_t(ns / 1'000'000'000), long(ns % 1'000'000'000)};
  }
  return syscall(SYS_clock_nanosleep, id, flags, &t, rest) == 0 ? 0 : errno;
}

}  // extern "C"
