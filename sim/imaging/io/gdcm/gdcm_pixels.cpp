// The part limberg-gdcm.so: compressed pixels by GDCM.
//
// GDCM and the libraries below it end the whole program on some damaged files (28 of 250 with bytes of JPEG 2000
// changed at random, by an assertion; GDCM 3.0.21, 2026-11-27). So each file is unpacked in a child process, which may
// end as it likes, with limits on its time and memory; what it made comes back in memory that both share.
#include <fcntl.h>
#include <gdcmImage.h>
#include <gdcmImageReader.h>
#include <gdcmTrace.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIMBERG_SANITIZED 1  // their shadow memory is not to be limited
#endif

namespace {

constexpr rlim_t kSeconds = 20;              // of CPU time, and one more for each MB of pixels
constexpr rlim_t kMemory = rlim_t(1) << 30;  // beside what the program has, and ten times the pixels

constexpr size_t kReason = 512;

/// Pixels of a file into `pixels`; returns what is wrong, or nothing.
std::string unpack(const std::string& file, size_t bytes, char* pixels) {
  try {
    // What is wrong is said by the caller, once, and not on the terminal.
    gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();
    gdcm::ImageReader reader;
    reader.SetFileName(file.c_str());
    if (!reader.Read()) return "its compressed pixels cannot be read by GDCM; the file may be damaged";
    const gdcm::Image& image = reader.GetImage();
    if (image.GetBufferLength() != bytes)
      return "its compressed pixels come to " + std::to_string(image.GetBufferLength()) + " bytes; " +
             std::to_string(bytes) + " were expected";
    if (!image.GetBuffer(pixels)) return "its compressed pixels cannot be unpacked by GDCM; the file may be damaged";
    return "";
  } catch (const std::exception& e) {
    return std::string("its compressed pixels cannot be unpacked by GDCM (") + e.what() + "); the file may be damaged";
  }
}

void limit(int what, rlim_t most) {
  const rlimit l{most, most};
  setrlimit(decltype(RLIMIT_CPU)(what), &l);
}

rlim_t seconds(size_t bytes) { return kSeconds + (bytes >> 20); }

void limit_child(size_t bytes) {
  limit(RLIMIT_CORE, 0), limit(RLIMIT_CPU, seconds(bytes));
#ifndef LIMBERG_SANITIZED
  unsigned long pages = 0;
  if (FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%lu", &pages) == 1)
      limit(RLIMIT_AS, pages * rlim_t(sysconf(_SC_PAGESIZE)) + kMemory + 10 * bytes);
    std::fclose(f);
  }
#else
  (void)bytes;
#endif
  for (const int s : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTERM, SIGINT, SIGXCPU}) signal(s, SIG_DFL);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);  // (assertions speak)
  if (nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
}

}  // namespace

/// What dicom_pixels.cpp asks for (UnpackPixels there). Nothing is thrown across the border of the part.
extern "C" __attribute__((visibility("default"))) void limberg_gdcm_pixels(const std::string& file, size_t bytes,
                                                                           std::string& out, std::string& why) {
  // A byte that says that it is done, then the reason, then the pixels.
  void* const map = mmap(nullptr, 1 + kReason + bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (map == MAP_FAILED) {
    why = "there is no memory to unpack its compressed pixels";
    return;
  }
  char* const shared = static_cast<char*>(map);
  const pid_t child = fork();
  if (child == 0) {
    limit_child(bytes);
    const std::string wrong = unpack(file, bytes, shared + 1 + kReason);
    std::strncpy(shared + 1, wrong.c_str(), kReason - 1);
    shared[0] = 1;
    _exit(0);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (child < 0)
    why = std::string("no child process can be started to unpack its compressed pixels (") + std::strerror(errno) + ")";
  else if (shared[0] != 1)
    why = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)
              ? "its compressed pixels take GDCM more than " + std::to_string(seconds(bytes)) +
                    " s or too much memory; the file may be damaged"
              : std::string("GDCM fails on its compressed pixels; the file is damaged");
  else if (shared[1] != 0)
    why = shared + 1;
  else
    out.assign(shared + 1 + kReason, bytes);
  munmap(map, 1 + kReason + bytes);
}
