// One end of a lock-step exchange between two nodes: messages out on one topic, the other side's on another.
// Whoever waits takes the messages from the network itself (a queue of its own, no spinner between), and
// notices when the other side is gone: its connection ends, or it is silent for too long. Between nodelets
// of one manager messages pass by pointer.
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/subscriber.h>

#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace wheel_twin::nodes {

/// Thrown out of a wait because the node itself ends.
struct NodeEnds {};

/// What does not depend on the messages: who is connected, and waiting.
class LinkState {
 public:
  /// `peer`: the other side's name in messages to people. `quit`: the node ends.
  LinkState(std::string peer, std::function<bool()> quit) : peer_(std::move(peer)), quit_(std::move(quit)) {}

  const std::string& peer() const { return peer_; }

 protected:
  static constexpr double forever = 1e9;  // s

  /// Until `done`. Throws Error when the other side is gone or `patience` s pass, NodeEnds when the node
  /// ends.
  void wait(const std::function<bool()>& done, double patience, const std::string& what);
  void connected(const std::string& node) { present_.push_back(node); }
  void disconnected(const std::string& node);
  void heard(const std::string& node);
  bool known_peer_present() const;

  ros::CallbackQueue queue_;

 private:
  std::string peer_;
  std::function<bool()> quit_;
  std::vector<std::string> present_;  // nodes that hear what is sent, one entry a connection
  std::string node_;                  // that the last message came from
  bool gone_ = false;
};

template <typename Out, typename In>
class Link : public LinkState {
 public:
  Link(ros::NodeHandle node, const std::string& out, const std::string& in, const std::string& peer,
       std::function<bool()> quit)
      : LinkState(peer, std::move(quit)) {
    ros::AdvertiseOptions advertise = ros::AdvertiseOptions::create<Out>(
        out, 100, [this](const ros::SingleSubscriberPublisher& s) { connected(s.getSubscriberName()); },
        [this](const ros::SingleSubscriberPublisher& s) { disconnected(s.getSubscriberName()); }, nullptr,
        &queue_);
    out_ = node.advertise(advertise);
    ros::SubscribeOptions subscribe;
    subscribe.initByFullCallbackType<const ros::MessageEvent<In const>&>(
        in, 100, [this](const ros::MessageEvent<In const>& event) {
          heard(event.getPublisherName());
          inbox_.push_back(event.getConstMessage());
        });
    subscribe.callback_queue = &queue_;
    subscribe.transport_hints = ros::TransportHints().tcpNoDelay();
    in_ = node.subscribe(subscribe);
  }
  ~Link() {
    in_.shutdown();
    out_.shutdown();
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Until there is another side to talk to. Throws as receive() does.
  void meet(double patience) {
    wait([this] { return known_peer_present() && in_.getNumPublishers() > 0; }, patience,
         "does not appear on " + in_.getTopic());
  }

  void send(const boost::shared_ptr<const Out>& message) { out_.publish(message); }

  /// The next message. Throws Error naming the other side when it is gone or silent for `patience` s, and
  /// NodeEnds.
  boost::shared_ptr<const In> receive(double patience) {
    wait([this] { return !inbox_.empty(); }, patience, "is silent");
    const boost::shared_ptr<const In> message = inbox_.front();
    inbox_.pop_front();
    return message;
  }
  /// The next message, however long it takes, whoever comes and goes in the meantime. Throws NodeEnds.
  boost::shared_ptr<const In> receive_any() {
    for (;;) {
      try {
        return receive(forever);
      } catch (const std::exception&) {
        continue;  // another side may come
      }
    }
  }

 private:
  ros::Publisher out_;
  ros::Subscriber in_;
  std::deque<boost::shared_ptr<const In>> inbox_;
};

}  // namespace wheel_twin::nodes
