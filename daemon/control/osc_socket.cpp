#include "daemon/control/osc_socket.h"

#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <array>
#include <ctime>

#include "daemon/control/osc.h"
#include "daemon/looks/refusal.h"
#include "daemon/runtime/sockets.h"
#include "proto/rigs/vmc/osc.h"

namespace styled::control {
namespace {

constexpr int kReceiveBuffer_bytes = 1 << 20;
constexpr std::size_t kMaxMessages = 16;  // of one datagram

}  // namespace

OscSocket::OscSocket(Descriptor socket)
    : socket_(std::move(socket)),
      endpoint_(runtime::BoundAddress(socket_.get())),
      buffer_(vmc::osc::kMaxDatagramSize) {}

Result<std::unique_ptr<OscSocket>> OscSocket::Open(const std::string& listen) {
  auto socket = runtime::BindSocket(SOCK_DGRAM, listen, kReceiveBuffer_bytes);
  if (!socket.ok()) return socket.status();
  return std::unique_ptr<OscSocket>(new OscSocket(std::move(socket.value())));
}

bool OscSocket::Receive() {
  sockaddr_storage from{};
  socklen_t from_size = sizeof from;
  const ssize_t size = recvfrom(socket_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT,
                                reinterpret_cast<sockaddr*>(&from), &from_size);
  if (size < 0) return false;
  size_ = static_cast<std::size_t>(size);
  const auto* const bytes = reinterpret_cast<const std::byte*>(&from);
  sender_.assign(bytes, bytes + from_size);
  return true;
}

std::unique_ptr<pipeline::Exchange> OscSocket::Refused(const std::string& address,
                                                       const std::string& reason) const {
  auto exchange = std::make_unique<pipeline::Exchange>();
  exchange->envelope.push_back(sender_);
  exchange->osc = address;
  pipeline::FillReply(pipeline::Malformed(reason), exchange->reply);
  return exchange;
}

std::vector<std::unique_ptr<pipeline::Exchange>> OscSocket::Read() const {
  using Step = vmc::osc::Reader::Step;
  std::vector<std::unique_ptr<pipeline::Exchange>> read;
  vmc::osc::Reader reader({buffer_.data(), size_});
  vmc::osc::Message message;
  Step step = Step::kEnd;
  while ((step = reader.Next(message)) == Step::kMessage) {
    const std::string address(message.address.substr(0, 120));
    if (read.size() == kMaxMessages) {
      read.push_back(Refused(address, "a datagram has at most 16 messages"));
      return read;
    }
    auto request = ReadOsc(message);
    if (!request.ok()) {
      read.push_back(Refused(address, request.status().message()));
      continue;
    }
    if (request.value().command_case() == v1::Request::COMMAND_NOT_SET)
      continue;  // a button's release
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->envelope.push_back(sender_);
    exchange->osc = address;
    exchange->request = std::move(request.value());
    read.push_back(std::move(exchange));
  }
  if (step == Step::kBroken) {
    read.clear();
    read.push_back(Refused("/", "is not OSC: " + std::string(vmc::osc::Name(reader.result()))));
  }
  return read;
}

void OscSocket::Answer(const pipeline::Exchange& exchange) {
  if (exchange.reply.code() == v1::CODE_OK) return;
  std::array<std::byte, 1024> bytes;
  vmc::osc::Writer writer(bytes);
  writer.BeginMessage("/styled/error", "ss");
  writer.Text(exchange.osc);
  writer.Text(std::string_view(exchange.reply.reason()).substr(0, 500));
  writer.EndMessage();
  const auto& to = exchange.envelope.front();
  if (writer.ok()) {
    (void)sendto(socket_.get(), bytes.data(), writer.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(to.data()), static_cast<socklen_t>(to.size()));
  }
  const std::int64_t now_s = std::time(nullptr);
  if (now_s == logged_s_) return;
  logged_s_ = now_s;
  std::string line = "OSC " + exchange.osc + ": " + exchange.reply.reason();
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  }
  spdlog::warn("{}", line);
}

}  // namespace styled::control
