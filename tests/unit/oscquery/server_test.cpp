#include "clients/oscquery/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <list>
#include <random>
#include <thread>

#include "clients/oscquery/tree.h"

namespace styled::oscquery {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using testing::HasSubstr;
using testing::StartsWith;
using Clock = std::chrono::steady_clock;

// A server on a thread of its own.
class Running {
 public:
  explicit Running(std::uint16_t osc_port = 0,
                   std::chrono::milliseconds request_time = std::chrono::seconds(5)) {
    auto started =
        Server::Start(io_, "127.0.0.1",
                      {"styled-stage", TreeOf(MethodsOf("vmc"), "stage"), osc_port}, request_time);
    EXPECT_TRUE(started.ok()) << started.status().message();
    server_ = std::move(started.value());
    port = server_->port();
    thread_ = std::jthread([this] { io_.run(); });
  }
  ~Running() {
    asio::post(io_, [this] { server_ = nullptr; });
    thread_ = {};  // no connection outlives the server, so the loop ends
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  std::uint16_t port = 0;

 private:
  asio::io_context io_{1};
  std::unique_ptr<Server> server_;
  std::jthread thread_;
};

class Connection {
 public:
  explicit Connection(const Running& server) {
    socket_.connect({asio::ip::make_address("127.0.0.1"), server.port});
  }
  // False if the server has closed.
  bool Send(std::string_view text) {
    boost::system::error_code closed;
    asio::write(socket_, asio::buffer(text), closed);
    return !closed;
  }
  // Everything up to the server's end.
  std::string Read() {
    std::string text;
    boost::system::error_code end;
    asio::read(socket_, asio::dynamic_buffer(text), end);
    return text;
  }

 private:
  asio::io_context io_;
  tcp::socket socket_{io_};
};

std::string Get(const Running& server, const std::string& target = "/?HOST_INFO") {
  Connection connection(server);
  connection.Send("GET " + target + " HTTP/1.1\r\nHost: x\r\n\r\n");
  return connection.Read();
}

TEST(OscQueryServer, AnswersWithTheAddressAtWhichItWasReached) {
  const Running server;
  const std::string answer = Get(server);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: application/json"));
  EXPECT_THAT(answer, HasSubstr(R"("OSC_IP":"127.0.0.1")"));
  EXPECT_THAT(Get(server, "/VMC/Ext/T?TYPE"), HasSubstr(R"({"TYPE":"f"})"));
  EXPECT_THAT(Get(server, "/none"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Get(server, "/VMC/Ext/T?VALUE"), StartsWith("HTTP/1.1 204"));
}

TEST(OscQueryServer, HeadHasNoBody) {
  const Running server;
  Connection connection(server);
  connection.Send("HEAD / HTTP/1.1\r\nHost: x\r\n\r\n");
  const std::string answer = connection.Read();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_TRUE(answer.ends_with("\r\n\r\n"));
}

TEST(OscQueryServer, UsesTheTcpPortOfTheSourcesNumberOrAnother) {
  std::uint16_t taken = 0;
  {
    const Running first;
    taken = first.port;
    const Running second(taken);
    EXPECT_NE(second.port, taken);
    EXPECT_THAT(Get(second), StartsWith("HTTP/1.1 200"));
  }
  const Running third(taken);
  EXPECT_EQ(third.port, taken);
}

TEST(OscQueryServer, RefusesAnAddressThatIsNotThere) {
  asio::io_context io;
  const auto text = Server::Start(io, "nonsense", {});
  EXPECT_THAT(text.status().message(), HasSubstr("'nonsense' is not a numeric address"));
  const auto absent = Server::Start(io, "192.0.2.77", {});
  EXPECT_THAT(absent.status().message(), HasSubstr("HTTP at 192.0.2.77: "));
}

TEST(OscQueryServer, RefusesBadRequestsAndContinues) {
  const Running server(0, std::chrono::milliseconds(500));
  const std::vector<std::string> requests{
      "nonsense\r\n\r\n",
      "GET / HTTP/9.9\r\n\r\n",
      "GET / HTTP/1.1\r\nHost: " + std::string(100000, 'x') + "\r\n\r\n",
      "GET /" + std::string(100000, 'a') + " HTTP/1.1\r\n\r\n",
      "GET / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
      "GET / HTTP/1.1\r\nContent-Length: 4\r\n\r\nbody",
      "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n",
      "GET / HTTP/1.1\r\nA: b\r\n\0\r\n\r\n",
      std::string(100000, '\n'),
      "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",  // TLS
  };
  for (const std::string& request : requests) {
    Connection connection(server);
    connection.Send(request);
    const std::string answer = request[0] == '\x16' ? "" : connection.Read();
    // Where the server closes while the request still arrives, its answer may be lost.
    if (!answer.empty()) {
      EXPECT_THAT(answer, StartsWith("HTTP/1.1 4")) << request.substr(0, 60);
    }
    EXPECT_THAT(Get(server), StartsWith("HTTP/1.1 200"));
  }
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "NONSENSE"}) {
    Connection connection(server);
    connection.Send(std::string(method) + " / HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_THAT(connection.Read(), StartsWith("HTTP/1.1 405")) << method;
  }
}

TEST(OscQueryServer, NoiseDoesNotEndIt) {
  const Running server;
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    std::string noise = i % 2 == 0 ? "GET / HTTP/1.1\r\n" : "";
    for (int j = 0; j < 300; ++j) noise += static_cast<char>(random());
    Connection(server).Send(noise);
  }
  EXPECT_THAT(Get(server), StartsWith("HTTP/1.1 200"));
}

// Clients that never finish: the oldest of them is closed for each one more than the limit.
TEST(OscQueryServer, SlowClientsDoNotKeepOthersOut) {
  const Running server;
  std::list<Connection> slow;
  for (std::size_t i = 0; i < 2 * Server::kMaxConnections; ++i) {
    slow.emplace_back(server).Send("GET / HT");
  }
  const auto begin = Clock::now();
  for (int i = 0; i < 5; ++i) EXPECT_THAT(Get(server), StartsWith("HTTP/1.1 200"));
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(2)) << "before the first of them times out";
  EXPECT_EQ(slow.front().Read(), "") << "closed";
}

TEST(OscQueryServer, ASlowRequestEndsAtItsTime) {
  const Running server(0, std::chrono::milliseconds(500));
  Connection slow(server);
  const auto begin = Clock::now();
  while (slow.Send("G") && Clock::now() - begin < std::chrono::seconds(20)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_GT(Clock::now() - begin, std::chrono::milliseconds(400));
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(20));
}

}  // namespace
}  // namespace styled::oscquery
