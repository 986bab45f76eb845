#include "sim/skull/bone/rigid_world.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"

namespace limberg::bone {
namespace {

constexpr double kCm = 0.1;  // per mm

btVector3 to_bullet(const Vec3& x_mm) {
  return {btScalar(kCm * x_mm.x()), btScalar(kCm * x_mm.y()), btScalar(kCm * x_mm.z())};
}
Vec3 from_bullet(const btVector3& x) { return Vec3(x.x(), x.y(), x.z()) / kCm; }
btQuaternion to_bullet(const Mat3& R) {
  const Eigen::Quaterniond q(R);
  return btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())).normalized();
}

}  // namespace

struct RigidWorld::Inside {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<RigidPart> parts;
  size_t held = 0;
  double radius_mm = 0;  // of the held part about its centre
  Eigen::Isometry3d wanted;
  RigidFigures figures;

  ~Inside() {
    for (auto& b : bodies) world.removeRigidBody(b.get());
  }
  btTransform transform(const RigidPart& p, const Eigen::Isometry3d& pose) const {
    return btTransform(to_bullet(Mat3(pose.linear())), to_bullet(Vec3(pose * p.centre_mm)));
  }
  Eigen::Isometry3d read(size_t i) const {
    const btTransform& t = bodies[i]->getWorldTransform();
    const btQuaternion q = t.getRotation();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
    pose.translation() = from_bullet(t.getOrigin()) - pose.linear() * parts[i].centre_mm;
    return pose;
  }
  int touching() {
    int n = 0;
    figures.deepest_mm = 0, figures.pairs = dispatcher.getNumManifolds();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold* m = dispatcher.getManifoldByIndexInternal(i);
      n += m->getNumContacts();
      for (int k = 0; k < m->getNumContacts(); ++k)
        figures.deepest_mm = std::max(figures.deepest_mm, -double(m->getContactPoint(k).getDistance()) / kCm);
    }
    return n;
  }
};

RigidWorld::~RigidWorld() = default;

RigidWorld::RigidWorld(const std::vector<RigidPart>& parts, size_t held) : in_(std::make_unique<Inside>()) {
  Inside& w = *in_;
  w.parts = parts, w.held = held, w.wanted = parts[held].pose;
  w.world.setGravity(btVector3(0, 0, 0));
  w.world.getDispatchInfo().m_deterministicOverlappingPairs = true;
  w.world.getSolverInfo().m_numIterations = 20;
  for (size_t i = 0; i < parts.size(); ++i) {
    const RigidPart& p = parts[i];
    auto compound = std::make_unique<btCompoundShape>(true, 64);
    for (size_t k = 0; k < p.prisms.size(); ++k)
      for (const Prism& prism : *p.prisms[k]) {
        Vec3 middle = Vec3::Zero();
        std::vector<Vec3> x;
        for (const Vec3& y : prism)
          x.push_back(p.offset[k] * y - p.centre_mm), middle += x.back() / double(prism.size());
        auto hull = std::make_unique<btConvexHullShape>();
        for (const Vec3& y : x) {
          hull->addPoint(to_bullet(Vec3(y - middle)), false);
          if (i == held) w.radius_mm = std::max(w.radius_mm, y.norm());
        }
        hull->recalcLocalAabb();
        hull->setMargin(btScalar(kCm * kMargin_mm));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), to_bullet(middle)), hull.get());
        w.shapes.push_back(std::move(hull));
      }
    btVector3 inertia(0, 0, 0);
    const btScalar mass = p.fixed ? btScalar(0) : btScalar(p.mass_g);
    if (!p.fixed) compound->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, compound.get(), inertia);
    info.m_startWorldTransform = w.transform(p, p.pose);
    info.m_friction = btScalar(0.1), info.m_restitution = 0;
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    w.world.addRigidBody(body.get());
    w.shapes.push_back(std::move(compound));
    w.bodies.push_back(std::move(body));
  }
}

void RigidWorld::want(const Eigen::Isometry3d& pose) { in_->wanted = pose; }

void RigidWorld::step(double dt) {
  Inside& w = *in_;
  if (!(dt > 0) || !std::isfinite(dt)) return;
  btRigidBody& body = *w.bodies[w.held];
  const RigidPart& part = w.parts[w.held];
  const btTransform target = w.transform(part, w.wanted);
  const auto turn = [&] {  // from now to the target, radians about an axis
    btQuaternion q = target.getRotation() * body.getWorldTransform().getRotation().inverse();
    if (q.w() < 0) q = -q;
    const btVector3 axis(q.x(), q.y(), q.z());
    const btScalar s = axis.length();
    return s > btScalar(1e-7) ? axis * (2 * elementary::atan2(s, q.w()) / s) : btVector3(0, 0, 0);
  };
  const btVector3 way = target.getOrigin() - body.getWorldTransform().getOrigin();
  const double path = double(way.length()) / kCm + double(turn().length()) * w.radius_mm;
  const double most = kMostSubsteps * kStride_mm, share = path > most ? most / path : 1;
  const int n = std::clamp(int(std::ceil(share * path / kStride_mm - 1e-9)), 1, kMostSubsteps);
  const double h = dt / n;
  int touched = 0;
  std::vector<uint8_t> pushed(w.bodies.size(), 0);
  for (int i = 0; i < n; ++i) {
    // What is left of this step's way, in the substeps that are left.
    const double part_of = share < 1 ? share / (n - i * share) : 1. / (n - i);
    const btScalar rate = btScalar(part_of / h);
    for (auto& b : w.bodies)
      b->setLinearVelocity(btVector3(0, 0, 0)), b->setAngularVelocity(btVector3(0, 0, 0)), b->clearForces();
    body.setLinearVelocity((target.getOrigin() - body.getWorldTransform().getOrigin()) * rate);
    body.setAngularVelocity(turn() * rate);
    w.world.stepSimulation(btScalar(h), 0);
    touched += w.touching();
    for (size_t k = 0; k < w.bodies.size(); ++k)
      if (k != w.held && !w.parts[k].fixed)
        pushed[k] |= w.bodies[k]->getLinearVelocity().length2() > 0 || w.bodies[k]->getAngularVelocity().length2() > 0;
  }
  w.figures.substeps = n, w.figures.contacts = w.touching();
  for (size_t k = 0; k < w.bodies.size(); ++k) {
    if (k == w.held) {
      // Free all the way: where the hand wants it, in doubles.
      if (touched == 0 && share == 1)
        w.parts[k].pose = w.wanted, w.bodies[k]->setWorldTransform(target);
      else
        w.parts[k].pose = w.read(k);
    } else if (pushed[k]) {
      w.parts[k].pose = w.read(k);
    }
  }
}

Eigen::Isometry3d RigidWorld::pose(size_t part) const { return in_->parts[part].pose; }
RigidFigures RigidWorld::figures() const { return in_->figures; }

}  // namespace limberg::bone
