#include "wheel/joint_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "base/random.h"

namespace wheel_twin::wheel {
namespace {

// A ring of eight bodies with a leg of three bodies from one of them to an immovable hub, solved densely
// beside.
TEST(JointSolver, AgreesWithADenseSolution) {
  const int bodies = 11, hub = 11;
  std::vector<std::array<int, 2>> joints{{8, hub}, {9, 8}, {10, 9}, {2, 10}};
  for (int i = 0; i < 8; ++i) joints.push_back({i, (i + 1) % 8});
  Random random(1);
  std::vector<double> inverse_mass, inverse_inertia;
  for (int i = 0; i < bodies; ++i) {
    inverse_mass.push_back(random.uniform(1.0, 3.0));
    inverse_inertia.push_back(random.uniform(100.0, 300.0));
  }
  std::vector<Vec2> arms, b;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (int side = 0; side < 2; ++side)
      arms.push_back({random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)});
    b.push_back({random.normal(), random.normal()});
  }
  const auto n = static_cast<Eigen::Index>(joints.size());
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(2 * n, 3 * bodies);
  Eigen::MatrixXd inverse_M = Eigen::MatrixXd::Zero(3 * bodies, 3 * bodies);
  for (int i = 0; i < bodies; ++i) {
    inverse_M(3 * i, 3 * i) = inverse_M(3 * i + 1, 3 * i + 1) = inverse_mass[i];
    inverse_M(3 * i + 2, 3 * i + 2) = inverse_inertia[i];
  }
  Eigen::VectorXd g(2 * n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (int side = 0; side < 2; ++side) {
      const int body = joints[j][side];
      if (body == hub) continue;
      const double sign = side == 0 ? 1.0 : -1.0;
      const Vec2 p = perp(arms[2 * j + side]);
      G(2 * j, 3 * body) = G(2 * j + 1, 3 * body + 1) = sign;
      G(2 * j, 3 * body + 2) = sign * p.x;
      G(2 * j + 1, 3 * body + 2) = sign * p.z;
    }
    g(2 * j) = b[j].x;
    g(2 * j + 1) = b[j].z;
  }
  const Eigen::VectorXd expected = (G * inverse_M * G.transpose()).ldlt().solve(g);
  JointSolver solver(joints, bodies);
  solver.factorize(arms, inverse_mass, inverse_inertia);
  solver.solve(b);
  for (Eigen::Index j = 0; j < n; ++j) {
    EXPECT_NEAR(b[j].x, expected(2 * j), 1e-11 * expected.norm()) << "joint " << j;
    EXPECT_NEAR(b[j].z, expected(2 * j + 1), 1e-11 * expected.norm()) << "joint " << j;
  }
}

}  // namespace
}  // namespace wheel_twin::wheel
