#include "sim/rigs/natnet.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdlib>

#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"

namespace styled::rigs {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using body::Quat;
using body::Vec3;
using natnet::MessageId;

constexpr std::uint64_t kClock_hz = 10'000'000;
constexpr double kStart_s = 100;  // the server's clock at the start of a session
constexpr std::int32_t kFirstFrame = 1000;
constexpr std::string_view kMulticast = "multicast";

// Motive's names, in the canonical joints' order.
constexpr std::array<std::string_view, body::kJointCount> kBones{
    "Hip",   "Ab",    "Chest",     "Neck",   "Head",  "LShoulder", "LUArm",
    "LFArm", "LHand", "RShoulder", "RUArm",  "RFArm", "RHand",     "LThigh",
    "LShin", "LFoot", "LToe",      "RThigh", "RShin", "RFoot",     "RToe"};

bool IsTracked(const Quat& rotation) { return rotation.coeffs().allFinite(); }

std::array<float, 3> ToArray(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
std::array<float, 4> ToArray(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }
Vec3 ZFromY(const Vec3& v) { return {v.x(), -v.z(), v.y()}; }
Quat ZFromY(const Quat& q) { return {q.w(), q.x(), -q.z(), q.y()}; }

// The destination of frames in multicast mode.
class GroupSocket {
 public:
  // Opens "GROUP[:PORT][@INTERFACE]"; "" = the default group.
  Status Open(const std::string& text) {
    const auto refuse = [&text](const std::string& why) {
      return Status::Error("natnet: quirk multicast=" + text + ": " + why +
                           ", expected GROUP[:PORT][@INTERFACE]");
    };
    const std::size_t at = std::min(text.find('@'), text.size());
    const std::size_t colon = std::min(text.substr(0, at).find(':'), at);
    if (colon > 0) group_ = text.substr(0, colon);
    if (colon < at) port_ = std::atoi(text.substr(colon + 1, at - colon - 1).c_str());
    if (port_ < 1 || port_ > 65535) return refuse("port");
    boost::system::error_code error;
    const auto group = asio::ip::make_address_v4(group_, error);
    if (error || !group.is_multicast()) return refuse("no multicast address");
    receiver_ = {group, static_cast<std::uint16_t>(port_)};
    bytes_ = group.to_bytes();
    socket_.open(udp::v4(), error);
    if (!error && at < text.size()) {
      const auto interface = asio::ip::make_address_v4(text.substr(at + 1), error);
      if (!error) socket_.set_option(asio::ip::multicast::outbound_interface(interface), error);
      // Clients identify the server by its source address.
      if (!error) socket_.bind({interface, 0}, error);
    }
    return error ? refuse(error.message()) : Status::Ok();
  }

  void Send(std::span<const std::byte> bytes) {
    boost::system::error_code ignored;  // a multicast sender does not know whether anyone receives
    socket_.send_to(asio::buffer(bytes.data(), bytes.size()), receiver_, 0, ignored);
  }
  std::uint16_t port() const { return receiver_.port(); }
  const std::array<std::uint8_t, 4>& group() const { return bytes_; }

 private:
  asio::io_context context_;
  udp::socket socket_{context_};
  udp::endpoint receiver_;
  std::string group_ = "239.255.42.99";
  int port_ = natnet::kDataPort;
  std::array<std::uint8_t, 4> bytes_{};
};

class NatNet final : public Rig {
 public:
  NatNet(const Options& options, std::unique_ptr<GroupSocket> group)
      : options_(options), group_(std::move(group)), buffer_(natnet::kMaxPacketSize) {
    if (HasQuirk(options_, "2.9")) version_ = {2, 9};
    if (HasQuirk(options_, "4.1")) version_ = {4, 1};
    if (HasQuirk(options_, "4.2")) version_ = {4, 2};
    local_ = HasQuirk(options_, "local");
    z_up_ = HasQuirk(options_, "z-up");
    MakeModel();
  }

  void Encode(const Frame& frame, const Send& send) override {
    natnet::Frame& out = *frame_;
    out.number = kFirstFrame + static_cast<std::int32_t>(frame.index);
    out.timestamp_s = kStart_s + frame.time_s;
    out.exposure_ticks = static_cast<std::uint64_t>(out.timestamp_s * kClock_hz);
    out.received_ticks = out.exposure_ticks + kClock_hz / 1000;
    out.transmit_ticks = out.received_ticks + kClock_hz / 1000;
    ticks_ = out.transmit_ticks;
    out.params = frame.index == 0 ? natnet::kModelsChanged : 0;
    out.skeleton_count = frame.poses.size();
    for (std::size_t k = 0; k < frame.poses.size(); ++k) {
      Place(frame.poses[k], static_cast<std::int32_t>(k + 1), out.skeletons[k]);
    }
    out.rigid_bodies_read = frame.props.size();
    for (std::size_t k = 0; k < frame.props.size(); ++k) {
      const rig::Placed placed = frame.props[k].value_or(rig::Placed());
      const Vec3& position = placed.position_m;
      out.rigid_bodies[k] = {RigidBodyId(k), ToArray(z_up_ ? ZFromY(position) : position),
                             ToArray(z_up_ ? ZFromY(placed.rotation) : placed.rotation),
                             frame.props[k].has_value()};
    }
    const auto bytes = std::span(buffer_).first(natnet::EncodeFrame(out, version_, buffer_));
    group_ != nullptr ? group_->Send(bytes) : send(bytes);
  }

  void Receive(std::span<const std::byte> datagram, const Send& send) override {
    natnet::Packet packet;
    if (natnet::DecodePacket(datagram, packet) != natnet::DecodeResult::kOk) return;
    const auto put = [&](std::size_t size) { send(std::span(buffer_).first(size)); };
    natnet::Echo echo;
    switch (packet.id) {
      case MessageId::kConnect:
      case MessageId::kDiscovery:
        return put(natnet::EncodeServerInfo(Info(), buffer_));
      case MessageId::kRequestModelDef:
        return put(natnet::EncodeModel(*model_, version_, buffer_));
      case MessageId::kRequest:
        if (natnet::DecodeRequest(packet.payload) == "FrameRate") {
          return put(natnet::EncodeNumber(static_cast<float>(options_.rate_hz), buffer_));
        }
        return put(natnet::EncodePacket({MessageId::kUnrecognized, {}}, buffer_));
      case MessageId::kEchoRequest:
        if (natnet::DecodeEchoRequest(packet.payload, echo) != natnet::DecodeResult::kOk) return;
        echo.server = ticks_;
        return put(natnet::EncodeEchoResponse(echo, buffer_));
      default:  // keep-alives and disconnects: the link tracks the clients
        return;
    }
  }

  std::string default_address() const override { return "udp://127.0.0.1:1510"; }
  bool is_server() const override { return true; }

 private:
  static std::int32_t RigidBodyId(std::size_t prop) {
    constexpr std::int32_t kFirst = 101;
    return kFirst + static_cast<std::int32_t>(prop);
  }

  natnet::ServerInfo Info() const {
    natnet::ServerInfo info;
    info.name = "Motive";
    info.application = {static_cast<std::uint8_t>(version_.major - 1), 1};
    info.natnet = version_;
    info.connection = {
        kClock_hz, group_ != nullptr ? group_->port() : natnet::kDataPort, group_ != nullptr, {}};
    if (group_ != nullptr) info.connection->group = group_->group();
    return info;
  }

  void MakeModel() {
    model_->rigid_bodies_read = options_.props.size();
    for (std::size_t k = 0; k < options_.props.size(); ++k) {
      model_->rigid_bodies[k] = {options_.props[k].name, RigidBodyId(k), -1};
    }
    model_->skeleton_count = options_.performers.size();
    names_.reserve(options_.performers.size() * kBones.size());
    for (std::size_t k = 0; k < options_.performers.size(); ++k) {
      natnet::SkeletonDescription& skeleton = model_->skeletons[k];
      skeleton.name = options_.performers[k];
      skeleton.id = static_cast<std::int32_t>(k + 1);
      skeleton.bone_count = kBones.size();
      for (std::size_t j = 0; j < kBones.size(); ++j) {
        std::string name(kBones[j]);
        if (HasQuirk(options_, "prefix")) {
          name = options_.performers[k];
          if (j > 0) name.append("_").append(kBones[j]);
        }
        names_.push_back(std::move(name));
        const int joint = static_cast<int>(j);
        skeleton.bones[j] = {names_.back(), joint + 1, body::kHumanoid[j].parent + 1,
                             OffsetOf(joint)};
      }
    }
  }

  std::array<float, 3> OffsetOf(int joint) const {
    const Vec3 offset = joint == 0 ? Vec3(Vec3::Zero()) : body::Offset(joint);
    return ToArray(z_up_ ? ZFromY(offset) : offset);
  }

  void Place(const body::Pose& pose, std::int32_t id, natnet::Skeleton& skeleton) const {
    body::Pose whole = pose;
    for (Quat& rotation : whole.rotations) {
      if (!IsTracked(rotation)) rotation = Quat::Identity();
    }
    body::WorldPose world;
    body::ForwardKinematics(whole, world);
    skeleton.id = id;
    skeleton.bone_count = kBones.size();
    for (std::size_t j = 0; j < kBones.size(); ++j) {
      const bool local = local_ && j > 0;
      const Quat& rotation = local ? whole.rotations[j] : world.rotations[j];
      const Vec3& position = world.positions_m[j];
      natnet::Bone& bone = skeleton.bones[j];
      bone.id = id << 16 | static_cast<std::int32_t>(j + 1);
      bone.position_m =
          local ? OffsetOf(static_cast<int>(j)) : ToArray(z_up_ ? ZFromY(position) : position);
      bone.rotation = ToArray(z_up_ ? ZFromY(rotation) : rotation);
      bone.tracked = IsTracked(pose.rotations[j]);
    }
  }

  Options options_;
  std::unique_ptr<GroupSocket> group_;
  natnet::Version version_{3, 0};
  bool local_ = false, z_up_ = false;
  std::uint64_t ticks_ = 0;
  std::vector<std::string> names_;  // owns the text that the model's views refer to
  std::vector<std::byte> buffer_;
  std::unique_ptr<natnet::Frame> frame_ = std::make_unique<natnet::Frame>();
  std::unique_ptr<natnet::Model> model_ = std::make_unique<natnet::Model>();
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeNatNet(const Options& options) {
  Options others = options;
  std::unique_ptr<GroupSocket> group;
  for (const std::string& quirk : options.quirks) {
    if (quirk != kMulticast && !quirk.starts_with(std::string(kMulticast) + "=")) continue;
    group = std::make_unique<GroupSocket>();
    const Status opened = group->Open(quirk.substr(std::min(kMulticast.size() + 1, quirk.size())));
    if (!opened.ok()) return opened;
    std::erase(others.quirks, quirk);
  }
  const Status status = CheckOptions("natnet", others, static_cast<int>(natnet::kMaxSkeletons),
                                     {"2.9", "4.1", "4.2", "local", "z-up", "prefix", kMulticast},
                                     natnet::kMaxRigidBodies);
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<NatNet>(options, std::move(group)));
}

}  // namespace styled::rigs
