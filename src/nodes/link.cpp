#include "nodes/link.h"

#include <fmt/format.h>
#include <ros/init.h>

#include <algorithm>
#include <chrono>

#include "base/error.h"

namespace wheel_twin::nodes {

void LinkState::wait(const std::function<bool()>& done, double patience, const std::string& what) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const ros::WallDuration look_up(0.1);  // for what is not a message
  while (!done()) {
    if (quit_() || !ros::ok()) throw NodeEnds{};
    if (gone_) {
      gone_ = false;
      node_.clear();
      throw Error(fmt::format("{} is gone", peer_));
    }
    if (std::chrono::duration<double>(Clock::now() - begin).count() > patience)
      throw Error(fmt::format("{} {} for {:g} s", peer_, what, patience));
    queue_.callOne(look_up);
  }
}

void LinkState::disconnected(const std::string& node) {
  const auto entry = std::find(present_.begin(), present_.end(), node);
  if (entry != present_.end()) present_.erase(entry);
  if (node == node_) gone_ = true;
}

void LinkState::heard(const std::string& node) {
  node_ = node;
  gone_ = false;
}

bool LinkState::known_peer_present() const {
  if (node_.empty()) return !present_.empty();
  return std::find(present_.begin(), present_.end(), node_) != present_.end();
}

}  // namespace wheel_twin::nodes
