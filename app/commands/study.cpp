#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <thread>

#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/study_parts.h"
#include "app/commands/this_call.h"
#include "app/program/interrupt.h"
#include "app/program/temporary_folder.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/run_result.h"
#include "app/study/campaign.h"
#include "app/study/processes.h"
#include "app/study/uncertainty.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

namespace fs = std::filesystem;
using study::Family;
using study::Gathered;
using study::Values;

std::string plain(double v) { return fmt::format("{:.6g}", v); }

constexpr double kSlurmLimit_s = 600;  // of a member, where none is given: a cluster wants to know

std::optional<study::SampledStudy> sampled_of(const StudyOptions& o) {
  if (o.sample.empty()) {
    if (o.sensitivity) throw InputError("", 0, "--sensitivity is of a sample; expected --sample sobol N with it");
    return std::nullopt;
  }
  if (o.check) throw InputError("", 0, "--sample and --check are two studies; expected one of them");
  const bool sobol = o.sample[0] == "sobol";
  if (!sobol && o.sample[0] != "latin")
    throw InputError("", 0, "--sample " + o.sample[0] + ": no such way; expected sobol N or latin N");
  const int64_t n = std::strtoll(o.sample[1].c_str(), nullptr, 10);
  if (o.sample[1].find_first_not_of("0123456789") != std::string::npos || n < 2 || n > 50'000)
    throw InputError("", 0, "--sample " + o.sample[0] + " " + o.sample[1] + ": expected a number from 2 to 50000");
  const Family& family = study::find_family(o.name);
  return study::sampled_study(family, o.settings, study::load_ranges(o.ranges, family),
                              sobol ? study::SampleKind::sobol : study::SampleKind::latin, size_t(n), o.seed,
                              o.sensitivity);
}

/// What is to be there: the family's own members and, with --check, those that its checks need beside them.
std::vector<Gathered> wanted(const StudyOptions& o, const std::optional<study::SampledStudy>& sampled) {
  const Family& own = study::find_family(o.name);
  std::vector<Gathered> parts;
  if (sampled) {
    parts.push_back({&own, sampled->members, {}, {}, {}});
    return parts;
  }
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

int list_jobs(const StudyOptions& o, const std::vector<Gathered>& parts) {
  if (o.common.out_dir.empty())
    throw InputError("", 0, "--list-jobs needs --out DIR, where the jobs leave their files");
  for (const Gathered& g : parts)
    for (const Values& v : g.members) {
      std::string line;
      for (const std::string& w : study::member_call({g.family, v}, o.common.out_dir, o.limits(1)))
        line += (line.empty() ? "" : " ") + study::quoted(w);
      std::printf("%s\n", line.c_str());
    }
  return kDone;
}

void print_bands(const ResultUncertainty& u) {
  for (const ResultCase& c : u.cases) {
    std::printf("%s%-24s %10s %10s %10s   for %s\n", c.setting.empty() ? "" : (c.setting + "\n").c_str(), "figure",
                "median", "5 % below", "95 %", u.ranges.c_str());
    for (const ResultBand& b : c.figures)
      std::printf("%-24s %10.4g %10.4g %10.4g\n", b.figure.c_str(), b.median.value_or(NAN), b.low.value_or(NAN),
                  b.high.value_or(NAN));
  }
}

int finish(const StudyOptions& o, const std::vector<Gathered>& parts, const std::vector<std::string>& pictures,
           const std::optional<study::SampledStudy>& sampled) {
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
    study::leave_files(parts, o.common.out_dir, sampled), study::leave_pictures(parts[0], pictures, o.common.out_dir);
  Result result = study::result_of(parts, bars, sampled);
  if (sampled) print_bands(study::uncertainty_of(*sampled, *parts[0].family, parts[0].rows, parts[0].row_of));
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
int collect(const StudyOptions& o, std::vector<Gathered> parts, const std::optional<study::SampledStudy>& sampled) {
  o.common.prepare();
  if (o.settings.empty() && !o.check && !sampled) {  // whatever is there
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
  const MemberPlaces at{o.collect, o.common.out_dir};
  Gathering gathering(parts, at, !sampled);
  gathering.look(true);
  return finish(o, parts, gathering.pictures(), sampled);
}

std::unique_ptr<study::Engine> engine_of(const StudyOptions& o, const std::string& dir) {
  const int cores = std::max(1, int(std::thread::hardware_concurrency()));
  if (o.engine == "slurm") {
    StudyOptions with = o;
    if (with.limit_s == 0) with.limit_s = kSlurmLimit_s;
    const int workers = o.common.workers > 0 ? o.common.workers : 1;
    return study::slurm_engine(dir, with.limits(workers), {o.name, o.jobs, o.per_task, o.sbatch});
  }
  const int at_once = o.jobs > 0 ? o.jobs : cores;
  const int workers = o.common.workers > 0 ? o.common.workers : at_once > 1 ? 1 : o.common.worker_count();
  return study::local_engine(dir, o.limits(workers), at_once);
}

/// Those that are not there, or not of this program and these inputs; what is in their place is taken away.
std::vector<Gathering::Key> missing_members(const std::vector<Gathered>& parts, const std::string& dir) {
  std::vector<Gathering::Key> out;
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
      if (m && m->failure.empty() && m->program == study::program_hash() && m->inputs == inputs_of(f, v)) continue;
      std::error_code ignored;
      fs::remove(file, ignored);
      fs::remove(study::member_file(dir, f, v, ".png"), ignored);
      out.push_back({p, i});
    }
  return out;
}

/// Runs them; how far it is goes to the terminal, and a line every ten seconds into DIR/progress.log.
void run_missing(const StudyOptions& o, const std::string& dir, const std::vector<Gathered>& parts,
                 Gathering& gathering) {
  const std::vector<Gathering::Key> keys = missing_members(parts, dir);
  size_t members = 0;
  for (const Gathered& g : parts) members += g.members.size();
  if (keys.size() < members) say(std::to_string(members - keys.size()) + " members are there already");
  gathering.missing.insert(keys.begin(), keys.end());
  gathering.look(false);
  if (keys.empty()) return;
  std::vector<study::Job> jobs;
  for (const auto& [p, i] : keys) jobs.push_back({parts[p].family, parts[p].members[i]});

  const auto engine = engine_of(o, dir);
  Progress progress("study " + o.name);
  study::CampaignLog log(dir + "/progress.log", "study " + o.name);
  study::CampaignSettings set;
  set.dir = dir, set.retries = o.retries, set.interrupted = interrupted;
  set.show = [&](const study::Counts& c) {
    progress.note(in_words(c));
    log.note(in_words(c));
  };
  set.ended = [&](size_t job, bool done, const std::string& why) {
    if (done) {
      gathering.missing.erase(keys[job]);
    } else {
      gathering.given_up.insert(keys[job]);
      gathering.reason[keys[job]] = why;
    }
    progress.clear();
    gathering.look(false);
  };
  const study::Counts counts = study::run_campaign(jobs, *engine, set);
  log.end(in_words(counts) + fmt::format(", {} lost and {} cut short on the way, {:.0f} s", counts.lost,
                                         counts.cut_short, counts.seconds));
}

int run_study(const StudyOptions& o) {
  catch_interrupts();
  if (!o.task.empty()) return run_task(o);
  if (o.member) return run_member(o);
  const std::optional<study::SampledStudy> sampled = sampled_of(o);
  std::vector<Gathered> parts = wanted(o, sampled);
  if (o.list_jobs) return list_jobs(o, parts);
  if (!o.collect.empty()) return collect(o, std::move(parts), sampled);
  if (o.engine == "slurm" && o.common.out_dir.empty())
    throw InputError("", 0, "--engine slurm needs --out DIR, in a folder that all nodes see");
  o.common.prepare();
  std::optional<TemporaryFolder> temporary;
  if (o.common.out_dir.empty()) temporary.emplace("--out DIR");
  const std::string dir = temporary ? temporary->path().string() : o.common.out_dir;
  prepare_folder(dir + "/members");
  const MemberPlaces at{{dir}, dir};
  Gathering gathering(parts, at, !sampled);
  run_missing(o, dir, parts, gathering);
  gathering.look(true);
  return finish(o, parts, gathering.pictures(), sampled);
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
         "On a cluster: --engine slurm (docs/cluster.md). On other machines: limberg study NAME --list-jobs --out DIR "
         "| "
         "parallel,\n"
         "then limberg study NAME --collect DIR --out DIR.\n"
         "What is not known of a tissue: --sample sobol 128 --sensitivity --ranges facial-skin gives each figure a "
         "band "
         "that nine in\n"
         "ten members lie in, and each parameter's share of the variance.\n"
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
  c->add_option("--jobs", o->jobs,
                "Members at a time, each a process (default: as many as cores); slurm: tasks at a time")
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
  c->add_option("--engine", o->engine, "Where members run: local, or slurm: tasks of a Slurm array")
      ->check(CLI::IsMember({"local", "slurm"}));
  c->add_option("--limit", o->limit_s, "Seconds that a member may take; then it has failed (slurm: 600 by itself)")
      ->type_name("S")
      ->check(number_from(0, 1e6));
  c->add_option("--memory", o->memory_MB, "MB that a member may take")->type_name("MB")->check(whole_from(16, 1 << 24));
  c->add_option("--retries", o->retries, "So often a member is tried again that was cut short or lost (2)")
      ->type_name("N")
      ->check(whole_from(0, 100));
  c->add_option("--per-task", o->per_task,
                "Slurm: members of a task, one after the other (so that tasks are about 100)")
      ->type_name("N")
      ->check(whole_from(1, 100000));
  c->add_option("--sbatch", o->sbatch,
                "Slurm: an option for sbatch, --sbatch=--partition=short; may be given several times")
      ->type_name("OPTION")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--task", o->task,
                "Run the members of a task's file and leave their files in DIR/members (what slurm calls)")
      ->type_name("FILE");
  c->add_option("--sample", o->sample, "Members drawn from --ranges instead of all combinations: sobol N or latin N")
      ->type_name("KIND N")
      ->expected(2);
  c->add_option("--ranges", o->ranges, "What is drawn: shipped ranges, or a TOML file (default facial-skin)");
  c->add_option("--seed", o->seed, "Of the sample (1)")->check(whole_from(0, 1000000000));
  c->add_flag("--sensitivity", o->sensitivity,
              "N (parameters + 2) members, and each parameter's share of the variance");
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(footer());
  c->callback([o, &chosen] { chosen = [o] { return run_study(*o); }; });
}

}  // namespace limberg
