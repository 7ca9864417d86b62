#include "sim/rigs/qtm.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>
#include <sstream>
#include <utility>

#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"
#include "sim/rigs/qtm_skeleton.h"

namespace styled::rigs {
namespace {

using qtm::PacketType;

constexpr std::size_t kMostClients = 10;  // of QTM
constexpr double kTimecode_hz = 30;

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Components that a client has asked for.
struct Components {
  bool skeletons = false, timecode = false, markers = false;
  // False: QTM has no such component. Components that this stand-in lacks are left out, as QTM does
  // with those that a measurement lacks.
  bool Add(const std::string& word) {
    static const std::vector<std::string> kOthers{
        "2d",          "2dlin",      "3dres",      "3dnolabels",  "3dnolabelsres", "analog",
        "6d",          "6dres",      "6deuler",    "6deulerres",  "image",         "force",
        "forcesingle", "gazevector", "eyetracker", "analogsingle"};
    skeletons = skeletons || word == "skeleton" || word == "all";
    timecode = timecode || word == "timecode" || word == "all";
    markers = markers || word == "3d" || word == "all";
    return word == "skeleton" || word == "timecode" || word == "3d" || word == "all" ||
           std::ranges::find(kOthers, word) != kOthers.end();
  }
};

// Whether the client has requested a component of that type.
bool Wants(const Components& components, std::uint32_t type) {
  switch (static_cast<qtm::Component>(type)) {
    case qtm::Component::kMarkers:
      return components.markers;
    case qtm::Component::kTimecode:
      return components.timecode;
    case qtm::Component::kSkeletons:
      return components.skeletons;
  }
  return false;
}

std::uint32_t ReadU32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

// The data packet with only the requested components. A damaged one is left as it is.
std::vector<std::byte> Select(std::span<const std::byte> packet, const Components& components) {
  constexpr std::size_t kHead = 24, kCountAt = 20;
  std::vector<std::byte> whole(packet.begin(), packet.end());
  if (packet.size() < kHead) return whole;
  std::vector<std::byte> out(packet.begin(), packet.begin() + kHead);
  std::uint32_t count = 0;
  for (std::size_t at = kHead; at < packet.size();) {
    if (packet.size() - at < qtm::kHeaderSize) return whole;
    const std::size_t size = ReadU32(packet, at);
    if (size < qtm::kHeaderSize || size > packet.size() - at) return whole;
    const auto component = packet.subspan(at, size);
    at += size;
    if (!Wants(components, ReadU32(component, 4))) continue;
    ++count;
    out.insert(out.end(), component.begin(), component.end());
  }
  const auto size = static_cast<std::uint32_t>(out.size());
  std::memcpy(out.data(), &size, sizeof size);
  std::memcpy(&out[kCountAt], &count, sizeof count);
  return out;
}

// The state that all clients share.
struct Server {
  std::vector<std::string> performers;
  double rate_hz = 60;
  int newest_minor = qtm::kNewestMinor;
  bool z_up = true, split = false, full = false;
  qtm::Parameters parameters;    // all of them
  std::vector<std::byte> frame;  // the last data packet; empty: no measurement runs
  std::minstd_rand random{1};    // of the pieces
};

class Client final : public Session {
 public:
  explicit Client(Server& server) : server_(server), buffer_(qtm::kMaxXmlSize) {}

  bool Receive(std::span<const std::byte> bytes, const Send& send) override {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    std::size_t size = 0, begin = 0;
    auto cut = rigs::Cut::kRecord;
    while ((cut = qtm::CutPacket(std::span(waiting_).subspan(begin), size)) == rigs::Cut::kRecord) {
      qtm::Packet packet;
      const auto record = std::span(waiting_).subspan(begin, size);
      if (qtm::DecodePacket(record, packet) == qtm::DecodeResult::kOk &&
          packet.type == PacketType::kCommand) {
        Handle(std::string(qtm::TextOf(packet.payload)), send);
      }
      begin += size;
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(begin));
    return cut != rigs::Cut::kBroken;
  }

  void Forward(std::span<const std::byte> bytes, const Send& send) override {
    if (minor_ < qtm::kOldestMinor) return;
    qtm::Packet packet;
    const bool read = qtm::DecodePacket(bytes, packet) == qtm::DecodeResult::kOk;
    const bool data = !read || packet.type == PacketType::kData;
    if (!data && packet.type == PacketType::kEvent) return Put(bytes, send);
    if (!streaming_ || (data && frames_++ % divisor_ != 0)) return;
    Put(data ? Select(bytes, components_) : std::vector(bytes.begin(), bytes.end()), send);
  }

  void Greet(const Send& send) { Answer("QTM RT Interface connected", send); }
  void Refuse(const Send& send) {
    Complain("Connection refused. Max number of clients reached.", send);
  }

 private:
  void Put(std::span<const std::byte> bytes, const Send& send) {
    while (server_.split && bytes.size() > 1) {
      const std::size_t size = std::min<std::size_t>(bytes.size(), 1 + server_.random() % 1000);
      send(bytes.first(size));
      bytes = bytes.subspan(size);
    }
    if (!bytes.empty()) send(bytes);
  }
  void Text(PacketType type, std::string_view text, const Send& send) {
    Put(std::span(buffer_).first(qtm::EncodeText(type, text, buffer_)), send);
  }
  void Answer(std::string_view text, const Send& send) { Text(PacketType::kCommand, text, send); }
  void Complain(std::string_view text, const Send& send) { Text(PacketType::kError, text, send); }

  void Handle(const std::string& text, const Send& send) {
    const auto words = Words(Lower(text));
    const std::string_view name = words.empty() ? std::string_view() : words[0];
    if (name == "version") return SetVersion(words, send);
    if (name == "qtmversion") return Answer("QTM Version is 2024.3 (build 0)", send);
    if (name == "byteorder") return Answer("Byte order is little endian", send);
    if (name == "getstate") {
      std::array<std::byte, 16> event;
      const auto state =
          server_.frame.empty() ? qtm::Event::kConnectionClosed : qtm::Event::kCaptureStarted;
      return Put(std::span(event).first(qtm::EncodeEvent(state, event)), send);
    }
    if (minor_ < qtm::kOldestMinor) return Complain("Command not supported in version 1.1", send);
    if (name == "getparameters") return SendParameters(words, send);
    if (name == "streamframes") return Stream(words, send);
    if (name == "getcurrentframe") return SendFrame(words, send);
    Complain("Parse error", send);
  }

  void SetVersion(const std::vector<std::string>& words, const Send& send) {
    const std::string wanted = words.size() > 1 ? words[1] : "";
    const int minor = wanted.starts_with("1.") ? std::atoi(wanted.c_str() + 2) : 0;
    if (minor < 1 || minor > server_.newest_minor) return Complain("Version NOT supported", send);
    minor_ = minor;
    Answer("Version set to 1." + std::to_string(minor), send);
  }

  void SendParameters(const std::vector<std::string>& words, const Send& send) {
    qtm::Parameters asked;
    for (const std::string& word : std::span(words).subspan(1)) {
      const bool all = word == "all";
      if (all || word == "general") asked.frequency_hz = server_.parameters.frequency_hz;
      if (all || word == "3d") {
        asked.up = server_.parameters.up;
        asked.labels = server_.parameters.labels;
      }
      if (all || word == "skeleton") {
        asked.skeletons.emplace();
        for (std::size_t k = 0; k < server_.performers.size(); ++k) {
          asked.skeletons->push_back(DescribeQtmSkeleton(server_.performers[k], FirstId(k),
                                                         server_.z_up, minor_ < qtm::kNestedMinor));
        }
      }
    }
    Text(PacketType::kXml, qtm::WriteParameters(asked, minor_), send);
  }

  bool ReadComponents(std::span<const std::string> words, const Send& send) {
    components_ = {};
    for (const std::string& word : words) {
      if (components_.Add(word)) continue;
      Complain("Parse error", send);
      return false;
    }
    return true;
  }

  void Stream(const std::vector<std::string>& words, const Send& send) {
    const std::string how = words.size() > 1 ? words[1] : "";
    streaming_ = false;
    if (how == "stop") return;
    const double number =
        std::atof(how.substr(std::min(how.find(':'), how.size() - 1) + 1).c_str());
    if (how.starts_with("frequency:") && number > 0) {
      divisor_ = static_cast<std::uint64_t>(std::max(1L, std::lround(server_.rate_hz / number)));
    } else if (how.starts_with("frequencydivisor:") && number >= 1) {
      divisor_ = static_cast<std::uint64_t>(number);
    } else if (how == "allframes") {
      divisor_ = 1;
    } else {
      return Complain("Parse error", send);
    }
    streaming_ = ReadComponents(std::span(words).subspan(2), send);
    frames_ = 0;
  }

  void SendFrame(const std::vector<std::string>& words, const Send& send) {
    const Components streamed = components_;
    if (!ReadComponents(std::span(words).subspan(1), send)) return;
    std::array<std::byte, 16> none;
    if (server_.frame.empty()) {
      Put(std::span(none).first(qtm::EncodeNoMoreData(none)), send);
    } else {
      Put(Select(server_.frame, components_), send);
    }
    components_ = streamed;
  }

 public:
  static std::uint32_t FirstId(std::size_t performer) {
    return kQtmFirstId + 100 * static_cast<std::uint32_t>(performer);
  }

 private:
  Server& server_;
  std::vector<std::byte> waiting_, buffer_;
  int minor_ = 1;  // QTM's version until the client requests another one
  bool streaming_ = false;
  std::uint64_t divisor_ = 1, frames_ = 0;
  Components components_;
};

class Qtm final : public Rig {
 public:
  explicit Qtm(const Options& options)
      : timecode_(HasQuirk(options, "timecode")),
        blink_(HasQuirk(options, "blink")),
        buffer_(qtm::kMaxPacketSize) {
    server_.performers = options.performers;
    server_.rate_hz = options.rate_hz;
    if (HasQuirk(options, "flat")) server_.newest_minor = qtm::kNestedMinor - 1;
    server_.z_up = !HasQuirk(options, "y-up");
    server_.split = HasQuirk(options, "split");
    server_.full = HasQuirk(options, "full");
    server_.parameters.frequency_hz = options.rate_hz;
    server_.parameters.up = server_.z_up ? qtm::Axis::kZ : qtm::Axis::kY;
    for (const std::string& performer : options.performers) {
      for (const auto& joint : body::kHumanoid) {
        server_.parameters.labels.push_back(performer + "_" + std::string(joint.name));
      }
    }
  }

  void Encode(const Frame& frame, const Send& send) override {
    const auto put = [&](std::size_t size) { send(std::span(buffer_).first(size)); };
    if (std::exchange(restarted_, false)) {
      put(qtm::EncodeNoMoreData(buffer_));
      put(qtm::EncodeEvent(qtm::Event::kCaptureStarted, buffer_));
    }
    qtm::Frame& out = *frame_;
    out.timestamp_us = std::llround(frame.time_s * 1e6);
    out.number = 1 + static_cast<std::uint32_t>(frame.index);
    out.has_skeletons = out.has_markers = true;
    out.skeleton_count = frame.poses.size();
    out.markers.count = 0;
    const double period = server_.rate_hz;  // in frames: a second
    const bool hidden =
        blink_ && std::fmod(static_cast<double>(frame.index), period) > 0.9 * period;
    for (std::size_t k = 0; k < frame.poses.size(); ++k) {
      PlaceQtmSkeleton(frame.poses[k], Client::FirstId(k), server_.z_up, out.skeletons[k]);
      if (hidden) out.skeletons[k].segment_count = 0;
      PlaceMarkers(frame.poses[k], out.markers);
    }
    out.has_timecode = timecode_;
    if (timecode_) out.timecode = TimecodeAt(frame.time_s);
    const std::size_t size = qtm::EncodeFrame(out, buffer_);
    server_.frame.assign(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    put(size);
  }

  void Restart() override {
    restarted_ = true;
    server_.frame.clear();
  }

  std::unique_ptr<Session> Accept(std::size_t others, const Send& send) override {
    auto client = std::make_unique<Client>(server_);
    if (others >= kMostClients || server_.full) {
      client->Refuse(send);
      return nullptr;
    }
    client->Greet(send);
    return client;
  }

  std::string default_address() const override { return "tcp://127.0.0.1:22223"; }
  bool is_server() const override { return true; }

 private:
  void PlaceMarkers(const body::Pose& pose, qtm::Markers& markers) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    for (const auto& position : world.positions_m) {
      if (markers.count == qtm::kMaxMarkers) return;
      markers.positions_mm[markers.count++] = ToQtm(position, server_.z_up);
    }
  }

  // From ten o'clock on.
  static qtm::Timecode TimecodeAt(double time_s) {
    const auto frames = static_cast<std::uint32_t>(std::floor(time_s * kTimecode_hz + 1e-6));
    const std::uint32_t seconds = frames / static_cast<std::uint32_t>(kTimecode_hz);
    return qtm::PackSmpte({10 + seconds / 3600 % 14, seconds / 60 % 60, seconds % 60,
                           frames % static_cast<std::uint32_t>(kTimecode_hz)});
  }

  bool timecode_, blink_, restarted_ = false;
  Server server_;
  std::vector<std::byte> buffer_;
  std::unique_ptr<qtm::Frame> frame_ = std::make_unique<qtm::Frame>();
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeQtm(const Options& options) {
  const Status status = CheckOptions("qtm", options, static_cast<int>(qtm::kMaxSkeletons),
                                     {"flat", "y-up", "split", "timecode", "blink", "full"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<Qtm>(options));
}

}  // namespace styled::rigs
