#include "clients/doctor/natnet_call.h"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/model.h"

namespace styled::doctor {
namespace {

using natnet::MessageId;

constexpr double kAsk_s = 0.4, kKeepAlive_s = 1;

class NatNetCall final : public Listener {
 public:
  NatNetCall(Descriptor fd, const sockaddr_storage& server, NatNetAnswers& answers)
      : fd_(std::move(fd)), server_(server), answers_(answers) {}

  int fd() const override { return fd_.get(); }

  void Listen(Notebook& notes) override {
    for (int i = 0; i < kBatch; ++i) {
      sockaddr_storage sender{};
      socklen_t length = sizeof sender;
      const ssize_t size = recvfrom(fd_.get(), notes.buffer.data(), notes.buffer.size(),
                                    MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&sender), &length);
      if (size < 0) return;
      // Frames may come from another port of the server.
      if (FromSocket(sender).host != answers_.server.host) continue;
      Accept(std::span(notes.buffer).first(static_cast<std::size_t>(size)), notes);
    }
  }

  void Tick(double now_s) override {
    if (now_s < next_s_) return;
    next_s_ = now_s + kAsk_s;
    if (!answers_.answered) return RequestServerInfo();
    if (!answers_.model_answered) Send(MessageId::kRequestModelDef);
    if (now_s >= next_alive_s_) {
      next_alive_s_ = now_s + kKeepAlive_s;
      Send(MessageId::kKeepAlive);
    }
  }

 private:
  void Accept(std::span<const std::byte> bytes, Notebook& notes) {
    natnet::Packet packet;
    if (natnet::DecodePacket(bytes, packet) != natnet::DecodeResult::kOk) return;
    if (packet.id == MessageId::kServerInfo) return HandleInfo(packet.payload, notes);
    if (packet.id == MessageId::kFrameOfData)
      return answers_.frames.Add(notes.sniffer.Sniff(bytes));
    if (packet.id != MessageId::kModelDef || !answers_.answered) return;
    answers_.model_answered = true;
    answers_.model_read =
        natnet::DecodeModel(packet.payload, answers_.version, *model_) == natnet::DecodeResult::kOk;
    if (!answers_.model_read) return;
    answers_.skeletons = model_->skeleton_count + model_->skeletons_left_out;
    answers_.rigid_bodies = model_->rigid_body_count;
  }

  void HandleInfo(std::span<const std::byte> payload, Notebook& notes) {
    natnet::ServerInfo info;
    if (natnet::DecodeServerInfo(payload, info) != natnet::DecodeResult::kOk) return;
    answers_.answered = true;
    answers_.name = Printable(info.name, 40);
    answers_.version = info.natnet;
    notes.sniffer.set_natnet_version(info.natnet);
    if (!info.connection) return;
    answers_.multicast = info.connection->multicast;
    answers_.data_port = info.connection->data_port;
    const auto& g = info.connection->group;
    answers_.group = std::to_string(g[0]) + "." + std::to_string(g[1]) + "." +
                     std::to_string(g[2]) + "." + std::to_string(g[3]);
  }

  // Alternates between the request that old servers understand and the one of version 4.0 and
  // later.
  void RequestServerInfo() {
    natnet::Connect connect;
    connect.shape =
        asked_++ % 2 == 0 ? natnet::Connect::Shape::kRecord : natnet::Connect::Shape::kBitstream;
    connect.name = "stylectl doctor";
    connect.application = connect.natnet = {3, 0};
    std::array<std::byte, 300> buffer;
    Send(std::span(buffer).first(natnet::EncodeConnect(connect, buffer)));
  }

  void Send(MessageId id) {
    std::array<std::byte, natnet::kHeaderSize> buffer;
    Send(std::span(buffer).first(natnet::EncodePacket({id, {}}, buffer)));
  }
  void Send(std::span<const std::byte> packet) {
    (void)sendto(fd_.get(), packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&server_), sizeof(sockaddr_in));
  }

  Descriptor fd_;
  sockaddr_storage server_;
  NatNetAnswers& answers_;
  std::unique_ptr<natnet::Model> model_ = std::make_unique<natnet::Model>();
  double next_s_ = 0, next_alive_s_ = 0;
  unsigned asked_ = 0;
};

}  // namespace

Result<std::unique_ptr<Listener>> MakeNatNetCall(const std::string& server,
                                                 NatNetAnswers& answers) {
  const bool has_port = server.find(':') != std::string::npos;
  const auto endpoint =
      ParseEndpoint(has_port ? server : server + ":" + std::to_string(natnet::kCommandPort));
  sockaddr_storage address;
  const socklen_t size = endpoint ? ToSocket(*endpoint, address) : 0;
  if (size == 0 || address.ss_family != AF_INET) {
    return Status::Error("server: \"" + server + "\" is not an IPv4 address");
  }
  answers.server = *endpoint;
  Descriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return Status::Error(std::strerror(errno));
  return std::unique_ptr<Listener>(std::make_unique<NatNetCall>(std::move(fd), address, answers));
}

}  // namespace styled::doctor
