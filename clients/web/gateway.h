#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clients/cpp/asker.h"
#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"
#include "clients/cpp/reach.h"
#include "clients/cpp/subscriber.h"
#include "clients/web/access.h"
#include "clients/web/crowd.h"
#include "clients/web/hub.h"
#include "clients/web/metrics.h"
#include "clients/web/page.h"
#include "clients/web/upstream.h"

namespace styled::web {

struct Options {
  std::string listen = "127.0.0.1:7080";  // HOST:PORT, numeric or localhost; port 0 = any free one
  std::string publish = std::string(client::kDefaultPublisher);
  std::string control = std::string(client::kDefaultControl);
  client::KeyOptions keys;  // for a daemon that requires them
  std::string page;        // folder of the built page; "" = next to the program, if it exists there
  std::string token_file;  // required on addresses other than loopback, unless ...
  bool allow_unauthenticated_remote = false;  // ... this allows access without a token
  std::vector<std::string> origins;           // of pages of other sites that may connect
  std::vector<std::string> hosts;             // further names of this machine, without a port
  bool watch_only = false;                    // control requests are refused
  // 1 .. 10000. At the limit, the oldest unfinished request is closed; if there is none, the new
  // connection is closed at once.
  int max_connections = 64;
};

// The state shared by all connections, and the loop's timers. One thread runs `io`; all functions
// except Start must be called on it.
class Gateway {
 public:
  // Starts listening. Errors: an invalid option, which is named, or an address that cannot be
  // bound.
  static Result<std::unique_ptr<Gateway>> Start(boost::asio::io_context& io,
                                                const Options& options);
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  const std::string& address() const { return address_; }  // "http://127.0.0.1:7080"

  boost::asio::io_context& io;
  Options options;
  AccessRules access;
  Page page;
  Counters counters;
  std::unique_ptr<Upstream> upstream;
  std::unique_ptr<Hub> hub;
  std::unique_ptr<client::Asker> asker;
  std::shared_ptr<Crowd> crowd = std::make_shared<Crowd>();  // may outlive the gateway

  Gauges gauges() const;

 private:
  Gateway(boost::asio::io_context& io, const Options& options);
  Status Prepare();
  Status Listen();
  void Accept();
  void Tick();

  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer tick_, retry_;
  std::unique_ptr<client::Lookout> lookout_;  // used while no daemon publishes
  std::string address_;
};

}  // namespace styled::web
