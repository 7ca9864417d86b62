#include "clients/web/gateway.h"

#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <utility>

#include "clients/web/connection.h"
#include "model/base/text.h"

namespace styled::web {
namespace {

using boost::asio::ip::tcp;

constexpr std::chrono::milliseconds kTick(500), kAcceptRetry(200);

Result<tcp::endpoint> ParseListen(const std::string& text) {
  const Status wrong = Status::Error("--listen " + text +
                                     ": expected HOST:PORT, HOST numeric or localhost, e.g. "
                                     "127.0.0.1:7080 or [::1]:7080");
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return wrong;
  std::string host = text.substr(0, colon);
  if (host == "localhost") host = "127.0.0.1";
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(host, error);
  if (error) return wrong;
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + colon + 1, end, port);
  if (parsed.ec != std::errc() || parsed.ptr != end) return wrong;
  return tcp::endpoint(address, port);
}

}  // namespace

Gateway::Gateway(boost::asio::io_context& io_context, const Options& from)
    : io(io_context), options(from), acceptor_(io), tick_(io), retry_(io) {}

Result<std::unique_ptr<Gateway>> Gateway::Start(boost::asio::io_context& io,
                                                const Options& options) {
  std::unique_ptr<Gateway> gateway(new Gateway(io, options));
  Status status = gateway->Prepare();
  if (status.ok()) status = gateway->Listen();
  if (!status.ok()) return status;
  gateway->Accept();
  gateway->Tick();
  return gateway;
}

Status Gateway::Prepare() {
  if (!options.token_file.empty()) {
    auto token = ReadToken(options.token_file);
    if (!token.ok()) return token.status();
    access.token = std::move(token.value());
  }
  access.origins = options.origins;
  for (const std::string& name : options.hosts) {
    if (!IsHostName(name)) {
      return Status::Error("--host \"" + Printable(name, 80) +
                           "\": expected a name or address without a port, as stage.lan");
    }
  }
  access.hosts = options.hosts;
  // A machine's own name, and its name in the local network.
  std::array<char, 256> own{};
  if (gethostname(own.data(), own.size() - 1) == 0 && IsHostName(own.data())) {
    access.hosts.emplace_back(own.data());
    access.hosts.push_back(std::string(own.data()) + ".local");
  }
  const std::string folder = options.page.empty() ? FindPage() : options.page;
  if (!folder.empty()) {
    auto loaded = Page::Load(folder);
    if (!loaded.ok()) return loaded.status();
    page = std::move(loaded.value());
  }
  const auto curve = client::ReadKeys(options.keys);
  if (!curve.ok()) return curve.status();
  auto asking = client::Asker::Start(options.control, curve.value());
  if (!asking.ok()) return Status::Error("--control: " + asking.status().message());
  asker = std::move(asking.value());
  auto listening = Upstream::Connect(io, options.publish, curve.value(),
                                     {[this](std::string_view topic, std::string_view payload) {
                                        hub->Publish(topic, payload, Hub::Clock::now());
                                      },
                                      [this] { hub->Disconnected(Hub::Clock::now()); }});
  if (!listening.ok()) return listening.status();
  upstream = std::move(listening.value());
  lookout_ =
      std::make_unique<client::Lookout>(options.publish, client::Peer::kPublisher, curve.value());
  hub = std::make_unique<Hub>(
      options.publish,
      Hub::Upward{[this](const std::string& topic) { upstream->Subscribe(topic); },
                  [this](const std::string& topic) { upstream->Unsubscribe(topic); }},
      counters, Hub::Clock::now());
  return Status::Ok();
}

Status Gateway::Listen() {
  const auto endpoint = ParseListen(options.listen);
  if (!endpoint.ok()) return endpoint.status();
  access.loopback = endpoint.value().address().is_loopback();
  if (!access.loopback && access.token.empty() && !options.allow_unauthenticated_remote) {
    return Status::Error("--listen " + options.listen +
                         " can be reached by others: give --token-file, or "
                         "--allow-unauthenticated-remote if everyone there may watch and control");
  }
  boost::system::error_code error;
  const auto step = [&error](auto&& action) {
    if (!error) action();
  };
  step([&] { acceptor_.open(endpoint.value().protocol(), error); });
  step([&] { acceptor_.set_option(tcp::acceptor::reuse_address(true), error); });
  step([&] { acceptor_.bind(endpoint.value(), error); });
  step([&] { acceptor_.listen(boost::asio::socket_base::max_listen_connections, error); });
  if (error) return Status::Error("--listen " + options.listen + ": " + error.message());
  const tcp::endpoint bound = acceptor_.local_endpoint(error);
  const std::string host = bound.address().is_v6() ? "[" + bound.address().to_string() + "]"
                                                   : bound.address().to_string();
  address_ = "http://" + host + ":" + std::to_string(bound.port());
  return Status::Ok();
}

void Gateway::Accept() {
  acceptor_.async_accept([this](const boost::system::error_code& error, tcp::socket socket) {
    if (error == boost::asio::error::operation_aborted) return;
    if (error) {  // out of descriptors: retry later
      retry_.expires_after(kAcceptRetry);
      retry_.async_wait([this](const boost::system::error_code& aborted) {
        if (!aborted) Accept();
      });
      return;
    }
    ++counters.connections;
    const bool full = crowd->size() >= static_cast<std::size_t>(options.max_connections);
    if (full && !crowd->MakeRoom()) {
      ++counters.refused_full;
      socket.close();
    } else {
      if (full) ++counters.gave_way;
      Serve(std::move(socket), *this);
    }
    Accept();
  });
}

void Gateway::Tick() {
  hub->Tick(Hub::Clock::now());
  if (hub->daemon_up()) {
    lookout_->Rest();
  } else {
    const client::Reach& reach = lookout_->Look();
    const std::string advice = client::Advice(reach.obstacle, client::Peer::kPublisher);
    hub->SetObstacle(reach.text + (advice.empty() ? "" : "; " + advice));
  }
  tick_.expires_after(kTick);
  tick_.async_wait([this](const boost::system::error_code& error) {
    if (!error) Tick();
  });
}

Gauges Gateway::gauges() const {
  return {.daemon_up = hub->daemon_up(),
          .browsers = hub->browsers(),
          .connections = crowd->size(),
          .subscriptions = upstream->topics()};
}

}  // namespace styled::web
