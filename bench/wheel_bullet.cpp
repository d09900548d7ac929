// Why the wheel's dynamics are not Bullet's: the AMALIA rim as Bullet would have it, freely spinning after a
// blow, against src/wheel. Sequential impulses (btHingeConstraint ring, btRigidBody) and Featherstone's
// articulated body with a loop constraint (btMultiBody chain of revolute joints closed by
// btMultiBodyPoint2Point). Double precision. Torsion springs are the same explicit torques in every case.
// Prints cost a step, the largest gap of a joint and the loss of angular momentum and energy over 0.1 s.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "wheel/flexible_wheel.h"

namespace {

using wheel_twin::wheel::FlexibleWheel;
using wheel_twin::wheel::HubMotion;
using wheel_twin::wheel::WheelModel;

constexpr double kStep = 1.0e-5, kSeconds = 0.1, kRate = 10.0, kBlow = 2.0;
constexpr int kBlowSteps = 200;

struct Result {
  double microseconds = 0.0, gap = 0.0, momentum = 0.0, energy = 0.0;
};

void print(const char* name, const Result& r) {
  std::printf("%-44s %9.1f us  gap %.2g m  momentum %.2g  energy %.2g\n", name, r.microseconds, r.gap,
              r.momentum, r.energy);
}

WheelModel ring_model() {
  WheelModel model =
      wheel_twin::wheel::read_wheel_file(std::string(WHEEL_TWIN_SOURCE_DIR) + "/config/wheels/amalia.yaml");
  model.grousers = 0;
  model.damping_ratio = 0.0;
  model.springs.positions = 0;
  return model;
}

/// Steps a system: `blow` during the first steps, then measures. The callbacks look at the system from
/// outside.
template <class Step, class Momentum, class Energy, class Gap>
Result measure(Step step, Momentum momentum, Energy energy, Gap gap) {
  for (int i = 0; i < kBlowSteps; ++i) step(kBlow);
  step(0.0);
  const double L = momentum(), E = energy();
  Result result;
  const int steps = static_cast<int>(kSeconds / kStep);
  double spent = 0.0;
  for (int i = 0; i < steps; ++i) {
    const auto start = std::chrono::steady_clock::now();
    step(0.0);
    spent += std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
    if (i % 20 != 0) continue;
    result.gap = std::max(result.gap, gap());
    result.momentum = std::max(result.momentum, std::abs(momentum() / L - 1.0));
    result.energy = std::max(result.energy, std::abs(energy() / E - 1.0));
  }
  result.microseconds = spent / steps;
  return result;
}

Result own(const WheelModel& model) {
  FlexibleWheel wheel(model);
  HubMotion hub;
  hub.rate = kRate;
  wheel.place(hub);
  hub.rate = 0.0;
  return measure(
      [&](double force) {
        if (force != 0.0) {
          wheel.apply(0, {0.0, 0.0, -force}, Eigen::Vector3d::Zero());
          wheel.apply(model.segments / 2, {0.0, 0.0, force}, Eigen::Vector3d::Zero());
        }
        wheel.step(kStep, hub);
      },
      [&] { return wheel.angular_momentum(); },
      [&] { return wheel.energy().kinetic + wheel.energy().elastic; },
      [&] { return wheel.largest_joint_gap(); });
}

/// A world of Bullet without gravity and what both rings in it have in common.
template <class World, class Solver>
struct RingWorld {
  explicit RingWorld(const WheelModel& wheel) : model(wheel) { world.setGravity({0, 0, 0}); }

  WheelModel model;
  double half = 0.5 * wheel_twin::wheel::segment_length(model);
  double apothem = model.radius * std::cos(M_PI / model.segments);
  double mass = model.rim.density * model.rim.width * model.rim.thickness * 2.0 * half;
  double inertia = mass * (4.0 * half * half + model.rim.thickness * model.rim.thickness) / 12.0;
  btVector3 pivot{half, 0, 0};
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  Solver solver;
  World world{&dispatcher, &broadphase, &solver, &configuration};
};

/// The rim in Bullet's plane x-z, axis y, as rigid bodies with hinges.
struct HingeRing : RingWorld<btDiscreteDynamicsWorld, btSequentialImpulseConstraintSolver> {
  HingeRing(const WheelModel& wheel, int iterations) : RingWorld(wheel) {
    world.getSolverInfo().m_numIterations = iterations;
    shape = std::make_unique<btBoxShape>(btVector3(half, 0.5 * model.rim.width, 0.5 * model.rim.thickness));
    for (int i = 0; i < model.segments; ++i) {
      const double angle = 2.0 * M_PI * i / model.segments;
      btTransform pose(btQuaternion(btVector3(0, 1, 0), angle),
                       btVector3(apothem * std::sin(angle), 0, apothem * std::cos(angle)));
      btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(),
                                                    btVector3(inertia, inertia, inertia));
      info.m_startWorldTransform = pose;
      bodies.push_back(std::make_unique<btRigidBody>(info));
      bodies.back()->setDamping(0, 0);
      bodies.back()->setActivationState(DISABLE_DEACTIVATION);
      bodies.back()->setAngularVelocity({0, kRate, 0});
      bodies.back()->setLinearVelocity(btVector3(0, kRate, 0).cross(pose.getOrigin()));
      world.addRigidBody(bodies.back().get(), 0, 0);
    }
    const btVector3 axis(0, 1, 0);
    for (int i = 0; i < model.segments; ++i) {
      hinges.push_back(std::make_unique<btHingeConstraint>(*bodies[i], *bodies[(i + 1) % model.segments],
                                                           btVector3(half, 0, 0), btVector3(-half, 0, 0),
                                                           axis, axis));
      world.addConstraint(hinges.back().get(), true);
    }
  }
  ~HingeRing() {
    for (auto& hinge : hinges) world.removeConstraint(hinge.get());
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }

  double turn(int i) const {
    const btTransform& a = bodies[i]->getWorldTransform();
    const btTransform& b = bodies[(i + 1) % model.segments]->getWorldTransform();
    const btVector3 x = a.getBasis().getColumn(0), y = b.getBasis().getColumn(0);
    return std::atan2(x.cross(y).y(), x.dot(y)) - 2.0 * M_PI / model.segments;
  }
  void step(double force) {
    for (int i = 0; i < model.segments; ++i) {
      const double torque = model.rim_joint_stiffness * turn(i);
      bodies[i]->applyTorque({0, torque, 0});
      bodies[(i + 1) % model.segments]->applyTorque({0, -torque, 0});
    }
    bodies[0]->applyCentralForce({0, 0, -force});
    bodies[model.segments / 2]->applyCentralForce({0, 0, force});
    world.stepSimulation(kStep, 0, kStep);
  }
  double momentum() const {
    double sum = 0.0;
    for (const auto& body : bodies) {
      sum += mass * body->getWorldTransform().getOrigin().cross(body->getLinearVelocity()).y() +
             inertia * body->getAngularVelocity().y();
    }
    return sum;
  }
  double energy() const {
    double sum = 0.0;
    for (int i = 0; i < model.segments; ++i) {
      sum += 0.5 * mass * bodies[i]->getLinearVelocity().length2() +
             0.5 * inertia * bodies[i]->getAngularVelocity().length2() +
             0.5 * model.rim_joint_stiffness * turn(i) * turn(i);
    }
    return sum;
  }
  double gap() const {
    double largest = 0.0;
    for (int i = 0; i < model.segments; ++i) {
      const btVector3 a = bodies[i]->getWorldTransform() * pivot;
      const btVector3 b = bodies[(i + 1) % model.segments]->getWorldTransform() * (-pivot);
      largest = std::max(largest, static_cast<double>((a - b).length()));
    }
    return largest;
  }

  std::unique_ptr<btBoxShape> shape;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btHingeConstraint>> hinges;
};

/// The rim as one articulated body: a floating segment, 63 revolute links, and a point-to-point loop closure.
struct FeatherstoneRing : RingWorld<btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver> {
  explicit FeatherstoneRing(const WheelModel& wheel) : RingWorld(wheel) {
    const int links = model.segments - 1;
    const btVector3 inertias(inertia, inertia, inertia);
    body = std::make_unique<btMultiBody>(links, mass, inertias, false, false);
    body->setBasePos({0, 0, apothem});
    const double pitch = 2.0 * M_PI / model.segments;
    for (int i = 0; i < links; ++i) {
      body->setupRevolute(i, mass, inertias, i - 1, btQuaternion(btVector3(0, 1, 0), -pitch), {0, 1, 0},
                          btVector3(half, 0, 0), btVector3(half, 0, 0), true);
    }
    body->finalizeMultiDof();
    body->setLinearDamping(0);
    body->setAngularDamping(0);
    body->setCanSleep(false);
    body->setBaseOmega({0, kRate, 0});
    body->setBaseVel(btVector3(0, kRate, 0).cross(btVector3(0, 0, apothem)));
    world.addMultiBody(body.get());
    loop = std::make_unique<btMultiBodyPoint2Point>(body.get(), links - 1, body.get(), -1,
                                                    btVector3(half, 0, 0), btVector3(-half, 0, 0));
    world.addMultiBodyConstraint(loop.get());
  }
  ~FeatherstoneRing() {
    world.removeMultiBodyConstraint(loop.get());
    world.removeMultiBody(body.get());
  }

  btVector3 to_world(int link, const btVector3& local) const { return body->localPosToWorld(link, local); }
  double closing_turn() const {
    const btVector3 x = body->localDirToWorld(model.segments - 2, {1, 0, 0});
    const btVector3 y = body->localDirToWorld(-1, {1, 0, 0});
    return std::atan2(x.cross(y).y(), x.dot(y)) - 2.0 * M_PI / model.segments;
  }
  void step(double force) {
    for (int i = 0; i < model.segments - 1; ++i) {
      body->addJointTorque(i, -model.rim_joint_stiffness * body->getJointPos(i));
    }
    const double closing = model.rim_joint_stiffness * closing_turn();
    body->addLinkTorque(model.segments - 2, {0, closing, 0});
    body->addBaseTorque({0, -closing, 0});
    body->addBaseForce({0, 0, -force});
    body->addLinkForce(model.segments / 2 - 1, {0, 0, force});
    world.stepSimulation(kStep, 0, kStep);
  }
  /// Centre positions and their rates by differences of a step: independent of the library's own bookkeeping.
  void look(std::vector<btVector3>& x, std::vector<double>& angle) const {
    x.clear();
    angle.clear();
    for (int link = -1; link < model.segments - 1; ++link) {
      x.push_back(to_world(link, {0, 0, 0}));
      const btVector3 direction = body->localDirToWorld(link, {1, 0, 0});
      angle.push_back(std::atan2(-direction.z(), direction.x()));
    }
  }
  double gap() const { return (to_world(model.segments - 2, pivot) - to_world(-1, -pivot)).length(); }

  std::unique_ptr<btMultiBody> body;
  std::unique_ptr<btMultiBodyPoint2Point> loop;
};

Result featherstone(const WheelModel& model) {
  FeatherstoneRing ring(model);
  std::vector<btVector3> before, now;
  std::vector<double> angle_before, angle_now;
  ring.look(now, angle_now);
  const auto step = [&](double force) {
    before.swap(now);
    angle_before.swap(angle_now);
    ring.step(force);
    ring.look(now, angle_now);
  };
  const auto rate = [&](std::size_t i) {
    return std::remainder(angle_now[i] - angle_before[i], 2.0 * M_PI) / kStep;
  };
  return measure(
      step,
      [&] {
        double sum = 0.0;
        for (std::size_t i = 0; i < now.size(); ++i) {
          sum += ring.mass * now[i].cross((now[i] - before[i]) / kStep).y() + ring.inertia * rate(i);
        }
        return sum;
      },
      [&] {
        double sum = 0.5 * model.rim_joint_stiffness * std::pow(ring.closing_turn(), 2);
        for (std::size_t i = 0; i < now.size(); ++i) {
          sum += 0.5 * ring.mass * ((now[i] - before[i]) / kStep).length2() +
                 0.5 * ring.inertia * rate(i) * rate(i);
          if (i > 0)
            sum += 0.5 * model.rim_joint_stiffness *
                   std::pow(ring.body->getJointPos(static_cast<int>(i) - 1), 2);
        }
        return sum;
      },
      [&] { return ring.gap(); });
}

}  // namespace

int main() {
  const WheelModel model = ring_model();
  print("src/wheel: RATTLE, direct joint solver", own(model));
  for (const int iterations : {10, 50, 500}) {
    HingeRing ring(model, iterations);
    const Result result = measure([&](double force) { ring.step(force); }, [&] { return ring.momentum(); },
                                  [&] { return ring.energy(); }, [&] { return ring.gap(); });
    const std::string name = "Bullet hinges, " + std::to_string(iterations) + " iterations";
    print(name.c_str(), result);
  }
  print("Bullet btMultiBody, loop constraint", featherstone(model));
  return 0;
}
