// The part limberg-bullet.so: RigidWorld by Bullet.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/skull/bone/rigid_world.h"

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

class BulletWorld final : public RigidWorld {
 public:
  BulletWorld(const std::vector<RigidPart>& parts, const std::vector<size_t>& held);
  ~BulletWorld() override;
  void want(size_t part, const Eigen::Isometry3d& pose) override;
  void step(double dt_s) override;
  Eigen::Isometry3d pose(size_t part) const override { return parts_[part].pose; }
  RigidFigures figures() const override { return figures_; }

 private:
  btTransform transform(const RigidPart& p, const Eigen::Isometry3d& pose) const {
    return btTransform(to_bullet(Mat3(pose.linear())), to_bullet(Vec3(pose * p.centre_mm)));
  }
  Eigen::Isometry3d read(size_t i) const;
  int touching();

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<RigidPart> parts_;
  struct InHand {
    size_t part = 0;
    double radius_mm = 0;  // about its centre
    Eigen::Isometry3d wanted;
  };
  bool in_hand(size_t part) const {
    return std::any_of(held_.begin(), held_.end(), [&](const InHand& h) { return h.part == part; });
  }
  std::vector<InHand> held_;
  RigidFigures figures_;
};

BulletWorld::~BulletWorld() {
  for (auto& b : bodies_) world_.removeRigidBody(b.get());
}

Eigen::Isometry3d BulletWorld::read(size_t i) const {
  const btTransform& t = bodies_[i]->getWorldTransform();
  const btQuaternion q = t.getRotation();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  pose.translation() = from_bullet(t.getOrigin()) - pose.linear() * parts_[i].centre_mm;
  return pose;
}

int BulletWorld::touching() {
  int n = 0;
  figures_.deepest_mm = 0, figures_.pairs = dispatcher_.getNumManifolds();
  for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
    const btPersistentManifold* m = dispatcher_.getManifoldByIndexInternal(i);
    n += m->getNumContacts();
    for (int k = 0; k < m->getNumContacts(); ++k)
      figures_.deepest_mm = std::max(figures_.deepest_mm, -double(m->getContactPoint(k).getDistance()) / kCm);
  }
  return n;
}

void BulletWorld::want(size_t part, const Eigen::Isometry3d& pose) {
  for (InHand& h : held_)
    if (h.part == part) h.wanted = pose;
}

BulletWorld::BulletWorld(const std::vector<RigidPart>& parts, const std::vector<size_t>& held) : parts_(parts) {
  for (const size_t part : held) held_.push_back({part, 0, parts[part].pose});
  world_.setGravity(btVector3(0, 0, 0));
  world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
  world_.getSolverInfo().m_numIterations = 20;
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
          for (InHand& h : held_)
            if (h.part == i) h.radius_mm = std::max(h.radius_mm, y.norm());
        }
        hull->recalcLocalAabb();
        hull->setMargin(btScalar(kCm * kMargin_mm));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), to_bullet(middle)), hull.get());
        shapes_.push_back(std::move(hull));
      }
    btVector3 inertia(0, 0, 0);
    const btScalar mass = p.fixed ? btScalar(0) : btScalar(p.mass_g);
    if (!p.fixed) compound->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, compound.get(), inertia);
    info.m_startWorldTransform = transform(p, p.pose);
    info.m_friction = btScalar(0.1), info.m_restitution = 0;
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(body.get());
    shapes_.push_back(std::move(compound));
    bodies_.push_back(std::move(body));
  }
}

void BulletWorld::step(double dt) {
  if (!(dt > 0) || !std::isfinite(dt)) return;
  const auto target = [&](const InHand& h) { return transform(parts_[h.part], h.wanted); };
  const auto turn = [&](const InHand& h) {  // from now to the target, radians about an axis
    btQuaternion q = target(h).getRotation() * bodies_[h.part]->getWorldTransform().getRotation().inverse();
    if (q.w() < 0) q = -q;
    const btVector3 axis(q.x(), q.y(), q.z());
    const btScalar s = axis.length();
    return s > btScalar(1e-7) ? axis * (2 * elementary::atan2(s, q.w()) / s) : btVector3(0, 0, 0);
  };
  const auto way = [&](const InHand& h) -> btVector3 {
    return target(h).getOrigin() - bodies_[h.part]->getWorldTransform().getOrigin();
  };
  double path = 0;
  for (const InHand& h : held_)
    path = std::max(path, double(way(h).length()) / kCm + double(turn(h).length()) * h.radius_mm);
  const double most = kMostSubsteps * kStride_mm, share = path > most ? most / path : 1;
  const int n = std::clamp(int(std::ceil(share * path / kStride_mm - 1e-9)), 1, kMostSubsteps);
  const double h = dt / n;
  int touched = 0;
  std::vector<uint8_t> pushed(bodies_.size(), 0);
  for (int i = 0; i < n; ++i) {
    // What is left of this step's way, in the substeps that are left.
    const double part_of = share < 1 ? share / (n - i * share) : 1. / (n - i);
    const btScalar rate = btScalar(part_of / h);
    for (auto& b : bodies_)
      b->setLinearVelocity(btVector3(0, 0, 0)), b->setAngularVelocity(btVector3(0, 0, 0)), b->clearForces();
    for (const InHand& k : held_)
      bodies_[k.part]->setLinearVelocity(way(k) * rate), bodies_[k.part]->setAngularVelocity(turn(k) * rate);
    world_.stepSimulation(btScalar(h), 0);
    touched += touching();
    for (size_t k = 0; k < bodies_.size(); ++k)
      if (!in_hand(k) && !parts_[k].fixed)
        pushed[k] |= bodies_[k]->getLinearVelocity().length2() > 0 || bodies_[k]->getAngularVelocity().length2() > 0;
  }
  figures_.substeps = n, figures_.contacts = touching();
  for (size_t k = 0; k < bodies_.size(); ++k)
    if (pushed[k]) parts_[k].pose = read(k);
  // Free all the way: where the hands want them, in doubles.
  for (const InHand& k : held_)
    if (touched == 0 && share == 1)
      parts_[k.part].pose = k.wanted, bodies_[k.part]->setWorldTransform(target(k));
    else
      parts_[k.part].pose = read(k.part);
}

}  // namespace
}  // namespace limberg::bone

extern "C" limberg::bone::RigidWorld* limberg_rigid_world(const std::vector<limberg::bone::RigidPart>& parts,
                                                          const std::vector<size_t>& held) {
  return new limberg::bone::BulletWorld(parts, held);
}
