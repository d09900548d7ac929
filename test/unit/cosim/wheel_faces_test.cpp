// A sphere against the rim of a wheel made of segments, compared with Hertz's closed form (paper, Section 3)
// where the place of contact is known exactly: on a face, on a joint, on an edge, inside the rim, at a
// grouser.
#include "cosim/wheel_faces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dem/system.h"
#include "wheel/flexible_wheel.h"

namespace wheel_twin::cosim {
namespace {

using Eigen::Vector3d;

constexpr double ball_radius = 3e-3;  // m
constexpr double deep = 1e-5;         // overlap, m

wheel::WheelModel rigid_model(int grousers = 0) {
  wheel::WheelModel model;
  model.suspension = wheel::Suspension::rigid;
  model.radius = 0.09;
  model.width = 0.07;
  model.segments = 64;
  model.rim.thickness = 0.0004;
  model.grousers = grousers;
  model.grouser_height = grousers > 0 ? 0.007 : 0.0;
  return model;
}

/// One ball and the faces of a wheel whose axle is the y axis, in space without gravity.
class Faces {
 public:
  explicit Faces(int grousers = 0, double time_step = 1e-7) : wheel_(rigid_model(grousers)) {
    dem::MaterialTable materials;
    materials.add({"soil", 2759.0, 3e7, 0.25});
    materials.add({"steel", 7800.0, 8.023e10, 0.29});
    dem::PairProperties pair;
    pair.friction = 0.5;
    materials.set_pair(0, 1, pair);
    dem::WorldSettings world;
    world.low.setConstant(-0.2);
    world.high.setConstant(0.2);
    world.gravity.setZero();
    world.time_step = time_step;
    system_ = std::make_unique<dem::System>(
        world, materials,
        std::vector<dem::ClumpTemplate>{dem::make_clump("ball", {{Vector3d::Zero(), ball_radius}})});
    std::vector<wheel::SegmentShape> shapes;
    for (int i = 0; i < wheel_.segment_count(); ++i) shapes.push_back(wheel_.shape(i));
    for (const dem::Mesh& mesh : wheel_faces(shapes)) {
      dem::Wall wall;
      wall.material = 1;
      wall.shape = mesh;
      wall.surface = 0;
      system_->add_wall(wall);
    }
    hub_.rate = 0.0;
    wheel_.place(hub_);
    place();
  }

  void put_ball(const Vector3d& at) {
    dem::Particle ball;
    ball.position = at;
    system_->add({ball});
  }
  void place() {
    for (int i = 0; i < wheel_.segment_count(); ++i) {
      const wheel::SegmentState s = wheel_.segment(i);
      system_->set_wall_pose(static_cast<std::uint32_t>(i), {s.position, s.orientation},
                             {s.velocity, s.angular_velocity});
    }
  }
  /// Turns the rigid wheel by one step at `rate`, rad/s, the ball held where it is.
  void turn(double rate) {
    hub_.angle += rate * system_->time_step();
    hub_.rate = rate;
    wheel_.place(hub_);
    place();
    system_->set_velocity(0, Vector3d::Zero(), Vector3d::Zero());
    system_->step();
  }
  Vector3d force_on_wheel() const {
    Vector3d sum = Vector3d::Zero();
    for (std::uint32_t w = 0; w < system_->wall_count(); ++w) sum += system_->wall_wrench(w).force;
    return sum;
  }
  Vector3d torque_on_wheel() const {  // about the axle's middle
    Vector3d sum = Vector3d::Zero();
    for (std::uint32_t w = 0; w < system_->wall_count(); ++w) {
      const dem::Wrench wrench = system_->wall_wrench(w);
      sum += wrench.torque + system_->wall(w).pose.position.cross(wrench.force);
    }
    return sum;
  }
  dem::System& system() { return *system_; }
  double apothem() const { return 0.09 * std::cos(M_PI / 64); }

 private:
  wheel::FlexibleWheel wheel_;
  wheel::HubMotion hub_;
  std::unique_ptr<dem::System> system_;
};

/// Hertz between a ball of soil and a flat of steel (Table 2), N.
double hertz(double overlap) {
  const double soil = 2.0 * 3e7 * 1.25 / (1.0 - 0.25 * 0.25);
  const double steel = 2.0 * 8.023e10 * 1.29 / (1.0 - 0.29 * 0.29);
  const double modulus = 1.0 / (1.0 / soil + 1.0 / steel);
  return 4.0 / 3.0 * modulus * std::sqrt(ball_radius) * std::pow(overlap, 1.5);
}

Vector3d outward(double angle) {
  return {std::sin(angle), 0.0, std::cos(angle)};
}

TEST(WheelFaces, ABallOnAFaceFollowsHertz) {
  Faces faces;
  // Bottom of the wheel: a segment's middle.
  faces.put_ball({0.0, 0.01, -(faces.apothem() + 0.0002 + ball_radius - deep)});
  faces.system().step();
  EXPECT_NEAR(faces.force_on_wheel().z(), hertz(deep), 1e-4 * hertz(deep));
  EXPECT_NEAR(faces.force_on_wheel().head<2>().norm(), 0.0, 1e-6 * hertz(deep));
  EXPECT_NEAR(faces.torque_on_wheel().x(), 0.01 * hertz(deep), 1e-4 * 0.01 * hertz(deep));
  EXPECT_EQ(faces.system().state().wall_contacts.size(), 1U);
}

TEST(WheelFaces, ABallOnAJointTouchesOnce) {
  Faces faces;
  const double joint = M_PI + M_PI / 64;
  // The outer faces meet on the bisector, at apothem + half the thickness over the cosine of half the angle.
  const double corner = (faces.apothem() + 0.0002) / std::cos(M_PI / 64);
  faces.put_ball((corner + ball_radius - deep) * outward(joint));
  faces.system().step();
  const Vector3d force = faces.force_on_wheel();
  EXPECT_NEAR((force + hertz(deep) * outward(joint)).norm(), 0.0, 1e-4 * hertz(deep));
  EXPECT_NEAR(faces.torque_on_wheel().norm(), 0.0, 1e-8);
  EXPECT_EQ(faces.system().state().wall_contacts.size(), 1U);
}

TEST(WheelFaces, ABallOnTheEdgeOfTheSheetIsPushedAlongTheAxle) {
  Faces faces;
  faces.put_ball({0.0, 0.035 + ball_radius - deep, -faces.apothem()});
  faces.system().step();
  EXPECT_NEAR((faces.force_on_wheel() + hertz(deep) * Vector3d::UnitY()).norm(), 0.0, 1e-4 * hertz(deep));
  EXPECT_EQ(faces.system().state().wall_contacts.size(), 1U);
}

TEST(WheelFaces, ABallInsideTheRimIsPushedIn) {
  Faces faces;
  faces.put_ball({0.0, 0.0, -(faces.apothem() - 0.0002 - ball_radius + deep)});
  faces.system().step();
  EXPECT_NEAR((faces.force_on_wheel() + hertz(deep) * Vector3d::UnitZ()).norm(), 0.0, 1e-4 * hertz(deep));
}

TEST(WheelFaces, ABallInTheCornerOfAGrouserTouchesBoth) {
  Faces faces(16);
  const double rim = -(faces.apothem() + 0.0002 + ball_radius - deep);
  faces.put_ball({0.0005 + ball_radius - deep, 0.0, rim});
  faces.system().step();
  const Vector3d expected(-hertz(deep), 0.0, hertz(deep));
  EXPECT_NEAR((faces.force_on_wheel() - expected).norm(), 0.0, 1e-4 * hertz(deep));
  EXPECT_EQ(faces.system().state().wall_contacts.size(), 2U);
}

// The spring that the turning rim stretches passes to the next segment: the force keeps growing by the
// tangential stiffness times the way, S_t = 8 G sqrt(R d), beside the dashpot's steady share (paper,
// Section 3), as on the middle of a face.
TEST(WheelFaces, TheTangentialSpringPassesTheJoint) {
  const double soil = 3e7 / (2.0 - 0.25);
  const double steel = 8.023e10 / (2.0 - 0.29);
  const double stiffness = 8.0 / (1.0 / soil + 1.0 / steel) * std::sqrt(ball_radius * deep);
  const double mass = 2759.0 * 4.0 / 3.0 * M_PI * std::pow(ball_radius, 3);
  const double beta = -std::log(0.5) / std::hypot(std::log(0.5), M_PI);
  const double dashpot = 2.0 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(stiffness * mass);
  for (const bool on_joint : {false, true}) {
    Faces faces;
    const double way = 2e-6;  // m, half before the joint; sliding starts at some 5e-6
    const double angle = on_joint ? M_PI + M_PI / 64 : M_PI;
    const double corner = (faces.apothem() + 0.0002) / std::cos(M_PI / 64);
    const double radius = on_joint ? corner : faces.apothem() + 0.0002;
    const double speed = 1e-2;  // m/s
    faces.put_ball((radius + ball_radius - deep) * outward(angle + 0.5 * way / radius));
    faces.system().step();
    const int steps = static_cast<int>(std::lround(way / speed / faces.system().time_step()));
    for (int i = 0; i < steps; ++i) faces.turn(speed / radius);
    const Vector3d along(std::cos(angle), 0.0, -std::sin(angle));  // forward at the top
    const double force = -faces.force_on_wheel().dot(along);
    EXPECT_NEAR(force, stiffness * way + dashpot * speed, 0.01 * stiffness * way)
        << (on_joint ? "joint" : "face");
    EXPECT_EQ(faces.system().state().wall_contacts.size(), 1U);
  }
}

TEST(WheelFaces, TheOutermostRadiusIsThatOfTheGrousersCorners) {
  const wheel::FlexibleWheel smooth(rigid_model());
  EXPECT_NEAR(outermost_radius(smooth), 0.09 + 0.0002 / std::cos(M_PI / 64), 3e-5);
  const wheel::FlexibleWheel toothed(rigid_model(16));
  const double height = 0.09 * std::cos(M_PI / 64) + 0.0002 + 0.007;
  EXPECT_NEAR(outermost_radius(toothed), std::hypot(height, 0.0005), 1e-9);
}

}  // namespace
}  // namespace wheel_twin::cosim
