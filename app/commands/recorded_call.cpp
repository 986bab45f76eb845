#include "app/commands/recorded_call.h"

#include <algorithm>
#include <utility>

#include "app/result/progress.h"
#include "devices/log_source.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

std::string describe(const LogDamage& d, const std::string& file) {
  std::string s = file + ": damaged: " + std::to_string(d.total()) + " events lost";
  if (d.skipped_bytes > 0) s += ", " + std::to_string(d.skipped_bytes) + " bytes skipped";
  if (!d.first_message.empty()) s += "; first: " + d.first_message;
  return s + "; what is whole is replayed";
}

}  // namespace

Recording open_session(const std::string& file) {
  Recording rec = read_recording(file);
  if (!rec.session)
    throw InputError(
        file, 0,
        "no valid record of a session in it; expected a recording made by limberg run --record or limberg emulate");
  if (rec.samples.empty())
    throw InputError(file, 0, "no valid record of a sample in it; expected a stream of stylus samples");
  return rec;
}

void expect_scene_of(const Recording& rec, const std::string& file, const Scene& scene) {
  if (!rec.session || rec.session->scene_hash == scene.hash) return;
  if (differs_in_words_only(scene, unbundle_scene(rec, file).scene.text, rec.session->scene_hash)) return;
  throw InputError(file, 0,
                   "log of another scene (" + rec.session->scene_name + ", hash " + hex(rec.session->scene_hash) +
                       "); expected " + scene.name + ", hash " + hex(scene.hash) +
                       ", or one that differs in comments only");
}

void take_session(SessionCall& call, const Recording& rec, const std::string& file) {
  Unbundled u = unbundle_scene(rec, file);
  if (u.scene.hash != rec.session->scene_hash)
    throw InputError(file, 0,
                     "its scene is not the one that it was recorded with (hash " + hex(u.scene.hash) + ", recorded " +
                         hex(rec.session->scene_hash) + "); expected an unchanged recording");
  if (rec.damage.total() > 0) say(describe(rec.damage, file));
  if (!rec.end && rec.damage.total() == 0)
    say(file + ": has no end record: the session was cut short; what is there is replayed");
  call.scene = std::move(u.scene);
  call.scene_files = u.files;
  call.calibration = unbundle_calibration(rec, file);
  call.progressive_cut = (rec.session->seeds[2] & SessionInfo::kProgressiveCut) != 0;
  call.threads_slip = (rec.session->seeds[2] & SessionInfo::kThreadsSlip) != 0;
  call.in_space = (rec.session->seeds[2] & SessionInfo::kInSpace) != 0;
  call.as_meant = (rec.session->seeds[2] & SessionInfo::kAsMeant) != 0;
  call.ticks_per_solver_step = std::max(1, rec.session->ticks_per_solver_step);
  call.expected = rec.checkpoints;
  call.expected_states = rec.states;
  call.recorded_by = rec.session->program;
  call.damage = rec.damage;
  if (!rec.end) return;
  call.end_tick = rec.end->tick;
  call.expected.push_back({rec.end->tick, rec.end->hash});
}

void take_samples(SessionCall& call, Recording rec, const std::string& file, bool as_it_was) {
  as_it_was &= rec.damage.total() == rec.damage.truncated;  // a killed session ends within an event
  if (as_it_was && rec.schedule.usable()) {
    call.schedule = std::move(rec.schedule);
    call.taken = std::move(rec.samples);
    call.known_length_s = double(call.schedule.solver.back().tick) * 1e-3;
    return;
  }
  if (rec.schedule.usable())
    call.expected.clear(),
        call.expected_states.clear();  // hashes of a live session are those of its own interleaving
  else if (rec.schedule.broken)
    say(file + ": what its threads found is not whole: replayed on an even clock, not exactly as it was");
  auto source = std::make_unique<LogSource>(std::move(rec.samples), rec.damage.total());
  call.known_length_s = double(source->last_ns()) * 1e-9;
  call.sources.push_back(std::move(source));
}

SessionCall continued_session(const std::string& file) {
  SessionCall call;
  Recording rec = open_session(file);
  take_session(call, rec, file);
  call.surgeon_seed = rec.session->seeds[1];
  SessionCall::GoesOn on;
  on.file = file, on.files = rec.blobs, on.session = *rec.session;
  std::vector<Sample> samples = rec.samples;
  on.end_tick = rec.end ? rec.end->tick : 0;
  for (const Sample& s : samples)
    if (!rec.end) on.end_tick = std::max(on.end_tick, (time_of(s) + 999'999) / 1'000'000);
  // What came after that was never acted upon.
  std::erase_if(rec.samples, [&](const Sample& s) { return time_of(s) > on.end_tick * 1'000'000; });
  on.samples = rec.samples;
  take_samples(call, std::move(rec), file, true);
  if (call.schedule.usable()) {
    size_t taken = 0;
    for (const DeviceRun& r : call.schedule.device) taken += size_t(r.samples);
    samples.resize(std::min(taken, samples.size()));
    call.taken = on.samples = std::move(samples);
  }
  on.earlier = std::exchange(call.sources, {});
  call.end_tick = -1;
  call.goes_on = std::move(on);
  return call;
}

}  // namespace limberg
