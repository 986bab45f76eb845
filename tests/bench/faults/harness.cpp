#include "tests/bench/faults/harness.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <utility>

#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "devices/fastrak/port.h"
#include "devices/lcm_publisher.h"
#include "devices/monotonic.h"
#include "devices/recording.h"
#include "sim/base/whole_file.h"
#include "tests/own_port.h"

namespace limberg::bench::faults {

namespace fs = std::filesystem;

namespace {

std::string words_in(const std::string& file) {
  std::error_code ec;
  return fs::is_regular_file(file, ec) ? read_whole_file(file) : std::string();
}

/// The shared page of a child.
class MappedJournal {
 public:
  explicit MappedJournal(const std::string& file) {
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || ::ftruncate(fd, sizeof(Journal)) != 0)
      throw InputError(file, 0, "no journal can be made; expected room");
    void* p = ::mmap(nullptr, sizeof(Journal), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    ::close(fd);
    if (p == MAP_FAILED) throw InputError(file, 0, "no journal can be mapped; expected memory");
    journal_ = static_cast<Journal*>(p);
  }
  ~MappedJournal() { ::munmap(journal_, sizeof(Journal)); }
  MappedJournal(const MappedJournal&) = delete;
  MappedJournal& operator=(const MappedJournal&) = delete;
  const Journal& operator*() const { return *journal_; }
  const Journal* operator->() const { return journal_; }

 private:
  Journal* journal_ = nullptr;
};

/// What a call leaves without any fault.
struct Reference {
  std::string recording;  // its bytes
  std::string hash;
  int64_t end_tick = 0, readings = 0;  // of the session; of a clock meanwhile
};

/// The other end of a device: a FASTRAK on a pseudo-terminal behind a link that stays, or a stylus over LCM.
class ServedDevice {
 public:
  ServedDevice(Call::Device device, const Case& c, const std::string& folder)
      : case_(c), link_(folder + "/port"), port_(free_udp_port()), random_(uint64_t(c.number)) {
    if (device == Call::fastrak) line_ = std::make_unique<fastrak::EmulatedPort>(fastrak::hand_at_work(1)), lay();
    if (device == Call::lcm) stylus_ = std::make_unique<LcmPublisher>(udpm_here(port_), false);
  }
  std::string port() const { return std::to_string(port_); }
  int64_t faults() const { return faults_; }
  /// So long after the start; `at_work`: the program has begun its work.
  void serve(int64_t ns, bool at_work) {
    if (at_work && began_ns_ < 0) began_ns_ = ns;
    const int64_t ms = began_ns_ < 0 ? -1 : (ns - began_ns_) / 1'000'000;
    if (line_ && case_.kind == Kind::device_pulled && ms >= case_.at && !pulled_) {
      pulled_ = true, ++faults_;
      ::unlink(link_.c_str());
      line_->unplug();
    }
    if (line_ && pulled_ && !laid_again_ && ms >= case_.at + case_.more) laid_again_ = true, lay();
    if (stylus_ && ns - sent_ns_ > 8'000'000) sent_ns_ = ns, send(double(ns) * 1e-9);
  }

 private:
  void lay() {
    std::error_code ec;
    fs::remove(link_, ec);
    fs::create_symlink(line_->path(), link_, ec);
  }
  void send(double t) {
    StylusSample s;
    s.device_id = 3, s.seq = seq_++, s.t_ns = monotonic_ns();
    s.tip_mm = Vec3(10 * std::sin(t), 10 * std::cos(t), 6);
    const bool now = case_.more > 0 && random_() % uint64_t(case_.more) == 0;
    if (now && case_.kind == Kind::packets_lost) return void(++faults_);
    if (now && case_.kind == Kind::packets_reordered && !later_) return void((++faults_, later_ = s));
    stylus_->publish(s);
    if (now && case_.kind == Kind::packets_doubled) ++faults_, stylus_->publish(s);
    if (later_) stylus_->publish(*std::exchange(later_, std::nullopt));
  }
  const Case case_;
  const std::string link_;
  const int port_;
  std::mt19937_64 random_;
  std::unique_ptr<fastrak::EmulatedPort> line_;
  std::unique_ptr<LcmPublisher> stylus_;
  std::optional<StylusSample> later_;
  bool pulled_ = false, laid_again_ = false;
  int64_t began_ns_ = -1, sent_ns_ = 0, seq_ = 0, faults_ = 0;
};

struct Process {
  Case of;
  std::string folder;
  std::unique_ptr<MappedJournal> journal;
  std::unique_ptr<ServedDevice> device;
  pid_t pid = -1;
  int64_t began_ns = 0, stopped_ns = 0;
  bool again = false;  // the replay of what the case left
  Judgement judgement;
};

class Harness {
 public:
  explicit Harness(const Settings& s) : set_(s) {}

  std::vector<Judgement> run() {
    for (const std::string& file : {program_, shim_})
      if (!fs::exists(file)) throw InputError(file, 0, "is not there; expected ninja -C build limberg limberg_faults");
    write_patient(common());
    prepare();
    const int64_t n = set_.only.empty() ? set_.cases : int64_t(set_.only.size());
    int64_t next = 0;
    while (next < n || !running_.empty()) {
      const bool stop = set_.stop && set_.stop();
      if (stop) next = n;
      while (next < n && int(running_.size()) < set_.at_once) {
        begin(set_.only.empty() ? case_of(set_.seed, next, counts_) : scaled(set_.only[size_t(next)]));
        ++next;
      }
      look();
      ::usleep(1000);
    }
    std::sort(done_.begin(), done_.end(),
              [](const Judgement& a, const Judgement& b) { return a.of.number < b.of.number; });
    return std::move(done_);
  }

 private:
  std::string common() const { return folder_.path().string(); }
  const Call& call(const Process& p) const { return calls()[p.of.call]; }

  /// Of a case whose `at` is in percent.
  Case scaled(Case c) const {
    if (c.at >= 0) return c;
    const Counts& n = counts_[c.early][c.call];
    const int64_t of = c.kind == Kind::no_memory ? n.allocations[size_t(c.thread)] : n.readings;
    c.at = std::max<int64_t>(1, -c.at * of / 100);
    return c;
  }

  pid_t start(const std::vector<std::string>& words, const std::string& folder, const Case* fault, const char* arm,
              const std::string& port = "") {
    const pid_t pid = ::fork();
    if (pid != 0) return pid;
    const auto to = [](const std::string& file, int fd) {
      const int f = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      if (f >= 0) ::dup2(f, fd);
    };
    ::close(STDIN_FILENO);
    ::open("/dev/null", O_RDONLY);
    to(folder + "/out", STDOUT_FILENO), to(folder + "/err", STDERR_FILENO);
    ::unsetenv("DISPLAY"), ::unsetenv("WAYLAND_DISPLAY");
    ::setenv("TMPDIR", folder.c_str(), 1);
    if (fault) {
      ::setenv("LD_PRELOAD", shim_.c_str(), 1);
      ::setenv("LIMBERG_FAULT", fault->fault().c_str(), 1);
      ::setenv("LIMBERG_FAULT_ARM", arm, 1);
      ::setenv("LIMBERG_FAULT_JOURNAL", (folder + "/journal").c_str(), 1);
      ::setenv("LIMBERG_FAULT_FOLDER", (folder + "/rec").c_str(), 1);
    }
    std::vector<std::string> text{program_};
    for (std::string w : words) {
      for (const auto& [mark, stands_for] : {std::pair<char, std::string>{'@', folder}, {'%', common()}, {'~', port}})
        if (const size_t at = w.find(mark); at != std::string::npos) w.replace(at, 1, stands_for);
      text.push_back(w);
    }
    std::vector<char*> argv;
    for (std::string& w : text) argv.push_back(w.data());
    argv.push_back(nullptr);
    ::execv(program_.c_str(), argv.data());
    ::_exit(127);
  }

  void begin(const Case& c) {
    auto p = std::make_unique<Process>();
    p->of = c, p->judgement.of = c;
    p->folder = common() + "/case-" + std::to_string(begun_++);
    fs::create_directories(p->folder + "/rec");
    p->journal = std::make_unique<MappedJournal>(p->folder + "/journal");
    p->began_ns = monotonic_ns();
    p->device = std::make_unique<ServedDevice>(call(*p).device, c, p->folder);
    p->pid = start(call(*p).words, p->folder, &c, c.early ? call(*p).starts : call(*p).begins, p->device->port());
    running_.push_back(std::move(p));
  }

  void look() {
    for (auto& p : running_) {
      int status = 0;
      const pid_t ended = ::waitpid(p->pid, &status, WNOHANG | WUNTRACED);
      const int64_t now = monotonic_ns();
      if (p->device) p->device->serve(now - p->began_ns, (*p->journal)->armed != 0);
      if (ended == p->pid && WIFSTOPPED(status)) {
        p->stopped_ns = now;
        continue;
      }
      if (p->stopped_ns != 0 && now - p->stopped_ns > p->of.more * 1'000'000)
        p->stopped_ns = 0, ::kill(p->pid, SIGCONT);
      if (ended == p->pid) {
        const int s = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
        if (p->again)
          judge_again(*p, s);
        else
          judge(*p, s);
      } else if (double(now - p->began_ns) * 1e-9 > kLongest_s) {
        ::kill(p->pid, SIGKILL);
        ::waitpid(p->pid, &status, 0);
        p->judgement.hang = true;
        p->judgement.why = p->again ? "the replay of what it left hangs" : "hangs";
        p->pid = -1;
      }
    }
    for (auto& p : running_) {
      if (p->pid > 0) continue;
      if (p->judgement.sound()) {
        std::error_code ec;
        fs::remove_all(p->folder, ec);
      }
      done_.push_back(std::move(p->judgement));
      if (set_.progress) set_.progress(fmt::format("{} cases", done_.size()));
      p.reset();
    }
    std::erase_if(running_, [](const auto& p) { return !p; });
  }

  nlohmann::json result_of(const std::string& file) const {
    nlohmann::json j = nlohmann::json::parse(words_in(file), nullptr, false);
    return j.is_object() ? j : nlohmann::json::object();
  }

  void judge(Process& p, int status) {
    Judgement& j = p.judgement;
    const Call& c = call(p);
    const Journal& did = **p.journal;
    const std::string said = words_in(p.folder + "/err");
    j.status = status, j.reached = did.injected > 0 || p.device->faults() > 0;
    j.said = said.substr(said.size() - std::min<size_t>(said.size(), 400));
    p.pid = -1;
    const auto finding = [&](bool& of, const std::string& why) {
      of = true;
      j.why += (j.why.empty() ? "" : "; ") + why;
    };
    const int own = p.of.kind == Kind::killed    ? SIGKILL
                    : p.of.kind == Kind::crashed ? SIGSEGV
                    : p.of.kind == Kind::aborted ? SIGABRT
                                                 : -1;
    if (status > 1000 && status != 1000 + own) finding(j.crash, fmt::format("ended by signal {}", status - 1000));
    if (status == 1 || said.find("internal error") != std::string::npos)
      finding(j.crash, "spoke of a defect of its own");
    if (status > 0 && status < 1000 && said.rfind("limberg: ") == std::string::npos)
      finding(j.speechless, fmt::format("status {} without a word", status));
    if (!c.reads.empty() && read_whole_file(common() + "/" + c.reads) != before_.at(c.reads))
      finding(j.lost, "the recording that it read was touched");
    const nlohmann::json result = c.result.empty() ? nlohmann::json() : result_of(p.folder + "/" + c.result);
    if (status == 0) {
      if (result.empty() || !result.value("ok", false)) finding(j.wrong, "no good result");
      if (!c.live && result.value("state_hash", "") != reference_.at(c.name).hash)
        finding(j.wrong, "another patient than without the fault");
    }
    if (!c.recording.empty()) judge_recording(p, status, result);
    if (c.live && j.sound() && !again_.empty()) {
      p.again = true, p.began_ns = monotonic_ns();
      p.pid = start({"replay", again_, "--json", "@/again.json"}, p.folder, nullptr, nullptr);
      again_.clear();
    }
  }

  void judge_recording(Process& p, int status, const nlohmann::json& result) {
    Judgement& j = p.judgement;
    const Call& c = call(p);
    const Journal& did = **p.journal;
    const Reference& whole = reference_.at(c.name);
    const auto finding = [&](bool& of, const std::string& why) {
      of = true;
      j.why += (j.why.empty() ? "" : "; ") + why;
    };
    // How far the session had come when the fault was met.
    int64_t had_ms = j.reached ? did.wakes_then.load() : 0;
    if (!c.live) had_ms = j.reached ? whole.end_tick * did.readings_then / std::max<int64_t>(1, whole.readings) : 0;
    if (p.of.early) had_ms = 0;  // counted from another moment
    const std::string file = p.folder + "/" + c.recording;
    std::optional<Recording> rec;
    try {
      rec = read_recording(file);
    } catch (const InputError& e) {
      if (status == 0) return finding(j.wrong, "no recording");
      if (had_ms > 1000) finding(j.lost, fmt::format("no recording of {} ms", had_ms));
      return;
    }
    if (rec->damage.total() != rec->damage.truncated)
      finding(status == 0 ? j.wrong : j.lost, "its recording is damaged: " + rec->damage.first_message);
    if (status == 0 && (!rec->end || rec->damage.total() > 0)) finding(j.wrong, "its recording has no end");
    if (!c.live) {
      if (status == 0 && words_in(file) != whole.recording)
        finding(j.wrong, "another recording than without the fault");
      const int64_t has_ms = rec->samples.empty() ? 0 : time_of(rec->samples.back()) / 1'000'000;
      if (has_ms < had_ms - 1000) finding(j.lost, fmt::format("{} ms of {} recorded", has_ms, had_ms));
      return;
    }
    const LiveSchedule& s = rec->schedule;
    if (status == 0 && !s.usable()) finding(j.wrong, "its recording cannot be replayed as it was");
    const int64_t from_ms = c.reads.empty() ? 0 : continues_at_ms_;
    const int64_t has_ms = s.device.empty() ? 0 : s.device.back().tick + s.device.back().count;
    if (had_ms > 0 && has_ms < from_ms + had_ms - 1000)
      finding(j.lost, fmt::format("{} ms of {} recorded", has_ms, from_ms + had_ms));
    if (status == 0 && rec->end && result.value("state_hash", "") != fmt::format("{:016x}", rec->end->hash))
      finding(j.wrong, "its result is not that of its recording");
    // A device that was pulled before it said anything leaves a session without a hand: nothing to replay.
    if (s.usable() && !rec->samples.empty()) again_ = file;
  }

  /// A recording has to replay to the bits that it says, whatever ended its session.
  void judge_again(Process& p, int status) {
    Judgement& j = p.judgement;
    p.pid = -1;
    const nlohmann::json r = result_of(p.folder + "/again.json");
    const nlohmann::json c = r.value("checkpoints", nlohmann::json::object());
    if (status != 0 && status != 3)
      j.lost = true, j.why = fmt::format("its recording does not replay: status {}", status);
    else if (c.value("compared", 0) != c.value("equal", 0))
      j.lost = true, j.why = "its recording replays to other bits";
  }

  /// Each call without a fault: what it leaves, and what it does on the way.
  void prepare() {
    for (const bool early : {true, false}) {
      counts_[early].clear();
      for (size_t i = 0; i < calls().size(); ++i) {
        const Call& c = calls()[i];
        const std::string folder = common() + fmt::format("/without-{}-{}", i, int(early));
        fs::create_directories(folder + "/rec");
        const MappedJournal journal(folder + "/journal");
        const Case none;
        int status = 0;
        ServedDevice device(c.device, none, folder);
        const int64_t began_ns = monotonic_ns();
        const pid_t pid = start(c.words, folder, &none, early ? c.starts : c.begins, device.port());
        while (::waitpid(pid, &status, WNOHANG) == 0)
          device.serve(monotonic_ns() - began_ns, journal->armed != 0), ::usleep(1000);
        const nlohmann::json result = result_of(folder + "/" + c.result);
        if (status != 0 || journal->armed == 0)
          throw InputError("", 0,
                           fmt::format("limberg {} ends with status {} without any fault ({}); expected 0", c.name,
                                       status, words_in(folder + "/err")));
        counts_[early].push_back(counts_of(*journal));
        Reference& r = reference_[c.name];
        r.hash = result.value("state_hash", ""), r.readings = journal->readings;
        if (!c.recording.empty()) {
          r.recording = words_in(folder + "/" + c.recording);
          const Recording rec = read_recording(folder + "/" + c.recording);
          r.end_tick = rec.end ? rec.end->tick : 0;
        }
        if (std::string(c.name) == "run") {
          write_whole_file(common() + "/live.lcm", r.recording);
          write_whole_file(common() + "/cut.lcm", r.recording.substr(0, r.recording.size() * 3 / 5));
          const Recording cut = read_recording(common() + "/cut.lcm");
          if (!cut.schedule.usable()) throw InputError("", 0, "the cut recording has no schedule; expected one");
          continues_at_ms_ = cut.schedule.device.back().tick;
        }
      }
    }
    for (const Call& c : calls())
      if (!c.reads.empty()) before_[c.reads] = read_whole_file(common() + "/" + c.reads);
  }

  const Settings& set_;
  const TemporaryFolder folder_;
  const std::string program_ = binary_dir() + "/limberg", shim_ = binary_dir() + "/tests/limberg_faults.so";
  std::vector<Counts> counts_[2];
  std::map<std::string, Reference> reference_;
  std::map<std::string, std::string> before_;  // what is read, as it was
  int64_t continues_at_ms_ = 0, begun_ = 0;
  std::string again_;
  std::vector<std::unique_ptr<Process>> running_;
  std::vector<Judgement> done_;
};

}  // namespace

std::vector<Judgement> run_cases(const Settings& settings) { return Harness(settings).run(); }

}  // namespace limberg::bench::faults
