#include "clients/doctor/sniff.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <variant>

#include "clients/doctor/address.h"
#include "proto/rigs/ifacialmocap/ifacialmocap.h"
#include "proto/rigs/livelinkface/live_link_face.h"
#include "proto/rigs/mocopi/mocopi.h"
#include "proto/rigs/mvn/mvn.h"
#include "proto/rigs/mvn/stream.h"
#include "proto/rigs/native/datagram.h"
#include "proto/rigs/native/header.h"
#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"
#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/rokoko/rokoko.h"
#include "proto/rigs/slimevr/udp.h"
#include "proto/rigs/vmc/device.h"
#include "proto/rigs/vmc/osc.h"
#include "proto/rigs/vmc/vmc.h"
#include "proto/rigs/vrchat/vrchat.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::doctor {
namespace {

using Bytes = std::span<const std::byte>;

std::string_view AsText(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string Words(std::string_view name) {
  std::string out(name);
  std::ranges::replace(out, '_', ' ');
  return out;
}

std::string Version(natnet::Version version) {
  return "NatNet " + std::to_string(version.major) + "." + std::to_string(version.minor);
}

Sniffed SniffNative(Bytes bytes) {
  Sniffed out{Format::kNative, Verdict::kDamaged, ""};
  native::Datagram datagram;
  const auto result = native::Decode(bytes, datagram);
  if (result == native::DecodeResult::kBadVersion) {
    out.verdict = Verdict::kUseless;
    out.kind = "version " + std::to_string(std::to_integer<int>(bytes[native::header::kVersion]));
    return out;
  }
  if (result != native::DecodeResult::kOk) {
    out.kind = Words(native::Name(result));
    return out;
  }
  const auto size = static_cast<int>(datagram.payload.size());
  const bool is_body = datagram.kind == native::Kind::kBody;
  v1::Body body;
  v1::SourceFrame frame;
  const bool parsed = is_body ? body.ParseFromArray(datagram.payload.data(), size)
                              : frame.ParseFromArray(datagram.payload.data(), size);
  out.kind = is_body ? "skeletons" : "frames";
  if (parsed) {
    out.verdict = is_body ? Verdict::kSkeleton : Verdict::kPose;
  } else {
    out.kind = "unreadable " + out.kind;
  }
  return out;
}

// Names of the types that the daemon ignores.
std::string_view MvnMode(int type) {
  switch (type) {
    case 3:
      return "marker positions";
    case 5:
      return "Unity3D poses";
    case 20:
      return "joint angles";
    case 21:
      return "linear kinematics";
    case 22:
      return "angular kinematics";
    case 23:
      return "raw trackers";
    case 24:
      return "centre of mass";
    default:
      return "datagrams";
  }
}

Sniffed SniffMvn(Bytes bytes) {
  const auto say = [](Verdict verdict, std::string_view kind, int type) {
    std::array<char, 8> digits{};
    std::snprintf(digits.data(), digits.size(), " (%02d)", type);
    return Sniffed{Format::kMvn, verdict, std::string(kind) + digits.data()};
  };
  mvn::Header header;
  if (const auto result = mvn::DecodeHeader(bytes, header); result != mvn::DecodeResult::kOk) {
    return {Format::kMvn, Verdict::kDamaged, Words(mvn::Name(result))};
  }
  auto result = mvn::DecodeResult::kOk;
  std::string_view kind;
  Verdict verdict = Verdict::kTalk;
  if (header.type == mvn::Type::kEuler || header.type == mvn::Type::kQuaternion) {
    mvn::Pose pose;
    result = mvn::DecodePose(bytes, header, pose);
    kind = header.type == mvn::Type::kEuler ? "Euler angles" : "quaternions";
    verdict = Verdict::kPose;
  } else if (header.type == mvn::Type::kScale) {
    mvn::Scale scale;
    result = mvn::DecodeScale(bytes, scale);
    kind = "T-pose";
    verdict = Verdict::kSkeleton;
  } else if (header.type == mvn::Type::kMeta || header.type == mvn::Type::kTimecode) {
    kind = header.type == mvn::Type::kMeta ? "names" : "timecode";
  } else {
    return say(Verdict::kUseless, MvnMode(static_cast<int>(header.type)),
               static_cast<int>(header.type));
  }
  if (result != mvn::DecodeResult::kOk) verdict = Verdict::kDamaged;
  return say(verdict, kind, static_cast<int>(header.type));
}

Sniffed SniffMocopi(Bytes bytes, mocopi::Datagram& datagram) {
  const auto result = mocopi::Decode(bytes, datagram);
  if (result == mocopi::DecodeResult::kNotMocopi) return {};
  if (result == mocopi::DecodeResult::kBadVersion) {
    return {Format::kMocopi, Verdict::kUseless, "a version that is not 1"};
  }
  if (result != mocopi::DecodeResult::kOk) {
    return {Format::kMocopi, Verdict::kDamaged, Words(mocopi::Name(result))};
  }
  if (datagram.kind == mocopi::Datagram::Kind::kFrame) {
    return {Format::kMocopi, Verdict::kPose, "poses (fram)"};
  }
  return {Format::kMocopi, Verdict::kSkeleton, "skeleton (skdf)"};
}

constexpr std::string_view kVrChatAddress = "/tracking/";

// The contents of an OSC datagram of VMC or for VRChat; the most useful message determines the
// verdict.
class OscContent {
 public:
  void Add(const vmc::osc::Message& message) {
    if (message.address.starts_with(kVrChatAddress)) {
      vrchat_ = true;
      vrchat::Message content;
      trackers_ |= vrchat::Decode(message, content) == vrchat::DecodeResult::kOk;
      return;
    }
    if (!message.address.starts_with("/VMC/")) {
      if (foreign_.empty()) foreign_ = message.address;
      return;
    }
    vmc_ = true;
    vmc::Message content;
    if (vmc::Decode(message, content) != vmc::DecodeResult::kOk) {
      vmc::Device device;
      devices_ |= vmc::Decode(message, device) == vmc::DecodeResult::kOk;
      return;
    }
    bones_ |= std::holds_alternative<vmc::Bone>(content);
    face_ |= std::holds_alternative<vmc::Blend>(content);
    const auto* available = std::get_if<vmc::Available>(&content);
    unloaded_ |= available != nullptr && available->loaded == 0;
  }
  Sniffed Summary() const {
    if (trackers_) return {Format::kVrChat, Verdict::kPose, "trackers"};
    if (vrchat_) return {Format::kVrChat, Verdict::kTalk, "tracking without trackers"};
    if (!vmc_) {
      return {Format::kUnknown, Verdict::kForeign, "OSC, but not VMC: " + Printable(foreign_, 40)};
    }
    if (bones_) return {Format::kVmc, Verdict::kPose, "bones"};
    if (unloaded_) return {Format::kVmc, Verdict::kUseless, "\"no avatar is loaded\""};
    if (face_) return {Format::kVmc, Verdict::kTalk, "facial expressions"};
    if (devices_) return {Format::kVmc, Verdict::kPose, "devices"};
    return {Format::kVmc, Verdict::kTalk, "time and state"};
  }

 private:
  bool vrchat_ = false, trackers_ = false;
  bool vmc_ = false, bones_ = false, face_ = false, devices_ = false, unloaded_ = false;
  std::string_view foreign_;
};

Sniffed SniffOsc(Bytes bytes) {
  if (const auto result = vmc::osc::Check(bytes); result != vmc::osc::Result::kOk) {
    const bool vmc = AsText(bytes).find("/VMC/") != std::string_view::npos;
    const bool vrchat = AsText(bytes).find(kVrChatAddress) != std::string_view::npos;
    if (!vmc && !vrchat) return {Format::kUnknown, Verdict::kForeign, "damaged OSC"};
    return {vmc ? Format::kVmc : Format::kVrChat, Verdict::kDamaged, Words(vmc::osc::Name(result))};
  }
  OscContent content;
  vmc::osc::Reader reader(bytes);
  vmc::osc::Message message;
  while (reader.Next(message) == vmc::osc::Reader::Step::kMessage) content.Add(message);
  return content.Summary();
}

// SlimeVR's packets have no marker: only a type whose upper bytes are 0, and a number.
bool LooksLikeSlimeVr(Bytes bytes) {
  const auto at = [bytes](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  if (bytes.size() < 12 || at(0) + at(1) + at(2) != 0) return false;
  const unsigned type = at(3);
  const bool known = type <= 27 || type == 100 || type == 101 || type == 200;
  return known && at(4) + at(5) + at(6) == 0;  // the packet number stays below 2^40
}

std::optional<Sniffed> SniffSlimeVr(Bytes bytes, slimevr::Datagram& datagram) {
  if (!LooksLikeSlimeVr(bytes)) return {};
  if (slimevr::Decode(bytes, datagram) != slimevr::UdpResult::kOk || datagram.count == 0) return {};
  bool pose = false, handshake = false;
  for (const auto& packet : std::span(datagram.packets).first(datagram.count)) {
    pose |= std::holds_alternative<slimevr::Rotation>(packet) ||
            std::holds_alternative<slimevr::LegacyRotation>(packet) ||
            std::holds_alternative<slimevr::RotationAndAcceleration>(packet);
    handshake |= std::holds_alternative<slimevr::Handshake>(packet);
  }
  if (pose) return Sniffed{Format::kSlimeVr, Verdict::kPose, "rotations"};
  if (handshake) return Sniffed{Format::kSlimeVr, Verdict::kTalk, "trackers seeking a server"};
  return Sniffed{Format::kSlimeVr, Verdict::kTalk, "state of trackers"};
}

// Each has a mark of its own: a version and two texts with their lengths; names of expressions.
std::optional<Sniffed> SniffFace(Bytes bytes) {
  live_link_face::Frame phone;
  const auto result = live_link_face::Decode(bytes, phone);
  if (result == live_link_face::DecodeResult::kOk) {
    return Sniffed{Format::kLiveLinkFace, phone.has_face ? Verdict::kPose : Verdict::kTalk,
                   phone.has_face ? "facial expressions" : "\"no face is seen\""};
  }
  ifacialmocap::Frame text;
  if (AsText(bytes).find('|') != std::string_view::npos &&
      ifacialmocap::Decode(bytes, text) == ifacialmocap::DecodeResult::kOk && text.known > 0) {
    return Sniffed{Format::kIFacialMocap, Verdict::kPose, "facial expressions"};
  }
  return {};
}

// The messages of a QTM server. Only its greeting, and data packets whose components add up, can be
// recognized reliably.
std::optional<Sniffed> SniffQtm(Bytes bytes, qtm::Frame& frame) {
  qtm::Packet packet;
  if (qtm::DecodePacket(bytes, packet) != qtm::DecodeResult::kOk) return {};
  const auto say = [](Verdict verdict, std::string kind) {
    return Sniffed{Format::kQtm, verdict, std::move(kind)};
  };
  const std::string_view text = qtm::TextOf(packet.payload);
  if (packet.type == qtm::PacketType::kCommand && qtm::IsGreeting(text)) {
    return say(Verdict::kTalk, "server's greeting");
  }
  if (packet.type == qtm::PacketType::kXml && text.find("<QTM_") != text.npos) {
    return say(Verdict::kSkeleton, "parameters");
  }
  if (packet.type != qtm::PacketType::kData ||
      qtm::DecodeFrame(packet.payload, frame) != qtm::DecodeResult::kOk) {
    return {};
  }
  const auto skeletons = std::span(frame.skeletons).first(frame.skeleton_count);
  const bool seen =
      std::ranges::any_of(skeletons, [](const auto& s) { return s.segment_count > 0; });
  return seen ? say(Verdict::kPose, "skeletons")
              : say(Verdict::kUseless, "frames without a skeleton");
}

bool HasMarks(Bytes bytes, std::size_t at, std::initializer_list<unsigned> marks) {
  if (bytes.size() < at + marks.size()) return false;
  return std::equal(marks.begin(), marks.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    [](unsigned mark, std::byte b) { return std::byte(mark) == b; });
}

Sniffed SniffForeign(Bytes bytes) {
  const auto say = [](std::string kind) {
    return Sniffed{Format::kUnknown, Verdict::kForeign, std::move(kind)};
  };
  if (bytes.empty()) return say("empty datagrams");
  // Header of Noitom's binary BVH.
  if (HasMarks(bytes, 0, {0xFF, 0xDD}) && HasMarks(bytes, 62, {0xFF, 0xEE})) {
    return say("Noitom Axis Studio (binary BVH), which is not supported");
  }
  if (bytes[0] == std::byte{'{'}) return say("JSON, but not Rokoko's");
  const auto start = bytes.first(std::min<std::size_t>(bytes.size(), 8));
  const bool text = std::ranges::all_of(start, [](std::byte b) {
    return (b >= std::byte{' '} && b <= std::byte{'~'}) || b == std::byte{'\n'} ||
           b == std::byte{'\r'} || b == std::byte{'\t'};
  });
  if (text) return say("text: " + Printable(AsText(bytes), 16));
  std::string hex = "bytes";
  for (const std::byte b : start.first(std::min<std::size_t>(start.size(), 4))) {
    std::array<char, 4> digits{};
    std::snprintf(digits.data(), digits.size(), " %02X", std::to_integer<unsigned>(b));
    hex += digits.data();
  }
  return say(hex);
}

bool IsOsc(std::string_view text) {
  return text.starts_with('/') || text.starts_with(std::string_view("#bundle\0", 8));
}

bool IsMocopi(std::string_view text) {
  return text.substr(std::min(text.size(), 4UL), 4) == "head";
}

}  // namespace

struct Sniffer::Scratch {
  mocopi::Datagram mocopi;
  slimevr::Datagram slimevr;
  natnet::Frame natnet_frame;
  natnet::Model natnet_model;
  qtm::Frame qtm_frame;
  rokoko::Decoder rokoko;
  rokoko::Frame rokoko_frame;
};

const char* Name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPose:
      return "pose";
    case Verdict::kSkeleton:
      return "skeleton";
    case Verdict::kTalk:
      return "talk";
    case Verdict::kUseless:
      return "useless";
    case Verdict::kDamaged:
      return "damaged";
    case Verdict::kCut:
      return "cut";
    case Verdict::kForeign:
      break;
  }
  return "foreign";
}

Sniffer::Sniffer() : scratch_(std::make_unique<Scratch>()) {}
Sniffer::~Sniffer() = default;

Sniffed Sniffer::Sniff(Bytes datagram) {
  const std::string_view text = AsText(datagram);
  if (text.starts_with("STYD")) return SniffNative(datagram);
  if (text.starts_with("MXTP")) return SniffMvn(datagram);
  if (IsMocopi(text)) {
    Sniffed found = SniffMocopi(datagram, scratch_->mocopi);
    if (found.format != Format::kUnknown) return found;
  }
  if (IsOsc(text)) return SniffOsc(datagram);
  if (text.starts_with('{') || rokoko::IsLz4Frame(datagram)) {
    if (auto found = SniffRokoko(datagram)) return *found;
  }
  if (auto found = SniffFace(datagram)) return *found;
  if (auto found = SniffQtm(datagram, scratch_->qtm_frame)) return *found;
  if (auto found = SniffNatNet(datagram)) return *found;
  if (auto found = SniffSlimeVr(datagram, scratch_->slimevr)) return *found;
  return SniffForeign(datagram);
}

Sniffed Sniffer::SniffStart(Bytes start) {
  const std::string_view text = AsText(start);
  const auto cut = [](Format format) { return Sniffed{format, Verdict::kCut, "large datagrams"}; };
  if (text.starts_with("STYD")) return cut(Format::kNative);
  if (text.starts_with("MXTP")) return cut(Format::kMvn);
  if (IsMocopi(text)) return cut(Format::kMocopi);
  if (IsOsc(text) && text.find("/VMC/") != std::string_view::npos) return cut(Format::kVmc);
  if (IsOsc(text) && text.find(kVrChatAddress) != std::string_view::npos) {
    return cut(Format::kVrChat);
  }
  const bool scene = text.starts_with('{') && text.find("\"scene\"") != std::string_view::npos;
  if (scene || rokoko::IsLz4Frame(start)) return cut(Format::kRokoko);
  return {Format::kUnknown, Verdict::kForeign, "large datagrams"};
}

// Recognizes the messages from a server to its clients. The clients' requests have too few fixed
// bytes to be recognized.
std::optional<Sniffed> Sniffer::SniffNatNet(Bytes bytes) {
  natnet::Packet packet;
  if (natnet::DecodePacket(bytes, packet) != natnet::DecodeResult::kOk) return {};
  const auto say = [](Verdict verdict, std::string kind) {
    return Sniffed{Format::kNatNet, verdict, std::move(kind)};
  };
  natnet::ServerInfo info;
  if (packet.id == natnet::MessageId::kServerInfo) {
    if (natnet::DecodeServerInfo(packet.payload, info) != natnet::DecodeResult::kOk) return {};
    natnet_version_ = info.natnet;
    const bool old = info.natnet < natnet::kOldest;
    return say(old ? Verdict::kUseless : Verdict::kTalk, "server of " + Version(info.natnet));
  }
  const bool frame = packet.id == natnet::MessageId::kFrameOfData;
  if (!frame && packet.id != natnet::MessageId::kModelDef) return {};
  const auto decode = [&](natnet::Version version) {
    return frame ? natnet::DecodeFrame(packet.payload, version, scratch_->natnet_frame)
                 : natnet::DecodeModel(packet.payload, version, scratch_->natnet_model);
  };
  constexpr std::array<natnet::Version, 7> kVersions{
      {{4, 2}, {4, 1}, {4, 0}, {3, 1}, {3, 0}, {2, 9}, {2, 7}}};
  bool read = natnet_version_ && decode(*natnet_version_) == natnet::DecodeResult::kOk;
  for (std::size_t i = 0; !read && !natnet_version_ && i < kVersions.size(); ++i) {
    read = decode(kVersions[i]) == natnet::DecodeResult::kOk;
  }
  const std::string what = frame ? "frames" : "model";
  if (!read) {
    // Without a known version, only the message id identifies the format.
    return natnet_version_ ? say(Verdict::kDamaged, "unreadable " + what)
                           : std::optional<Sniffed>();
  }
  const std::size_t skeletons =
      frame ? scratch_->natnet_frame.skeleton_count : scratch_->natnet_model.skeleton_count;
  if (skeletons == 0) return say(Verdict::kUseless, what + " without a skeleton");
  return say(frame ? Verdict::kPose : Verdict::kSkeleton, what + " with skeletons");
}

std::optional<Sniffed> Sniffer::SniffRokoko(Bytes bytes) {
  const bool packed = rokoko::IsLz4Frame(bytes);
  const bool marked = packed || AsText(bytes).find("\"actors\"") != std::string_view::npos ||
                      AsText(bytes).find("\"scene\"") != std::string_view::npos;
  if (!marked) return {};
  const auto say = [](Verdict verdict, std::string kind) {
    return Sniffed{Format::kRokoko, verdict, std::move(kind)};
  };
  const auto result = scratch_->rokoko.Decode(bytes, scratch_->rokoko_frame);
  if (result == rokoko::DecodeResult::kBadVersion) {
    return say(Verdict::kUseless, "a JSON version that is not 2 to 3");
  }
  if (result != rokoko::DecodeResult::kOk) {
    return say(Verdict::kDamaged, Words(rokoko::Name(result)));
  }
  const auto& frame = scratch_->rokoko_frame;
  const auto actors = std::span(frame.actors).first(static_cast<std::size_t>(frame.actor_count));
  const bool pose = std::ranges::any_of(actors, [](const auto& a) { return a.has.any(); });
  return pose ? say(Verdict::kPose, packed ? "actors (LZ4)" : "actors (JSON)")
              : say(Verdict::kUseless, "frames without an actor's body");
}

std::size_t RecordSize(Bytes received) {
  const std::string_view text = AsText(received);
  std::size_t size = 0;
  if (text.starts_with("MXTP")) {
    switch (mvn::CutRecord(received, size)) {
      case mvn::Cut::kRecord:
        return size;
      case mvn::Cut::kNeedMore:
        return 0;
      case mvn::Cut::kBroken:
        return received.size();
    }
  }
  constexpr std::string_view kQtmGreeting = "QTM RT Interface";
  if (text.substr(std::min(text.size(), qtm::kHeaderSize)).starts_with(kQtmGreeting)) {
    const rigs::Cut cut = qtm::CutPacket(received, size);
    return cut == rigs::Cut::kRecord ? size : cut == rigs::Cut::kNeedMore ? 0 : received.size();
  }
  if (!text.starts_with("STYD")) return received.size();
  if (received.size() < native::kHeaderSize) return 0;
  size =
      native::kHeaderSize + native::header::Read<std::uint32_t>(received, native::header::kLength);
  if (size > native::kMaxDatagramSize) return received.size();
  return size <= received.size() ? size : 0;
}

}  // namespace styled::doctor
