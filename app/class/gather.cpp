#include "app/class/gather.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "app/class/member.h"
#include "app/report/report_names.h"
#include "devices/recording.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/base/whole_file.h"
#include "sim/commands/script.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostSessions = 2000, kMostFiles = 50'000;
constexpr int kDeepest = 6;
constexpr size_t kMostRecording = size_t(4) << 30, kMostScript = size_t(64) << 20, kMostResult = size_t(256) << 20;

uint64_t hash_of(const std::string& bytes) {
  Hash64 h;
  h.add(bytes);
  return h.value();
}

FoundSession recording_at(const std::string& path) {
  const std::string bytes = read_whole_file(path, kMostRecording, "a recording");
  const Recording rec = read_recording(std::vector<uint8_t>(bytes.begin(), bytes.end()), path);
  if (!rec.session)
    throw InputError(path, 0, "is a stream without a session; expected a recording of limberg run --record");
  if (rec.samples.empty())
    throw InputError(path, 0, "holds no sample of a hand; expected a session in which one moved");
  return {FoundSession::recording, path, rec.session->scene_name, hash_of(bytes)};
}

FoundSession script_at(const std::string& path) {
  const std::string bytes = read_whole_file(path, kMostScript, "a script");
  const Script s = parse_script(bytes, path);
  if (s.lines.empty()) throw InputError(path, 0, "holds no action; expected a script with one at least");
  return {FoundSession::script, path, s.header.scene, hash_of(bytes)};
}

FoundSession result_at(const std::string& folder) {
  const std::string file = folder + "/" + report_names::result;
  const std::string bytes = read_whole_file(file, kMostResult, "a result");
  const ClassMember m = read_member(bytes, file);
  const std::string command = said(m.result.command);
  if (command != "run" && command != "replay" && command != "operate" && command != "emulate")
    throw InputError(file, 0, "is a result of \"" + command + "\"; expected one of run, replay or operate");
  return {FoundSession::result, folder, said(m.result.scene), hash_of(bytes)};
}

bool ends(const fs::path& p, const char* with) { return p.extension() == with; }

struct Search {
  fs::path without;
  const std::function<bool(size_t)>& look;
  GatheredSessions out;
  size_t files = 0;
  bool over = false;

  void leave_out(const fs::path& p, const std::string& reason, bool broken) {
    out.left_out.push_back({p.string(), reason, broken});
  }

  void take(const fs::path& p, FoundSession (*read)(const std::string&)) {
    if (over || (over = !look(out.sessions.size()))) return;
    try {
      out.sessions.push_back(read(p.string()));
    } catch (const InputError& e) {
      std::string why = e.what();
      for (const std::string& before : {p.string(), (p / report_names::result).string()})
        if (why.starts_with(before + ":")) why.erase(0, before.size() + 1);
      why.erase(0, why.find_first_not_of(' '));
      leave_out(p, why, true);
    }
    if (out.sessions.size() > kMostSessions)
      throw InputError(p.parent_path().string(), 0,
                       "more than " + std::to_string(kMostSessions) + " sessions below it; expected those of a class");
  }

  void folder(const fs::path& dir, int depth) {
    std::error_code ec;
    if (!without.empty() && fs::equivalent(dir, without, ec)) return;
    std::vector<fs::path> names, folders;
    fs::directory_iterator it(dir, ec);
    if (ec) return leave_out(dir, "cannot be looked into (" + ec.message() + ")", true);
    for (const fs::directory_iterator end; it != end && ++files < kMostFiles; it.increment(ec)) {
      if (ec) break;
      std::error_code of_this;
      (it->is_directory(of_this) && !it->is_symlink(of_this) ? folders : names).push_back(it->path());
    }
    std::sort(names.begin(), names.end()), std::sort(folders.begin(), folders.end());
    std::set<std::string> recorded;
    for (const fs::path& p : names)
      if (ends(p, ".lcm")) recorded.insert(p.stem().string());
    const bool has_result =
        std::any_of(names.begin(), names.end(), [](const fs::path& p) { return p.filename() == report_names::result; });
    const auto taken = [&](const fs::path& p) {
      if (ends(p, ".lcm")) return take(p, recording_at), true;
      if (p.filename() == report_names::result) {
        if (recorded.empty()) take(dir, result_at);
        return true;
      }
      if (!ends(p, ".jsonl")) return has_result;  // what a session has left beside its result
      if (!recorded.contains(p.stem().string()) && !has_result) take(p, script_at);
      return true;
    };
    for (const fs::path& p : names)
      if (!over && !taken(p)) leave_out(p, "neither a recording (.lcm), a script (.jsonl) nor a result.json", false);
    if (has_result) return;  // folders of its pictures
    for (const fs::path& p : folders) {
      if (depth == kDeepest)
        leave_out(p, "lies more than " + std::to_string(kDeepest) + " folders deep", false);
      else
        folder(p, depth + 1);
    }
  }
};

}  // namespace

FoundSession session_at(const std::string& path) {
  std::error_code ec;
  if (fs::is_directory(path, ec)) return result_at(path);
  return ends(path, ".jsonl") ? script_at(path) : recording_at(path);
}

GatheredSessions gather(const std::string& folder, const std::string& without,
                        const std::function<bool(size_t)>& look) {
  std::error_code ec;
  if (!fs::is_directory(folder, ec))
    throw InputError(folder, 0, "is no folder; expected one that holds the recordings of a class");
  Search s{without, look, {}, 0, false};
  s.folder(folder, 0);
  return std::move(s.out);
}

}  // namespace limberg
