#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/program/temporary_folder.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/run_result.h"
#include "app/session/workers_pool.h"
#include "app/study/member_file.h"
#include "app/study/processes.h"
#include "app/study/study_result.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

namespace fs = std::filesystem;
using study::Family;
using study::Gathered;
using study::Values;

struct StudyOptions {
  std::string name;
  std::vector<std::string> settings, collect;
  int jobs = 0;
  bool check = false, list_jobs = false, member = false;
  CommonOptions common;
};

std::string plain(double v) { return fmt::format("{:.6g}", v); }

uint64_t inputs_of(const Family& f, const Values& v) { return f.inputs ? f.inputs(v) : 0; }

/// What is to be there: the family's own members and, with --check, those that its checks need beside them.
std::vector<Gathered> wanted(const StudyOptions& o) {
  const Family& own = study::find_family(o.name);
  std::vector<Gathered> parts;
  if (!o.check || own.check.empty()) {
    parts.push_back({&own, study::members(own, o.settings), {}, {}, {}});
    return parts;
  }
  for (const study::CheckPart& p : own.check) {
    const Family& f = study::find_family(p.family);
    std::vector<std::string> settings = p.settings;
    if (&f == &own)
      for (const std::string& s : o.settings) {  // a user's values stand for the check's
        const std::string key = study::parameter_named(f, s.substr(0, s.find('=')));
        std::erase_if(settings,
                      [&](const std::string& t) { return study::parameter_named(f, t.substr(0, t.find('='))) == key; });
        settings.push_back(s);
      }
    parts.push_back({&f, study::members(f, settings), {}, {}, {}});
  }
  return parts;
}

std::vector<std::string> member_call(const Family& f, const Values& v, int workers, const std::string& dir) {
  std::vector<std::string> words{study::this_program(), "study", f.name};
  for (size_t i = 0; i < v.size(); ++i) {
    const std::string brief = fmt::format("{:g}", v[i]);  // where it means the same
    const std::string t = "=" + (std::strtod(brief.c_str(), nullptr) == v[i] ? brief : fmt::format("{:.17g}", v[i]));
    words.insert(words.end(), {"--set", f.parameters[i].name + t});
  }
  words.insert(words.end(), {"--member", "--workers", std::to_string(workers), "--out", dir});
  return words;
}

std::string quoted(const std::string& word) {
  if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:") ==
      std::string::npos)
    return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// One member, here and now; leaves its file and picture. Whatever goes wrong with it is said in its file.
int run_member(const StudyOptions& o) {
  catch_interrupts();
  const Family& f = study::find_family(o.name);
  const std::vector<Values> members = study::members(f, o.settings);
  if (members.size() != 1)
    throw InputError("", 0,
                     "--member: the settings name " + std::to_string(members.size()) + " members of study " + f.name +
                         "; expected one value for each key");
  if (o.common.out_dir.empty()) throw InputError("", 0, "--member needs --out DIR, where its file is left");
  const Values& v = members[0];
  prepare_folder(o.common.out_dir + "/members");
  study::MemberResult m;
  m.program = study::program_hash(), m.inputs = inputs_of(f, v);
  WorkersPool workers(o.common.worker_count());
  const auto start = std::chrono::steady_clock::now();
  try {
    m.row = f.run(v, {workers, interrupted});
  } catch (const InputError& e) {
    m.failure = e.what();
  } catch (const std::bad_alloc&) {
    m.failure = "not enough memory";
  }
  if (interrupted()) return kGoalMissed;
  m.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (m.failure.empty() && m.row.shown && !m.row.title.empty())
    draw_member_picture(study::member_file(o.common.out_dir, f, v, ".png"), m.row.title, *m.row.shown);
  write_whole_file(study::member_file(o.common.out_dir, f, v, ".json"), study::member_text(f, v, m));
  if (m.failure.empty()) return kDone;
  say(study::member_name(f, v) + ": " + m.failure);
  return kGoalMissed;
}

void print_row(const study::Row& r, bool head) {
  if (head) {
    for (const auto& [name, v] : r.figures) std::printf("%*s ", std::max(9, int(name.size())), name.c_str());
    std::printf("\n");
  }
  for (const auto& [name, v] : r.figures) std::printf("%*s ", std::max(9, int(name.size())), plain(v).c_str());
  std::printf("\n");
  std::fflush(stdout);
}

/// Where the members' files are looked for and left.
struct Places {
  std::vector<std::string> look;  // --collect's, or the one folder of this study
  std::string leave;
};

std::optional<study::MemberResult> found(const Places& at, const Family& f, const Values& v, std::string& dir) {
  for (const std::string& d : at.look)
    if (auto m = study::read_member(study::member_file(d, f, v, ".json"), f, v)) return dir = d, m;
  return std::nullopt;
}

/// Reads what is there and lasts, prints what is new in the order of the members.
class Gathering {
 public:
  Gathering(std::vector<Gathered>& parts, const Places& at) : parts_(parts), at_(at) {}
  /// `final`: also what lies behind members that are missing.
  void look(bool final) {
    for (; part_ < parts_.size(); ++part_, member_ = 0, head_ = true) {
      Gathered& g = parts_[part_];
      for (; member_ < g.members.size(); ++member_) {
        const Key key{part_, member_};
        const bool there = !missing_.contains(key), over = final || given_up_.contains(key);
        if (!there && !over) return;
        std::string dir;
        const auto m = there ? found(at_, *g.family, g.members[member_], dir) : std::nullopt;
        if (!m || !m->failure.empty()) {
          const std::string why = m ? m->failure : reason_.contains(key) ? reason_.at(key) : "";
          if (!why.empty()) g.failed.push_back({study::member_name(*g.family, g.members[member_]), why});
          continue;
        }
        g.rows.push_back(m->row);
        g.row_of.push_back(member_);
        if (part_ == 0) pictures_.push_back(study::member_file(dir, *g.family, g.members[member_], ".png"));
        print_row(g.rows.back(), head_);
        head_ = false;
      }
    }
  }
  using Key = std::pair<size_t, size_t>;
  std::set<Key> missing_;  // still to be made
  std::set<Key> given_up_;
  std::map<Key, std::string> reason_;
  const std::vector<std::string>& pictures() const { return pictures_; }

 private:
  std::vector<Gathered>& parts_;
  const Places& at_;
  std::vector<std::string> pictures_;
  size_t part_ = 0, member_ = 0;
  bool head_ = true;
};

std::string first_line(const std::string& file) {
  std::error_code ec;
  if (!fs::exists(file, ec)) return {};
  const std::string text = read_whole_file(file, size_t(1) << 20);
  return text.substr(0, text.find('\n'));
}

int list_jobs(const StudyOptions& o, const std::vector<Gathered>& parts) {
  if (o.common.out_dir.empty())
    throw InputError("", 0, "--list-jobs needs --out DIR, where the jobs leave their files");
  for (const Gathered& g : parts)
    for (const Values& v : g.members) {
      std::string line;
      for (const std::string& w : member_call(*g.family, v, 1, o.common.out_dir))
        line += (line.empty() ? "" : " ") + quoted(w);
      std::printf("%s\n", line.c_str());
    }
  return kDone;
}

int finish(const StudyOptions& o, const std::vector<Gathered>& parts, const std::vector<std::string>& pictures) {
  size_t members = 0, done = 0;
  for (const Gathered& g : parts) members += g.members.size(), done += g.rows.size();
  if (done == 0) {
    for (const Gathered& g : parts)
      for (const auto& [name, why] : g.failed) say(name + ": " + why);
    say(interrupted() ? "interrupted; no member was finished" : "no member was finished");
    return kGoalMissed;
  }
  const auto bars = study::bars_of(parts);
  if (!o.common.out_dir.empty())
    study::leave_files(parts, o.common.out_dir), study::leave_pictures(parts[0], pictures, o.common.out_dir);
  Result result = study::result_of(parts, bars);
  write_fields(result, "", made_by(this_call()));
  leave_result(result, o.common);
  bool ok = true;
  std::printf("\n%-76s %10s %10s\n", o.check ? "check" : "bar", "value", "bar");
  for (const Bar& b : bars) {
    std::printf("%-76s %10.4g %s%9.4g  %s\n", b.name.c_str(), b.value, b.larger_is_better ? ">" : "<", b.bar,
                b.pass ? "pass" : "FAIL");
    ok &= b.pass;
  }
  for (const Gathered& g : parts)
    for (const auto& [name, why] : g.failed) say(name + " failed: " + why);
  if (done < members) {
    say(std::string(interrupted() ? "interrupted after " : "only ") + std::to_string(done) + " of " +
        std::to_string(members) + " members are there" +
        (o.common.out_dir.empty() ? "" : "; the same call goes on from them"));
    return kGoalMissed;
  }
  return ok ? kDone : kGoalMissed;
}

/// Results that were made elsewhere, and nothing else.
int collect(const StudyOptions& o, std::vector<Gathered> parts) {
  o.common.prepare();
  if (o.settings.empty() && !o.check) {  // whatever is there
    std::vector<Values>& all = parts[0].members;
    all.clear();
    for (const std::string& dir : o.collect)
      for (Values& v : study::members_in(dir, *parts[0].family)) all.push_back(std::move(v));
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    if (all.empty()) throw InputError(o.collect[0], 0, "holds no member of study " + parts[0].family->name);
  }
  // Figures of different programs say nothing together.
  std::optional<std::pair<uint64_t, std::string>> program;
  for (const Gathered& g : parts)
    for (const Values& v : g.members)
      for (const std::string& dir : o.collect) {
        const std::string file = study::member_file(dir, *g.family, v, ".json");
        const auto m = study::read_member(file, *g.family, v);
        if (!m) continue;
        if (!program) program = {m->program, file};
        if (m->program != program->first)
          throw InputError(file, 0,
                           "was made by another program than " + program->second + "; expected members of one program");
      }
  const Places at{o.collect, o.common.out_dir};
  Gathering gathering(parts, at);
  gathering.look(true);
  return finish(o, parts, gathering.pictures());
}

int run_study(const StudyOptions& o) {
  catch_interrupts();
  if (o.member) return run_member(o);
  std::vector<Gathered> parts = wanted(o);
  if (o.list_jobs) return list_jobs(o, parts);
  if (!o.collect.empty()) return collect(o, std::move(parts));
  o.common.prepare();
  std::optional<TemporaryFolder> temporary;
  if (o.common.out_dir.empty()) temporary.emplace("--out DIR");
  const std::string dir = temporary ? temporary->path().string() : o.common.out_dir;
  prepare_folder(dir + "/members");
  const Places at{{dir}, dir};
  Gathering gathering(parts, at);

  const int at_once = o.jobs > 0 ? o.jobs : std::max(1, int(std::thread::hardware_concurrency()));
  const int workers = o.common.workers > 0 ? o.common.workers : at_once > 1 ? 1 : o.common.worker_count();
  std::vector<study::Process> processes;
  std::vector<Gathering::Key> key;
  size_t kept = 0;
  for (size_t p = 0; p < parts.size(); ++p)
    for (size_t i = 0; i < parts[p].members.size(); ++i) {
      const Family& f = *parts[p].family;
      const Values& v = parts[p].members[i];
      const std::string file = study::member_file(dir, f, v, ".json");
      std::optional<study::MemberResult> m;
      try {
        m = study::read_member(file, f, v);
      } catch (const InputError& e) {
        say(std::string(e.what()) + "; it is made again");
      }
      if (m && m->failure.empty() && m->program == study::program_hash() && m->inputs == inputs_of(f, v)) {
        ++kept;
        continue;
      }
      std::error_code ignored;
      fs::remove(file, ignored);
      fs::remove(study::member_file(dir, f, v, ".png"), ignored);
      gathering.missing_.insert({p, i});
      key.push_back({p, i});
      processes.push_back({member_call(f, v, workers, dir), study::member_file(dir, f, v, ".log")});
      if (!o.common.simd.empty())
        processes.back().arguments.insert(processes.back().arguments.end(), {"--simd", o.common.simd});
    }
  if (kept) say(std::to_string(kept) + " members are there already");
  gathering.look(false);
  {
    Progress progress("study " + o.name);
    size_t done = 0;
    const auto show = [&](size_t running) {
      progress.show(double(done), double(processes.size()),
                    ("members, " + std::to_string(running) + " running").c_str());
    };
    study::run_processes(processes, at_once, interrupted, show, [&](size_t i, int status) {
      ++done;
      const std::string said = first_line(processes[i].log_file);
      if (status == kDone)
        gathering.missing_.erase(key[i]);
      else
        gathering.given_up_.insert(key[i]);
      if (status != kDone && status != -1 && !interrupted())
        gathering.reason_[key[i]] = !said.empty()    ? said
                                    : status >= 1000 ? "ended by signal " + std::to_string(status - 1000)
                                                     : "exit status " + std::to_string(status);
      if (status == -1 && !interrupted()) gathering.reason_[key[i]] = "could not be started";
      if (status == kDone && said.empty()) {
        std::error_code ignored;
        fs::remove(processes[i].log_file, ignored);
      }
      progress.clear();
      gathering.look(false);
    });
  }
  gathering.look(true);
  return finish(o, parts, gathering.pictures());
}

std::string footer() {
  std::string text;
  for (const Family& f : study::families()) {
    text += f.name + ": " + f.about + "\n";
    for (const study::Parameter& p : f.parameters) {
      std::string values;
      for (const double v : p.values) values += (values.empty() ? "" : ",") + plain(v);
      const std::string line =
          fmt::format("  {:<20} {}, {:g} to {:g} (by itself {})\n", p.name, p.help, p.lo, p.hi, values);
      text += line;
    }
  }
  return text +
         "Leaves rows.csv, charts as SVG, result.json and report.html in DIR, and members/, from which the same call "
         "goes on where it\n"
         "was stopped: a member is run again only when the program, its files or its settings have changed.\n"
         "On other machines: limberg study NAME --list-jobs --out DIR | parallel     (or one line for each task of a "
         "Slurm array),\n"
         "then limberg study NAME --collect DIR --out DIR.\n"
         "Exit status 3: a bar is missed, or a member failed.\n"
         "Example: limberg study gape --set angle_deg=90,45 --set prestretch_percent=5,10,20 --out out/gape";
}

}  // namespace

void add_study(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<StudyOptions>();
  CLI::App* c = app.add_subcommand("study", "A family of operations, each brought to rest: table, charts and bars");
  c->add_option("NAME", o->name, "Which (see below)")->required();
  c->add_option("--set", o->settings, "Values of a setting instead of its own; once per setting")
      ->type_name("KEY=V1,V2,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_flag("--check", o->check,
              "The members that all checks of the study need, its controls too; each check with its figure");
  c->add_option("--jobs", o->jobs, "Members at a time, each a process (default: as many as cores)")
      ->type_name("N")
      ->check(whole_from(1, 1024));
  c->add_flag("--list-jobs", o->list_jobs,
              "Print one command a line for each member, to be run elsewhere, and do nothing");
  c->add_option("--collect", o->collect,
                "Gather members that were made elsewhere from DIR/members; may be given several times")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_flag("--member", o->member, "Run one member and leave its file in DIR/members (what --list-jobs prints)");
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(footer());
  c->callback([o, &chosen] { chosen = [o] { return run_study(*o); }; });
}

}  // namespace limberg
