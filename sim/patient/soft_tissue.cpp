#include "sim/patient/soft_tissue.h"

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/patient/open_stroke.h"

namespace limberg {
namespace {

constexpr double kRest = 1e-3;  // relative residual of a state whose forces count

}  // namespace

void TissueChange::append(TissueChange& later) {
  ParentList both = later.ancestor.through(ancestor);
  steps.reserve(steps.size() + later.steps.size());
  std::move(later.steps.begin(), later.steps.end(), std::back_inserter(steps));
  ancestor = std::move(both);
}

SoftTissue::SoftTissue(WorldSpec spec, Workers& workers) : tissue_(std::move(spec), workers) {
  figures_.volume_mm3 = tissue_.initial_volume_mm3();
  loads_.place();
  publish_holding();
}

SoftTissue::~SoftTissue() = default;

// ---- acts ----

Acted<TissueChange> SoftTissue::act(const Command& command) {
  const Holding held = holding_;
  const auto roll_back = [&] {  // a cut has taken itself back by now
    if (stroke_) stop_stroke("a piece of it failed");
    holding_ = held;
    publish_holding();
  };
  try {
    return carry_out_act(command);
  } catch (const InputError& e) {
    roll_back();
    return {false, std::string("the act failed inside (") + e.what() + "); nothing has changed"};
  } catch (...) {
    roll_back();
    throw;
  }
}

Acted<TissueChange> SoftTissue::carry_out_act(const Command& command) {
  const auto holds = [&](const auto& c) -> Acted<TissueChange> {
    using Act = std::decay_t<decltype(c)>;
    constexpr bool is_hook =
        std::is_same_v<Act, SetHook> || std::is_same_v<Act, MoveHook> || std::is_same_v<Act, ReleaseHook>;
    constexpr bool is_suture = std::is_same_v<Act, Suture> || std::is_same_v<Act, SutureRow> ||
                               std::is_same_v<Act, SutureCorner> || std::is_same_v<Act, SutureBetween> ||
                               std::is_same_v<Act, CutSuture> || std::is_same_v<Act, SutureBite> ||
                               std::is_same_v<Act, TieSuture> || std::is_same_v<Act, LetThreadGo>;
    constexpr bool is_cut = std::is_same_v<Act, Incise> || std::is_same_v<Act, InciseMore> ||
                            std::is_same_v<Act, Undermine> || std::is_same_v<Act, Excise> ||
                            std::is_same_v<Act, ExcisePiece> || std::is_same_v<Act, CutThrough>;
    if constexpr (std::is_same_v<Act, InSpace>) {
      return act_in_space(c);
    } else if constexpr (std::is_same_v<Act, Activate>) {
      return activate(c);
    } else if constexpr (is_hook) {
      Acted<TissueChange> made = hooks_.act(c);
      made.ends_redo = made.done && !std::is_same_v<Act, MoveHook>;
      if (made.done) publish_holding();
      return made;
    } else if constexpr (is_suture) {
      TissueChange change;
      change.before = moment();
      const Outcome o = sutures_.act(c);
      if (!o.done) return o;
      publish_holding();
      another_act();
      return {o, std::move(change)};
    } else if constexpr (is_cut) {
      if (!tissue_.arrangement()) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
      Acted<TissueChange> made = cut(c);
      if (made.change && !std::is_same_v<Act, InciseMore>) another_act();
      return made;
    } else {
      return {false, "soft tissue knows no such act; a cut, a hook or a stitch was expected"};
    }
  };
  return std::visit(holds, command);
}

Acted<TissueChange> SoftTissue::activate(const Activate& c) {
  const auto& regions = tissue_.body().regions;
  std::string muscles;
  for (size_t r = 0; r < regions.size(); ++r) {
    if (!regions[r]->activation()) continue;
    if (regions[r]->name() != c.region) {
      muscles += (muscles.empty() ? "" : ", ") + regions[r]->name();
      continue;
    }
    TissueChange change;
    change.before = moment();
    std::vector<double> activation = tissue_.version().activation;
    activation[r] = c.level;
    tissue_.activate(std::move(activation));
    publish_holding();
    contacts_.resume(change.before.contacts);
    another_act();
    return {{true, {}}, std::move(change)};
  }
  return {false,
          "the patient has no muscle \"" + c.region + "\"; expected " +
              (muscles.empty() ? "a scene with a [[region]] whose law has \"activation\"" : "one of " + muscles)};
}

void SoftTissue::take_back(TissueChange& change) {
  change.after = moment();
  // Each node returns from one of the nodes that it was parted into.
  ParentList parent;
  if (!change.ancestor.empty()) parent = change.ancestor.reversed(change.before.version.model->X_mm.size());
  TissueCut::make_room_to_take_back(tissue_, change.steps);
  try {
    return_to(change.before, std::move(parent));
  } catch (...) {
    return_to(*change.after, change.ancestor);
    throw;
  }
  TissueCut::take_back(tissue_, change.steps);
}

Outcome SoftTissue::make_again(TissueChange& change) {
  const TissueMoment now = moment();
  std::optional<TissueCut> cut;  // takes itself back unless it is kept
  if (!change.steps.empty()) cut.emplace(tissue_);
  for (const CutStep& s : change.steps)
    if (!cut->again(s)) return {false, "the same cut came out differently: a defect of the program"};
  try {
    return_to(*change.after, change.ancestor);
  } catch (...) {
    return_to(now, change.ancestor.empty() ? ParentList{} : change.ancestor.reversed(now.version.model->X_mm.size()));
    throw;
  }
  if (cut) cut->keep();
  change.after.reset();
  return {true, {}};
}

std::vector<Spring> SoftTissue::all_springs() {
  std::vector<Spring> all = springs(holding_, tissue_.spec());
  const std::vector<Spring>& soft = soft_hold_.springs();
  all.insert(all.end(), soft.begin(), soft.end());
  return all;
}

void SoftTissue::publish_holding() {
  tissue_.solver().set_springs(all_springs());
  tissue_.solver().set_loads(loads(holding_));
}

TissueMoment SoftTissue::moment() const {
  return {tissue_.version(), tissue_.solver().save(), tissue_.solver().path(), contacts_.memory(), holding_, figures_};
}

void SoftTissue::return_to(const TissueMoment& m, ParentList parent) {
  tissue_.return_to(m.version, std::move(parent));
  holding_ = m.holding;
  figures_ = m.figures;
  publish_holding();
  tissue_.solver().restore(m.solver);
  if (m.path) tissue_.solver().take_up(*m.path);
  contacts_.resume(m.contacts);
}

// ---- steps ----

StepReport SoftTissue::step(const StepSettings& settings) {
  if (sutures_.draw_tight()) publish_holding();
  StepReport report = contacts_.step(settings);
  report.distance_mm += sutures_.to_draw_mm();  // the hand is not done
  figures_.last = {report.energy_uJ, float(report.residual), float(report.distance_mm)};
  if (report.residual > kRest || !settled()) return report;
  if (holding_.hooks.empty() && holding_.stitches.empty()) figures_.open_energy_uJ = report.energy_uJ;
  sutures_.note_forces();
  return report;
}

std::optional<double> SoftTissue::closure_energy_uJ() const {
  if (!figures_.open_energy_uJ || holding_.stitches.empty() || !holding_.hooks.empty()) return std::nullopt;
  return figures_.last.energy_uJ - *figures_.open_energy_uJ;
}

void SoftTissue::fill(Snapshot& snapshot, bool with_field) const {
  publisher_.fill(tissue_, holding_, figures_.last, snapshot, with_field);
  snapshot.sewn = sutures_.sewn().value_or(SewnThread{});
}

PressAnswer SoftTissue::press(const PressQuestion& question, int iterations) {
  if (!press_) press_ = std::make_unique<PressProbe>(tissue_.workers());
  const std::vector<Spring> held = all_springs();
  return press_->ask(
      {tissue_.surface(), tissue_.version().model, tissue_.solver(), held, contacts_.contacts(), tissue_.body()},
      question, iterations);
}

// ---- hashes ----

uint64_t SoftTissue::state_hash() const {
  Hash64 h;
  h.add(topology_hash());
  const std::span<const Vec3f> u = solver().displacement_mm();
  h.bytes(u.data(), u.size() * sizeof(Vec3f));
  for (const Hook& k : holding_.hooks) {
    h.add(k.id);
    h.bytes(k.anchor.X_mm.data(), 3 * sizeof(double));
    h.bytes(k.handle_mm.data(), 3 * sizeof(double));
  }
  for (const Stitch& s : holding_.stitches) {
    h.add(s.id);
    h.bytes(s.a.X_mm.data(), 3 * sizeof(double));
    h.bytes(s.b.X_mm.data(), 3 * sizeof(double));
    h.bytes(s.slack_mm.data(), 3 * sizeof(double));
    if (s.own_mm >= 0) h.add(s.own_mm);
  }
  for (const Thread& t : holding_.threads) h.add(t.id), h.add(t.length_mm);
  for (const PlacedLoad& l : holding_.loads) h.bytes(l.anchor.X_mm.data(), 3 * sizeof(double));
  if (const auto m = solver().memory(); !m.empty()) h.bytes(m.data(), m.size() * sizeof(float));
  return h.value();
}

uint64_t SoftTissue::full_hash() const {
  FieldHash h;
  h(moment(), arrangement() ? arrangement()->full_hash() : 0);
  return h.value();
}

}  // namespace limberg
