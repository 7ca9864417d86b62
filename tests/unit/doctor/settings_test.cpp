#include "clients/doctor/settings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "daemon/config/config.h"
#include "tests/support/temporary_folder.h"

namespace styled::doctor {
namespace {

class SettingsTest : public testing::Test {
 protected:
  Result<Settings> Read(const std::string& text) {
    std::ofstream(file_) << text;
    return ReadSettings(file_);
  }
  support::TemporaryFolder folder_;
  std::string file_ = folder_ / "settings.toml";
};

TEST_F(SettingsTest, AFileThatIsNotThereIsNamed) {
  const auto settings = ReadSettings("/nowhere/styled.toml");
  ASSERT_FALSE(settings.ok());
  EXPECT_NE(settings.status().message().find("/nowhere/styled.toml"), std::string::npos);
}

TEST_F(SettingsTest, WhatIsNoTomlIsNamedByItsLine) {
  const auto settings = Read("[control]\naddress = = 3\n");
  ASSERT_FALSE(settings.ok());
  EXPECT_NE(settings.status().message().find(file_ + ":2"), std::string::npos)
      << settings.status().message();
}

TEST_F(SettingsTest, SourcesAreReadAndTheRestIsPassedOver) {
  const auto settings = Read(R"(
unknown = 3
[control]
address = "tcp://127.0.0.1:7102"
[[source]]
name = "suit"
type = "mvn"
[[source]]
name = "cams"
type = "natnet"
server = "192.0.2.7"
interface = "eth1"
multicast = false
[[source]]
type = "mvn-tcp"
listen = "[::]:9800"
[[source]]
name = "dongle"
type = "slimevr-usb"
)");
  ASSERT_TRUE(settings.ok()) << settings.status().message();
  EXPECT_EQ(settings.value().control, "tcp://127.0.0.1:7102");
  const auto& sources = settings.value().sources;
  ASSERT_EQ(sources.size(), 4U);
  EXPECT_EQ(sources[0].name, "suit");
  EXPECT_EQ(sources[0].format, Format::kMvn);
  EXPECT_EQ(ToString(sources[0].listen), "0.0.0.0:9763") << "the type's usual one";
  EXPECT_FALSE(sources[0].stream);
  EXPECT_EQ(sources[1].format, Format::kNatNet);
  EXPECT_EQ(sources[1].server, "192.0.2.7");
  EXPECT_EQ(sources[1].interface, "eth1");
  EXPECT_FALSE(sources[1].multicast);
  EXPECT_EQ(ToString(sources[1].listen), "192.0.2.7:1510") << "its server, at the usual port";
  EXPECT_TRUE(sources[2].stream);
  EXPECT_EQ(sources[2].format, Format::kMvn);
  EXPECT_EQ(ToString(sources[2].listen), "[::]:9800");
  EXPECT_FALSE(sources[3].network);
}

TEST_F(SettingsTest, AFileWithoutSourcesHasTheDaemonsOwn) {
  const auto settings = Read("[log]\nlevel = \"info\"\n");
  ASSERT_TRUE(settings.ok());
  ASSERT_EQ(settings.value().sources.size(), 2U);
  EXPECT_EQ(ToString(settings.value().sources[0].listen), "127.0.0.1:7000");
  EXPECT_TRUE(settings.value().sources[1].stream);
}

// The client includes nothing of the daemon: what both have to know is held together here.
TEST_F(SettingsTest, TypesListenWhereTheDaemonHasThem) {
  int known = 0;
  for (const auto& type : rigs::kSourceTypes) {
    const auto expected =
        MakeExpected(ExpectedSource::Origin::kConfig, "rig", std::string(type.name), "");
    if (type.usb) {
      EXPECT_FALSE(expected.network) << type.name;
      continue;
    }
    ++known;
    EXPECT_NE(expected.format, Format::kUnknown) << type.name;
    EXPECT_EQ(expected.stream, type.stream) << type.name;
    EXPECT_EQ(TypeFor(expected.format, type.stream), type.name);
    if (type.usual_address.empty()) continue;
    EXPECT_EQ(ToString(expected.listen), type.usual_address);
  }
  EXPECT_EQ(known, 13);
  std::vector<config::Source> assumed;
  for (const auto& expected : AssumedSources()) {
    assumed.push_back({expected.name, expected.type, ToString(expected.listen)});
  }
  EXPECT_EQ(assumed, config::Config().sources);
}

TEST_F(SettingsTest, ListenTakesATypeAndAnAddress) {
  for (const std::string text :
       {"", "mvn", "mvn=", "mvn=9763", "suit=0.0.0.0:9763", "mvn=localhost:9763", "=1.2.3.4:5"}) {
    EXPECT_FALSE(ParseListen(text).ok()) << text;
  }
  const auto expected = ParseListen("vmc=0.0.0.0:39540");
  ASSERT_TRUE(expected.ok()) << expected.status().message();
  EXPECT_EQ(expected.value().format, Format::kVmc);
  EXPECT_EQ(ToString(expected.value().listen), "0.0.0.0:39540");
}

}  // namespace
}  // namespace styled::doctor
