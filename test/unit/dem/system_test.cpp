#include "dem/system.h"

#include <gmock/gmock.h>

#include <functional>

#include "base/error.h"
#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

/// Largest difference of two systems' states, bit for bit.
void expect_same_bits(const System& a, const System& b) {
  const State p = a.state();
  const State q = b.state();
  ASSERT_EQ(p.step, q.step);
  ASSERT_EQ(p.position.size(), q.position.size());
  for (std::size_t k = 0; k < p.position.size(); ++k) {
    ASSERT_EQ(p.position[k], q.position[k]) << "particle " << k;
    ASSERT_EQ(p.velocity[k], q.velocity[k]) << "particle " << k;
    ASSERT_EQ(p.angular_momentum[k], q.angular_momentum[k]) << "particle " << k;
    ASSERT_EQ(p.orientation[k], q.orientation[k]) << "particle " << k;
    ASSERT_EQ(p.load[k], q.load[k]) << "particle " << k;
  }
  ASSERT_EQ(p.contacts.size(), q.contacts.size());
  for (std::size_t k = 0; k < p.contacts.size(); ++k) {
    ASSERT_EQ(p.contacts[k].a, q.contacts[k].a);
    ASSERT_EQ(p.contacts[k].b, q.contacts[k].b);
    ASSERT_EQ(p.contacts[k].overlap, q.contacts[k].overlap);
    ASSERT_EQ(p.contacts[k].shear, q.contacts[k].shear);
  }
}

TEST(System, SameBitsForAnyNumberOfThreads) {
  const std::vector<ClumpTemplate> shapes{four(), lopsided(), ball()};
  const auto particles = cloud(8, 6, 6, 0.0115, 3, 1);
  System one = box_of(8, 6, 0.2, 0.0115, shapes, 1);
  System two = box_of(8, 6, 0.2, 0.0115, shapes, 2);
  System four_threads = box_of(8, 6, 0.2, 0.0115, shapes, 4);
  for (System* s : {&one, &two, &four_threads}) {
    s->add(particles);
    s->step(8000);
  }
  EXPECT_GT(one.statistics().contacts, 60U);
  expect_same_bits(one, two);
  expect_same_bits(one, four_threads);
}

TEST(System, RestartContinuesWithTheSameBits) {
  const std::vector<ClumpTemplate> shapes{four(), lopsided()};
  System whole = box_of(6, 6, 0.2, 0.0115, shapes);
  whole.add(cloud(6, 6, 5, 0.0115, 2, 2));
  Wall plate;
  plate.name = "plate";
  plate.material = 1;
  plate.shape = box_mesh({0.0, 0.0, 0.0}, {0.03, 0.03, 0.001});
  plate.pose.position = {0.01, 0.01, 0.0005};
  plate.motion.velocity = {0.05, 0.0, 0.01};
  plate.motion.angular_velocity = {0.0, 0.0, 1.0};
  whole.add_wall(plate);
  System again = box_of(6, 6, 0.2, 0.0115, shapes);
  whole.step(500);
  const State state = whole.state();
  again.restore(state);
  whole.step(7000);
  again.step(7000);
  EXPECT_GT(whole.statistics().contacts, 60U);
  EXPECT_GT(whole.wall_wrench(1).force.norm(), 0.0);
  EXPECT_EQ(whole.wall_wrench(1).force, again.wall_wrench(1).force);
  expect_same_bits(whole, again);
}

TEST(System, ListsDoNotChangeResults) {
  // A copy that starts anew from its own state every few steps has other lists, orders and skins.
  const std::vector<ClumpTemplate> shapes{four()};
  System steady = box_of(6, 6, 0.2, 0.0115, shapes);
  steady.add(cloud(6, 6, 5, 0.0115, 1, 3));
  System restless = box_of(6, 6, 0.2, 0.0115, shapes);
  restless.restore(steady.state());
  for (int k = 0; k < 450; ++k) {
    steady.step(17);
    restless.step(17);
    restless.restore(restless.state());
  }
  EXPECT_LT(steady.statistics().list_builds, restless.statistics().list_builds);
  expect_same_bits(steady, restless);
}

TEST(System, RefusesBadParticles) {
  System system = box_of(4, 4, 0.2, 0.012, {ball()});
  const auto message = [&](const Particle& p) {
    try {
      system.add({p});
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message(at({0.02, 0.02, 0.5})), testing::HasSubstr("outside the domain"));
  EXPECT_THAT(message(at({0.02, NAN, 0.1})), testing::HasSubstr("not finite"));
  EXPECT_THAT(message(at({0.02, 0.02, 0.001})), testing::HasSubstr("overlaps wall 'floor'"));
  EXPECT_EQ(message(at({0.02, 0.02, 0.1})), "accepted");
  EXPECT_THAT(message(at({0.02, 0.022, 0.1})), testing::HasSubstr("overlaps particle 0"));
  Particle unknown = at({0.03, 0.03, 0.15});
  unknown.shape = 1;
  EXPECT_THAT(message(unknown), testing::HasSubstr("template 1 of 1"));
  EXPECT_EQ(system.size(), 1U);
}

TEST(System, NamesTheParticleThatLeaves) {
  WorldSettings settings = empty_space(0.1);
  System system(settings, table(), {ball()});
  system.add({at({0.0, 0.0, 0.0}), at({0.05, 0.0, 0.0}, {60.0, 0.0, 0.0})});
  try {
    system.step(2000);
    FAIL() << "nothing was noticed";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("particle 1 at (0.1"));
    EXPECT_THAT(error.what(), testing::HasSubstr("outside the domain"));
  }
}

TEST(System, RefusesWhatIsNotANumber) {
  System system = box_of(4, 4, 0.2, 0.012, {ball()});
  const auto plate = system.add_wall(floor_wall(-0.005));
  Motion motion;
  motion.velocity.z() = NAN;
  Wall wall = floor_wall();
  wall.pose.position.x() = NAN;
  const Mesh flat = parallelogram({0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.0, 0.01, 0.0});
  Wall square = floor_wall(0.1);
  square.name = "square";
  square.shape = flat;
  const auto number = system.add_wall(square);
  Mesh bent = flat;
  bent.vertices[1].z() = NAN;
  const auto refuses = testing::HasSubstr("not finite");
  EXPECT_THAT(message_of([&] { system.set_wall_motion(plate, motion); }), refuses);
  EXPECT_THAT(message_of([&] { system.set_wall_pose(plate, wall.pose, {}); }), refuses);
  EXPECT_THAT(message_of([&] { system.add_wall(wall); }), refuses);
  EXPECT_THAT(message_of([&] { system.set_wall_shape(number, bent); }), refuses);
  EXPECT_THAT(message_of([&] { system.set_gravity({0.0, NAN, 0.0}); }), refuses);
  // What nobody looks at before: the step at which it is felt names the particle.
  system.add({at({0.02, 0.02, 0.05})});
  system.step(3);
  system.set_velocity(0, {0.0, NAN, 0.0}, {0.0, 0.0, 0.0});
  const std::string message = message_of([&] { system.step(); });
  EXPECT_THAT(message, testing::HasSubstr("step 4: particle 0"));
  EXPECT_THAT(message, refuses);
}

TEST(System, AWallThroughTheBedIsNamedAtTheStep) {
  System system = box_of(6, 6, 0.2, 0.0115, {four()});
  system.add(cloud(6, 6, 4, 0.0115, 1, 4));
  system.step(8000);
  Wall plate = floor_wall(0.01);
  plate.name = "plate";
  plate.shape = box_mesh({0.005, 0.005, 0.0}, {0.06, 0.06, 0.004});
  const State before = system.state();
  system.add_wall(plate);
  const std::string message = message_of([&] { system.step(); });
  EXPECT_THAT(message, testing::HasSubstr("step 8001: particle"));
  EXPECT_THAT(message, testing::HasSubstr("deep in wall 'plate'"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  // The state from before goes on.
  system.restore(before);
  system.step(100);
}

TEST(System, RefusesAStepBeyondTheRayleighTime) {
  WorldSettings settings = empty_space();
  settings.time_step = 6e-5;  // the Rayleigh time of Table 2's soil at 3 mm is 98.5 us (Eq. 4)
  EXPECT_THROW(System(settings, table(), {ball()}), Error);
  settings.time_step = 4e-5;
  EXPECT_NEAR(System(settings, table(), {ball()}).rayleigh_step(), 9.853e-5, 2e-8);
}

TEST(System, RemovalKeepsTheOthers) {
  System system = box_of(6, 6, 0.2, 0.0115, {four()});
  system.add(cloud(6, 6, 4, 0.0115, 1, 4));
  system.step(7000);
  const auto before = system.particles();
  const auto contacts = system.contacts();
  std::vector<bool> which(system.size(), false);
  for (std::size_t k = 0; k < which.size(); k += 3) which[k] = true;
  system.remove(which);
  const auto after = system.particles();
  ASSERT_EQ(after.size(), before.size() - (before.size() + 2) / 3);
  std::size_t next = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (which[k]) continue;
    EXPECT_EQ(after[next].position, before[k].position);
    ++next;
  }
  EXPECT_LT(system.contacts().size(), contacts.size());
  EXPECT_GT(system.contacts().size(), 0U);
  system.step(100);
}

}  // namespace
}  // namespace wheel_twin::dem::test
