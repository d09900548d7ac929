#include "wheel/rigid_ground.h"

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace wheel_twin::wheel {
namespace {

using Eigen::Vector3d;

// Bullet's own lengths (collision margins, contact thresholds) are made for objects of its unit: millimetres
// bring them to 0.04 mm and below.
constexpr double kUnit = 1.0e-3;
constexpr int kWheelGroup = 1, kGroundGroup = 2;
constexpr double kFloorHalf = 50.0;   // m
constexpr double kFloorDepth = 0.5;   // m
constexpr double kSameSpot = 5.0e-4;  // m on the plate, within which a contact goes on
// A plate is struck on its outer face: contacts against its side faces are the joints between neighbours.
constexpr double kFacing = 0.5;

btVector3 in(const Vector3d& v) {
  return {v.x() / kUnit, v.y() / kUnit, v.z() / kUnit};
}
Vector3d out(const btVector3& v) {
  return Vector3d(v.x(), v.y(), v.z()) * kUnit;
}
Vector3d direction(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

struct Grip {  ///< a contact's tangential spring
  Vector3d spot;
  double stretch;
};

struct Plate {
  int segment;
  bool rim;
  Vector3d centre;  // segment axes
  std::unique_ptr<btBoxShape> shape;
  std::unique_ptr<btCollisionObject> object;
  std::vector<Grip> grips, next;
};

}  // namespace

struct RigidGround::Impl {
  Impl(const FlexibleWheel& wheel, const Ground& g) : ground(g) {
    world.getDispatchInfo().m_enableSatConvex =
        true;  // plates lie on triangles by their faces, not by a point
    for (int i = 0; i < wheel.segment_count(); ++i) {
      const std::vector<Box>& boxes = wheel.shape(i).boxes;
      for (std::size_t b = 0; b < boxes.size(); ++b) {
        Plate plate;
        plate.segment = i;
        plate.rim = b == 0;
        plate.centre = boxes[b].centre;
        plate.shape = std::make_unique<btBoxShape>(in(boxes[b].half_extents));
        plate.shape->setMargin(0.02);
        plate.shape->initializePolyhedralFeatures();
        plate.object = std::make_unique<btCollisionObject>();
        plate.object->setCollisionShape(plate.shape.get());
        plates.push_back(std::move(plate));
      }
    }
    // Addresses are final now.
    for (Plate& plate : plates) {
      plate.object->setUserPointer(&plate);
      world.addCollisionObject(plate.object.get(), kWheelGroup, kGroundGroup);
    }
    if (ground.floor) {
      add(std::make_unique<btBoxShape>(in({kFloorHalf, kFloorHalf, 0.5 * kFloorDepth})),
          {0.0, 0.0, *ground.floor - 0.5 * kFloorDepth}, 0.0);
    }
    for (const GroundBox& box : ground.boxes)
      add(std::make_unique<btBoxShape>(in(0.5 * box.size)), box.centre, box.pitch);
    for (const GroundSphere& sphere : ground.spheres)
      add(std::make_unique<btSphereShape>(sphere.radius / kUnit), sphere.centre, 0.0);
    for (const GroundRock& rock : ground.rocks) {
      auto shape = std::make_unique<btConvexHullShape>();
      for (const Vector3d& v : rock.vertices) shape->addPoint(in(v), false);
      shape->recalcLocalAabb();
      shape->setMargin(0.0);
      shape->initializePolyhedralFeatures();
      add(std::move(shape), Vector3d::Zero(), 0.0);
    }
  }
  ~Impl() {
    for (auto& object : objects) world.removeCollisionObject(object.get());
    for (auto& plate : plates) world.removeCollisionObject(plate.object.get());
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add(std::unique_ptr<btCollisionShape> shape, const Vector3d& at, double pitch) {
    auto object = std::make_unique<btCollisionObject>();
    object->setCollisionShape(shape.get());
    object->setWorldTransform(btTransform(btQuaternion(btVector3(0, 1, 0), pitch), in(at)));
    object->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    world.addCollisionObject(object.get(), kGroundGroup, kWheelGroup);
    shapes.push_back(std::move(shape));
    objects.push_back(std::move(object));
  }

  /// Brings Bullet's plates to the wheel's, `raised` higher (m), and finds all contacts.
  void detect(const FlexibleWheel& wheel, double raised) {
    states.resize(wheel.segment_count());
    for (int i = 0; i < wheel.segment_count(); ++i) states[i] = wheel.segment(i);
    for (Plate& plate : plates) {
      const SegmentState& s = states[plate.segment];
      const Eigen::Quaterniond& q = s.orientation;
      const Vector3d centre = s.position + q * plate.centre + Vector3d(0.0, 0.0, raised);
      plate.object->setWorldTransform(btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), in(centre)));
      world.updateSingleAabb(plate.object.get());
    }
    // What a manifold remembers of earlier steps is left out: a contact is what the shapes say now.
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
      dispatcher.getManifoldByIndexInternal(i)->clearManifold();
    world.computeOverlappingPairs();
    dispatcher.dispatchAllCollisionPairs(world.getBroadphase()->getOverlappingPairCache(),
                                         world.getDispatchInfo(), &dispatcher);
    found.clear();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) collect(*dispatcher.getManifoldByIndexInternal(i));
  }

  void collect(const btPersistentManifold& manifold) {
    // Bullet's normal points to the first body.
    const bool plate_first = manifold.getBody0()->getUserPointer() != nullptr;
    auto* plate =
        static_cast<Plate*>((plate_first ? manifold.getBody0() : manifold.getBody1())->getUserPointer());
    const Vector3d outward = states[plate->segment].orientation * Vector3d::UnitZ();
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& p = manifold.getContactPoint(k);
      const Vector3d normal = (plate_first ? 1.0 : -1.0) * direction(p.m_normalWorldOnB);
      if (p.getDistance() >= 0.0 || (plate->rim && -normal.dot(outward) < kFacing)) continue;
      found.push_back({plate, out(plate_first ? p.getPositionWorldOnA() : p.getPositionWorldOnB()), normal,
                       -kUnit * p.getDistance()});
    }
  }

  struct Found {
    Plate* plate;
    Vector3d point, normal;
    double overlap;
  };
  Ground ground;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btCollisionObject>> objects;
  std::vector<Plate> plates;
  std::vector<SegmentState> states;
  std::vector<Found> found;
  std::vector<GroundContact> contacts;
};

RigidGround::RigidGround(const FlexibleWheel& wheel, const Ground& ground)
    : impl_(std::make_unique<Impl>(wheel, ground)) {}
RigidGround::~RigidGround() = default;
RigidGround::RigidGround(RigidGround&&) noexcept = default;
RigidGround& RigidGround::operator=(RigidGround&&) noexcept = default;

const std::vector<GroundContact>& RigidGround::contacts() const {
  return impl_->contacts;
}
const Ground& RigidGround::ground() const {
  return impl_->ground;
}

Vector3d RigidGround::press(FlexibleWheel& wheel, double dt) {
  Impl& impl = *impl_;
  // Two points hold an edge.
  const double stiffness = 0.5 * impl.ground.contact.stiffness;
  const double damping = 0.5 * impl.ground.contact.damping;
  impl.contacts.clear();
  impl.detect(wheel, 0.0);
  Vector3d total = Vector3d::Zero();
  for (const auto& [at_plate, point, normal, overlap] : impl.found) {
    Plate& plate = *at_plate;
    const SegmentState& state = impl.states[plate.segment];
    const Vector3d arm = point - state.position;
    const Vector3d velocity = state.velocity + state.angular_velocity.cross(arm);
    const double pressing = std::max(0.0, stiffness * overlap - damping * velocity.dot(normal));
    const Vector3d axle = state.orientation * Vector3d::UnitY();
    const Vector3d heading = axle.cross(normal).normalized();
    const Vector3d spot = state.orientation.conjugate() * arm;
    double stretch = dt * velocity.dot(heading);
    const auto nearest =
        std::min_element(plate.grips.begin(), plate.grips.end(), [&](const Grip& a, const Grip& b) {
          return (a.spot - spot).squaredNorm() < (b.spot - spot).squaredNorm();
        });
    if (nearest != plate.grips.end() && (nearest->spot - spot).norm() < kSameSpot)
      stretch += nearest->stretch;
    const double limit = impl.ground.contact.friction * pressing;
    const double friction = std::clamp(stiffness * stretch, -limit, limit);
    plate.next.push_back({spot, friction / stiffness});
    const Vector3d force = pressing * normal - friction * heading;
    wheel.apply(plate.segment, force, arm.cross(force));
    total += force;
    impl.contacts.push_back({plate.segment, point, normal, overlap, force});
  }
  for (Plate& plate : impl.plates) {
    plate.grips.swap(plate.next);
    plate.next.clear();
  }
  return total;
}

double RigidGround::touching_height(const FlexibleWheel& wheel, const Ground& ground) {
  Impl probe(wheel, ground);
  const double now = wheel.hub().position.z();
  const double reach = 2.0 * wheel.model().radius + wheel.model().grouser_height;
  const auto touches = [&](double height) {
    probe.detect(wheel, height - now);
    return !probe.found.empty();
  };
  // From far above down in steps of a millimetre, so that the first touch is the highest one.
  double top = reach + ground.floor.value_or(-10.0);
  for (const GroundBox& box : ground.boxes) top = std::max(top, reach + box.centre.z() + box.size.norm());
  for (const GroundSphere& sphere : ground.spheres)
    top = std::max(top, reach + sphere.centre.z() + sphere.radius);
  for (const GroundRock& rock : ground.rocks)
    for (const Vector3d& v : rock.vertices) top = std::max(top, reach + v.z());
  const double step = 0.1 * wheel.model().rim.thickness + 1.0e-4;
  double high = top;
  double low = top;
  while (!touches(low)) {
    high = low;
    low -= step;
    if (top - low > 4.0 * reach + 1.0) throw Error("there is no ground below the hub");
  }
  while (high - low > 1.0e-6) {
    const double middle = 0.5 * (low + high);
    (touches(middle) ? low : high) = middle;
  }
  return high;
}

}  // namespace wheel_twin::wheel
