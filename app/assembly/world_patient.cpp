#include "app/assembly/world_patient.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <tuple>

#include "sim/cutting/strokes/free_margin.h"
#include "sim/patient/soft_tissue.h"
#include "sim/skull/head/head.h"

namespace limberg {

namespace {

double depth_of(const Command& c) {
  if (const auto* i = std::get_if<Incise>(&c)) return i->depth_mm;
  if (const auto* m = std::get_if<InciseMore>(&c)) return m->depth_mm;
  if (const auto* u = std::get_if<Undermine>(&c)) return u->depth_mm;
  if (const auto* e = std::get_if<Excise>(&c)) return e->depth_mm;
  return 0;
}

}  // namespace

bool WorldPatient::chart_means(const ChartPoint& place, const Vec3& X_mm) const {
  const Skin& skin = world_.skin()->skin_at_rest();
  const auto hit = skin.at(place);
  return hit && limberg::chart_means(hit->X_mm, hit->normal, X_mm, skin.body().chart_normal());
}

Vec3 WorldPatient::normal(const Vec3& X_mm) const { return world_.skin()->skin_at_rest().frame(X_mm).normal; }

// A hand stops short of a margin, or rolls over it: a lip's red is some 8 mm from skin to crest, and half of it is
// turned away.
bool WorldPatient::margin_beyond(const Vec3& X_mm, const Vec3& out, const Vec3& way) const {
  constexpr double kReach_mm = 5;
  return limberg::margin_beyond(world_.skin()->skin_at_rest(), X_mm, out, way, kReach_mm);
}

void WorldPatient::fill_lattice(LatticeShown& out) const {
  if (!world_.skin()) {
    out = {};
    return;
  }
  const SoftTissue& skin = *world_.skin();
  const FemModel& model = skin.solver().model();
  const std::span<const Vec3f> u = skin.solver().displacement_mm();
  const uint64_t version = skin.topology()->version;
  if (!lattice_.edges || lattice_.version != version) {
    const std::shared_ptr<const LatticeTopology> lattice = skin.lattice();
    auto edges = std::make_shared<std::vector<LatticeShown::Edge>>();
    // Corner k of a cell is high in x, y, z where bit 0, 1, 2 of k is set: an edge changes one bit.
    for (size_t c = 0; c < model.cells.size(); ++c) {
      const bool copied = lattice && c < lattice->cells.size() && lattice->copies_of(lattice->cells[c].cell) > 1;
      for (int k = 0; k < 8; ++k)
        for (int bit = 1; bit < 8; bit *= 2)
          if (!(k & bit)) {
            const auto [a, b] = std::minmax(model.cells[c].node[size_t(k)], model.cells[c].node[size_t(k | bit)]);
            edges->push_back({a, b, copied});
          }
    }
    std::sort(edges->begin(), edges->end(), [](const auto& x, const auto& y) {
      return std::tuple(x.a, x.b, !x.copied) < std::tuple(y.a, y.b, !y.copied);
    });
    edges->erase(std::unique(edges->begin(), edges->end(),
                             [](const auto& x, const auto& y) { return x.a == y.a && x.b == y.b; }),
                 edges->end());
    lattice_.version = version, lattice_.edges = std::move(edges);
  }
  out.version = version, out.edges = lattice_.edges;
  out.node_mm.resize(model.X_mm.size());
  for (size_t n = 0; n < model.X_mm.size(); ++n) out.node_mm[n] = model.X_mm[n].cast<float>() + u[n];
}

int WorldPatient::pieces_of_bone() const {
  const Head* head = world_.head();
  return head ? int(head->bones().fragments().size()) : -1;
}

Outcome WorldPatient::apply(const Command& c) {
  const double depth = depth_of(c);
  if (world_.skin() && depth > max_depth_mm_)
    return {false, fmt::format("depth {:.6g} mm is deeper than the scene allows; expected at most {:.6g} mm", depth,
                               max_depth_mm_)};
  Outcome o = world_.apply(c);
  // World refuses an act for which there was no memory. A session must not go on after that: whoever does it again has
  // the memory, and another patient.
  if (o.no_memory) throw std::bad_alloc();
  return o;
}

}  // namespace limberg
