#include "tests/bench/fuzz/readers.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#include "app/operating_point/cpu_clock.h"
#include "app/program/temporary_folder.h"
#include "sim/base/error.h"
#include "tests/bench/fuzz/random.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIMBERG_SANITIZED 1  // their shadow memory is not to be limited
#endif

namespace limberg::bench {

std::string fault_of_refusal(const std::string& what, const std::string& file) {
  constexpr size_t kLongestReason = 3000;
  if (what.size() > kLongestReason) return "refused with a reason of " + std::to_string(what.size()) + " bytes";
  if (what.find(file) == std::string::npos) return "refused without the file's name: " + what;
  const size_t after = what.find(": ", what.find(file));
  if (after == std::string::npos || what.size() < after + 12) return "refused without a reason: " + what;
  return "";
}

namespace {

namespace fs = std::filesystem;
using fuzz::Random;
constexpr int64_t kSlice = 2000;  // cases of one child

/// What a child tells its parent; after a crash too.
struct Told {
  volatile int64_t at;  // the case that is under way
  int64_t taken, refused, violations;
  double slowest_ms, cpu_ms;
  int64_t first;  // case of the first violation
  char what[400];
};

bool numeric(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+'; }

/// A number of a text becomes an absurd one.
void absurd_number(std::string& s, Random& r) {
  constexpr const char* kAbsurd[] = {
      "0",          "-1", "1e308",  "-1e308", "nan",  "inf", "4294967296", "99999999999999999999",
      "2147483648", "",   "1e-320", "65536",  "0x10", "true"};
  const size_t from = size_t(r.next() % s.size());
  size_t at = from;
  while (at < s.size() && !numeric(s[at])) ++at;
  if (at == s.size()) return;
  size_t end = at;
  while (end < s.size() && numeric(s[end])) ++end;
  s.replace(at, end - at, kAbsurd[r.below(int(std::size(kAbsurd)))]);
}

/// One to four hits, half of them in the first 400 bytes, where headers are.
std::string damaged(std::string s, Random& r) {
  for (int n = 1 + r.below(4); n-- > 0 && !s.empty();) {
    const size_t reach = r.one_in(2) ? std::min<size_t>(s.size(), 400) : s.size(), at = size_t(r.next() % reach);
    const size_t some = 1 + size_t(r.below(12));
    switch (r.below(11)) {
      case 0:
        s[at] = char(r.next());
        break;
      case 1:
        s[at] = char(s[at] ^ 1 << r.below(8));
        break;
      case 2:
        s.erase(at, some);
        break;
      case 3:
        s.insert(at, std::string(some, char(r.next())));
        break;
      case 4:
        s.resize(at);
        break;
      case 5:  // a length or a count: 16 GB and more
        for (size_t k = at; k < std::min(s.size(), at + 4); ++k) s[k] = char(0xff);
        break;
      case 6:
        for (size_t k = at; k < std::min(s.size(), at + 4); ++k) s[k] = k + 1 == at + 4 ? char(0x7f) : char(0);
        break;
      case 7: {  // a stretch twice, or elsewhere
        const std::string part = s.substr(at, 4 * some);
        s.insert(size_t(r.next() % s.size()), part);
        break;
      }
      case 8: {  // a line less, or twice
        const size_t end = std::min(s.size(), s.find('\n', at)), begin = at == 0 ? 0 : s.rfind('\n', at - 1) + 1;
        if (r.one_in(2))
          s.erase(begin, end - begin + 1);
        else
          s.insert(begin, s.substr(begin, end - begin + 1));
        break;
      }
      default:
        absurd_number(s, r);
    }
  }
  return s;
}

void write(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

/// The damage of a case, put into the folder of its sound files. Returns what is to be opened.
class Hit {
 public:
  Hit(const Reader& reader, const fs::path& dir, uint64_t seed, int64_t number) : dir_(dir) {
    Random mix{seed * 0x100000001b3ull + uint64_t(number)};
    Random r{mix.next()};
    const size_t variant = size_t(number) % reader.sound.size();
    sound_ = &reader.sound[variant];
    dir_ /= std::to_string(variant);
    which_ = size_t(r.below(int(sound_->file.size())));
    const fs::path path = dir_ / sound_->file[which_].first;
    const bool several = sound_->open.empty();
    if (several && r.one_in(8)) {  // a slice is missing, is there twice, or is one of another series
      const int how = r.below(3);
      const SoundFiles& other = reader.sound[size_t(r.below(int(reader.sound.size())))];
      content_ = how == 0   ? ""
                 : how == 1 ? sound_->file[(which_ + 1) % sound_->file.size()].second
                            : other.file[size_t(r.below(int(other.file.size())))].second;
      if (how == 0)
        fs::remove(path);
      else
        write(path, content_);
    } else {
      content_ = damaged(sound_->file[which_].second, r);
      write(path, content_);
    }
    open_ = several ? dir_ : dir_ / sound_->open;
  }
  ~Hit() { write(dir_ / sound_->file[which_].first, sound_->file[which_].second); }
  Hit(const Hit&) = delete;
  const fs::path& open() const { return open_; }
  const std::string& content() const { return content_; }
  const std::string& name() const { return sound_->file[which_].first; }

 private:
  const SoundFiles* sound_;
  fs::path dir_, open_;
  size_t which_ = 0;
  std::string content_;
};

void violated(Told& told, int64_t number, const std::string& what) {
  if (told.violations++ > 0) return;
  told.first = number;
  told.what[what.copy(told.what, sizeof told.what - 1)] = 0;
}

void limit_memory(int64_t most_bytes) {
#ifndef LIMBERG_SANITIZED
  std::ifstream in("/proc/self/statm");
  int64_t pages = 0;
  if (!(in >> pages)) return;
  const rlim_t most = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + rlim_t(most_bytes);
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
#else
  (void)most_bytes;
#endif
}

[[noreturn]] void child(const Reader& reader, const fs::path& dir, const ReadersFuzzSettings& s, uint64_t seed,
                        int64_t from, int64_t to, Told& told) {
  limit_memory(s.most_bytes);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  std::signal(SIGVTALRM, SIG_DFL);
  for (int64_t n = from; n < to; ++n) {
    told.at = n;
    const itimerval patience{{0, 0}, {s.most_s, 0}};
    setitimer(ITIMER_VIRTUAL, &patience, nullptr);
    const double begin = cpu_ms();
    std::string fault;
    bool taken = false;
    {
      const Hit hit(reader, dir, seed, n);
      try {
        fault = reader.read(hit.open().string());
        taken = true;
      } catch (const InputError& e) {
        fault = fault_of_refusal(e.what(), dir.string());
      } catch (const std::bad_alloc&) {
        fault = "memory: asked for more than " + std::to_string(s.most_bytes >> 20) + " MB for a file of " +
                std::to_string(hit.content().size()) + " bytes";
      } catch (const std::exception& e) {
        fault = std::string("threw what is no InputError: ") + e.what();
      }
    }
    const double ms = cpu_ms() - begin;
    told.slowest_ms = std::max(told.slowest_ms, ms), told.cpu_ms += ms;
    ++(taken ? told.taken : told.refused);
    if (!fault.empty()) violated(told, n, fault);
  }
  told.at = to;
  _exit(0);
}

struct Shared {
  Told* told;
  Shared()
      : told(static_cast<Told*>(
            mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (told == MAP_FAILED) throw InputError("", 0, "no memory to share with a child process");
  }
  ~Shared() { munmap(told, sizeof(Told)); }
  Shared(const Shared&) = delete;
};

}  // namespace

int64_t ReadersFuzzReport::cases() const {
  int64_t n = 0;
  for (const Family& f : family) n += f.cases;
  return n;
}

int64_t ReadersFuzzReport::violations() const {
  int64_t n = 0;
  for (const Family& f : family) n += f.violations;
  return n;
}

ReadersFuzzReport readers_fuzz(const ReadersFuzzSettings& s, const std::vector<Reader>& readers) {
  ReadersFuzzReport report;
  report.seed = s.seed;
  const TemporaryFolder folder;
  const Shared shared;
  for (size_t k = 0; k < readers.size(); ++k) {
    const Reader& reader = readers[k];
    const uint64_t seed = s.seed * 0x9e3779b97f4a7c15ull + k;
    report.family.push_back({});
    ReadersFuzzReport::Family& f = report.family.back();
    f.name = reader.name;
    f.cases =
        std::max<int64_t>(1, s.cases / int64_t(readers.size()) + (int64_t(k) < s.cases % int64_t(readers.size())));
    const fs::path dir = folder.path() / std::to_string(k);
    for (size_t v = 0; v < reader.sound.size(); ++v) {
      fs::create_directories(dir / std::to_string(v));
      for (const auto& [name, content] : reader.sound[v].file) write(dir / std::to_string(v) / name, content);
    }
    const auto keep = [&](int64_t number, const std::string& what) {
      std::string line = reader.name + ", case " + std::to_string(number) + ": " + what;
      if (!s.out_dir.empty()) {
        fs::create_directories(s.out_dir);
        const Hit hit(reader, dir, seed, number);
        const fs::path file = fs::path(s.out_dir) / (reader.name + "-" + std::to_string(number) + "-" + hit.name());
        write(file, hit.content());
        line += "; kept as " + file.string();
      }
      if (report.violation.size() < 20) report.violation.push_back(line);
      if (s.progress) s.progress("violation: " + line);
    };
    for (int64_t from = 0; from < f.cases;) {
      const int64_t to = std::min(f.cases, from + kSlice);
      Told& told = *shared.told;
      std::memset(static_cast<void*>(&told), 0, sizeof told);
      told.at = from;
      const pid_t pid = fork();
      if (pid < 0) throw InputError("", 0, "no child process could be started");
      if (pid == 0) child(reader, dir, s, seed, from, to, told);
      int status = 0;
      while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
      }
      f.taken += told.taken, f.refused += told.refused, f.violations += told.violations, f.cpu_ms += told.cpu_ms;
      f.slowest_ms = std::max(f.slowest_ms, told.slowest_ms);
      if (told.violations > 0) keep(told.first, told.what);
      from = told.at;
      if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        ++f.violations;
        const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
        keep(from, signal == SIGVTALRM ? "time: more than " + std::to_string(s.most_s) + " s of CPU time"
                   : signal            ? "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")"
                                       : "the process ended by itself");
        for (size_t v = 0; v < reader.sound.size(); ++v)  // (the child could not)
          for (const auto& [name, content] : reader.sound[v].file) write(dir / std::to_string(v) / name, content);
        ++from;
      }
      if (s.progress)
        s.progress(reader.name + ", " + std::to_string(report.cases() - f.cases + from) + " of " +
                   std::to_string(s.cases) + " cases, " + std::to_string(report.violations()) + " violations");
    }
  }
  return report;
}

Result ReadersFuzzReport::result() const {
  Result out;
  for (const Family& f : family) {
    Row r;
    r.name = f.name;
    r.method = "damaged files";
    const std::string b = fmt::format(", slowest {:.1f} ms, seed ", f.slowest_ms);
    r.settings = std::to_string(f.cases) + " cases, " + std::to_string(f.taken) + " taken, " +
                 std::to_string(f.refused) + " refused" + b + std::to_string(seed);
    r.time_ms = f.cpu_ms;
    r.error = double(f.violations);
    r.error_unit = "violations";
    r.reference = "refused with file and reason, or sound";
    r.pass = f.violations == 0;
    out.rows.push_back(r);
  }
  out.bars.push_back(
      {"violations", double(violations()), false, 0, false, violations() == 0,
       "no damaged file may crash, hang, take memory that its header claims, or be refused without file and reason"});
  for (const std::string& v : violation) out.notes.push_back("violation: " + v);
  return out;
}

}  // namespace limberg::bench
