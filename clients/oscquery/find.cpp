#include "clients/oscquery/find.h"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/oscquery/mdns.h"
#include "model/base/text.h"

namespace styled::oscquery {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using nlohmann::json;

constexpr std::size_t kMaxHeaderBytes = 16 << 10, kMaxBodyBytes = 4 << 20;
constexpr std::size_t kMaxAddresses = 4096;
constexpr int kMaxDepth = 32;
constexpr std::chrono::seconds kHttpTime(2);
constexpr int kWritable = 2;  // the bit of ACCESS
constexpr auto kAwait = asio::as_tuple(asio::use_awaitable);

// Adds the addresses of the node's methods that can be written. A method without ACCESS may be.
void AddAddresses(const json& node, int depth, std::vector<std::string>& addresses) {
  if (!node.is_object() || depth > kMaxDepth || addresses.size() >= kMaxAddresses) return;
  const auto path = node.find("FULL_PATH");
  const auto access = node.find("ACCESS");
  const bool writable = access != node.end() ? access->is_number_integer() &&
                                                   (access->get<std::int64_t>() & kWritable) != 0
                                             : node.contains("TYPE");
  if (path != node.end() && path->is_string() && writable) addresses.push_back(*path);
  const auto contents = node.find("CONTENTS");
  if (contents == node.end() || !contents->is_object()) return;
  for (const auto& child : *contents) AddAddresses(child, depth + 1, addresses);
}

// The address for OSC: the given one if it is an address that leads somewhere from here.
std::string OscAddress(const json& host_info, const std::string& http_address) {
  const auto given = host_info.find("OSC_IP");
  if (given == host_info.end() || !given->is_string()) return http_address;
  boost::system::error_code error;
  const auto address = asio::ip::make_address_v4(given->get<std::string>(), error);
  const bool usable = !error && !address.is_unspecified() && !address.is_loopback();
  return usable ? address.to_string() : http_address;
}

struct Fetched {
  std::string text;
  std::string trouble;  // "": `text` is the answer
};

asio::awaitable<void> Fetch(std::string address, std::uint16_t port, std::string target,
                            Fetched& out) {
  beast::tcp_stream stream(co_await asio::this_coro::executor);
  stream.expires_after(kHttpTime);
  const asio::ip::tcp::endpoint endpoint(asio::ip::make_address(address), port);
  const std::string host = address + ":" + std::to_string(port);
  out.trouble = "no answer at http://" + host;
  const auto [refused] = co_await stream.async_connect(endpoint, kAwait);
  if (refused) {
    out.trouble += ": " + refused.message();
    co_return;
  }
  http::request<http::empty_body> request(http::verb::get, target, 11);
  request.set(http::field::host, host);
  request.set(http::field::connection, "close");
  const auto [unsent, sent] = co_await http::async_write(stream, request, kAwait);
  if (unsent) co_return;
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.header_limit(kMaxHeaderBytes);
  parser.body_limit(kMaxBodyBytes);
  const auto [unread, size] = co_await http::async_read(stream, buffer, parser, kAwait);
  if (unread) {
    out.trouble += ": " + unread.message();
    co_return;
  }
  if (parser.get().result() != http::status::ok) {
    out.trouble = "http://" + host + " answers " + std::to_string(parser.get().result_int());
    co_return;
  }
  out.text = std::move(parser.get().body());
  out.trouble.clear();
}

bool BeginsWith(std::string_view text, std::string_view start) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return text.size() >= start.size() && std::equal(start.begin(), start.end(), text.begin(), same);
}

}  // namespace

bool HasPath(const Receiver& receiver, std::string_view path) {
  return std::any_of(receiver.addresses.begin(), receiver.addresses.end(),
                     [path](const std::string& address) {
                       return address.starts_with(path) &&
                              (address.size() == path.size() || address[path.size()] == '/');
                     });
}

Status ReadAnswers(const std::string& host_info, const std::string& tree,
                   const std::string& http_address, std::uint16_t http_port, Receiver& receiver) {
  const json info = json::parse(host_info, nullptr, false);
  const json root = json::parse(tree, nullptr, false);
  if (!info.is_object()) return Status::Error("its HOST_INFO is not a JSON object");
  if (!root.is_object()) return Status::Error("its tree is not a JSON object");
  const auto transport = info.find("OSC_TRANSPORT");
  if (transport != info.end() && *transport == "TCP") {
    return Status::Error("it takes OSC by TCP; expected UDP");
  }
  receiver.address = OscAddress(info, http_address);
  receiver.port = http_port;
  if (const auto port = info.find("OSC_PORT"); port != info.end()) {
    const auto value = port->is_number_integer() ? port->get<std::int64_t>() : 0;
    if (value < 1 || value > 65535) return Status::Error("its OSC_PORT is not 1 to 65535");
    receiver.port = static_cast<std::uint16_t>(value);
  }
  receiver.addresses.clear();
  AddAddresses(root, 0, receiver.addresses);
  return Status::Ok();
}

Result<std::vector<Receiver>> FindReceivers(std::chrono::milliseconds timeout) {
  const auto seen = Browse(timeout);
  if (!seen.ok()) return seen.status();
  struct Answers {
    const Sighting* sighting;
    Fetched host_info, tree;
  };
  std::vector<Answers> answers;
  for (const Sighting& sighting : seen.value()) {
    if (sighting.has_tree) answers.push_back({&sighting, {}, {}});
  }
  asio::io_context io(1);
  for (Answers& a : answers) {
    const Sighting& s = *a.sighting;
    asio::co_spawn(io, Fetch(s.address, s.port, "/?HOST_INFO", a.host_info), asio::detached);
    asio::co_spawn(io, Fetch(s.address, s.port, "/", a.tree), asio::detached);
  }
  io.run();
  std::vector<Receiver> receivers;
  for (const Answers& a : answers) {
    const Sighting& s = *a.sighting;
    Receiver receiver{s.name, s.host, s.address, 0, {}, {}};
    receiver.trouble = !a.host_info.trouble.empty() ? a.host_info.trouble : a.tree.trouble;
    if (receiver.trouble.empty()) {
      receiver.trouble =
          ReadAnswers(a.host_info.text, a.tree.text, s.address, s.port, receiver).message();
    }
    receivers.push_back(std::move(receiver));
  }
  // An OSC service belongs to the tree of its name, or has none.
  for (const Sighting& s : seen.value()) {
    if (s.has_tree) continue;
    const auto known = std::find_if(receivers.begin(), receivers.end(),
                                    [&](const Receiver& r) { return r.name == s.name; });
    if (known == receivers.end()) {
      receivers.push_back({s.name, s.host, s.address, s.port, {}, "it has no OSCQuery"});
    } else if (known->port == 0) {
      known->address = s.address;
      known->port = s.port;
    }
  }
  std::sort(receivers.begin(), receivers.end(),
            [](const Receiver& a, const Receiver& b) { return a.name < b.name; });
  return receivers;
}

Result<Receiver> Choose(const std::vector<Receiver>& receivers, const std::string& name) {
  std::vector<const Receiver*> matching;
  std::string names;
  for (const Receiver& receiver : receivers) {
    names += (names.empty() ? "" : ", ") + Printable(receiver.name, 63);
    if (!BeginsWith(receiver.name, name)) continue;
    if (receiver.name.size() == name.size()) return receiver;
    matching.push_back(&receiver);
  }
  if (names.empty()) names = "none";
  if (matching.empty()) {
    return Status::Error("no OSC receiver in the network has that name; found: " + names);
  }
  if (matching.size() > 1) {
    return Status::Error("several OSC receivers begin so; expected one of: " + names);
  }
  return *matching.front();
}

}  // namespace styled::oscquery
