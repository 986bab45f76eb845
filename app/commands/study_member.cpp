#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "app/commands/study_parts.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/session/workers_pool.h"
#include "app/study/campaign.h"
#include "app/study/task_file.h"
#include "sim/base/error.h"

namespace limberg {

using study::Family;
using study::Job;
using study::Values;

uint64_t inputs_of(const Family& f, const Values& v) { return f.inputs ? f.inputs(v) : 0; }

int run_member(const StudyOptions& o) {
  catch_interrupts();
  const Family& f = study::find_family(o.name);
  const std::vector<Values> members = study::members(f, o.settings);
  if (members.size() != 1)
    throw InputError("", 0,
                     "--member: the settings name " + std::to_string(members.size()) + " members of study " + f.name +
                         "; expected one value for each key");
  if (o.common.out_dir.empty()) throw InputError("", 0, "--member needs --out DIR, where its file is left");
  if (o.memory_MB > 0) {  // more is refused, so that the member can still say so
    const rlimit most{rlim_t(o.memory_MB) << 20, rlim_t(o.memory_MB) << 20};
    ::setrlimit(RLIMIT_DATA, &most);
  }
  const Values& v = members[0];
  prepare_folder(o.common.out_dir + "/members");
  study::MemberResult m;
  m.program = study::program_hash(), m.inputs = inputs_of(f, v);
  const auto start = std::chrono::steady_clock::now();
  try {
    WorkersPool workers(o.common.worker_count());
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

namespace {

/// That stands as it is: of this program, done or failed in its own words.
bool stands(const std::string& dir, const Job& job) {
  try {
    const auto m =
        study::read_member(study::member_file(dir, *job.family, job.values, ".json"), *job.family, job.values);
    return m && !m->cut_short && m->program == study::program_hash() &&
           (!m->failure.empty() || m->inputs == inputs_of(*job.family, job.values));
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

int run_task(const StudyOptions& o) {
  catch_interrupts();
  if (o.common.out_dir.empty()) throw InputError("", 0, "--task needs --out DIR, where the members' files are left");
  const std::vector<Job> all = study::read_task(o.task);
  prepare_folder(o.common.out_dir + "/members");
  std::vector<Job> missing;
  for (const Job& job : all)
    if (!stands(o.common.out_dir, job)) missing.push_back(job);
  const std::string again = variable("SLURM_RESTART_COUNT"), node = variable("SLURMD_NODENAME");
  say(fmt::format("task {}{}{}: {} of {} members to be run", o.task, node.empty() ? "" : " on " + node,
                  again.empty() ? "" : ", begun again " + again + " times", missing.size(), all.size()));
  const auto engine = study::local_engine(o.common.out_dir, o.limits(o.common.worker_count()), 1, false);
  // Whoever has submitted the task tries again what is cut short here.
  const study::Counts counts = study::run_campaign(missing, *engine, {o.common.out_dir, 0, interrupted, {}, {}});
  say(in_words(counts));
  return interrupted() || counts.failed > 0 ? kGoalMissed : kDone;
}

}  // namespace limberg
