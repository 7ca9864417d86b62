#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "model/body/pose.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::client {

// The canonical humanoid as a body message of `performer`, under `hash`.
inline v1::Body HumanoidBody(const std::string& performer, v1::Output output, std::uint64_t hash) {
  v1::Body body;
  body.set_performer(performer);
  body.set_output(output);
  body.set_hash(hash);
  body.set_metres_per_unit(1.0F);
  for (const body::JointRow& row : body::kHumanoid) {
    body.add_names(std::string(row.name));
    body.add_parents(row.parent);
    for (const float offset : {row.x_m, row.y_m, row.z_m}) body.add_offsets(offset);
  }
  return body;
}

// `pose` as a frame on that body.
inline v1::Frame HumanoidFrame(const v1::Body& body, const body::Pose& pose, std::uint64_t sequence,
                               std::uint64_t epoch = 1) {
  v1::Frame frame;
  frame.set_performer(body.performer());
  frame.set_output(body.output());
  frame.set_body_hash(body.hash());
  frame.set_epoch(epoch);
  frame.set_sequence(sequence);
  for (int axis = 0; axis < 3; ++axis) frame.add_root_position(pose.hips_position_m[axis]);
  for (const body::Quat& rotation : pose.rotations) {
    for (int k = 0; k < 4; ++k) frame.add_rotations(rotation.coeffs()[k]);
  }
  return frame;
}

// A daemon's two sockets, speaking WIRE.md, on ports that the kernel picks; its own thread. Tests
// define what it publishes, which bodies a new subscription gets, and what it answers.
class FakeDaemon {
 public:
  using Handler = std::function<v1::Reply(const v1::Request&)>;

  explicit FakeDaemon(Handler handler = {}, const std::string& publisher = "tcp://127.0.0.1:*",
                      const std::string& control = "tcp://127.0.0.1:*")
      : handler_(std::move(handler)) {
    xpub_.set(zmq::sockopt::linger, 0);
    xpub_.set(zmq::sockopt::xpub_verbose, 1);
    router_.set(zmq::sockopt::linger, 0);
    xpub_.bind(publisher);
    router_.bind(control);
    publisher_ = xpub_.get(zmq::sockopt::last_endpoint);
    control_ = router_.get(zmq::sockopt::last_endpoint);
    thread_ = std::jthread([this](const std::stop_token& stop) { Loop(stop); });
  }

  const std::string& publisher() const { return publisher_; }
  const std::string& control() const { return control_; }
  int subscriptions() const { return subscriptions_; }

  // Publishes `body` now and to each client that subscribes to its performer (or to all).
  void AddBody(const v1::Body& body) {
    const std::scoped_lock lock(mutex_);
    bodies_.push_back(body);
    outbox_.emplace_back("body/" + body.performer() + "/", body.SerializeAsString());
  }
  void Publish(const std::string& topic, const std::string& payload) {
    const std::scoped_lock lock(mutex_);
    outbox_.emplace_back(topic, payload);
  }
  void Publish(const std::string& topic, const v1::Frame& frame) {
    Publish(topic, frame.SerializeAsString());
  }

  // The handler's data from before its last reply may be read after this: the reply itself orders
  // them too, but through libzmq, which a thread sanitizer cannot see.
  void Synchronize() { const std::scoped_lock lock(handling_); }

  // Waits for a subscription to `topic`. False after two seconds.
  bool WaitForSubscription(const std::string& topic) {
    for (int wait = 0; wait < 400 && !Subscribed(topic); ++wait) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return Subscribed(topic);
  }
  bool Subscribed(const std::string& topic) {
    const std::scoped_lock lock(mutex_);
    return topics_.contains(topic);
  }

 private:
  void Loop(const std::stop_token& stop) {
    std::vector<zmq::pollitem_t> items{{xpub_.handle(), 0, ZMQ_POLLIN, 0},
                                       {router_.handle(), 0, ZMQ_POLLIN, 0}};
    while (!stop.stop_requested()) {
      zmq::poll(items, std::chrono::milliseconds(1));
      zmq::message_t message;
      while (xpub_.recv(message, zmq::recv_flags::dontwait)) Subscription(message.to_string());
      while (router_.recv(message, zmq::recv_flags::dontwait)) Request(message);
      const std::scoped_lock lock(mutex_);
      for (const auto& [topic, payload] : outbox_) Send(topic, payload);
      outbox_.clear();
    }
  }

  void Subscription(const std::string& message) {
    const std::string topic = message.substr(1);
    const std::scoped_lock lock(mutex_);
    if (message[0] == 0) {
      topics_.erase(topic);
      return;
    }
    ++topics_[topic];
    ++subscriptions_;
    for (const v1::Body& body : bodies_) {
      const bool named = topic.find("/" + body.performer() + "/") != std::string::npos;
      if (named || topic == "body/")
        Send("body/" + body.performer() + "/", body.SerializeAsString());
    }
  }

  void Request(zmq::message_t& identity) {
    zmq::message_t part;
    std::vector<std::string> parts{identity.to_string()};
    while (router_.get(zmq::sockopt::rcvmore)) {
      (void)router_.recv(part);
      parts.push_back(part.to_string());
    }
    v1::Request request;
    if (!handler_ || !request.ParseFromString(parts.back())) return;
    v1::Reply reply = [&] {
      const std::scoped_lock lock(handling_);
      return handler_(request);
    }();
    if (reply.id() == 0) reply.set_id(request.id());
    parts.back() = reply.SerializeAsString();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      router_.send(zmq::buffer(parts[i]),
                   i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
  }

  void Send(const std::string& topic, const std::string& payload) {
    xpub_.send(zmq::buffer(topic), zmq::send_flags::sndmore);
    xpub_.send(zmq::buffer(payload), zmq::send_flags::none);
  }

  Handler handler_;
  zmq::context_t context_{1};
  zmq::socket_t xpub_{context_, zmq::socket_type::xpub};
  zmq::socket_t router_{context_, zmq::socket_type::router};
  std::string publisher_, control_;
  std::mutex mutex_;
  std::mutex handling_;  // held while the handler runs
  std::vector<v1::Body> bodies_;
  std::vector<std::pair<std::string, std::string>> outbox_;
  std::map<std::string, int> topics_;
  std::atomic<int> subscriptions_{0};
  std::jthread thread_;
};

}  // namespace styled::client
