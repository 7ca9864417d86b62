#include "sim/rigs/stream_server.h"

#include <fcntl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <list>

namespace styled::rigs {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kMostWaiting = 8U << 20U;  // seconds of the largest stream

class StreamServer final : public player::Link {
 public:
  explicit StreamServer(Rig& server) : server_(server), buffer_(65536) {}

  // `url` has been checked.
  Status Open(const std::string& url, std::string* bound) {
    const std::size_t begin = std::string("tcp://").size(), colon = url.rfind(':');
    std::string host = url.substr(begin, colon - begin);
    if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
    error_code error;
    const auto address = asio::ip::make_address(host, error);
    if (error) return Status::Error(error.message() + ", expected a numeric address");
    const tcp::endpoint at(address, static_cast<std::uint16_t>(std::stoi(url.substr(colon + 1))));
    acceptor_.open(at.protocol(), error);
    // Prevents a process that is started meanwhile from keeping the port.
    if (!error) (void)::fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error) acceptor_.non_blocking(true, error);
    if (error) return Status::Error(error.message());
    if (bound != nullptr) {
      *bound = url.substr(0, colon + 1) + std::to_string(acceptor_.local_endpoint().port());
    }
    return Status::Ok();
  }

  Status Send(std::span<const std::byte> bytes) override {
    for (Client& client : clients_) {
      client.session->Forward(bytes, client.Sender());
    }
    std::erase_if(clients_, [](const Client& client) { return client.gone; });
    return Status::Ok();
  }

  // Talks with the clients. There are no datagrams.
  std::size_t Receive(std::span<std::byte> /*datagram*/) override {
    Accept();
    for (Client& client : clients_) {
      Read(client);
      Write(client, {});
    }
    std::erase_if(clients_, [](const Client& client) { return client.gone; });
    return 0;
  }

 private:
  struct Client {
    explicit Client(tcp::socket connected) : socket(std::move(connected)) {}
    rigs::Send Sender() {
      return [this](std::span<const std::byte> bytes) { Write(*this, bytes); };
    }
    tcp::socket socket;
    std::unique_ptr<Session> session;
    std::vector<std::byte> waiting;  // data that the socket has not accepted yet
    bool gone = false;
  };

  void Accept() {
    while (true) {
      error_code error;
      tcp::socket socket = acceptor_.accept(error);
      if (error) return;
      (void)::fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
      socket.set_option(tcp::no_delay(true), error);
      socket.non_blocking(true, error);
      Client& client = clients_.emplace_back(std::move(socket));
      client.session = server_.Accept(clients_.size() - 1, client.Sender());
      if (client.session == nullptr || client.gone) clients_.pop_back();
    }
  }

  void Read(Client& client) {
    error_code error;
    for (std::size_t size = 0; !client.gone;) {
      size = client.socket.read_some(asio::buffer(buffer_), error);
      if (error == asio::error::would_block) return;
      client.gone =
          error || !client.session->Receive(std::span(buffer_).first(size), client.Sender());
    }
  }

  static void Write(Client& client, std::span<const std::byte> bytes) {
    client.waiting.insert(client.waiting.end(), bytes.begin(), bytes.end());
    error_code error;
    while (!client.waiting.empty() && !client.gone) {
      const std::size_t size = client.socket.write_some(asio::buffer(client.waiting), error);
      client.waiting.erase(client.waiting.begin(),
                           client.waiting.begin() + static_cast<std::ptrdiff_t>(size));
      if (error == asio::error::would_block) break;
      client.gone = static_cast<bool>(error);
    }
    client.gone = client.gone || client.waiting.size() > kMostWaiting;
  }

  Rig& server_;
  std::vector<std::byte> buffer_;
  asio::io_context context_;
  tcp::acceptor acceptor_{context_};
  std::list<Client> clients_;
};

}  // namespace

Result<std::unique_ptr<player::Link>> Listen(Rig& server, const std::string& url,
                                             std::string* bound) {
  if (Status status = player::CheckAddress(url, 0); !status.ok()) return status;
  const bool stream = player::IsStream(url);
  if (stream != player::IsStream(server.default_address())) {
    return Status::Error(url + ": expected " + (stream ? "udp" : "tcp") + "://HOST:PORT");
  }
  if (!stream) return player::Listen(url, bound, server.audience());
  auto link = std::make_unique<StreamServer>(server);
  const Status status = link->Open(url, bound);
  if (!status.ok()) return Status::Error(url + ": " + status.message());
  return std::unique_ptr<player::Link>(std::move(link));
}

}  // namespace styled::rigs
