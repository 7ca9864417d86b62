// Others' OSCQuery and mDNS (npm: oscquery, bonjour-service, @homebridge/ciao) find the daemon's
// sources by styleoscquery, whatever restarts, and reach them; stylevmc finds others' receivers.
// run.sh provides the network, the D-Bus and the folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "clients/cpp/control.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// run.sh's two machines.
constexpr const char* kOwnAddress = "10.83.0.1";
constexpr const char* kFarAddress = "10.83.0.2";
constexpr const char* kControl = "tcp://127.0.0.1:7002";
constexpr const char* kSources =
    "[[source]]\nname = \"stage\"\ntype = \"vmc\"\nlisten = \"0.0.0.0:39540\"\n"
    "[[source]]\nname = \"head\"\ntype = \"vrchat\"\n"
    "[[source]]\nname = \"near\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:39542\"\n";

// A command that runs on the second machine.
std::string Far(const std::string& command) {
  const char* prefix = std::getenv("STYLED_FAR");
  EXPECT_NE(prefix, nullptr) << "run by run.sh";
  return std::string(prefix == nullptr ? "" : prefix) + " " + command;
}

bool WaitUntil(const std::function<bool()>& done, double seconds = 10) {
  for (double waited = 0; waited < seconds; waited += 0.02) {
    if (done()) return true;
    Sleep(0.02);
  }
  return done();
}

class Avahi {
 public:
  Avahi()
      : child_({"/bin/sh", "-c",
                "exec avahi-daemon --no-drop-root --no-chroot --no-rlimits -f /run/avahi.conf"},
               folder_ / "log.txt") {
    EXPECT_TRUE(WaitUntil([this] {
      return ReadText(folder_ / "log.txt").find("startup complete") != std::string::npos;
    })) << ReadText(folder_ / "log.txt");
  }
  ~Avahi() {
    child_.Signal(SIGTERM);
    EXPECT_EQ(child_.Wait(5).value_or(-1), 0);
  }
  Avahi(const Avahi&) = delete;
  Avahi& operator=(const Avahi&) = delete;

 private:
  TemporaryFolder folder_;
  Child child_;
};

// A program whose output is read while it runs.
class Program {
 public:
  explicit Program(const std::string& command)
      : child_({"/bin/sh", "-c", "exec " + command + " >'" + (folder_ / "out.txt") + "'"},
               folder_ / "err.txt") {}

  // The lines that begin with `what`, without it.
  std::vector<std::string> Lines(const std::string& what) const {
    std::vector<std::string> lines;
    std::istringstream text(ReadText(folder_ / "out.txt"));
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with(what + " ")) lines.push_back(line.substr(what.size() + 1));
    }
    return lines;
  }
  std::string Text() const { return ReadText(folder_ / "out.txt") + ReadText(folder_ / "err.txt"); }
  Child& child() { return child_; }

 private:
  TemporaryFolder folder_;
  Child child_;
};

// The services that the other program has found and not lost.
struct Found {
  std::map<std::string, json> servers;  // by name: what it has read
  std::set<std::string> receivers;      // NAME:PORT
  explicit Found(const Program& witness) {
    std::istringstream text(witness.Text());
    for (std::string line; std::getline(text, line);) {
      const auto value = json::parse(line.substr(line.find(' ') + 1), nullptr, false);
      if (!value.is_object() || value.value("address", kOwnAddress) != kOwnAddress) continue;
      if (line.starts_with("up ")) servers[value["name"]] = value;
      if (line.starts_with("down ")) servers.erase(value["name"].get<std::string>());
      if (line.starts_with("osc ")) {
        receivers.insert(value["name"].get<std::string>() + ":" + value["port"].dump());
      }
    }
  }
  // The OSC port of a server; 0: not found.
  int Port(const std::string& name) const {
    return servers.contains(name) ? servers.at(name).value("oscPort", 0) : 0;
  }
};

std::uint64_t Received(const std::string& source) {
  client::ControlOptions options;
  options.endpoint = kControl;
  const auto control = client::Control::Connect(options);
  v1::StatusReply status;
  if (!control.ok() || !control.value()->Status(&status).ok()) return 0;
  for (const auto& info : status.sources()) {
    if (info.name() == source) return info.received();
  }
  return 0;
}

TEST(OscQueryWitness, FindsTheSourcesAndTheirChanges) {
  auto avahi = std::make_unique<Avahi>();
  Daemon daemon({std::string("control.address=") + kControl}, kSources);
  const Program ours(STYLEOSCQUERY_BINARY);
  const Program witness(Far("node discover.mjs"));
  const Program near("node discover.mjs");
  const auto has = [&witness](int stage, int head) {
    const Found found(witness);
    return found.Port("styled-stage") == stage && found.Port("styled-head") == head;
  };
  ASSERT_TRUE(WaitUntil([&] { return has(39540, 9000); })) << ours.Text() << witness.Text();
  EXPECT_TRUE(WaitUntil([&] {
    return near.Text().find("up {\"name\":\"styled-head\"") != std::string::npos;
  })) << "on the same machine: "
      << near.Text();
  {
    const Found found(witness);
    EXPECT_EQ(found.servers.size(), 2U) << "none for the source that only this machine reaches";
    const json& stage = found.servers.at("styled-stage");
    EXPECT_EQ(stage["oscIp"], kOwnAddress);
    EXPECT_EQ(stage["oscTransport"], "UDP");
    EXPECT_EQ(stage["port"], 39540) << "HTTP, by TCP";
    EXPECT_EQ(stage["methods"]["/VMC/Ext/Bone/Pos"], (json{{"access", 2}, {"types", "sfffffff"}}));
    const json& head = found.servers.at("styled-head")["methods"];
    for (const char* device : {"head", "leftwrist", "rightwrist"}) {
      EXPECT_EQ(head["/tracking/vrsystem/" + std::string(device) + "/pose"],
                (json{{"access", 2}, {"types", "ffffff"}}));
    }
  }
  EXPECT_TRUE(WaitUntil([&] {
    return Found(witness).receivers ==
           std::set<std::string>{"styled-stage:39540", "styled-head:9000"};
  })) << witness.Text();
  // The message that it has sent to what it found.
  EXPECT_TRUE(WaitUntil([] { return Received("stage") > 0 && Received("head") > 0; }));
  EXPECT_EQ(Received("near"), 0U);
  EXPECT_THAT(ours.Text(), HasSubstr("near (vmc, 127.0.0.1:39542) is not announced"));

  // The daemon ends, and so does avahi-daemon; both start again, with another port and without a
  // source.
  EXPECT_EQ(daemon.Stop(), 0);
  EXPECT_TRUE(WaitUntil([&] { return has(0, 0); })) << ours.Text() << witness.Text();
  avahi = nullptr;
  EXPECT_TRUE(WaitUntil([&] {
    return ours.Text().find("systemctl start avahi-daemon") != std::string::npos;
  })) << ours.Text();
  daemon.Configure("[[source]]\nname = \"stage\"\ntype = \"vmc\"\nlisten = \"0.0.0.0:39545\"\n");
  daemon.Start();
  avahi = std::make_unique<Avahi>();
  EXPECT_TRUE(WaitUntil([&] { return has(39545, 0); })) << ours.Text() << witness.Text();
}

TEST(OscQueryWitness, StylevmcSendsToAReceiverByItsName) {
  const Avahi avahi;
  const Program witness(Far("node offer.mjs Marionette-7"));
  ASSERT_TRUE(WaitUntil([&] { return !witness.Lines("port").empty(); })) << witness.Text();
  const std::string place = kFarAddress + (":" + witness.Lines("port")[0]);
  Program list(STYLEOSCQUERY_BINARY " --list");
  Program as_vrchat(STYLEVMC_BINARY " --find marionette --as vrchat");
  Daemon daemon;
  const Program stylevmc(STYLEVMC_BINARY " --find marionette --publish " + daemon.publish);
  EXPECT_EQ(list.child().Wait(20).value_or(-1), 0);
  EXPECT_THAT(list.Text(), HasSubstr("\nMarionette-7  " + place + "  VMC\n"));
  EXPECT_EQ(as_vrchat.child().Wait(20).value_or(-1), 1);
  EXPECT_THAT(as_vrchat.Text(), HasSubstr("Marionette-7 takes VMC, not VRChat's trackers"));
  const UdpLink link(daemon.udp);
  Rig rig("a");
  const auto arrived = [&] {
    return testing::Value(witness.Lines("osc"), testing::Contains("/VMC/Ext/Bone/Pos"));
  };
  for (int i = 0; i < 1200 && !arrived(); ++i) {
    if (i % 60 == 0) link.Send(rig.Body());
    link.Send(rig.Frame());
    Sleep(1.0 / 120);
  }
  EXPECT_TRUE(arrived()) << stylevmc.Text() << witness.Text();
  EXPECT_THAT(stylevmc.Text(), HasSubstr("rig.a -> Marionette-7 (" + place + ")"));
}

}  // namespace
}  // namespace styled::support
