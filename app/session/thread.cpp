#include "app/session/thread.h"

#include <link.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace limberg {

namespace {

void* run(void* p) {
  const std::unique_ptr<std::function<void()>> body(static_cast<std::function<void()>*>(p));
  (*body)();
  return nullptr;
}

bool memory_lock_allowed() {
  rlimit lim{};
  return geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &lim) == 0 && lim.rlim_cur == RLIM_INFINITY);
}

/// What is there stays, and what is touched later stays from then on; nothing is brought in for it, such as stacks of
/// which a thread needs a hundredth. Programs and libraries are: a page of these may have to come from a disk.
bool lock_memory() {
  if (!memory_lock_allowed() || mlockall(MCL_CURRENT | MCL_ONFAULT) != 0) return false;
  dl_iterate_phdr(
      [](dl_phdr_info* object, size_t, void*) {
        const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
        for (int i = 0; i < object->dlpi_phnum; ++i) {
          const ElfW(Phdr)& part = object->dlpi_phdr[i];
          if (part.p_type != PT_LOAD || (part.p_flags & PF_W) != 0) continue;
          const uintptr_t begin = (object->dlpi_addr + part.p_vaddr) & ~(page - 1);
          const uintptr_t end = object->dlpi_addr + part.p_vaddr + part.p_memsz;
          madvise(reinterpret_cast<void*>(begin), end - begin,
                  MADV_POPULATE_READ);  // Linux 5.14: else as they are used
        }
        return 0;
      },
      nullptr);
  return true;
}

}  // namespace

ScheduledThread::ScheduledThread(std::function<void()> body) {
  pthread_attr_t attr;
  pthread_attr_init(&attr);
  const sched_param normal{};
  pthread_attr_setinheritsched(&attr, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attr, SCHED_OTHER);
  pthread_attr_setschedparam(&attr, &normal);
  auto owned = std::make_unique<std::function<void()>>(std::move(body));
  const int err = pthread_create(&id_, &attr, run, owned.get());
  pthread_attr_destroy(&attr);
  if (err != 0) throw std::system_error(err, std::generic_category(), "starting a thread");
  owned.release();
  joinable_ = true;
}

void ScheduledThread::join() {
  if (joinable_) pthread_join(id_, nullptr);
  joinable_ = false;
}

std::string request_real_time(int priority) {
  if (priority <= 0) return "device thread: ordinary scheduling, as asked";
  sched_param p{};
  p.sched_priority = priority;
  const int err = pthread_setschedparam(pthread_self(), SCHED_FIFO, &p);
  const bool locked = lock_memory();
  std::string line = "device thread: ";
  line += err == 0 ? "SCHED_FIFO " + std::to_string(priority)
                   : std::string("ordinary scheduling (") + std::strerror(err) + ")";
  line += locked ? ", memory locked" : ", memory not locked";
  if (err != 0)
    line += "; expect late ticks when the machine is busy (grant CAP_SYS_NICE or an rtprio limit)";
  else if (!locked)
    line += "; a page fault may delay a tick (raise the memlock limit)";
  return line;
}

void unlock_memory() { munlockall(); }

void be_nice(int nice) {
  // On Linux the nice value belongs to the thread, named by its kernel id.
  setpriority(PRIO_PROCESS, id_t(syscall(SYS_gettid)), nice);
}

void request_exact_timers() { prctl(PR_SET_TIMERSLACK, 1UL); }

}  // namespace limberg
