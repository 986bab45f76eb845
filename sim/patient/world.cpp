#include "sim/patient/world.h"

#include "sim/patient/operating_table.h"
#include "sim/patient/press.h"

namespace limberg {

// The story of the patient is in operating_table.h; this is the door to it.
struct World::Impl : OperatingTable {
  using OperatingTable::OperatingTable;
};

World::World(WorldSpec spec, Workers& workers) : impl_(std::make_unique<Impl>(std::move(spec), workers)) {}
World::~World() = default;
World::World(World&&) noexcept = default;

Outcome World::apply(const Command& command) { return impl_->apply(command); }
StepReport World::step(const StepSettings& settings) { return impl_->step(settings); }
void World::hold_at(const std::function<Vec3(const Vec3&)>& where) { impl_->hold_at(where); }
void World::fill(Snapshot& snapshot, bool with_field) const { impl_->fill(snapshot, with_field); }
std::shared_ptr<const SurfaceTopology> World::topology() const { return impl_->topology(); }
PressAnswer World::press(const PressQuestion& q, int iterations) { return impl_->press(q, iterations); }
uint64_t World::topology_hash() const { return impl_->topology_hash(); }
uint64_t World::state_hash() const { return impl_->state_hash(); }
uint64_t World::full_hash() const { return impl_->full_hash(); }
const WorldSpec& World::spec() const { return impl_->spec(); }
const ElasticSolver& World::solver() const { return impl_->solver(); }
const Arrangement* World::arrangement() const { return impl_->arrangement(); }
std::shared_ptr<const LatticeTopology> World::lattice() const { return impl_->lattice(); }
double World::volume_mm3() const { return impl_->volume_mm3(); }
double World::removed_volume_mm3() const { return impl_->removed_volume_mm3(); }
double World::initial_volume_mm3() const { return impl_->initial_volume_mm3(); }
int World::pieces() const { return impl_->pieces(); }
int World::refused() const { return impl_->refused(); }
ContactCounts World::contact_counts() const { return impl_->contact_counts(); }
bool World::settled() const { return impl_->settled(); }
std::optional<double> World::closure_energy_uJ() const { return impl_->closure_energy_uJ(); }

}  // namespace limberg
