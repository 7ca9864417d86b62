#include "clients/rec/publish_outlet.h"

#include "clients/rec/rig_frames.h"
#include "model/base/random_id.h"
#include "proto/ipc/path.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::rec {
namespace {

// `payload` with another epoch; unchanged if it is not such a message.
template <typename Message>
std::string WithEpoch(const std::string& payload, std::uint64_t salt) {
  Message message;
  if (!message.ParseFromString(payload)) return payload;
  message.set_epoch(message.epoch() ^ salt);
  return message.SerializeAsString();
}

}  // namespace

Result<std::unique_ptr<PublishOutlet>> PublishOutlet::Bind(const std::string& endpoint,
                                                           bool as_recorded) {
  std::unique_ptr<PublishOutlet> outlet(new PublishOutlet());
  outlet->as_recorded_ = as_recorded;
  if (endpoint.starts_with("ipc://")) {
    const Status free = ipc::CheckFree(endpoint.substr(6));
    if (!free.ok()) return Status::Error("--publish " + endpoint + ": " + free.message());
  }
  try {
    outlet->socket_ = zmq::socket_t(outlet->context_, zmq::socket_type::xpub);
    outlet->socket_.set(zmq::sockopt::xpub_verbose, 1);
    outlet->socket_.set(zmq::sockopt::xpub_nodrop, 1);
    outlet->socket_.set(zmq::sockopt::sndtimeo, 1000);
    outlet->socket_.set(zmq::sockopt::linger, 1000);
    outlet->socket_.bind(endpoint);
    outlet->endpoint_ = outlet->socket_.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& error) {
    return Status::Error("--publish " + endpoint + ": " + error.what() +
                         "; expected e.g. tcp://127.0.0.1:7001 or ipc://PATH");
  }
  outlet->Restart();
  return outlet;
}

void PublishOutlet::Restart() { salt_ = RandomId(); }

std::string PublishOutlet::Renewed(const std::string& topic, const std::string& payload) const {
  if (as_recorded_ || topic.starts_with("body/")) return payload;
  return topic == "stats/" ? WithEpoch<styled::v1::Stats>(payload, salt_)
                           : WithEpoch<styled::v1::Frame>(payload, salt_);
}

void PublishOutlet::Keep(const recording::Published& published) {
  styled::v1::Body body;
  if (!published.topic().starts_with("body/") || !body.ParseFromString(published.payload())) return;
  bodies_[{published.topic(), body.output()}] = published.payload();
}

void PublishOutlet::Note(const recording::Record& record) {
  Keep(record.published());
  announce_ = true;
}

void PublishOutlet::Send(const std::string& topic, const std::string& payload) {
  try {
    if (socket_.send(zmq::buffer(topic), zmq::send_flags::sndmore) &&
        socket_.send(zmq::buffer(payload), zmq::send_flags::none)) {
      ++counts_.messages;
      return;
    }
  } catch (const zmq::error_t&) {  // interrupted by a signal
  }
  ++counts_.dropped;
}

Status PublishOutlet::Play(const recording::Record& record) {
  if (!record.has_published()) return Status::Ok();
  Idle();
  if (announce_) SendBodies("");
  announce_ = false;
  const recording::Published& published = record.published();
  Keep(published);
  Send(published.topic(), Renewed(published.topic(), published.payload()));
  return Status::Ok();
}

void PublishOutlet::Idle() {
  try {
    zmq::message_t message;
    while (socket_.recv(message, zmq::recv_flags::dontwait)) {
      const std::string text = message.to_string();
      if (text.empty() || text[0] != 1) continue;
      ++subscriptions_;
      SendBodies(text.substr(1));
    }
  } catch (const zmq::error_t&) {
    return;
  }
}

// Sends the bodies that match a subscription to one performer, or to a prefix of their topics.
void PublishOutlet::SendBodies(const std::string& prefix) {
  for (const auto& [key, payload] : bodies_) {
    const std::string id = IdOfTopic(key.first, "body/");
    for (const std::string& topic : {key.first, "source/" + id + "/", "styled/" + id + "/rig/",
                                     "styled/" + id + "/canonical/"}) {
      if (!topic.starts_with(prefix)) continue;
      Send(key.first, payload);
      break;
    }
  }
}

}  // namespace styled::rec
