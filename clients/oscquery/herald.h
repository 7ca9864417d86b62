#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "clients/cpp/asker.h"
#include "clients/oscquery/mdns.h"
#include "clients/oscquery/server.h"
#include "clients/oscquery/sources.h"

namespace styled::oscquery {

struct Options {
  std::string control = std::string(client::kDefaultControl);
  std::optional<client::Curve> curve;  // for a daemon that requires keys
  std::string name = "styled";         // a source's service is called NAME-SOURCE
};

// Asks the daemon each second for its sources, serves the tree of each that can be found, and
// announces it. A daemon that starts, and this machine's new addresses, change the announcements
// within two seconds. A daemon that has ended, or does not answer for three seconds, has none. One
// thread runs `io`. Changes are printed to `out`, obstacles to `err`, each once. Pinned by
// tests/witness/oscquery.
class Herald {
 public:
  // Errors: a control endpoint that ZeroMQ cannot parse, invalid keys.
  static Result<std::unique_ptr<Herald>> Start(boost::asio::io_context& io, const Options& options,
                                               std::ostream& out, std::ostream& err);
  Herald(const Herald&) = delete;
  Herald& operator=(const Herald&) = delete;

 private:
  struct Service {
    Source source;
    std::string name;   // as requested
    std::string shown;  // in force, and printed; "": not announced yet
    std::unique_ptr<Server> server;
  };

  Herald(boost::asio::io_context& io, const Options& options, std::ostream& out, std::ostream& err);
  void Tick();
  void Ask();
  void Receive(const client::CallStatus& status, const v1::Reply& reply);
  void Serve(const Plan& plan);
  std::string FreeName(const std::string& source) const;
  void ShowState();
  void Notice(const std::string& text);

  boost::asio::io_context& io_;
  Options options_;
  std::ostream& out_;
  std::ostream& err_;
  boost::asio::steady_timer timer_;
  Advertiser advertiser_;
  std::vector<Service> services_;
  std::set<std::string> notices_;         // printed
  std::string trouble_, daemon_trouble_;  // of mDNS and of the daemon, printed
  std::chrono::steady_clock::time_point answered_, asked_;
  bool asking_ = false;
  std::unique_ptr<client::Asker> asker_;  // last: its thread ends before the rest
};

}  // namespace styled::oscquery
