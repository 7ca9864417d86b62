#include "daemon/security/gatekeeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <memory>

#include "tests/support/rig.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/security/zap_cases.h"

namespace styled::security {
namespace {

using runtime::Counter;

// A gatekeeper whose turns the test takes, and libzmq's side of the dialogue: frames as they are.
class GatekeeperTest : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = Gatekeeper::Open(context_, keys_, counters_);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    keeper_ = std::move(opened.value());
    asker_ = runtime::ZmqSocket(context_, ZMQ_REQ);
    asker_.Set(ZMQ_RCVTIMEO, 5000);
    asker_.Set(ZMQ_LINGER, 0);
    ASSERT_EQ(zmq_connect(asker_.get(), "inproc://zeromq.zap.01"), 0);
  }
  void TearDown() override {
    asker_ = {};
    keeper_.reset();
    zmq_ctx_term(context_);
  }

  // The reply's frames.
  std::vector<std::string> Ask(const std::vector<std::string>& frames) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      zmq_send(asker_.get(), frames[i].data(), frames[i].size(),
               i + 1 < frames.size() ? ZMQ_SNDMORE : 0);
    }
    while (keeper_->DoWork()) {
    }
    std::vector<std::string> reply;
    std::array<char, 256> part{};
    do {
      const int size = zmq_recv(asker_.get(), part.data(), part.size(), 0);
      if (size < 0) return {};
      reply.emplace_back(part.data(), static_cast<std::size_t>(size));
    } while (asker_.Get(ZMQ_RCVMORE) != 0);
    return reply;
  }
  std::vector<std::string> AskFor(const std::string& key, const std::string& domain) {
    std::string bytes(32, '\0');
    zmq_z85_decode(reinterpret_cast<std::uint8_t*>(bytes.data()), key.c_str());
    return Ask({"1.0", "1", domain, "10.0.0.7", "", "CURVE", bytes});
  }
  std::string CodeFor(const std::string& key, const std::string& domain) {
    const auto reply = AskFor(key, domain);
    return reply.size() == 6 ? reply[2] : "no reply";
  }
  static std::string NewKey() { return keys::MakePair().value().public_key; }

  support::TemporaryFolder folder_;
  std::string keys_ = folder_ / "keys";
  void* context_ = zmq_ctx_new();
  runtime::Counters counters_;
  std::unique_ptr<Gatekeeper> keeper_;
  runtime::ZmqSocket asker_;
};

TEST_F(GatekeeperTest, HostileRequestsAreAnsweredWithARefusalAndNothingElse) {
  auto cases = ZapCases();
  cases.push_back({"a hundred frames", std::vector<std::string>(100, "1.0"), ZapResult::kFrames});
  cases.push_back({"a large frame", {std::string(1 << 20, 'x')}, ZapResult::kFrames});
  for (const ZapCase& tried : cases) {
    if (tried.frames.empty()) continue;  // ZeroMQ has no message without frames
    const auto reply = Ask(tried.frames);
    ASSERT_EQ(reply.size(), 6U) << tried.name;
    EXPECT_EQ(reply[0], "1.0");
    EXPECT_EQ(reply[1], tried.frames.size() > 1 ? tried.frames[1] : "");
    EXPECT_EQ(reply[2], "300") << tried.name << ": nobody's key, at best";
    EXPECT_EQ(reply[4], "");
  }
  EXPECT_EQ(counters_.Get(Counter::kSecurityRefused), cases.size() - 1);
  EXPECT_EQ(counters_.Get(Counter::kSecurityAdmitted), 0U);
}

TEST_F(GatekeeperTest, AChangeInTheFolderAppliesToTheNextRequest) {
  const std::string key = NewKey();
  EXPECT_EQ(CodeFor(key, "publish"), "300");
  ASSERT_TRUE(keys::Allow(keys_, {"anna", key, keys::Role::kSubscriber}).ok());
  const auto reply = AskFor(key, "publish");
  ASSERT_EQ(reply.size(), 6U);
  EXPECT_EQ(reply[2], "200");
  EXPECT_EQ(reply[4], key) << "by which the client is known from here on";
  EXPECT_EQ(CodeFor(key, "control"), "300");
  ASSERT_TRUE(keys::Allow(keys_, {"anna", key, keys::Role::kOperator}).ok());
  EXPECT_EQ(CodeFor(key, "control"), "200");
  EXPECT_EQ(counters_.Get(Counter::kSecurityClients), 1U);
  ASSERT_TRUE(keys::Revoke(keys_, "anna").ok());
  EXPECT_EQ(CodeFor(key, "publish"), "300");
  EXPECT_EQ(counters_.Get(Counter::kSecurityClients), 0U);
}

TEST_F(GatekeeperTest, WithItsFolderGoneNobodyIsLetInUntilThereIsAnother) {
  const std::string key = NewKey();
  ASSERT_TRUE(keys::Allow(keys_, {"anna", key, keys::Role::kSubscriber}).ok());
  EXPECT_EQ(CodeFor(key, "publish"), "200");
  std::filesystem::rename(keys::ClientsFolder(keys_), folder_ / "elsewhere");
  EXPECT_EQ(CodeFor(key, "publish"), "300");
  std::filesystem::rename(folder_ / "elsewhere", keys::ClientsFolder(keys_));
  std::string code;
  for (int i = 0; i < 500 && code != "200"; ++i) {
    code = CodeFor(key, "publish");
    support::Sleep(0.02);
  }
  EXPECT_EQ(code, "200") << "looked for once a second";
  ASSERT_TRUE(keys::Revoke(keys_, "anna").ok());
  EXPECT_EQ(CodeFor(key, "publish"), "300") << "and followed again";
}

TEST_F(GatekeeperTest, AFolderThatTurnsWritableForOthersLetsNobodyIn) {
  const std::string key = NewKey();
  ASSERT_TRUE(keys::Allow(keys_, {"anna", key, keys::Role::kSubscriber}).ok());
  ASSERT_EQ(chmod(keys::ClientsFolder(keys_).c_str(), 0777), 0);
  EXPECT_EQ(CodeFor(key, "publish"), "300");
  ASSERT_EQ(chmod(keys::ClientsFolder(keys_).c_str(), 0755), 0);
  EXPECT_EQ(CodeFor(key, "publish"), "200");
}

TEST_F(GatekeeperTest, OnlyOneInAProcess) {
  const auto second = Gatekeeper::Open(context_, folder_ / "more", counters_);
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.status().message(), testing::HasSubstr("security: "));
}

}  // namespace
}  // namespace styled::security
