#include "clients/oscquery/sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>

#include <array>
#include <string>
#include <vector>

namespace styled::oscquery {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

v1::StatusReply StatusWith(const std::string& type, const std::string& listen) {
  v1::StatusReply status;
  v1::SourceInfo& info = *status.add_sources();
  info.set_name("stage");
  info.set_type(type);
  info.set_listen(listen);
  return status;
}

TEST(OscQuerySources, OthersThanVmcAndVrChatAreLeftOut) {
  for (const char* type : {"udp", "mvn", "livelinkface", "slimevr", "", "newer"}) {
    const Plan plan = MakePlan(StatusWith(type, "0.0.0.0:7000"));
    EXPECT_TRUE(plan.sources.empty() && plan.notices.empty()) << type;
  }
}

TEST(OscQuerySources, OneThatOthersCannotReachIsNotAnnounced) {
  for (const char* listen : {"127.0.0.1:39540", "127.8.0.1:39540", "[::1]:39540"}) {
    const Plan plan = MakePlan(StatusWith("vmc", listen));
    EXPECT_TRUE(plan.sources.empty()) << listen;
    EXPECT_THAT(plan.notices, ElementsAre(HasSubstr("set its `listen` to \"0.0.0.0:39540\"")));
  }
  const Plan odd = MakePlan(StatusWith("vmc", "nonsense"));
  EXPECT_THAT(odd.notices, ElementsAre(HasSubstr("expected ADDRESS:PORT")));
  const Plan absent = MakePlan(StatusWith("vrchat", "192.0.2.77:9000"));
  EXPECT_TRUE(absent.sources.empty());
  EXPECT_THAT(absent.notices, ElementsAre(HasSubstr("no interface has that address")));
}

TEST(OscQuerySources, TheOthersAreAnnouncedWhereTheyListen) {
  for (const auto& [type, listen, address] : std::vector<std::array<std::string, 3>>{
           {"vmc", "0.0.0.0:39540", "0.0.0.0"}, {"vrchat", "[::]:39540", "::"}}) {
    const Plan plan = MakePlan(StatusWith(type, listen));
    EXPECT_TRUE(plan.notices.empty());
    ASSERT_EQ(plan.sources.size(), 1U);
    const Source& source = plan.sources[0];
    EXPECT_EQ(source.name, "stage");
    EXPECT_EQ(source.type, type);
    EXPECT_EQ(source.address, address);
    EXPECT_EQ(source.port, 39540);
    EXPECT_THAT(source.places, Contains(Place{if_nametoindex("lo"), "127.0.0.1"}));
    for (const Place& place : source.places) EXPECT_EQ(place.address.find(':'), place.address.npos);
  }
}

TEST(OscQuerySources, TheDaemonMustRunOnThisMachine) {
  for (const char* local : {"tcp://127.0.0.1:7002", "tcp://localhost:7002", "tcp://[::1]:7002",
                            "ipc:///run/styled/control", "tcp://no-such-host.invalid:7002"}) {
    EXPECT_TRUE(CheckLocal(local).ok()) << CheckLocal(local).message();
  }
  EXPECT_THAT(CheckLocal("tcp://192.0.2.77:7002").message(), HasSubstr("run styleoscquery there"));
  EXPECT_THAT(CheckLocal("tcp://[2001:db8::7]:7002").message(), HasSubstr("another machine's"));
  EXPECT_THAT(CheckLocal("tcp://127.0.0.1:7002,tcp://127.0.0.1:7102").message(),
              HasSubstr("names two daemons"));
}

}  // namespace
}  // namespace styled::oscquery
