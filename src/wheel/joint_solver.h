// Direct solution of the joints' constraint equations, (G M^-1 G^T) s = g, for revolute joints in a plane: a
// symmetric positive definite matrix of 2 x 2 blocks, one row a joint, factorised as L D L^T in the order of
// the joints. The pattern is found once. A ring whose joints are numbered around it fills one block column, a
// chain none: cost O(n).
#pragma once

#include <array>
#include <vector>

namespace wheel_twin::wheel {

struct Vec2 {
  double x = 0.0;
  double z = 0.0;
};
inline Vec2 operator+(Vec2 a, Vec2 b) {
  return {a.x + b.x, a.z + b.z};
}
inline Vec2 operator-(Vec2 a, Vec2 b) {
  return {a.x - b.x, a.z - b.z};
}
inline Vec2 operator*(double k, Vec2 a) {
  return {k * a.x, k * a.z};
}
inline double dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.z * b.z;
}
/// d(r)/d(angle) for an arm r that turns about +y (z towards x).
inline Vec2 perp(Vec2 r) {
  return {r.z, -r.x};
}

class JointSolver {
 public:
  /// `joints[j]` are the two bodies that joint j connects; bodies outside 0..bodies-1 are immovable.
  JointSolver(std::vector<std::array<int, 2>> joints, int bodies);

  /// `arms[2 j + side]` from the body's centre of mass to joint j in world axes; inverse masses and inertias
  /// by body.
  void factorize(const std::vector<Vec2>& arms, const std::vector<double>& inverse_mass,
                 const std::vector<double>& inverse_inertia);
  void solve(std::vector<Vec2>& right_hand_side) const;  ///< in place

 private:
  struct Diagonal {
    double xx, xz, zz;
  };
  struct Block {
    double xx, xz, zx, zz;
  };
  struct Contribution {  ///< of one body to one block
    int body, arm_row, arm_column, block;
    double sign;
  };
  struct Entry {
    int row, block;
  };
  struct Update {
    int left, right,
        target;  ///< block target -= L(left) A(right)^T; on the diagonal of a row where left == right
  };
  int block_index(int row, int column);

  std::vector<std::array<int, 2>> joints_;
  std::vector<Contribution> diagonal_terms_, block_terms_;
  std::vector<Entry> entries_;
  std::vector<int> first_entry_;
  std::vector<Update> updates_;
  std::vector<int> first_update_;
  std::vector<std::vector<Entry>> columns_;
  std::vector<Diagonal> diagonal_;
  std::vector<Block> block_, scratch_;
};

}  // namespace wheel_twin::wheel
