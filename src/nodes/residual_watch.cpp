#include "nodes/residual_watch.h"

#include <algorithm>
#include <cmath>

namespace wheel_twin::nodes {

ResidualWatch::ResidualWatch(std::size_t length, double limit)
    : length_(std::max<std::size_t>(1, length)), limit_(limit) {}

void ResidualWatch::add(double residual) {
  squares_.push_back(residual * residual);
  sum_ += squares_.back();
  if (squares_.size() <= length_) return;
  sum_ -= squares_.front();
  squares_.pop_front();
}

void ResidualWatch::clear() {
  squares_.clear();
  sum_ = 0.0;
}

double ResidualWatch::rms() const {
  return squares_.empty() ? 0.0 : std::sqrt(std::max(0.0, sum_) / static_cast<double>(squares_.size()));
}

bool ResidualWatch::exceeded() const {
  return squares_.size() == length_ && rms() > limit_;
}

}  // namespace wheel_twin::nodes
