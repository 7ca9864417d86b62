// The shipped hub and leaf server with TLS, as their comments say, and certificates of the test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/e2e/nats/raw_subscribers.h"
#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

constexpr const char* kTlsTopic = "styled/rig.a/canonical/";

class NatsTlsTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasNatsServer()) GTEST_SKIP() << "skipped, no nats-server (Debian: nats-server)";
    if (!Authority("ca") || !Authority("other")) GTEST_SKIP() << "skipped, no openssl";
    ASSERT_TRUE(Certificate("hub", "IP:127.0.0.1"));
  }
  bool Shell(const std::string& command) {
    return std::system(
               ("cd '" + folder_.path().string() + "' && " + command + " 2>/dev/null").c_str()) ==
           0;
  }
  bool Authority(const std::string& name) {
    return Shell(
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 "
        "-subj /CN=" +
        name + " -keyout " + name + ".key -out " + name + ".pem");
  }
  // Of a server with these names, signed by `ca`.
  bool Certificate(const std::string& name, const std::string& names) {
    return Shell("openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=" +
                 name + " -keyout " + name + ".key -out " + name + ".csr") &&
           Shell("echo subjectAltName=" + names + " > " + name + ".ext && openssl x509 -req -in " +
                 name + ".csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile " + name +
                 ".ext -out " + name + ".pem");
  }
  void StartServers(const std::string& certificate) {
    const std::string tls = "tls { cert_file: \"" + (folder_ / (certificate + ".pem")) +
                            "\", key_file: \"" + (folder_ / (certificate + ".key")) + "\" }";
    servers_.Edit("hub", "server_name: styled_hub", "server_name: styled_hub\n" + tls);
    const std::string listen = "listen: 127.0.0.1:" + servers_.hub_leaf_port;
    servers_.Edit("hub", listen, listen + "\n  " + tls);
    servers_.Edit("leaf", "{ url: $STYLED_NATS_HUB }",
                  "{ url: $STYLED_NATS_HUB, tls { ca_file: \"" + (folder_ / "ca.pem") + "\" } }");
    servers_.leaf_scheme = "tls";
    servers_.StartHub();
    servers_.StartLeaf();
  }
  std::unique_ptr<Stylenats> Join(const std::vector<std::string>& more,
                                  const std::string& scheme = "tls") {
    std::vector<std::string> words{"--join"};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Stylenats>("operator", scheme + "://127.0.0.1:" + servers_.hub_port,
                                       publish_, control_, words);
  }

  TemporaryFolder folder_;
  const std::string publish_ = "ipc://" + (folder_ / "publish"),
                    control_ = "ipc://" + (folder_ / "control");
  NatsServers servers_;
};

TEST_F(NatsTlsTest, FramesBodiesAndCommandsPassALeafServerAndAHubWithTls) {
  StartServers("hub");
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  const auto join = Join({"--nats-ca", folder_ / "ca.pem"});
  const Subscriber read(publish_, {"body/", kTlsTopic});
  const std::string log = bridge.Log() + join->Log() + servers_.Log();
  ASSERT_TRUE(read.WaitForFrames(60, kTlsTopic, 30)) << log;
  EXPECT_TRUE(read.WaitForBody()) << log;
  EXPECT_EQ(ControlClient(control_).SetStyle("rig.a", "style1").code(), v1::CODE_OK) << log;
  // A client without TLS is refused.
  EXPECT_FALSE(RawSubscribers({Wire::kNats, servers_.hub_port, "viewer", {"styled.>"}}).ok());
  // libnats does, where the server asks for it, also for nats://, and believes the system's
  // authorities alone.
  const auto plain = Join({}, "nats");
  EXPECT_FALSE(plain->WaitForLog("connected to", 1.5)) << plain->Log();
}

TEST_F(NatsTlsTest, AHubThatNobodyTrustedSignedIsNotUsed) {
  StartServers("hub");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--nats-ca", folder_ / "other.pem"}, std::vector<std::string>{}}) {
    const auto join = Join(more);
    EXPECT_TRUE(join->WaitForLog("certificate")) << join->Log();
    EXPECT_FALSE(join->WaitForLog("connected to", 1)) << join->Log();
  }
}

TEST_F(NatsTlsTest, AHubWithTheCertificateOfAnotherNameIsNotUsed) {
  ASSERT_TRUE(Certificate("elsewhere", "DNS:elsewhere.example"));
  StartServers("elsewhere");
  const auto join = Join({"--nats-ca", folder_ / "ca.pem"});
  EXPECT_TRUE(join->WaitForLog("no broker answers")) << join->Log();
  EXPECT_FALSE(join->WaitForLog("connected to", 1)) << join->Log();
}

}  // namespace
}  // namespace styled::support
