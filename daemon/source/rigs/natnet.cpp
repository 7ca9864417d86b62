#include "daemon/source/rigs/natnet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "daemon/config/sources.h"
#include "daemon/runtime/clock.h"
#include "daemon/source/rigs/named_performers.h"

namespace styled::source {
namespace {

using natnet::MessageId;
using runtime::Counter;
using runtime::kSecond_ns;

constexpr std::int64_t kPulse_ns = kSecond_ns;  // commands, keep-alives, requests
constexpr std::int64_t kServerSilence_ns =
    2 * kSecond_ns;  // silence after which CONNECT is repeated
// A frame at least this far behind the newest one means that the server restarted or replays a
// recording, not that the frame was overtaken.
constexpr std::int32_t kOvertaken = 16;
constexpr int kBadFrames = 10;         // consecutive: the bitstream may have changed
constexpr std::uint32_t kSteady = 30;  // equal steps that are the server's rate, not losses
constexpr std::string_view kClientName = "styled";
constexpr natnet::Version kClientVersion{3, 0};

std::string ToString(natnet::Version version) {
  return std::to_string(version.major) + "." + std::to_string(version.minor);
}

bool SameHost(const Peer& a, const Peer& b) {
  const auto& x = reinterpret_cast<const sockaddr_in&>(a.address);
  const auto& y = reinterpret_cast<const sockaddr_in&>(b.address);
  return x.sin_family == AF_INET && y.sin_family == AF_INET &&
         x.sin_addr.s_addr == y.sin_addr.s_addr;
}

}  // namespace

NatNet::NatNet(const config::Source& config, const sockaddr_in& server, in_addr group)
    : config_(config), group_(group), convention_(config.coordinates, config.up) {
  std::memcpy(&server_.address, &server, sizeof server);
  server_.address_size = sizeof server;
}

void NatNet::Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
                    Outbox& out) {
  if (!SameHost(peer, server_)) {
    out.LeaveHotSection();  // the line is composed before the check whether it was logged
    Log("ignoring packets that do not come from server " + config_.server, out);
    return out.Refuse(Counter::kSourceIgnored);
  }
  natnet::Packet packet;
  if (natnet::DecodePacket(datagram, packet) != natnet::DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  if (now_ns - heard_ns_ >= kServerSilence_ns) {  // the server answers again
    out.LeaveHotSection();
    logged_.Forget(now_ns);
  }
  heard_ns_ = now_ns;
  switch (packet.id) {
    case MessageId::kServerInfo:
      return HandleServerInfo(packet.payload, now_ns, out);
    case MessageId::kModelDef:
      return HandleModel(packet.payload, out);
    case MessageId::kFrameOfData:
      return HandleFrame(packet.payload, now_ns, out);
    default:
      return out.Refuse(Counter::kSourceIgnored);
  }
}

void NatNet::Tick(std::int64_t now_ns, Outbox& out) {
  if (now_ns < next_pulse_ns_) return;
  next_pulse_ns_ = now_ns + kPulse_ns;
  if (!version_ || now_ns - heard_ns_ >= kServerSilence_ns) RequestServerInfo(out);
  if (!version_) return;
  if (!stream_) SendCommand(MessageId::kKeepAlive, out);
  if (wants_model_) RequestModel(now_ns, out);
}

// Old servers know the first record, servers from 4.0 on also the longer one; no server objects to
// the one it does not know. No bitstream is requested: SERVER INFO states which one is used.
void NatNet::RequestServerInfo(Outbox& out) {
  natnet::Connect connect;
  connect.shape =
      asked_who_++ % 2 == 0 ? natnet::Connect::Shape::kRecord : natnet::Connect::Shape::kBitstream;
  connect.name = kClientName;
  connect.application = connect.natnet = kClientVersion;
  std::array<std::byte, 300> buffer;
  out.Reply(server_, std::span(buffer).first(natnet::EncodeConnect(connect, buffer)));
}

void NatNet::RequestModel(std::int64_t now_ns, Outbox& out) {
  asked_model_ns_ = now_ns;
  SendCommand(MessageId::kRequestModelDef, out);
}

void NatNet::SendCommand(MessageId id, Outbox& out) {
  std::array<std::byte, natnet::kHeaderSize> buffer;
  out.Reply(server_, std::span(buffer).first(natnet::EncodePacket({id, {}}, buffer)));
}

void NatNet::Log(std::string text, Outbox& out) {
  out.LeaveHotSection();
  if (logged_.Add(text)) out.Note([&text] { return std::move(text); });
}

void NatNet::HandleServerInfo(std::span<const std::byte> payload, std::int64_t now_ns,
                              Outbox& out) {
  natnet::ServerInfo info;
  if (natnet::DecodeServerInfo(payload, info) != natnet::DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  if (info.natnet < natnet::kOldest) {
    Log("server " + config_.server + " speaks NatNet " + ToString(info.natnet) + ", expected " +
            ToString(natnet::kOldest) + " or later",
        out);
    return out.Refuse(Counter::kSourceBadVersion);
  }
  version_ = info.natnet;
  bad_frames_ = 0;
  stream_.reset();
  if (!info.connection && config_.multicast) stream_ = {group_, natnet::kDataPort};
  if (info.connection && info.connection->multicast) {
    stream_ = {in_addr{}, info.connection->data_port};
    std::memcpy(&stream_->group.s_addr, info.connection->group.data(), sizeof stream_->group);
  }
  wants_model_ = true;
  RequestModel(now_ns, out);
}

void NatNet::HandleModel(std::span<const std::byte> payload, Outbox& out) {
  if (!version_) return out.Refuse(Counter::kSourceIgnored);
  if (natnet::DecodeModel(payload, *version_, *model_) != natnet::DecodeResult::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  wants_model_ = false;
  out.LeaveHotSection();
  if (!model_->complete) {
    Log("server " + config_.server +
            " sent data of an unknown type; the rest of that packet is lost",
        out);
  }
  if (model_->skeletons_left_out > 0) {
    Log("server " + config_.server + " has " + std::to_string(model_->skeletons_left_out) +
            " skeletons too many, or with too many bones",
        out);
  }
  if (model_->skeleton_count == 0) {
    Log("server " + config_.server + " streams no skeleton: enable them in its streaming settings",
        out);
  }
  prop_names_.clear();
  for (std::size_t b = 0; b < model_->rigid_bodies_read; ++b) {
    const natnet::RigidBodyDescription& body = model_->rigid_bodies[b];
    if (body.parent <= 0) prop_names_.emplace_back(body.id, body.name);
  }
  model_whole_ = model_->complete && model_->skeletons_left_out == 0;
  std::vector<std::unique_ptr<Performer>> performers;
  for (std::size_t s = 0; s < model_->skeleton_count; ++s) {
    if (Adopt(model_->skeletons[s], performers, out)) continue;
    model_whole_ = false;
    out.Refuse(Counter::kPipelineBodiesRefused);
  }
  performers_ = std::move(performers);
}

// Reuses the performer with this skeleton's name, or makes one.
bool NatNet::Adopt(const natnet::SkeletonDescription& description,
                   std::vector<std::unique_ptr<Performer>>& performers, Outbox& out) {
  auto skeleton = NatNetSkeleton::Make(description);
  if (!skeleton.ok()) {
    Log(skeleton.status().message(), out);
    return false;
  }
  Performer& performer = AdoptNamed(description.name, performers_, performers);
  performer.id = description.id;
  performer.skeleton = std::move(skeleton.value());
  performer.stream.SetBody(performer.skeleton.body(), out);
  performer.pose = rig::RigPose(performer.skeleton.body().skeleton);
  return true;
}

void NatNet::HandleFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out) {
  if (!version_) return out.Refuse(Counter::kSourceIgnored);
  const bool read = natnet::DecodeFrame(payload, *version_, *frame_) == natnet::DecodeResult::kOk &&
                    frame_->timestamp_s >= 0 && frame_->timestamp_s < 1e10;
  if (!read) {
    if (++bad_frames_ % kBadFrames == 0) RequestServerInfo(out);
    return out.Refuse(Counter::kSourceMalformed);
  }
  bad_frames_ = 0;
  if ((frame_->params & natnet::kBitstreamChanged) != 0) RequestServerInfo(out);
  if ((frame_->params & natnet::kModelsChanged) != 0) wants_model_ = true;
  std::uint64_t lost = 0;
  if (Sort(lost, out) == Order::kNext) Send(now_ns, lost, out);
  if (wants_model_ && now_ns - asked_model_ns_ >= kPulse_ns) RequestModel(now_ns, out);
}

NatNet::Order NatNet::Sort(std::uint64_t& lost, Outbox& out) {
  // Unsigned arithmetic, because hostile numbers may be any distance apart.
  const auto number = static_cast<std::uint32_t>(frame_->number);
  const auto ahead = static_cast<std::int32_t>(number - static_cast<std::uint32_t>(last_number_));
  if (any_frame_ && ahead == 0) {
    out.Refuse(Counter::kPipelineDuplicate);
    return Order::kOld;
  }
  if (any_frame_ && ahead < 0 && ahead > -kOvertaken) {
    out.Refuse(Counter::kPipelineReordered);
    return Order::kOld;
  }
  if (any_frame_ && ahead < 0) {
    for (auto& performer : performers_) performer->stream.Restart();
    stride_ = 0;
  } else if (any_frame_) {
    const auto step = static_cast<std::uint32_t>(ahead);
    steady_ = step == last_step_ ? steady_ + 1 : 0;
    last_step_ = step;
    // The stride is the smallest step seen. A larger step becomes the stride when it was repeated
    // kSteady times: then the server sends fewer frames. Any multiple of the stride counts as loss.
    stride_ = stride_ == 0 || steady_ >= kSteady ? step : std::min(stride_, step);
    lost = step / stride_ - 1;
  }
  last_number_ = frame_->number;
  any_frame_ = true;
  return Order::kNext;
}

NatNet::Performer* NatNet::Find(std::int32_t skeleton) noexcept {
  for (auto& performer : performers_) {
    if (performer->id == skeleton) return performer.get();
  }
  return nullptr;
}

void NatNet::WatchConvention(Outbox& out) {
  std::array<float, 4> misfits{};
  for (std::size_t s = 0; s < frame_->skeleton_count; ++s) {
    const natnet::Skeleton& bones = frame_->skeletons[s];
    for (std::size_t b = 0; b < bones.bone_count && !flags_; ++b) flags_ = bones.bones[b].tracked;
    const Performer* performer = Find(bones.id);
    if (performer != nullptr) performer->skeleton.AddMisfits(bones, flags_, misfits);
  }
  const bool was_known = convention_.known();
  if (!convention_.Evaluate(misfits) || !was_known) return;
  for (auto& performer : performers_) performer->stream.Restart();
  const NatNetConvention found = convention_.convention();
  Log("server " + config_.server + " now streams " + (found.local ? "local" : "global") +
          " coordinates, " + (found.z_up ? "+Z" : "+Y") + " up",
      out);
}

// A body of a skeleton has the skeleton's id in its upper 16 bits. An untracked body has the pose
// of an earlier frame.
void NatNet::HandleProps(Outbox& out) noexcept {
  props_.count = props_.left_out = 0;
  for (std::size_t b = 0; b < frame_->rigid_bodies_read; ++b) {
    const natnet::Bone& body = frame_->rigid_bodies[b];
    const auto named = std::ranges::find_if(
        prop_names_, [&body](const auto& known) { return known.first == body.id; });
    if (!body.tracked || body.id != body.description_id() || named == prop_names_.end()) continue;
    Prop prop;
    prop.name = named->second;
    ConvertRigidBody(body, convention_.convention(), prop.position, prop.rotation);
    props_.Add(prop);
  }
  for (std::size_t k = 0; k < props_.left_out; ++k) out.Refuse(Counter::kPipelinePropsLeftOut);
}

void NatNet::Send(std::int64_t now_ns, std::uint64_t lost, Outbox& out) {
  WatchConvention(out);
  HandleProps(out);
  PerformerStream::FrameInfo info;
  info.source_time_ns = static_cast<std::uint64_t>(std::llround(frame_->timestamp_s * 1e9));
  info.now_ns = now_ns;
  info.lost = lost;
  info.props = props_.all();
  info.scene_props = true;
  const std::uint32_t code = frame_->timecode;
  if (code != 0) {
    timecode_ = {code >> 24U, code >> 16U & 0xFFU, code >> 8U & 0xFFU, code & 0xFFU, 0, false};
    info.timecode = &timecode_;
  }
  for (std::size_t s = 0; s < frame_->skeleton_count; ++s) {
    const natnet::Skeleton& bones = frame_->skeletons[s];
    Performer* performer = Find(bones.id);
    if (performer == nullptr) {
      wants_model_ = wants_model_ || model_whole_;
      out.Refuse(Counter::kPipelineBeforeBody);
      continue;
    }
    if (!convention_.known()) {
      out.Refuse(Counter::kSourceIncomplete);
      continue;
    }
    performer->skeleton.Convert(bones, convention_.convention(), flags_, performer->pose);
    performer->stream.Send(performer->pose, info, out);
  }
}

std::unique_ptr<Translator> MakeNatNet(const config::Source& config) {
  const auto server = config::ParseServer(config.server, natnet::kCommandPort);
  const auto group = config::ParseGroup(config.group);
  return std::make_unique<NatNet>(config, server.ok() ? server.value() : sockaddr_in{},
                                  group.ok() ? group.value() : in_addr{});
}

}  // namespace styled::source
