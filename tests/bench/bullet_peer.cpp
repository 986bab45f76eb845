#include "tests/bench/bullet_peer.h"

#include <stdexcept>

#ifdef LIMBERG_HAS_BULLET
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>
#endif

namespace limberg::bench {

#ifdef LIMBERG_HAS_BULLET

bool has_bullet() { return true; }

namespace {

btVector3 to_bullet(const Vec3& v) { return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])}; }

/// Zero-length springs between weighted means of nodes, or to a place; linear, so its differential is constant.
class EmbeddedSprings final : public btDeformableLagrangianForce {
 public:
  struct Item {
    std::vector<int> node;
    std::vector<btScalar> w;
    btVector3 target{0, 0, 0};
    btScalar k = 0;
  };
  std::vector<Item> items;

  void addScaledForces(btScalar scale, TVStack& force) override { add(scale, force); }
  void addScaledExplicitForce(btScalar scale, TVStack& force) override { add(scale, force); }
  void addScaledDampingForce(btScalar, TVStack&) override {}
  void addScaledDampingForceDifferential(btScalar, const TVStack&, TVStack&) override {}
  void buildDampingForceDifferentialDiagonal(btScalar, TVStack&) override {}
  void addScaledElasticForceDifferential(btScalar scale, const TVStack& dx, TVStack& df) override {
    for (const Item& s : items) {
      btVector3 r(0, 0, 0);
      for (size_t i = 0; i < s.node.size(); ++i) r += s.w[i] * dx[s.node[i]];
      for (size_t i = 0; i < s.node.size(); ++i) df[s.node[i]] -= scale * s.k * s.w[i] * r;
    }
  }
  btDeformableLagrangianForceType getForceType() override { return BT_MOUSE_PICKING_FORCE; }
  double totalElasticEnergy(btScalar) override {
    double e = 0;
    for (const Item& s : items) e += 0.5 * double(s.k) * double(gap(s).length2());
    return e;
  }

 private:
  btVector3 gap(const Item& s) const {
    btVector3 r = -s.target;
    for (size_t i = 0; i < s.node.size(); ++i) r += s.w[i] * m_softBodies[0]->m_nodes[s.node[i]].m_q;
    return r;
  }
  void add(btScalar scale, TVStack& force) const {
    if (m_softBodies.size() == 0) return;
    for (const Item& s : items) {
      const btVector3 f = scale * s.k * gap(s);
      for (size_t i = 0; i < s.node.size(); ++i) force[s.node[i]] -= s.w[i] * f;
    }
  }
};

}  // namespace

struct BulletBody::Impl {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btDeformableBodySolver solver;
  btDeformableMultiBodyConstraintSolver constraints;
  btDeformableMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &constraints, &configuration, &solver};
  btDeformableNeoHookeanForce elastic;
  EmbeddedSprings springs;
  std::unique_ptr<btSoftBody> body;
  std::vector<Vec3> X;
  std::vector<uint8_t> fixed;

  Impl(const FemModel& m, double mu, double lambda, double damping)
      : elastic(btScalar(mu), btScalar(lambda), btScalar(damping)), X(m.X_mm) {
    for (const Held held : m.fixed) fixed.push_back(held.any());
    constraints.setDeformableSolver(&solver);
    world.setGravity({0, 0, 0});
    world.getWorldInfo().m_gravity = {0, 0, 0};
    world.getWorldInfo().m_sparsesdf.Initialize();
    std::vector<btVector3> x;
    std::vector<btScalar> mass;
    for (size_t i = 0; i < X.size(); ++i)
      x.push_back(to_bullet(X[i])), mass.push_back(fixed[i] ? 0 : btScalar(m.mass_kg[i]));
    body = std::make_unique<btSoftBody>(&world.getWorldInfo(), int(x.size()), x.data(), mass.data());
    for (auto t : five_tets(m)) {
      if ((X[size_t(t[1])] - X[size_t(t[0])])
              .cross(X[size_t(t[2])] - X[size_t(t[0])])
              .dot(X[size_t(t[3])] - X[size_t(t[0])]) < 0)
        std::swap(t[2], t[3]);
      body->appendTetra(t[0], t[1], t[2], t[3]);
    }
    btSoftBodyHelpers::generateBoundaryFaces(body.get());
    body->initializeDmInverse();
    body->m_tetraScratches.resize(body->m_tetras.size());
    body->m_tetraScratchesTn.resize(body->m_tetras.size());
    body->m_cfg.collisions = 0;
    body->m_cfg.m_maxStress = 0;
    body->setSelfCollision(false);
    body->m_sleepingThreshold = 0;
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addSoftBody(body.get());
    world.setImplicit(true);
    world.setLineSearch(false);
    world.setUseProjection(true);
    solver.setPreconditioner(btDeformableBackwardEulerObjective::Mass_preconditioner);
    world.addForce(body.get(), &elastic);
    world.addForce(body.get(), &springs);
  }
  ~Impl() { world.removeSoftBody(body.get()); }
};

BulletBody::BulletBody(const FemModel& m, double mu, double lambda, double damping)
    : impl_(std::make_unique<Impl>(m, mu, lambda, damping)) {}
BulletBody::~BulletBody() = default;

void BulletBody::set_springs(std::span<const Spring> springs) {
  impl_->springs.items.clear();
  for (const Spring& s : springs) {
    EmbeddedSprings::Item it;
    const auto add = [&](const EmbeddedPoint& p, float sign) {
      for (size_t i = 0; i < 8; ++i)
        if (p.w[i] != 0) it.node.push_back(p.node[i]), it.w.push_back(sign * p.w[i]);
    };
    add(s.a, 1);
    if (!s.to_world) add(s.b, -1);
    it.target = to_bullet(s.target_mm), it.k = btScalar(1000 * s.k_N_per_mm);
    impl_->springs.items.push_back(std::move(it));
  }
}

void BulletBody::set_displacement_mm(std::span<const Vec3f> u) {
  for (size_t i = 0; i < u.size(); ++i) {
    btSoftBody::Node& n = impl_->body->m_nodes[int(i)];
    n.m_x = n.m_q = to_bullet(impl_->X[i] + u[i].cast<double>());
  }
}

void BulletBody::set_velocity(const Vec3& v) {
  for (int i = 0; i < impl_->body->m_nodes.size(); ++i)
    if (!impl_->fixed[size_t(i)]) impl_->body->m_nodes[i].m_v = to_bullet(v);
}

void BulletBody::step(double dt) { impl_->world.stepSimulation(btScalar(dt), 1, btScalar(dt)); }

std::vector<Vec3> BulletBody::displacement_mm() const {
  std::vector<Vec3> u;
  for (int i = 0; i < impl_->body->m_nodes.size(); ++i) {
    const btVector3& x = impl_->body->m_nodes[i].m_x;
    u.push_back(Vec3(double(x.x()), double(x.y()), double(x.z())) - impl_->X[size_t(i)]);
  }
  return u;
}

#else

bool has_bullet() { return false; }
struct BulletBody::Impl {};
BulletBody::BulletBody(const FemModel&, double, double, double) { throw std::runtime_error("built without Bullet"); }
BulletBody::~BulletBody() = default;
void BulletBody::set_springs(std::span<const Spring>) {}
void BulletBody::set_displacement_mm(std::span<const Vec3f>) {}
void BulletBody::set_velocity(const Vec3&) {}
void BulletBody::step(double) {}
std::vector<Vec3> BulletBody::displacement_mm() const { return {}; }

#endif

}  // namespace limberg::bench
