#include "tests/bench/soak/acts.h"

#include <fmt/format.h>

#include "app/assembly/assembly.h"
#include "app/commands/session_command.h"
#include "app/operating_point/cpu_clock.h"
#include "sim/body/block.h"
#include "sim/patient/soft_tissue.h"
#include "tests/bench/fuzz/world_generator.h"

namespace limberg::bench {

namespace {

constexpr int64_t kThousand = 1000;

Bar acts_bar(const std::string& name, double value, double most, const std::string& source) {
  Bar b;
  b.name = name, b.value = value, b.bar = most, b.larger_is_better = false, b.pass = value <= most, b.source = source;
  return b;
}

double handed_out_mb() { return process_state("").allocated_mb; }

/// The fuzzer's patient, 50 x 50 x 10 mm, in coarse cells: ten thousand acts in minutes.
WorldSpec small_patient() {
  BlockSpec b;
  b.size_mm = Vec3(50, 50, 10);
  b.skin_cell_mm = 5;
  Material skin, fat;
  skin.young_kPa = 60, skin.poisson = 0.45, skin.prestretch_along = 1.1, skin.prestretch_across = 1.06;
  fat.young_kPa = 12, fat.poisson = 0.45;
  b.layers = {{"skin", 1.5, skin}, {"fat", 8.5, fat}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = 10;
  return spec;
}

class LongSession {
 public:
  LongSession() : world_(small_patient(), workers_) { step_.max_iterations = 4; }

  struct Thousand {
    int64_t done = 0, refused = 0, undone = 0, depth = 0;
    double most_mb = 0, floor_mb = 0;  // with all of the history; once it is gone
    int64_t compared = 0, other = 0;   // patients of which all was taken back, with themselves before it was done
  };

  Thousand next(int64_t acts, uint64_t seed, const std::function<bool()>& stop) {
    Thousand t;
    fuzz::WorldGenerator generator(seed);
    generator.start();
    act(t, Incise{{{-12, 0}, {12, 0}}, 4, 90, false});
    for (int64_t k = 1; k < acts && !stop(); ++k) act(t, random_act(generator));
    t.most_mb = handed_out_mb();
    while (!none_done_) act(t, Undo{}), t.depth += !none_done_;
    // An act that is none of the history ends what could be made again.
    world_.apply(SetHook{9, {0, 0}}), world_.apply(ReleaseHook{9});
    t.floor_mb = handed_out_mb();
    return t;
  }

 private:
  /// Now and then a surgeon who thinks better of all of it: skin that is cut a hundred times leaves nothing to cut.
  Command random_act(fuzz::WorldGenerator& generator) {
    if (back_ == 0 && ++since_ >= 30) back_ = 27, since_ = 0;
    if (back_ > 0) return --back_, Undo{};
    return generator.next();
  }
  // Time and hooks move the patient, and no undo takes them back: what is compared is the patient as it was when the
  // first act of all that are in the history began, with the one that it is right after the last of them was undone.
  // Only a refused undo tells that nothing is left; when the patient may have moved before that, nothing is compared.
  void act(Thousand& t, const Command& c) {
    const bool undo = std::holds_alternative<Undo>(c), redo = std::holds_alternative<Redo>(c),
               wait = std::holds_alternative<Wait>(c);
    const bool kept = !undo && !wait && !std::holds_alternative<SetHook>(c) && !std::holds_alternative<MoveHook>(c) &&
                      !std::holds_alternative<ReleaseHook>(c);
    const uint64_t now = none_done_ && kept && !redo ? world_.full_hash() : 0;
    bool done = true;
    if (wait)
      for (int i = 0; i < int(100 * std::get<Wait>(c).seconds + 0.5); ++i) world_.step(step_);
    else
      (done = world_.apply(c).done) ? ++t.done : ++t.refused;
    t.undone += done && undo;
    if (undo && !done && !none_done_) {
      if (just_undone_ && !doubtful_) ++t.compared, t.other += world_.full_hash() != before_;
      none_done_ = true, doubtful_ = false;
    }
    if (kept && done) {
      if (none_done_ && !redo) before_ = now;  // what is made again began where it did at first
      none_done_ = false;
    }
    if (!kept && !undo) doubtful_ |= undoing_;
    undoing_ = kept ? undoing_ && !done : undoing_ || (undo && done);
    just_undone_ = undo && done;
  }

  InlineWorkers workers_;
  World world_;
  StepSettings step_;
  int back_ = 0, since_ = 0;
  // Nothing is in the history; the act before was an undo that was done; the last act that was kept has been undone;
  // since then the patient has moved.
  bool none_done_ = true, just_undone_ = false, undoing_ = false, doubtful_ = false;
  uint64_t before_ = 0;
};

/// What the history keeps of one act on the patient of a scene that is operated on for real.
Row kept_of_an_act(const char* name, int acts, const std::function<Command(int)>& command) {
  const Scene scene = open_scene("rhomboid");
  InlineWorkers workers;
  const std::unique_ptr<World> world = make_world(scene, workers);
  world->step(step_settings(scene, false));
  world->apply(command(0));  // what every first one makes
  const double before = handed_out_mb();
  int done = 0;
  for (int k = 1; k <= acts; ++k) done += world->apply(command(k)).done;
  Row r;
  r.name = "acts, rhomboid", r.method = fmt::format("a {}, of {}", name, done);
  r.error = (handed_out_mb() - before) / std::max(done, 1), r.error_unit = "MB";
  r.settings = fmt::format("{} nodes; the act and what takes it back", world->skin()->solver().model().X_mm.size());
  r.reference = "the allocator's count", r.pass = done > 0;
  return r;
}

}  // namespace

Result soak_acts(const SoakSettings& set) {
  Result out;
  out.rows.push_back(kept_of_an_act("stitch", 40, [](int k) {
    return Suture{{-15 + 0.7 * k, 1.5}, {-15 + 0.7 * k, -1.5}};
  }));
  out.rows.push_back(kept_of_an_act("cut of 8 mm", 10, [](int k) {
    return Incise{{{-4, -25 + 5.0 * k}, {4, -25 + 5.0 * k}}, 3, 90, false};
  }));
  LongSession session;
  // The first thousands fill the table of what copies of a cell are made of (copy_layers.h): some 256 mixtures of two
  // layers. A leak goes on.
  double first_mb = 0, most_mb = 0;
  int64_t other = 0, compared = 0, acts = 0;
  for (uint64_t k = 0; acts < set.acts && !set.stop(); ++k) {
    const double cpu = cpu_ms();
    const int64_t n = std::min(kThousand, set.acts - acts);
    const LongSession::Thousand t = session.next(n, 1 + k % 5, set.stop);
    acts += n;
    double& half = acts <= set.acts / 2 || k == 0 ? first_mb : most_mb;
    half = std::max(half, t.floor_mb);
    other += t.other, compared += t.compared;
    Row r;
    r.name = "acts", r.method = fmt::format("{} to {}", acts - n + 1, acts);
    r.time_ms = (cpu_ms() - cpu) / double(n), r.error = t.floor_mb, r.error_unit = "MB";
    r.settings = fmt::format("{} done, {} refused, {} undone, then {} taken back: {:.1f} MB before", t.done, t.refused,
                             t.undone, t.depth, t.most_mb);
    r.reference = "once all is taken back; time: of an act";
    out.rows.push_back(r);
    if (set.progress) set.progress(fmt::format("{} acts: {:.1f} MB", acts, t.floor_mb));
  }
  if (most_mb > 0)  // acts enough for two halves
    out.bars.push_back(
        acts_bar(fmt::format("memory once acts are taken back, in the second half of {} more than in the first", acts),
                 most_mb / first_mb - 1, 0.05, "issue 24"));
  out.bars.push_back(acts_bar(fmt::format("of {} patients of which all was taken back, others than before", compared),
                              double(other), 0, "bit-exact"));
  out.bars.back().pass &= compared > 0;
  return out;
}

}  // namespace limberg::bench
