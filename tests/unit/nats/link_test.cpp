#include "clients/nats/link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace styled::stylenats {
namespace {

TEST(NatsLink, RefusesEachBadAddress) {
  const struct {
    const char* server;
    const char* says;
  } rows[] = {
      {"", "neither nats:// nor tls://"},
      {"127.0.0.1:4222", "neither nats:// nor tls://"},
      {"tcp://127.0.0.1:4222", "neither nats:// nor tls://"},
      {"nats://", "host or port is missing"},
      {"nats://host", "host or port is missing"},
      {"nats://:4222", "host or port is missing"},
      {"nats://host:", "is not a port"},
      {"nats://host:0", "is not a port"},
      {"nats://host:65536", "is not a port"},
      {"nats://host:4222x", "is not a port"},
      {"nats://host:99999999999", "is not a port"},
      {"nats://user:secret@host:4222", "--nats-login"},
      {"http://user:secret@host:4222", "neither nats:// nor tls://"},
      {"nats://host:4222?token=secret", "something follows the port"},
      {"nats://host:4222/secret", "something follows the port"},
      {"host?token=secret", "neither nats:// nor tls://"},
      {"user:sec@secret@host", "neither nats:// nor tls://"},
  };
  for (const auto& row : rows) {
    const Status status = CheckServer(row.server);
    EXPECT_FALSE(status.ok()) << row.server;
    EXPECT_THAT(status.message(), testing::HasSubstr(row.says)) << row.server;
    EXPECT_THAT(status.message(), testing::HasSubstr("expected nats://HOST:PORT")) << row.server;
    EXPECT_THAT(status.message(), testing::Not(testing::HasSubstr("sec"))) << "it may be logged";
  }
  for (const char* good : {"nats://127.0.0.1:4222", "tls://hub.example:4443", "nats://[::1]:1"}) {
    EXPECT_TRUE(CheckServer(good).ok()) << good;
  }
}

TEST(NatsLink, RefusesFilesThatItCannotUse) {
  LinkOptions options;
  options.ca = "/nonexistent/ca.pem";
  EXPECT_THAT(Link::Open(options).status().message(), testing::HasSubstr("no --nats is tls://"));
  options.servers = {"tls://127.0.0.1:1"};
  EXPECT_THAT(Link::Open(options).status().message(),
              testing::HasSubstr("--nats-ca /nonexistent/ca.pem"));
}

TEST(NatsLink, ABrokerThatIsAbsentIsNoErrorAndSaidOnce) {
  LinkOptions options;
  options.servers = {"nats://127.0.0.1:1"};
  auto link = Link::Open(options);
  ASSERT_TRUE(link.ok()) << link.status().message();
  EXPECT_FALSE(link.value()->connected());
  std::vector<LinkEvent> events;
  for (int i = 0; i < 15; ++i) {
    for (LinkEvent& event : link.value()->Events()) events.push_back(std::move(event));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, LinkEvent::Kind::kAbsent);
  EXPECT_EQ(link.value()->generation(), 0U);
}

}  // namespace
}  // namespace styled::stylenats
