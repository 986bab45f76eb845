#include "tests/bench/faults/cases.h"

#include <algorithm>
#include <random>

#include "sim/base/whole_file.h"
#include "tests/small_block.h"

namespace limberg::bench::faults {

namespace {

constexpr size_t kFastrak = 5, kLcm = 6;  // in calls()

constexpr const char* kScript = R"({"limberg_script":1,"scene":"tiny"}
{"action":"hook","id":1,"at":[3,4]}
{"action":"move","id":1,"to":[5,7,4],"seconds":0.3}
{"action":"incise","path":[[-6,-5],[6,-5]],"depth_mm":3,"angle_deg":90}
{"action":"release","id":1}
)";

}  // namespace

void write_patient(const std::string& folder) {
  write_whole_file(folder + "/tiny.toml",
                   test::small_block({.side_mm = 30, .skin_cell_mm = 5, .cell_mm = 10, .prestretch_along = "1.08"}));
  write_whole_file(folder + "/tiny.jsonl", kScript);
}

const std::vector<Call>& calls() {
  static const std::vector<Call> all{
      {"run",
       {"run", "%/tiny.toml", "--headless", "--device", "emulated:%/tiny.jsonl", "--record", "@/rec/r.lcm", "--json",
        "@/result.json", "--workers", "2"},
       "rec/r.lcm",
       "result.json",
       "",
       "r.lcm",
       "tiny.toml",
       true},
      {"run --continue",
       {"run", "--continue", "%/cut.lcm", "--headless", "--device", "emulated:%/tiny.jsonl", "--seconds", "1.5",
        "--record", "@/rec/c.lcm", "--json", "@/result.json", "--workers", "2"},
       "rec/c.lcm",
       "result.json",
       "cut.lcm",
       "c.lcm",
       "cut.lcm",
       true},
      {"emulate",
       {"emulate", "%/tiny.toml", "%/tiny.jsonl", "--out", "@/rec/e.lcm", "--json", "@/result.json", "--workers", "2"},
       "rec/e.lcm",
       "result.json",
       "",
       "e.lcm",
       "tiny.toml",
       false},
      {"replay",
       {"replay", "%/live.lcm", "--json", "@/result.json", "--workers", "2"},
       "",
       "result.json",
       "live.lcm",
       "live.lcm",
       "live.lcm",
       false},
      {"operate",
       {"operate", "%/tiny.toml", "%/tiny.jsonl", "--json", "@/result.json", "--workers", "2"},
       "",
       "result.json",
       "",
       "tiny.jsonl",
       "tiny.toml",
       false},
      {"run (FASTRAK)",
       {"run", "%/tiny.toml", "--headless", "--device", "fastrak:@/port,fts", "--seconds", "1.6", "--record",
        "@/rec/f.lcm", "--json", "@/result.json", "--workers", "2"},
       "rec/f.lcm",
       "result.json",
       "",
       "f.lcm",
       "tiny.toml",
       true,
       Call::fastrak},
      {"run (LCM)",
       {"run", "%/tiny.toml", "--headless", "--device", "lcm:udpm://239.255.76.67:~?ttl=0", "--seconds", "1.6",
        "--record", "@/rec/l.lcm", "--json", "@/result.json", "--workers", "2"},
       "rec/l.lcm",
       "result.json",
       "",
       "l.lcm",
       "tiny.toml",
       true,
       Call::lcm}};
  return all;
}

const std::vector<KindName>& kinds() {
  static const std::vector<KindName> all{
      {Kind::write_error, "disk full", "writes fail: once, a few times, for good"},
      {Kind::write_short, "short writes", "writes take half of what they are given"},
      {Kind::sync_error, "fsync fails", "what was written cannot be brought to the disk"},
      {Kind::open_error, "open fails", "a file cannot be opened or made"},
      {Kind::rename_error, "rename fails", "a file cannot be put in its place"},
      {Kind::no_memory, "no memory", "an allocation of some thread fails: one, a few, all further ones"},
      {Kind::no_thread, "no thread", "a thread cannot be started"},
      {Kind::slow_disk, "slow disk", "every write takes 20 to 200 ms"},
      {Kind::clock_stands, "clock stands", "for 50 to 1500 ms, and then leaps to where it would be"},
      {Kind::clock_leaps, "clock leaps", "by 50 to 3000 ms"},
      {Kind::killed, "SIGKILL", "at any moment"},
      {Kind::crashed, "SIGSEGV", "at any moment"},
      {Kind::aborted, "SIGABRT", "at any moment"},
      {Kind::stopped, "SIGSTOP", "at any moment, for 50 to 1000 ms"},
      {Kind::folder_removed, "folder removed", "the recording's folder, with the recording in it"},
      {Kind::device_pulled, "device pulled", "and plugged in again after 20 to 800 ms"},
      {Kind::packets_lost, "packets lost", "one in two to twenty"},
      {Kind::packets_doubled, "packets doubled", "one in two to twenty"},
      {Kind::packets_reordered, "packets reordered", "one in two to twenty"}};
  return all;
}

const char* name_of(Kind kind) {
  const auto it = std::find_if(kinds().begin(), kinds().end(), [&](const KindName& k) { return k.kind == kind; });
  return it == kinds().end() ? "none" : it->name;
}

std::string Case::fault() const {
  return std::to_string(int(kind)) + " " + std::to_string(at) + " " + std::to_string(more) + " " +
         std::to_string(thread);
}

Counts counts_of(const Journal& j) {
  Counts c{j.readings, j.writes, j.opens, j.renames, j.syncs, j.threads, {}};
  for (const auto& n : j.allocations) c.allocations.push_back(n);
  return c;
}

Case case_of(uint64_t seed, int64_t number, const std::vector<Counts> (&counts)[2]) {
  std::mt19937_64 random(seed * 1'000'003 + uint64_t(number));
  const auto below = [&](int64_t n) { return n <= 0 ? int64_t(0) : int64_t(random() % uint64_t(n)); };
  const auto one_of = [&](std::initializer_list<int64_t> some) { return some.begin()[below(int64_t(some.size()))]; };
  for (;;) {
    Case c;
    c.number = number;
    // In turn, so that each kind meets each call, until a call that never does what fails was passed over.
    c.kind = kinds()[size_t(number % int64_t(kinds().size()))].kind;
    // Calls against the clock take seconds each, the others a twentieth: half of the cases are theirs.
    c.call = size_t(one_of({0, 0, 1, 2, 2, 2, 3, 4, below(2) == 0 ? 0 : int64_t(kFastrak)}));
    c.early = c.kind == Kind::no_thread || (c.kind == Kind::no_memory && below(3) == 0) || below(8) == 0;
    const Counts& n = counts[c.early][c.call];
    int64_t most = n.readings;
    switch (c.kind) {
      case Kind::write_error:
        most = n.writes, c.more = one_of({0, 3, 1'000'000});
        break;
      case Kind::write_short:
        most = n.writes, c.more = one_of({0, 1'000'000});
        break;
      case Kind::sync_error:
        most = n.syncs;
        break;
      case Kind::open_error:
        most = n.opens, c.more = one_of({0, 1'000'000});
        break;
      case Kind::rename_error:
        most = n.renames;
        break;
      case Kind::no_thread:
        most = n.threads, c.more = one_of({0, 1'000'000});
        break;
      case Kind::slow_disk:
        most = n.writes, c.more = 20 + below(180);
        break;
      case Kind::clock_stands:
        c.more = 50 + below(1450);
        break;
      case Kind::clock_leaps:
        c.more = 50 + below(2950);
        break;
      case Kind::stopped:
        c.more = 50 + below(950);
        break;
      case Kind::folder_removed:
        if (calls()[c.call].recording.empty()) most = 0;
        break;
      case Kind::device_pulled:
        c.call = kFastrak, most = 1600, c.more = 20 + below(780);
        break;
      case Kind::packets_lost:
      case Kind::packets_doubled:
      case Kind::packets_reordered:
        c.call = kLcm, most = 1600, c.more = 2 + below(18);
        break;
      case Kind::no_memory: {
        std::vector<int> busy;
        for (size_t t = 0; t < n.allocations.size(); ++t)
          if (n.allocations[t] > 0) busy.push_back(int(t));
        if (busy.empty()) continue;
        c.thread = busy[size_t(below(int64_t(busy.size())))];
        most = n.allocations[size_t(c.thread)], c.more = one_of({0, 3, 1'000'000});
        break;
      }
      default:
        break;
    }
    if (most <= 0) continue;
    c.at = 1 + below(most);
    return c;
  }
}

}  // namespace limberg::bench::faults
