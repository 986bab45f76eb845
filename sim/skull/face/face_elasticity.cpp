#include "sim/skull/face/face_elasticity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/fem/elements/shaped_cells.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/lbfgs_solver.h"

namespace limberg::simplex {

double top_layer_kPa(const Tissue& t, double young_kPa, const ElasticitySettings& s) {
  if (!(s.skin_kPa > 0) || t.layers < 1) return young_kPa;
  const size_t n = t.node_mm.size() / size_t(t.layers + 1), top = n * size_t(t.layers);
  double thick = 0;
  for (size_t i = 0; i < n; ++i) thick += (t.node_mm[top + i] - t.node_mm[top - n + i]).norm() / double(n);
  const double share = thick > 0 ? std::min(1., s.skin_mm / thick) : 0;
  return (1 - share) * young_kPa + share * s.skin_kPa;
}

struct FaceElasticity::Impl {
  explicit Impl(Workers& w) : solver(w, true, {.factor_up_to_nodes = 1 << 30}) {}
  FemModel model;
  fem::LbfgsSolver solver;
  std::vector<Vec3f> u;
  std::vector<Vec3> last;  // what the solver gave back: given again unchanged, it goes on where it stands
};

FaceElasticity::FaceElasticity(std::span<const Body> bodies, const ElasticitySettings& s, Workers& workers)
    : impl_(std::make_unique<Impl>(workers)) {
  if (!(s.poisson >= 0 && s.poisson <= 0.49))
    throw InputError("", 0, "a Poisson ratio of 0 to 0.49 was expected for the tissue under a face");
  if (!(s.skin_mm >= 0) || !(s.skin_kPa >= 0) || !std::isfinite(s.skin_mm + s.skin_kPa))
    throw InputError("", 0, "the skin's thickness and stiffness must be finite numbers, 0 or more");
  ShapedModel shaped;
  std::vector<std::vector<int32_t>> law_of;  // of each bundle, by the pieces of its path
  for (const FaceBundle& b : s.bundles) {
    std::vector<int32_t>& laws = law_of.emplace_back();
    for (size_t k = 0; k == 0 || k + 1 < b.path_mm.size(); ++k)  // a path without a piece is refused with its first
      laws.push_back(shaped.add_law(bundle_law(b, k, s.poisson)));
  }
  bundled_.resize(s.bundles.size()), sliding_.resize(s.slides.size());
  std::map<std::array<double, 3>, int32_t> weld;  // nodes on the skin by their place, the same bits where regions meet
  for (const Body& b : bodies) {
    const Tissue& t = *b.tissue;
    if (t.tet.empty() || t.layers < 1) throw InputError("", 0, "a tissue with tetrahedra was expected");
    if (!(b.young_kPa > 0) || !std::isfinite(b.young_kPa))
      throw InputError("", 0, "finite elements need a stiffness above 0 kPa");
    const size_t n = t.node_mm.size() / size_t(t.layers + 1), top = n * size_t(t.layers);
    std::vector<int32_t>& number = node_.emplace_back();
    for (size_t i = 0; i < t.node_mm.size(); ++i) {
      const Vec3& X = t.node_mm[i];
      if (i >= top) {
        const auto [it, fresh] = weld.try_emplace({X.x(), X.y(), X.z()}, int32_t(held_.size()));
        if (!fresh) {
          number.push_back(it->second);
          continue;
        }
      }
      held_.push_back(i < n);
      number.push_back(shaped.add_node(X, i < n));
    }
    const double skinned = top_layer_kPa(t, b.young_kPa, s);
    const auto law = [&](double young) {
      const Elastic e = elastic_from_young(young, s.poisson);
      return shaped.add_law(stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa));
    };
    const int32_t fat = law(b.young_kPa), skin = law(skinned);
    std::map<std::pair<int, int>, int32_t> loose;  // by the slide, and the layer's thickness in steps of a twentieth
    const auto loose_law = [&](int slide, const std::array<int32_t, 4>& q) {
      double thickness_mm = 0;
      for (const int32_t v : q) {
        const size_t column = size_t(v) % n;
        thickness_mm += 0.25 * (t.node_mm[n + column] - t.node_mm[column]).norm();
      }
      const int step = int(std::lround(elementary::log(thickness_mm) / elementary::log(1.05)));
      const auto [at, anew] = loose.try_emplace({slide, step}, 0);
      if (anew)
        at->second =
            shaped.add_law(slide_law(s.slides[size_t(slide)], elementary::pow(1.05, step), b.young_kPa, s.poisson));
      return at->second;
    };
    const size_t of_layer = t.tet.size() / size_t(t.layers);
    for (size_t k = 0; k < t.tet.size(); ++k) {
      std::array<int32_t, 4> q{};
      for (size_t c = 0; c < 4; ++c) q[c] = number[size_t(t.tet[k][c])];
      const bool top_layer = k / of_layer + 1 == size_t(t.layers);
      int32_t own = top_layer ? skin : fat;
      if (!top_layer && !(s.bundles.empty() && s.slides.empty())) {
        std::array<Vec3, 4> X;
        for (size_t c = 0; c < 4; ++c) X[c] = t.node_mm[size_t(t.tet[k][c])];
        const Vec3 middle = 0.25 * (X[0] + X[1] + X[2] + X[3]);
        const auto count = [&](Bundled& in) {
          ++in.tetrahedra;
          in.volume_mm3 += std::fabs((X[1] - X[0]).cross(X[2] - X[0]).dot(X[3] - X[0])) / 6;
        };
        if (const auto in = bundle_at(s.bundles, middle)) {
          own = law_of[in->bundle][in->piece];
          count(bundled_[in->bundle]);
        } else if (const int slide = k < of_layer ? slide_at(s.slides, middle) : -1; slide >= 0) {
          own = loose_law(slide, t.tet[k]);
          count(sliding_[size_t(slide)]);
        }
      }
      shaped.add_tet(q, own);
    }
  }
  impl_->model = shaped.finish();
  impl_->solver.set_model(std::make_shared<const FemModel>(impl_->model), {});
  impl_->u.assign(held_.size(), Vec3f::Zero());
  impl_->last.assign(held_.size(), Vec3::Zero());
}

FaceElasticity::~FaceElasticity() = default;

size_t FaceElasticity::nodes() const { return held_.size(); }

void FaceElasticity::hold(std::span<const uint8_t> held) {
  if (held.size() != held_.size()) throw InputError("", 0, "one flag per node was expected");
  held_.assign(held.begin(), held.end());
  impl_->model.fixed.assign(held.size(), false);
  for (size_t i = 0; i < held.size(); ++i) impl_->model.fixed[i] = held[i] != 0;
  impl_->solver.set_model(std::make_shared<const FemModel>(impl_->model), {});
  impl_->last.assign(held_.size(), Vec3::Constant(NAN));
}

FaceElasticity::Report FaceElasticity::step(std::vector<Vec3>& u, int iterations, double tolerance) {
  Impl& m = *impl_;
  if (u.size() != held_.size()) throw InputError("", 0, "one displacement per node was expected");
  if (u != m.last) {
    for (size_t i = 0; i < u.size(); ++i) m.u[i] = u[i].cast<float>();
    m.solver.set_displacement_mm(m.u);
  }
  StepSettings s;
  s.max_iterations = iterations, s.tolerance = tolerance;
  const StepReport r = m.solver.step(s);
  const std::span<const Vec3f> now = m.solver.displacement_mm();
  for (size_t i = 0; i < u.size(); ++i) u[i] = now[i].cast<double>();
  m.last = u;
  return {r.iterations, r.residual, r.distance_mm, r.inverted_cells, r.converged || r.at_floor};
}

}  // namespace limberg::simplex
