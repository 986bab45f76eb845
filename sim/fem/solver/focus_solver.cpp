#include "sim/fem/solver/focus_solver.h"

#include <algorithm>
#include <cmath>

#include "sim/fem/model/hold_part.h"

namespace limberg {

std::unique_ptr<ElasticSolver> make_focus_solver(Workers& workers, const fem::FocusSettings& settings) {
  return std::make_unique<fem::FocusSolver>(workers, settings);
}

}  // namespace limberg

namespace limberg::fem {
namespace {

constexpr int kIdle = 12;         // steps without a moved target, a fifth of a second, after which nothing is carried
constexpr int kLook = 8;          // steps, at most, from one look at the rim to the next
constexpr int kSoon = 32;         // steps: a part that does not last so long was too small
constexpr double kAmple = 0.25;   // of the budget: what uses less reached too far
constexpr double kFarther = 1.5;  // reaches the next part, where the budget was not kept
constexpr int kWait = 60;         // steps, where a part was too large, or much too small
constexpr double kMoves = 0.25;   // of the largest move: what moves so far belongs to what is carried
constexpr double kBeside_mm = 5;  // around every contact and every spring
constexpr double kBin_mm = 5;     // the reach is counted in boxes, at least so large
constexpr int kMostBins = 128;    // along an axis
constexpr double kStillMoves_mm = 1e-3;

/// Boxes over a model's nodes at rest, marked and grown.
class Bins {
 public:
  explicit Bins(const SharedArray<Vec3>& X) {
    low_ = high_ = X[0];
    for (const Vec3& x : X) low_ = low_.cwiseMin(x), high_ = high_.cwiseMax(x);
    edge_ = std::max(kBin_mm, (high_ - low_).maxCoeff() / kMostBins);
    for (int k = 0; k < 3; ++k) n_[size_t(k)] = int((high_[k] - low_[k]) / edge_) + 1;
    marked_.assign(size_t(n_[0]) * size_t(n_[1]) * size_t(n_[2]), 0);
  }
  void mark(const Vec3& x) { marked_[at(x)] = 1; }
  bool is_marked(const Vec3& x) const { return marked_[at(x)] != 0; }
  /// By so many mm along every axis, or a little more.
  void grow(double mm) {
    const int by = int(std::ceil(mm / edge_));
    const std::array<size_t, 3> step{1, size_t(n_[0]), size_t(n_[0]) * size_t(n_[1])};
    for (size_t axis = 0; axis < 3; ++axis) {
      std::vector<uint8_t> grown(marked_.size(), 0);
      for (size_t i = 0; i < marked_.size(); ++i) {
        if (!marked_[i]) continue;
        const int here = int(i / step[axis]) % n_[axis];
        for (int k = std::max(0, here - by); k <= std::min(n_[axis] - 1, here + by); ++k)
          grown[i + size_t(k) * step[axis] - size_t(here) * step[axis]] = 1;
      }
      marked_ = std::move(grown);
    }
  }

 private:
  size_t at(const Vec3& x) const {
    size_t i = 0;
    for (int k = 2; k >= 0; --k)
      i = i * size_t(n_[size_t(k)]) + size_t(std::clamp(int((x[k] - low_[k]) / edge_), 0, n_[size_t(k)] - 1));
    return i;
  }
  Vec3 low_, high_;
  double edge_ = kBin_mm;
  std::array<int, 3> n_{};
  std::vector<uint8_t> marked_;
};

template <class Take>
void nodes_of(const EmbeddedPoint& p, Take&& take) {
  for (size_t i = 0; i < 8; ++i)
    if (p.w[i] != 0) take(p.node[i]);
}

/// Lists that would be zero are empty in a state.
void put(std::vector<float>& to, size_t size, const std::vector<float>& from, std::span<const int32_t> at,
         size_t each) {
  if (to.empty() && from.empty()) return;
  to.resize(size * each, 0.0f);
  for (size_t i = 0; i < at.size(); ++i)
    for (size_t k = 0; at[i] >= 0 && k < each; ++k)
      to[each * size_t(at[i]) + k] = from.empty() ? 0.0f : from[each * i + k];
}

std::vector<float> taken(const std::vector<float>& from, std::span<const int32_t> at, size_t each) {
  std::vector<float> out;
  if (from.empty()) return out;
  out.resize(each * at.size(), 0.0f);
  for (size_t i = 0; i < at.size(); ++i)
    for (size_t k = 0; at[i] >= 0 && k < each; ++k) out[each * i + k] = from[each * size_t(at[i]) + k];
  return out;
}

}  // namespace

FocusSolver::FocusSolver(Workers& workers, FocusSettings settings)
    : set_(settings), workers_(workers), whole_(std::make_unique<LbfgsSolver>(workers)), reach_mm_(settings.reach_mm) {}

// ---- what is given ----

void FocusSolver::set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) {
  forget();
  whole_->set_model(std::move(model), cell_parent);
  springs_.clear(), contacts_.clear();
}

void FocusSolver::set_springs(std::span<const Spring> springs) {
  std::vector<Spring> sorted(springs.begin(), springs.end());
  std::sort(sorted.begin(), sorted.end(), [](const Spring& a, const Spring& b) { return a.id < b.id; });
  const bool same = std::equal(sorted.begin(), sorted.end(), springs_.begin(), springs_.end(), held_alike);
  if (!same) leave(), carried_.clear();
  for (size_t i = 0; same && i < sorted.size(); ++i)
    if (sorted[i].target_mm != springs_[i].target_mm || sorted[i].thread_mm != springs_[i].thread_mm) {
      if (unmoved_steps_ > kIdle) carried_.clear(), whole_first_ = true;  // a step shows what moves along
      unmoved_steps_ = 0;
      carried_.insert(sorted[i].id);
    }
  if (on_)
    near_->set_springs(sorted), behind_ = true;
  else
    whole_->set_springs(springs);  // in its own order: its InputErrors are of that
  springs_ = std::move(sorted);
}

void FocusSolver::set_contacts(std::span<const Contact> contacts) {
  if (on_ &&
      !std::all_of(contacts.begin(), contacts.end(), [&](const Contact& c) { return covers(c.a) && covers(c.b); }))
    leave();
  if (on_)
    near_->set_contacts(contacts), behind_ = true;
  else
    whole_->set_contacts(contacts);
  contacts_.assign(contacts.begin(), contacts.end());
}

void FocusSolver::set_gravity(const Vec3& m_s2) {
  whole_->set_gravity(m_s2);
  if (near_) near_->set_gravity(m_s2);
}

void FocusSolver::set_loads(std::span<const DeadLoad> loads) {
  if (loads.empty() && whole_->loads().empty()) return;
  leave();
  whole_->set_loads(loads);
}

void FocusSolver::set_displacement_mm(std::span<const Vec3f> u) {
  leave();
  whole_->set_displacement_mm(u);
}

void FocusSolver::restore(const SolverState& state) {
  leave();
  whole_->restore(state);
  whole_first_ = false, calm_.clear();
}

// ---- the part ----

bool FocusSolver::may_focus(const StepSettings& s) const {
  return s.focus && s.dt_s == 0 && !s.afresh && whole_->model().X_mm.size() >= set_.from_nodes &&
         whole_->memory().empty() && whole_->loads().empty();
}

std::vector<uint8_t> FocusSolver::outside() const {
  const FemModel& m = whole_->model();
  Bins bins(m.X_mm);
  const auto mark = [&](int32_t node) { bins.mark(m.X_mm[size_t(node)]); };
  const auto mark_ends = [&](const Spring& s) {
    for (const HeldPlace& p : s.held_a()) nodes_of(p, mark);
    if (!s.to_world)
      for (const HeldPlace& p : s.held_b()) nodes_of(p, mark);
  };
  for (const Spring& s : springs_)
    if (carried_.count(s.id)) mark_ends(s);
  const std::span<const Vec3f> u = whole_->displacement_mm();
  if (calm_.size() == u.size()) {
    float most = 0;
    for (size_t i = 0; i < u.size(); ++i) most = std::max(most, (u[i] - calm_[i]).norm());
    for (size_t i = 0; i < u.size() && most > kStillMoves_mm; ++i)
      if ((u[i] - calm_[i]).norm() > kMoves * most) mark(int32_t(i));
  }
  bins.grow(reach_mm_);
  // Whatever holds or presses is there with both its ends. What holds a surface softly lies everywhere.
  for (const Spring& s : springs_)
    if (!s.lasting) mark_ends(s);
  for (const Contact& c : contacts_) nodes_of(c.a, mark), nodes_of(c.b, mark);
  bins.grow(kBeside_mm);
  std::vector<uint8_t> out(m.X_mm.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = !bins.is_marked(m.X_mm[i]);
  return out;
}

bool FocusSolver::covers(const EmbeddedPoint& p) const {
  bool in = true;
  nodes_of(p, [&](int32_t n) { in = in && near_->holds_node(n); });
  return in;
}

void FocusSolver::enter(const StepSettings& s) {
  if (wait_steps_ > 0) return;
  if (rim_most_mm_ < kAmple * set_.budget_mm) reach_mm_ = std::max(set_.reach_mm, reach_mm_ / kFarther);
  std::vector<uint8_t> out = outside();
  const size_t in = size_t(std::count(out.begin(), out.end(), uint8_t(0)));
  if (double(in) > set_.worth * double(out.size())) {
    wait_steps_ = kWait;
    return;
  }
  StepSettings none = s;
  none.max_iterations = 0;
  of_whole_ = whole_->step(none);                    // with the springs of now
  if (whole_->next_move_mm(out) > set_.budget_mm) {  // here a move goes far
    wait_steps_ = kWait;
    return;
  }
  // The part of before will do where nothing lies outside it now, unless it is much larger.
  const bool again =
      near_ && out_.size() == out.size() && 2 * size_t(std::count(out_.begin(), out_.end(), uint8_t(0))) < 3 * in &&
      std::equal(out.begin(), out.end(), out_.begin(), [](uint8_t now, uint8_t then) { return now >= then; });
  if (!again) {
    const auto part = hold_part(whole_->model(), out);
    part->parent = ParentList::identity(part->X_mm.size()), part->born.clear();
    if (near_) {  // what both parts have is not made again
      near_->set_model(part, ParentList::identity(part->cells.size()));
    } else {
      near_ = std::make_unique<RegionSolver>(std::make_unique<LbfgsSolver>(workers_, true, MetricPolicy{0}));
      near_->set_gravity(whole_->gravity_m_s2());
      near_->set_model(part, {});
    }
    out_ = std::move(out);
  }
  near_->set_springs(springs_);
  near_->set_contacts(contacts_);
  const SolverState all = whole_->save();
  SolverState part;
  part.displacement_mm = taken(all.displacement_mm, near_->nodes(), 3);
  part.pressure = taken(all.pressure, near_->cells(), 1);
  part.since_update = all.since_update;
  near_->restore(part);
  const StepReport at_first = near_->step(none);
  energy_beyond_uJ_ = of_whole_.energy_uJ - at_first.energy_uJ;
  inverted_beyond_ = std::max(0, of_whole_.inverted_cells - at_first.inverted_cells);
  rim_ = near_->support_forces_mN();
  rim_mm_ = rim_most_mm_ = 0, steps_here_ = 0, look_at_ = 1;
  most_nodes_ = std::max(most_nodes_, in);
  const std::span<const Vec3f> u = whole_->displacement_mm();
  shown_.assign(u.begin(), u.end());
  on_ = true, behind_ = false;
}

void FocusSolver::leave() {
  if (!on_) return;
  hand_over();
  on_ = false;
}

void FocusSolver::hand_over() const {
  if (!on_ || !behind_) return;
  whole_->set_springs(springs_);
  whole_->set_contacts(contacts_);
  const FemModel& m = whole_->model();
  SolverState all = whole_->save();
  const SolverState part = near_->save();
  put(all.displacement_mm, m.X_mm.size(), part.displacement_mm, near_->nodes(), 3);
  put(all.pressure, m.cells.size(), part.pressure, near_->cells(), 1);
  all.since_update = part.since_update;
  whole_->restore(all);
  behind_ = false;
}

void FocusSolver::show() {
  const std::span<const Vec3f> u = near_->displacement_mm();
  for (const int32_t v : near_->nodes())
    if (v >= 0) shown_[size_t(v)] = u[size_t(v)];
}

double FocusSolver::look_at_rim() {
  std::vector<SupportForce> more = near_->support_forces_mN();
  size_t n = 0;
  for (size_t i = 0; i < more.size(); ++i) {
    if (more[i].node < 0 || !out_[size_t(more[i].node)]) continue;  // held by the body's own hold as well
    more[n] = more[i], more[n++].force_mN -= rim_[i].force_mN;
  }
  more.resize(n);
  return whole_->first_move_mm(more);
}

void FocusSolver::forget() {
  leave();
  near_.reset(), out_.clear();
  carried_.clear(), calm_.clear();
  unmoved_steps_ = kIdle + 1, wait_steps_ = 0, whole_first_ = false;
  reach_mm_ = set_.reach_mm, rim_most_mm_ = 0;
}

StepReport FocusSolver::step(const StepSettings& s) {
  if (s.afresh) forget();
  const bool may = may_focus(s), carried = may && unmoved_steps_ <= kIdle;
  if (!carried) leave();
  if (carried && !on_ && !whole_first_) enter(s);
  unmoved_steps_ += unmoved_steps_ <= kIdle;
  wait_steps_ -= wait_steps_ > 0;
  if (!on_) {
    of_whole_ = whole_->step(s);
    whole_first_ = false;
    if (may && (of_whole_.converged || calm_.empty())) {
      const std::span<const Vec3f> u = whole_->displacement_mm();
      calm_.assign(u.begin(), u.end());
    }
    return of_whole_;
  }
  const bool given = unmoved_steps_ <= 1;  // something, since the step before
  StepReport r = near_->step(s);
  behind_ = true;
  if (r.converged && !given) {  // at rest: as far as it is near, so the whole sees to the rest of it
    leave();
    unmoved_steps_ = kIdle + 1;
    return of_whole_ = whole_->step(s);
  }
  show();
  ++steps_near_;
  if (++steps_here_ >= look_at_) {
    rim_mm_ = look_at_rim(), rim_most_mm_ = std::max(rim_most_mm_, rim_mm_);
    // Again before the budget is used up, if it goes on as from the beginning.
    const double steps = (set_.budget_mm - rim_mm_) / std::max(rim_mm_ / steps_here_, 1e-9);
    look_at_ = steps_here_ + std::clamp(int(std::min(steps, double(kLook))), 1, kLook);
  }
  r.distance_mm = std::max(r.distance_mm, rim_mm_);
  r.energy_uJ += energy_beyond_uJ_;
  r.inverted_cells += inverted_beyond_;
  r.min_J = std::min(r.min_J, of_whole_.min_J);
  if (rim_mm_ > set_.budget_mm) {
    leave();
    whole_first_ = true;
    if (steps_here_ < kSoon) reach_mm_ *= kFarther;
    if (steps_here_ < kLook) wait_steps_ = kWait;  // here a move goes far: parts are not worth their making
  }
  return r;
}

// ---- what is asked ----

std::span<const Vec3f> FocusSolver::displacement_mm() const {
  return on_ ? std::span<const Vec3f>(shown_) : whole_->displacement_mm();
}

SolverState FocusSolver::save() const {
  hand_over();
  return whole_->save();
}

std::shared_ptr<const SolverPath> FocusSolver::path() const {
  hand_over();
  return whole_->path();
}

Vec3 FocusSolver::spring_force_mN(int32_t id) const {
  if (!on_) return whole_->spring_force_mN(id);
  const auto at = std::lower_bound(springs_.begin(), springs_.end(), id,
                                   [](const Spring& s, int32_t wanted) { return s.id < wanted; });
  const bool lasting = at != springs_.end() && at->id == id && at->lasting;
  // One that lasts may hang on tissue that holds still; the whole has it where it is.
  return lasting && !covers(at->a) ? whole_->spring_force_mN(id) : near_->spring_force_mN(id);
}

double FocusSolver::contact_force_mN(size_t i) const {
  return on_ ? near_->contact_force_mN(i) : whole_->contact_force_mN(i);
}

Vec3 FocusSolver::contact_friction_mN(size_t i) const {
  return on_ ? near_->contact_friction_mN(i) : whole_->contact_friction_mN(i);
}

std::vector<SupportForce> FocusSolver::support_forces_mN() const {
  hand_over();
  return whole_->support_forces_mN();
}

void FocusSolver::cell_J(std::vector<float>& J) const {
  hand_over();
  whole_->cell_J(J);
}

Mat3 FocusSolver::cell_F(int32_t cell) const {
  return on_ && near_->holds_cell(cell) ? near_->cell_F(cell) : whole_->cell_F(cell);
}

std::string FocusSolver::describe() const {
  if (steps_near_ == 0) return whole_->describe();
  return whole_->describe() + "; " + std::to_string(steps_near_) + " steps near what was carried, " +
         std::to_string(most_nodes_) + " of " + std::to_string(whole_->model().X_mm.size()) + " nodes at most";
}

}  // namespace limberg::fem
