// A mesh wall as wide as the periodic domain holds a clump wherever along the period it meets the wall.
#include <gtest/gtest.h>

#include "dem/system.h"

namespace wheel_twin::dem {
namespace {

TEST(PeriodicWall, HoldsAlongTheWholePeriod) {
  constexpr double width = 0.08;
  WorldSettings world;
  world.low = {-0.05, 0.0, -0.05};
  world.high = {0.05, width, 0.05};
  world.periodic_y = true;
  world.gravity = {9.81, 0.0, 0.0};
  MaterialTable materials;
  materials.add({"grain", 2700.0, 3e7, 0.25});
  System system(world, materials, {make_clump("ball", {{{0, 0, 0}, 0.003}})});
  Wall wall;
  wall.name = "wall";
  wall.shape = parallelogram({0.0, 0.0, -0.04}, {0.0, width, 0.0}, {0.0, 0.0, 0.08});
  system.add_wall(wall);
  std::vector<Particle> balls;
  for (int j = 0; j < 11; ++j)
    for (int k = 0; k < 9; ++k) {
      Particle ball;
      ball.position = {-0.005, (j + 0.5) * width / 11.0, -0.035 + 0.0085 * k};
      balls.push_back(ball);
    }
  system.add(balls);
  while (system.time() < 0.2) system.step(100);
  for (std::size_t i = 0; i < balls.size(); ++i)
    EXPECT_LT(system.particle(i).position.x(), -0.0028)
        << "at y " << balls[i].position.y() << ", z " << balls[i].position.z();
  double weight = 0.0;
  for (std::size_t i = 0; i < balls.size(); ++i) weight += 9.81 * system.mass(i);
  EXPECT_NEAR(system.wall_wrench(0).force.x(), weight, 1e-3 * weight);
}

}  // namespace
}  // namespace wheel_twin::dem
