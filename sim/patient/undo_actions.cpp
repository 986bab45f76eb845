// Undo and redo: from moment to moment (operating_table.h).
#include "sim/base/hash.h"
#include "sim/contact/contact_finder.h"
#include "sim/patient/operating_table.h"

namespace limberg {
OperatingTable::Moment OperatingTable::moment() const {
  Moment m;
  m.version = version_;
  m.solver = solver_->save();
  m.contacts = contact_memory();
  m.hooks = hooks_;
  m.stitches = stitches_;
  m.threads = threads_;
  m.open_energy_uJ = open_energy_uJ_;
  m.volume_mm3 = volume_mm3_;
  m.removed_volume_mm3 = removed_volume_mm3_;
  m.cuts = cuts_;
  m.next_spring = next_spring_;
  m.next_stitch = next_stitch_;
  m.next_thread = next_thread_;
  return m;
}

ContactMemory OperatingTable::contact_memory() const {
  if (contacts_to_resume_) return *contacts_to_resume_;  // not taken up yet
  return contacts_ && contacts_lattice_ == version_.lattice ? contacts_->memory() : ContactMemory();
}

void OperatingTable::return_to(const Moment& m, ParentList parent) {
  if (m.version.lattice != version_.lattice) {
    version_ = m.version;
    // The same surface under a new number: readers take versions to grow.
    auto surface = std::make_shared<SurfaceTopology>(*m.version.surface);
    surface->version = next_version_++;
    version_.surface = surface;
    // The same model, for a solver that comes from another side of it than when it was made.
    auto model = std::make_shared<FemModel>(*m.version.model);
    model->parent = std::move(parent);
    version_.model = model;
    solver_->set_model(version_.model, {});
  }
  hooks_ = m.hooks;
  stitches_ = m.stitches;
  threads_ = m.threads;
  open_energy_uJ_ = m.open_energy_uJ;
  volume_mm3_ = m.volume_mm3;
  removed_volume_mm3_ = m.removed_volume_mm3;
  cuts_ = m.cuts;
  next_spring_ = m.next_spring;
  next_stitch_ = m.next_stitch;
  next_thread_ = m.next_thread;
  publish_springs();
  solver_->restore(m.solver);
  contacts_to_resume_ = m.contacts;
}

void OperatingTable::remember(Done done) {
  undone_.clear();
  if (stroke_ && stroke_->cut) stop_stroke(stroke_->id, "another act came between");
  done_.push_back(std::move(done));
}

void OperatingTable::take_back(std::span<const CutStep> steps) {
  if (!arrangement_) return;
  followed_.reset();  // (whatever is not taken back is followed again)
  for (size_t i = steps.size(); i-- > 0;)
    for (int k = 0; k < steps[i].operations; ++k) arrangement_->undo();
}

bool OperatingTable::cut_again(const CutStep& s) {
  const bool cuts = !s.blade.tri.empty();  // else it only takes something out
  if (cuts && !arrangement_->cut(s.blade, s.seed, s.first_try).ok()) return false;
  int operations = cuts;
  if (s.excised >= 0) operations += arrangement_->excise(s.excised).done;
  arrangement_->sweep_debris(kDebris_mm3);
  if (operations == s.operations && arrangement_->hash() == s.hash_after) return true;
  for (; operations > 0; --operations) arrangement_->undo();
  return false;
}

Outcome OperatingTable::act(const Undo&) {
  if (done_.empty()) return {false, "there is nothing to undo; a cut, an excision or a stitch before it was expected"};
  if (stroke_) stop_stroke(stroke_->id, "it was taken back");
  Undone u{std::move(done_.back()), moment()};
  done_.pop_back();
  take_back(u.done.steps);
  // Each node returns from one of the nodes that it was parted into.
  ParentList parent;
  if (!u.done.ancestor.empty()) parent = u.done.ancestor.reversed(u.done.before.version.model->X_mm.size());
  return_to(u.done.before, std::move(parent));
  undone_.push_back(std::move(u));
  return {true, {}};
}

Outcome OperatingTable::act(const Redo&) {
  if (undone_.empty()) return {false, "there is nothing to redo; an undo as the last act was expected"};
  if (stroke_) stop_stroke(stroke_->id, "another act came between");
  Undone& u = undone_.back();
  for (size_t i = 0; i < u.done.steps.size(); ++i)
    if (!cut_again(u.done.steps[i])) {
      take_back(std::span(u.done.steps).first(i));
      return {false, "the same cut came out differently: a defect of the program"};
    }
  return_to(u.after, u.done.ancestor);
  done_.push_back(std::move(u.done));
  undone_.pop_back();
  return {true, {}};
}

uint64_t OperatingTable::full_hash() const {
  Hash64 h;
  h.add(state_hash());
  h.add(arrangement_ ? arrangement_->full_hash() : 0);
  const SolverState s = solver_->save();
  for (const std::vector<float>* v : {&s.displacement_mm, &s.velocity_mm_s, &s.pressure, &s.memory}) {
    h.add(uint64_t(v->size()));
    h.bytes(v->data(), v->size() * sizeof(float));
  }
  h.add(s.since_update);
  if (s.before_s > 0)
    for (const std::vector<float>* v : {&s.displacement_before_mm, &s.velocity_before_mm_s})
      h.bytes(v->data(), v->size() * sizeof(float));
  const ContactMemory contacts = contact_memory();
  for (const HeldContact& c : contacts.pairs) {
    for (const int32_t v : {c.place, c.sheet, c.triangle, int32_t(c.judged)}) h.add(v);
    for (const double v : {c.bary[0], c.bary[1], c.bary[2], c.weight, c.gap_mm}) h.add(v);
    for (const Vec3* v : {&c.normal, &c.facet, &c.apart_mm}) h.bytes(v->data(), 3 * sizeof(double));
  }
  for (const ContactMemory::Spot& k : contacts.spots)
    h.add(k.place), h.add(k.turns), h.bytes(k.slid_mm.data(), 3 * sizeof(double));
  for (const Hook& k : hooks_) h.add(k.spring), h.add(k.anchor.at.triangle);
  for (const Stitch& k : stitches_) h.add(k.spring), h.add(k.a.at.triangle), h.add(k.b.at.triangle);
  for (const Thread& t : threads_) h.add(t.id), h.add(t.length_mm), h.add(uint64_t(t.closing));
  h.add(volume_mm3_), h.add(removed_volume_mm3_);
  h.add(cuts_), h.add(next_spring_), h.add(next_stitch_);
  const SurfaceTopology& t = *version_.surface;
  for (const Vec3& X : t.view.X_mm) h.bytes(X.data(), 3 * sizeof(double));
  for (const Tri& tri : t.view.tri) h.bytes(tri.data(), sizeof tri);
  for (const EmbeddedPoint& e : t.embedding) h.bytes(e.node.data(), sizeof e.node), h.bytes(e.w.data(), sizeof e.w);
  for (const float d : t.depth_mm.all()) h.add(d);
  return h.value();
}

}  // namespace limberg
