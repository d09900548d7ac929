// Sleeping parts of a bed: what they cost, that they carry the same, and that they wake.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "dem_fixture.h"

namespace wheel_twin::dem::test {
namespace {

constexpr int kSide = 10;
constexpr double kSpacing = 0.0115;

System box(bool sleeps, int threads = 1, bool book = false, double speed = SleepSettings{}.speed) {
  WorldSettings settings;
  settings.low = {0.0, 0.0, -0.01};
  settings.high = {kSide * kSpacing, kSide * kSpacing, 0.2};
  settings.periodic_x = settings.periodic_y = true;
  settings.time_step = book ? 8e-6 : 1.77e-5;
  settings.smallest_size = 0.9;
  settings.threads = threads;
  settings.track_energy = book;
  settings.sleep.enabled = sleeps;
  settings.sleep.time = 0.01;
  settings.sleep.speed = speed;
  System system(settings, table(), {four(), lopsided()});
  system.add_wall(floor_wall());
  return system;
}

/// A bed that has come to rest, made without sleep, once for all tests.
const State& settled() {
  static const State state = [] {
    System system = box(false);
    system.add(cloud(kSide, kSide, 7, kSpacing, 2, 1));
    system.step(15000);
    for (int k = 0; k < 60; ++k) {
      system.stop_all();
      system.step(50);
    }
    system.step(30000);  // a few loose grains roll on for half a second
    return system.state();
  }();
  return state;
}

double weight(const System& system) {
  double sum = 0.0;
  for (std::size_t i = 0; i < system.size(); ++i) sum += 9.81 * system.mass(i);
  return sum;
}

double surface(const System& system) {
  double top = 0.0;
  for (const auto& s : system.spheres()) top = std::max(top, s.center.z() + s.radius);
  return top;
}

/// A plate of 30 x 30 mm over the middle of the bed that goes down.
std::uint32_t add_plate(System& system, double speed, double shift = 0.0) {
  Wall plate;
  plate.name = "plate";
  plate.material = 1;
  plate.shape = box_mesh({-0.015, -0.015, 0.0}, {0.015, 0.015, 0.01});
  plate.pose.position = {0.0575 + shift, 0.0575, surface(system) + 1e-4};
  plate.motion.velocity.z() = -speed;
  return system.add_wall(plate);
}

TEST(Sleep, ABedAtRestCostsNextToNothingAndKeepsItsWeight) {
  System awake = box(false);
  System sleeping = box(true);
  awake.restore(settled());
  sleeping.restore(settled());
  awake.step(4000);
  sleeping.step(4000);
  EXPECT_GT(sleeping.statistics().sleeping, 97 * sleeping.size() / 100);
  EXPECT_LT(sleeping.statistics().candidates, awake.statistics().candidates / 10);
  EXPECT_NEAR(-sleeping.wall_wrench(0).force.z(), weight(sleeping), 1e-3 * weight(sleeping));
  // The same places as without sleep, within a thousandth of a grain.
  const auto a = awake.particles();
  const auto b = sleeping.particles();
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_LT((a[k].position - b[k].position).norm(), 6e-6);
}

TEST(Sleep, WakesAroundAPlateAndFallsAsleepAgain) {
  System system = box(true);
  system.restore(settled());
  system.step(4000);
  ASSERT_GT(system.statistics().sleeping, 9 * system.size() / 10);
  const std::uint32_t plate = add_plate(system, 0.05);
  system.step(1024);
  EXPECT_LT(system.statistics().sleeping, system.size());
  system.step(6000);
  EXPECT_LT(system.wall_wrench(0).force.z(), -1.05 * weight(system));  // the floor feels the plate
  EXPECT_NEAR(-system.wall_wrench(0).force.z(), weight(system) + system.wall_wrench(plate).force.z(),
              0.1 * weight(system));
  const std::size_t pressed = system.statistics().sleeping;
  system.set_wall_motion(plate, {});
  system.step(24000);
  EXPECT_GT(system.statistics().sleeping, pressed + system.size() / 5);
  EXPECT_NEAR(-system.wall_wrench(0).force.z(), weight(system) + system.wall_wrench(plate).force.z(),
              0.03 * weight(system));
}

constexpr int kPlaces = 5;

/// Mean force on a plate that goes down, and its variance over five places.
struct PlateForce {
  double mean = 0.0, variance = 0.0;
};

/// `bed_at`: the bed for the place that lies `shift` from the middle.
PlateForce plate_force(const std::function<System(double shift)>& bed_at) {
  std::vector<double> forces;
  for (int place = 0; place < kPlaces; ++place) {
    const double shift = 0.023 * place;
    System system = bed_at(shift);
    const std::uint32_t plate = add_plate(system, 0.05, shift);
    system.step(3000);
    double sum = 0.0;
    for (int k = 0; k < 100; ++k) {
      system.step(10);
      sum += system.wall_wrench(plate).force.z() / 100.0;
    }
    forces.push_back(sum);
  }
  PlateForce force;
  for (const double f : forces) force.mean += f / kPlaces;
  for (const double f : forces) force.variance += std::pow(f - force.mean, 2) / (kPlaces - 1);
  return force;
}

/// The difference of the means stays below what the scatter over the places allows (Student, 95 %, 8 degrees
/// of freedom: 2.31).
void expect_same_mean(const PlateForce& a, const PlateForce& b) {
  EXPECT_NEAR(b.mean, a.mean, 2.31 * std::sqrt((a.variance + b.variance) / kPlaces))
      << "scatter " << std::sqrt(a.variance) << " and " << std::sqrt(b.variance);
}

TEST(Sleep, APlateFeelsTheSameWithAndWithout) {
  const auto bed = [](bool sleeps) {
    return [sleeps](double /*shift*/) {
      System system = box(sleeps);
      system.restore(settled());
      system.step(2048);
      return system;
    };
  };
  const PlateForce awake = plate_force(bed(false));
  EXPECT_GT(awake.mean, 1.0);  // N
  expect_same_mean(awake, plate_force(bed(true)));
}

TEST(Sleep, SameBitsForAnyNumberOfThreadsAndAfterARestart) {
  std::vector<State> ends;
  for (const int threads : {1, 2, 0}) {
    System system = box(true, std::max(threads, 1));
    system.restore(settled());
    system.step(1536);
    add_plate(system, 0.05);
    system.step(1500);
    if (threads == 0) {
      const State state = system.state();
      EXPECT_GT(system.statistics().sleeping, 0U);
      System again = box(true, 2);
      again.restore(state);
      again.step(500);
      ends.push_back(again.state());
    } else {
      system.step(500);
      ends.push_back(system.state());
    }
  }
  for (std::size_t other : {1U, 2U}) {
    EXPECT_EQ(ends[0].asleep, ends[other].asleep);
    EXPECT_EQ(ends[0].quiet, ends[other].quiet);
    for (std::size_t k = 0; k < ends[0].position.size(); ++k) {
      ASSERT_EQ(ends[0].position[k], ends[other].position[k]) << "particle " << k;
      ASSERT_EQ(ends[0].velocity[k], ends[other].velocity[k]) << "particle " << k;
      ASSERT_EQ(ends[0].load[k], ends[other].load[k]) << "particle " << k;
    }
    ASSERT_EQ(ends[0].contacts.size(), ends[other].contacts.size());
  }
}

TEST(Sleep, TheEnergyBookStaysClosed) {
  System system = box(true, 1, true);
  system.restore(settled());
  const auto total = [&] {
    const EnergyBook book = system.energy();
    return book.kinetic + book.potential + book.elastic + book.damped + book.friction - book.wall_work;
  };
  system.step(1);
  const double before = total();
  system.step(6000);
  EXPECT_GT(system.statistics().sleeping, 0U);
  add_plate(system, 0.1);
  const double start = system.energy().wall_work;
  system.step(8000);
  const double work = system.energy().wall_work - start;
  EXPECT_GT(work, 1e-4);
  EXPECT_NEAR(total(), before, 1e-3 * work);
}

constexpr double kMiddle = 0.5 * kSide * kSpacing;

/// The settled bed in which nothing falls asleep by itself.
System windowed(int threads = 1, bool book = false) {
  System system = box(true, threads, book, 0.0);
  system.restore(settled());
  return system;
}

/// Steps with a window that swings by a cell to both sides, so that slabs fall asleep in motion and wake.
/// What moves the grains (the plate of 30 mm) stays inside.
void press(System& system, std::int64_t steps) {
  for (std::int64_t k = 0; k < steps; ++k) {
    const double phase = static_cast<double>(system.step_number() - settled().step) / 2000.0;
    system.hold_beyond(kMiddle + 0.01 * std::sin(M_PI * phase), 0.035);
    system.step();
  }
}

TEST(Window, HoldsWhatLiesOutsideAndLetsTheRestMove) {
  System system = windowed();
  system.hold_beyond(kMiddle, 0.03);
  add_plate(system, 0.05);
  system.step(4000);
  const auto before = settled().position;
  const auto after = system.particles();
  std::size_t still = 0;
  double farthest = 0.0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const double way = (after[k].position - before[k]).norm();
    const double from_middle = std::abs(before[k].x() - kMiddle);
    if (from_middle > 0.03 + 0.01) {  // a cell may reach over the edge by half of its 9 mm
      EXPECT_EQ(way, 0.0) << "particle " << k;
      ++still;
    }
    if (from_middle < 0.02) farthest = std::max(farthest, way);
  }
  EXPECT_GT(still, after.size() / 5);
  EXPECT_GE(system.statistics().sleeping, still);
  EXPECT_GT(farthest, 1e-3);
}

TEST(Window, APlateFeelsTheSameWithAndWithout) {
  const auto bed = [](bool holds) {
    return [holds](double shift) {
      System system = windowed();
      if (holds) system.hold_beyond(kMiddle + shift, 0.045);
      return system;
    };
  };
  expect_same_mean(plate_force(bed(false)), plate_force(bed(true)));
}

TEST(Window, SameBitsForAnyNumberOfThreadsAndAfterARestart) {
  std::vector<State> ends;
  for (const int threads : {1, 2, 0}) {
    System system = windowed(std::max(threads, 1));
    add_plate(system, 0.05);
    press(system, 2500);
    if (threads == 0) {
      System again = box(true, 2, false, 0.0);
      again.restore(system.state());
      press(again, 1000);
      ends.push_back(again.state());
    } else {
      press(system, 1000);
      ends.push_back(system.state());
    }
  }
  for (std::size_t other : {1U, 2U}) {
    EXPECT_EQ(ends[0].hold, ends[other].hold);
    EXPECT_EQ(ends[0].asleep, ends[other].asleep);
    EXPECT_EQ(ends[0].position, ends[other].position);
    EXPECT_EQ(ends[0].velocity, ends[other].velocity);
  }
}

TEST(Window, TheEnergyBookStaysClosed) {
  System system = windowed(1, true);
  system.step(1);
  const auto total = [&] { return dem::test::total(system.energy()); };
  const double before = total();
  add_plate(system, 0.1);
  press(system, 8000);
  EXPECT_GT(system.energy().wall_work, 1e-4);
  EXPECT_NEAR(total(), before, 1e-3 * system.energy().wall_work);
}

TEST(Window, NeedsSleepAndALength) {
  System awake = box(false);
  EXPECT_THROW(awake.hold_beyond(0.05, 0.03), Error);
  System system = windowed();
  EXPECT_THROW(system.hold_beyond(0.05, 0.0), Error);
  EXPECT_THROW(system.hold_beyond(std::nan(""), 0.03), Error);
}

}  // namespace
}  // namespace wheel_twin::dem::test
