#include "wheel/joint_solver.h"

#include <algorithm>
#include <utility>

namespace wheel_twin::wheel {

int JointSolver::block_index(int row, int column) {
  auto& entries = columns_[column];
  for (const Entry& entry : entries) {
    if (entry.row == row) return entry.block;
  }
  const int block = static_cast<int>(block_.size());
  block_.push_back({});
  entries.push_back({row, block});
  return block;
}

JointSolver::JointSolver(std::vector<std::array<int, 2>> joints, int bodies) : joints_(std::move(joints)) {
  const int n = static_cast<int>(joints_.size());
  columns_.resize(n);
  diagonal_.resize(n);
  std::vector<std::vector<std::array<int, 2>>> of_body(bodies);  // joint, side
  for (int j = 0; j < n; ++j) {
    for (int side = 0; side < 2; ++side) {
      const int body = joints_[j][side];
      if (body < bodies) of_body[body].push_back({j, side});
    }
  }
  for (int body = 0; body < bodies; ++body) {
    for (const auto& [row, row_side] : of_body[body]) {
      for (const auto& [column, column_side] : of_body[body]) {
        const double sign = row_side == column_side ? 1.0 : -1.0;
        const Contribution term{body, 2 * row + row_side, 2 * column + column_side, row, sign};
        if (row == column) diagonal_terms_.push_back(term);
        if (row > column) {
          block_terms_.push_back(term);
          block_terms_.back().block = block_index(row, column);
        }
      }
    }
  }
  for (int k = 0; k < n; ++k) {
    std::sort(columns_[k].begin(), columns_[k].end(), [](auto a, auto b) { return a.row < b.row; });
    first_entry_.push_back(static_cast<int>(entries_.size()));
    first_update_.push_back(static_cast<int>(updates_.size()));
    const std::vector<Entry> column = columns_[k];
    entries_.insert(entries_.end(), column.begin(), column.end());
    for (std::size_t i = 0; i < column.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const int target = i == j ? column[i].row : block_index(column[i].row, column[j].row);
        updates_.push_back({column[i].block, column[j].block, target});
      }
    }
  }
  first_entry_.push_back(static_cast<int>(entries_.size()));
  first_update_.push_back(static_cast<int>(updates_.size()));
  scratch_.resize(block_.size());
}

void JointSolver::factorize(const std::vector<Vec2>& arms, const std::vector<double>& inverse_mass,
                            const std::vector<double>& inverse_inertia) {
  std::fill(diagonal_.begin(), diagonal_.end(), Diagonal{});
  std::fill(block_.begin(), block_.end(), Block{});
  for (const Contribution& term : diagonal_terms_) {
    const Vec2 p = perp(arms[term.arm_row]);
    const double m = inverse_mass[term.body];
    const double i = inverse_inertia[term.body];
    Diagonal& d = diagonal_[term.block];
    d.xx += m + i * p.x * p.x;
    d.xz += i * p.x * p.z;
    d.zz += m + i * p.z * p.z;
  }
  for (const Contribution& term : block_terms_) {
    const Vec2 p = perp(arms[term.arm_row]);
    const Vec2 q = perp(arms[term.arm_column]);
    const double m = term.sign * inverse_mass[term.body];
    const double i = term.sign * inverse_inertia[term.body];
    Block& b = block_[term.block];
    b.xx += m + i * p.x * q.x;
    b.xz += i * p.x * q.z;
    b.zx += i * p.z * q.x;
    b.zz += m + i * p.z * q.z;
  }
  const int n = static_cast<int>(joints_.size());
  for (int k = 0; k < n; ++k) {
    Diagonal& d = diagonal_[k];
    const double inverse_determinant = 1.0 / (d.xx * d.zz - d.xz * d.xz);
    d = {d.zz * inverse_determinant, -d.xz * inverse_determinant, d.xx * inverse_determinant};
    for (int e = first_entry_[k]; e < first_entry_[k + 1]; ++e) {
      const int b = entries_[e].block;
      const Block a = block_[b];
      scratch_[b] = a;
      block_[b] = {a.xx * d.xx + a.xz * d.xz, a.xx * d.xz + a.xz * d.zz, a.zx * d.xx + a.zz * d.xz,
                   a.zx * d.xz + a.zz * d.zz};
    }
    for (int u = first_update_[k]; u < first_update_[k + 1]; ++u) {
      const Update& update = updates_[u];
      const Block& l = block_[update.left];
      const Block& a = scratch_[update.right];
      if (update.left == update.right) {
        Diagonal& t = diagonal_[update.target];
        t.xx -= l.xx * a.xx + l.xz * a.xz;
        t.xz -= l.xx * a.zx + l.xz * a.zz;
        t.zz -= l.zx * a.zx + l.zz * a.zz;
      } else {
        Block& t = block_[update.target];
        t.xx -= l.xx * a.xx + l.xz * a.xz;
        t.xz -= l.xx * a.zx + l.xz * a.zz;
        t.zx -= l.zx * a.xx + l.zz * a.xz;
        t.zz -= l.zx * a.zx + l.zz * a.zz;
      }
    }
  }
}

void JointSolver::solve(std::vector<Vec2>& right_hand_side) const {
  std::vector<Vec2>& s = right_hand_side;
  const int n = static_cast<int>(joints_.size());
  for (int k = 0; k < n; ++k) {
    const Vec2 y = s[k];
    for (int e = first_entry_[k]; e < first_entry_[k + 1]; ++e) {
      const Block& l = block_[entries_[e].block];
      Vec2& t = s[entries_[e].row];
      t.x -= l.xx * y.x + l.xz * y.z;
      t.z -= l.zx * y.x + l.zz * y.z;
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    const Diagonal& d = diagonal_[k];
    const Vec2 y = s[k];
    Vec2 t{d.xx * y.x + d.xz * y.z, d.xz * y.x + d.zz * y.z};
    for (int e = first_entry_[k]; e < first_entry_[k + 1]; ++e) {
      const Block& l = block_[entries_[e].block];
      const Vec2 v = s[entries_[e].row];
      t.x -= l.xx * v.x + l.zx * v.z;
      t.z -= l.xz * v.x + l.zz * v.z;
    }
    s[k] = t;
  }
}

}  // namespace wheel_twin::wheel
