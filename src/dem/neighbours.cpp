#include "dem/neighbours.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace wheel_twin::dem {
namespace {

/// Spheres of the grid in the order of their cells, coordinates from the grid's corner in single precision.
class Grid {
 public:
  Grid(const Bodies& bodies, const Spheres& spheres, const Period& period)
      : period_(period), body_(spheres.body), asleep_(bodies.asleep) {
    choose_big(spheres);
    choose_cells(bodies, spheres);
    fill(bodies, spheres);
    find_stirring(bodies);
  }

  template <typename Emit>
  void pairs(Emit&& emit) const {
    for (std::size_t p = 0; p < sphere_.size(); ++p) {
      const int cx = cell_of(0, x_[p]);
      const int cy = cell_of(1, y_[p]);
      const int cz = cell_of(2, z_[p]);
      if (asleep_[owner_[p]] != 0 && stirs_[number(cx, cy, cz)] == 0) continue;
      visit(cx - 1, cx + 1, cy - 1, cy + 1, cz - 1, cz + 1, p + 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t o = begin; o < end; ++o) {
          if (near(p, o)) emit(sphere_[p], sphere_[o]);
        }
      });
    }
    big_pairs(emit);
  }

 private:
  void choose_big(const Spheres& spheres) {
    double sum = 0.0;
    for (std::size_t s = 0; s < spheres.count; ++s) sum += spheres.row[s].radius;
    const double limit = 2.0 * sum / static_cast<double>(std::max<std::size_t>(spheres.count, 1));
    for (std::size_t s = 0; s < spheres.count; ++s) {
      const float radius = spheres.row[s].radius;
      if (radius > limit) {
        big_.push_back(static_cast<std::uint32_t>(s));
      } else {
        largest_small_ = std::max(largest_small_, radius);
      }
    }
  }

  void choose_cells(const Bodies& bodies, const Spheres& spheres) {
    float skin = 0.0F;
    for (std::size_t b = 0; b < bodies.count; ++b) skin = std::max(skin, bodies.reserve[b]);
    reach_ = largest_small_ + skin;
    double low[3] = {};
    double high[3] = {};
    for (int a = 0; a < 3; ++a) {
      low[a] = period_.low[a];
      high[a] = period_.high[a];
      if (period_.inverse[a] != 0.0) continue;
      low[a] = 1e300;
      high[a] = -1e300;
      for (std::size_t s = 0; s < spheres.count; ++s) {
        low[a] = std::min(low[a], spheres.row[s].x[a]);
        high[a] = std::max(high[a], spheres.row[s].x[a]);
      }
      if (spheres.count == 0) low[a] = high[a] = 0.0;
    }
    double extent = 0.0;
    for (int a = 0; a < 3; ++a) extent = std::max(extent, high[a] - low[a]);
    margin_ = static_cast<float>(1e-6 * extent);
    double cell = 2.0 * reach_ + 2.0 * margin_ + 1e-12;
    for (;; cell *= 1.26) {
      double total = 1.0;
      for (int a = 0; a < 3; ++a) {
        const double count = std::clamp(std::floor((high[a] - low[a]) / cell), 1.0, 1e6);
        cells_[a] = static_cast<int>(count);
        total *= count;
      }
      if (total <= 8.0 * static_cast<double>(spheres.count) + 1024.0) break;
    }
    for (int a = 0; a < 3; ++a) {
      low_[a] = low[a];
      length_[a] = static_cast<float>(high[a] - low[a]);
      inverse_cell_[a] = static_cast<float>(cells_[a] / std::max(high[a] - low[a], 1e-12));
      half_[a] = period_.inverse[a] != 0.0 ? 0.5F * length_[a] : 1e30F;
    }
  }

  void fill(const Bodies& bodies, const Spheres& spheres) {
    const std::size_t n = spheres.count - big_.size();
    std::vector<std::uint32_t> cell(spheres.count, 0);
    start_.assign(static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2] + 1, 0);
    std::vector<bool> is_big(spheres.count, false);
    for (const auto s : big_) is_big[s] = true;
    for (std::size_t s = 0; s < spheres.count; ++s) {
      float at[3];
      position(spheres.row[s], at);
      cell[s] = static_cast<std::uint32_t>(number(cell_of(0, at[0]), cell_of(1, at[1]), cell_of(2, at[2])));
      if (!is_big[s]) ++start_[cell[s] + 1];
    }
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    x_.resize(n);
    y_.resize(n);
    z_.resize(n);
    reach_of_.resize(n);
    sphere_.resize(n);
    owner_.resize(n);
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t s = 0; s < spheres.count; ++s) {
      if (is_big[s]) continue;
      const std::size_t p = next[cell[s]]++;
      float at[3];
      position(spheres.row[s], at);
      x_[p] = at[0];
      y_[p] = at[1];
      z_[p] = at[2];
      reach_of_[p] = spheres.row[s].radius + bodies.reserve[spheres.body[s]] + margin_;
      sphere_[p] = static_cast<std::uint32_t>(s);
      owner_[p] = spheres.body[s];
    }
    for (const auto s : big_) {
      float at[3];
      position(spheres.row[s], at);
      big_at_.push_back(
          {at[0], at[1], at[2], spheres.row[s].radius + bodies.reserve[spheres.body[s]] + margin_});
    }
  }

  /// Cells that have an awake sphere in them or beside them; nothing when all are awake.
  void find_stirring(const Bodies& bodies) {
    if (std::find(asleep_.begin(), asleep_.begin() + static_cast<std::ptrdiff_t>(bodies.count), 1) ==
        asleep_.begin() + static_cast<std::ptrdiff_t>(bodies.count))
      return;
    stirs_.assign(start_.size() - 1, 0);
    for (std::size_t p = 0; p < sphere_.size(); ++p) {
      if (asleep_[owner_[p]] == 0)
        stirs_[number(cell_of(0, x_[p]), cell_of(1, y_[p]), cell_of(2, z_[p]))] = 1;
    }
    // Spread by one cell along one axis after the other.
    std::vector<int> near;
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<std::uint8_t> before = stirs_;
      int at[3];
      for (at[0] = 0; at[0] < cells_[0]; ++at[0]) {
        for (at[1] = 0; at[1] < cells_[1]; ++at[1]) {
          for (at[2] = 0; at[2] < cells_[2]; ++at[2]) {
            if (before[number(at[0], at[1], at[2])] == 0) continue;
            axis_cells(axis, at[axis] - 1, at[axis] + 1, near);
            for (const int c : near) {
              int other[3] = {at[0], at[1], at[2]};
              other[axis] = c;
              stirs_[number(other[0], other[1], other[2])] = 1;
            }
          }
        }
      }
    }
  }

  /// From the grid's corner, on periodic axes within the period.
  void position(const SphereRow& row, float (&at)[3]) const {
    for (int a = 0; a < 3; ++a) {
      double x = row.x[a] - low_[a];
      if (period_.inverse[a] != 0.0) x -= period_.length[a] * std::floor(x * period_.inverse[a]);
      at[a] = static_cast<float>(x);
    }
  }

  int cell_of(int axis, float at) const {
    return std::clamp(static_cast<int>(at * inverse_cell_[axis]), 0, cells_[axis] - 1);
  }
  std::size_t number(int cx, int cy, int cz) const {
    return (static_cast<std::size_t>(cx) * cells_[1] + cy) * cells_[2] + cz;
  }
  float apart(int axis, float a, float b) const {
    const float d = std::fabs(a - b);
    return d > half_[axis] ? length_[axis] - d : d;
  }
  bool near(std::size_t p, std::size_t o) const {
    const float dx = apart(0, x_[p], x_[o]);
    const float dy = apart(1, y_[p], y_[o]);
    const float dz = z_[p] - z_[o];
    const float reach = reach_of_[p] + reach_of_[o];
    return dx * dx + dy * dy + dz * dz < reach * reach && owner_[p] != owner_[o];
  }

  /// Cells [low, high] of an axis as unique cell numbers.
  void axis_cells(int axis, int low, int high, std::vector<int>& cells) const {
    cells.clear();
    const int n = cells_[axis];
    if (period_.inverse[axis] == 0.0) {
      for (int c = std::max(low, 0); c <= std::min(high, n - 1); ++c) cells.push_back(c);
    } else if (high - low + 1 >= n) {
      for (int c = 0; c < n; ++c) cells.push_back(c);
    } else {
      for (int c = low; c <= high; ++c) cells.push_back((c + n) % n);
    }
  }

  /// Calls `run(begin, end)` for the runs of entries, none before `first`, in a box of cells.
  template <typename Run>
  void visit(int x0, int x1, int y0, int y1, int z0, int z1, std::size_t first, Run&& run) const {
    thread_local std::vector<int> xs;
    thread_local std::vector<int> ys;
    axis_cells(0, x0, x1, xs);
    axis_cells(1, y0, y1, ys);
    const int bottom = std::max(z0, 0);
    const int top = std::min(z1, cells_[2] - 1);
    for (const int x : xs) {
      for (const int y : ys) {
        const std::size_t begin = std::max<std::size_t>(start_[number(x, y, bottom)], first);
        const std::size_t end = start_[number(x, y, top) + 1];
        if (begin < end) run(begin, end);
      }
    }
  }

  template <typename Emit>
  void big_pairs(Emit&& emit) const {
    for (std::size_t k = 0; k < big_.size(); ++k) {
      const auto& at = big_at_[k];
      const float range = at[3] + reach_ + margin_;
      int low[3];
      int high[3];
      for (int a = 0; a < 3; ++a) {
        low[a] = static_cast<int>(std::floor((at[a] - range) * inverse_cell_[a]));
        high[a] = static_cast<int>(std::floor((at[a] + range) * inverse_cell_[a]));
      }
      // Entries outside the grid's z were clamped into its first and last layer.
      visit(low[0], high[0], low[1], high[1], std::min(low[2], cells_[2] - 1), std::max(high[2], 0), 0,
            [&](std::size_t begin, std::size_t end) {
              for (std::size_t o = begin; o < end; ++o) {
                const float dx = apart(0, at[0], x_[o]);
                const float dy = apart(1, at[1], y_[o]);
                const float dz = at[2] - z_[o];
                const float reach = at[3] + reach_of_[o];
                if (dx * dx + dy * dy + dz * dz < reach * reach && body_[big_[k]] != owner_[o]) {
                  emit(big_[k], sphere_[o]);
                }
              }
            });
      for (std::size_t m = k + 1; m < big_.size(); ++m) {
        const auto& other = big_at_[m];
        const float dx = apart(0, at[0], other[0]);
        const float dy = apart(1, at[1], other[1]);
        const float dz = at[2] - other[2];
        const float reach = at[3] + other[3];
        if (dx * dx + dy * dy + dz * dz < reach * reach && body_[big_[k]] != body_[big_[m]])
          emit(big_[k], big_[m]);
      }
    }
  }

  const Period& period_;
  const Column<std::uint32_t>& body_;
  const Column<std::uint8_t>& asleep_;
  std::vector<std::uint32_t> big_;
  std::vector<std::array<float, 4>> big_at_;
  float largest_small_ = 0.0F;
  float reach_ = 0.0F;
  float margin_ = 0.0F;
  int cells_[3] = {1, 1, 1};
  double low_[3] = {};
  float length_[3] = {};
  float half_[3] = {};
  float inverse_cell_[3] = {};
  std::vector<std::uint32_t> start_;
  std::vector<float> x_, y_, z_, reach_of_;
  std::vector<std::uint32_t> sphere_, owner_;
  std::vector<std::uint8_t> stirs_;
};

template <typename T>
void reorder(Column<T>& values, const std::vector<std::uint32_t>& order) {
  if (values.empty()) return;
  const Column<T> old = values;
  for (std::size_t k = 0; k < order.size(); ++k) values[k] = old[order[k]];
}

}  // namespace

void find_pairs(const Bodies& bodies, const Spheres& spheres, const Period& period,
                const ThreadBounds& bounds, OuterList& list, std::size_t without) {
  const std::size_t threads = bounds.size() - 1;
  list.i.assign(threads + 1, {});
  list.j.assign(threads + 1, {});
  const auto thread_of = [&](std::uint32_t sphere) {
    const std::size_t body = spheres.body[sphere];
    std::size_t t = 0;
    while (body >= bounds[t + 1]) ++t;
    return t;
  };
  Grid(bodies, spheres, period).pairs([&](std::uint32_t a, std::uint32_t b) {
    const std::size_t t = thread_of(a);
    const std::size_t part = t == thread_of(b) ? t : threads;
    if (part == without) return;
    list.i[part].push_back(a);
    list.j[part].push_back(b);
  });
  for (auto& part : list.i) part.shrink_to_fit();
  for (auto& part : list.j) part.shrink_to_fit();
}

std::vector<std::uint32_t> spatial_order(const Bodies& bodies, const Period& period, double cell) {
  double low[3] = {};
  double high[3] = {};
  for (int a = 0; a < 3; ++a) {
    low[a] = 1e300;
    high[a] = -1e300;
    for (std::size_t b = 0; b < bodies.count; ++b) {
      low[a] = std::min(low[a], bodies.x[a][b]);
      high[a] = std::max(high[a], bodies.x[a][b]);
    }
    if (period.inverse[a] != 0.0) {
      low[a] = period.low[a];
      high[a] = period.high[a];
    }
  }
  int axis[3] = {0, 1, 2};
  std::sort(axis, axis + 3, [&](int a, int b) {
    const double da = high[a] - low[a];
    const double db = high[b] - low[b];
    return da != db ? da > db : a < b;
  });
  std::vector<std::uint64_t> key(bodies.count);
  for (std::size_t b = 0; b < bodies.count; ++b) {
    for (int k = 0; k < 3; ++k) {
      const double c = std::clamp((bodies.x[axis[k]][b] - low[axis[k]]) / cell, 0.0, 1e6);
      key[b] = key[b] << 21U | static_cast<std::uint64_t>(c);
    }
  }
  std::vector<std::uint32_t> order(bodies.count);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (bodies.asleep[a] != bodies.asleep[b]) return bodies.asleep[a] < bodies.asleep[b];
    return key[a] != key[b] ? key[a] < key[b] : bodies.rank[a] < bodies.rank[b];
  });
  return order;
}

void permute(Bodies& bodies, Spheres& spheres, const ShapeTable& shapes,
             const std::vector<std::uint32_t>& order) {
  for (int k = 0; k < 3; ++k) {
    reorder(bodies.x[k], order);
    reorder(bodies.v[k], order);
    reorder(bodies.l[k], order);
    reorder(bodies.inverse_inertia[k], order);
  }
  for (auto& column : bodies.q) reorder(column, order);
  reorder(bodies.inverse_mass, order);
  reorder(bodies.size, order);
  reorder(bodies.stiffness, order);
  reorder(bodies.slack, order);
  reorder(bodies.reserve, order);
  reorder(bodies.reach, order);
  reorder(bodies.rank, order);
  reorder(bodies.shape, order);
  reorder(bodies.material, order);
  reorder(bodies.asleep, order);
  reorder(bodies.load, order);
  std::uint32_t next = 0;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    bodies.first[b] = next;
    for (std::uint32_t k = 0; k < shapes.count[bodies.shape[b]]; ++k) {
      spheres.body[next++] = static_cast<std::uint32_t>(b);
    }
  }
}

}  // namespace wheel_twin::dem
