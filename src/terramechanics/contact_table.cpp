#include "terramechanics/contact_table.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <mutex>

namespace wheel_twin::terramechanics {
namespace {

constexpr int sinkages = 81;     // evenly in sqrt(z / R), 0 to 1
constexpr int deflections = 65;  // evenly in sqrt(delta / R), 0 to 0.5
constexpr double slip_step = 0.02;
constexpr int slips = 101;  // -1 to 1
constexpr int no_slip = 50;
constexpr double largest_slip = 0.92;

/// Cubic through four neighbours: the first of them, and their weights.
struct Stencil {
  int first = 0;
  std::array<double, 4> weight{};
};

Stencil stencil(double place, int first) {
  const double t = place - first - 1;
  return {first,
          {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
           -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0}};
}

Stencil stencil(double place) {
  return stencil(place, static_cast<int>(std::floor(place)) - 1);
}

/// Braking and driving are two laws that meet at slip 0: the four nodes lie on one side of it.
Stencil slip_stencil(double slip) {
  const double place = (slip + 1.0) / slip_step;
  int first = static_cast<int>(std::floor(place)) - 1;
  if (first == no_slip - 1) first = no_slip;
  if (first == no_slip - 2) first = no_slip - 3;
  return stencil(place, first);
}

double sinkage_place(double z, double R) {
  return std::sqrt(z / R) * (sinkages - 1);
}
double deflection_place(double delta_d, double R) {
  return std::sqrt(delta_d / R) * 2.0 * (deflections - 1);
}

struct Node {
  enum State : int { empty, being_made, ready };
  std::atomic<int> state{empty};
  LoadBasis basis;
};

}  // namespace

double peak_position(const Soil& soil, double slip) {
  return std::clamp(soil.c1 + soil.c2 * std::abs(slip), 0.0, 1.0);
}

struct ContactTable::Impl {
  Wheel wheel;
  Soil soil;
  int deflection_count = 1;
  /// One sheet of sinkages and deflections for each slip, made when first touched, and one at rest.
  mutable std::array<std::atomic<Node*>, slips + 1> sheets{};
  mutable std::mutex making;

  Impl(const Wheel& w, const Soil& s) : wheel(w), soil(s), deflection_count(w.stiffness ? deflections : 1) {}
  ~Impl() {
    for (auto& sheet : sheets) delete[] sheet.load();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Node* sheet(int index) const {
    std::atomic<Node*>& place = sheets[static_cast<std::size_t>(index)];
    if (Node* nodes = place.load(std::memory_order_acquire)) return nodes;
    const std::lock_guard<std::mutex> lock(making);
    if (!place.load())
      place.store(new Node[static_cast<std::size_t>(sinkages * deflection_count)], std::memory_order_release);
    return place.load();
  }

  const LoadBasis& basis(int sheet_index, int i, int j) const {
    Node& node = sheet(sheet_index)[i * deflection_count + j];
    int state = node.state.load(std::memory_order_acquire);
    if (state == Node::ready) return node.basis;
    if (state == Node::empty && node.state.compare_exchange_strong(state, Node::being_made)) {
      node.basis = compute(sheet_index, i, j);
      node.state.store(Node::ready, std::memory_order_release);
      return node.basis;
    }
    while (node.state.load(std::memory_order_acquire) != Node::ready) {
    }
    return node.basis;
  }

  LoadBasis compute(int sheet_index, int i, int j) const {
    const double R = wheel.radius, u = static_cast<double>(i) / (sinkages - 1),
                 v = 0.5 * static_cast<double>(j) / (deflections - 1);
    ContactLaw law;
    law.n = soil.n;
    law.K = soil.K;
    const double z = std::max(1e-9, u * u) * R, delta_d = v * v * R;
    if (z + delta_d > R) return {};
    if (sheet_index == slips) {
      law.b = 1.0;
      law.k_eq = 1.0;
      LoadBasis rest;
      rest.pressure_cos = static_vertical_force(contact_geometry(R, z, delta_d, soil.gamma, 0.0), law);
      return rest;
    }
    const double slip = slip_step * sheet_index - 1.0;
    const ContactGeometry geometry = contact_geometry(R, z, delta_d, soil.gamma, peak_position(soil, slip));
    return load_basis(geometry, rim_motion(slip, 0.0), law);
  }

  struct Place {
    Stencil u, v;
    int deflections_used = 1;
  };
  Place place(double z, double delta_d) const {
    Place p;
    p.u = stencil(sinkage_place(z, wheel.radius));
    if (deflection_count > 1) {
      p.v = stencil(deflection_place(delta_d, wheel.radius));
      p.deflections_used = 4;
    } else {
      p.v.weight[0] = 1.0;
    }
    return p;
  }

  template <class Add>
  void gather(const Place& p, int sheet_index, double weight, Add add) const {
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < p.deflections_used; ++b)
        add(basis(sheet_index, p.u.first + a, p.v.first + b),
            weight * p.u.weight[static_cast<std::size_t>(a)] * p.v.weight[static_cast<std::size_t>(b)]);
  }

  template <class Add>
  void gather_rolling(double z, double delta_d, double slip, Add add) const {
    const Place p = place(z, delta_d);
    const Stencil s = slip_stencil(slip);
    for (int c = 0; c < 4; ++c) gather(p, s.first + c, s.weight[static_cast<std::size_t>(c)], add);
  }
};

ContactTable::ContactTable(const Wheel& wheel, const Soil& soil)
    : impl_(std::make_unique<Impl>(wheel, soil)) {}
ContactTable::~ContactTable() = default;

bool ContactTable::fits(const Wheel& wheel, const Soil& soil) const {
  const Wheel& w = impl_->wheel;
  const Soil& s = impl_->soil;
  return wheel.radius == w.radius && wheel.stiffness.has_value() == w.stiffness.has_value() &&
         soil.n == s.n && soil.K == s.K && soil.c1 == s.c1 && soil.c2 == s.c2 && soil.gamma == s.gamma;
}

bool ContactTable::covers(double z, double delta_d, double slip) const {
  const double R = impl_->wheel.radius;
  const double u = sinkage_place(z, R);
  if (!(u >= 1.0 && u < sinkages - 3 && z + delta_d < 0.9 * R && std::abs(slip) < largest_slip)) return false;
  if (impl_->deflection_count == 1) return delta_d == 0.0;
  const double v = deflection_place(delta_d, R);
  return v >= 1.0 && v < deflections - 3;
}

double ContactTable::vertical(double z, double delta_d, double slip, const ContactLaw& law) const {
  LoadBasis sum;
  impl_->gather_rolling(z, delta_d, slip, [&](const LoadBasis& node, double weight) {
    sum.pressure_cos += weight * node.pressure_cos;
    sum.friction_sin += weight * node.friction_sin;
    sum.cohesion_sin += weight * node.cohesion_sin;
  });
  return combined_vertical(sum, impl_->wheel.radius, law);
}

ContactLoads ContactTable::loads(double z, double delta_d, double slip, const ContactLaw& law) const {
  LoadBasis sum;
  impl_->gather_rolling(z, delta_d, slip,
                        [&](const LoadBasis& node, double weight) { sum.add(node, weight); });
  return combined(sum, impl_->wheel.radius, law);
}

double ContactTable::at_rest(double z, double delta_d, const ContactLaw& law) const {
  double sum = 0.0;
  impl_->gather(impl_->place(z, delta_d), slips, 1.0,
                [&](const LoadBasis& node, double weight) { sum += weight * node.pressure_cos; });
  return law.b * law.k_eq * sum;
}

}  // namespace wheel_twin::terramechanics
