#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "clients/cpp/key_options.h"
#include "clients/stylectl/cli.h"
#include "proto/keys/key_folder.h"
#include "tests/support/child.h"

namespace styled::stylectl {
namespace {

using testing::HasSubstr;

class KeyCommandsTest : public testing::Test {
 protected:
  void SetUp() override {
    bool made = false;
    server_ = keys::ServerPair(keys_, made).value().public_key;
  }
  int Run(std::vector<std::string> arguments) {
    out_.str("");
    err_.str("");
    return stylectl::Run(std::move(arguments), out_, err_);
  }
  int RunAt(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--keys", keys_});
    return Run(std::move(arguments));
  }

  support::TemporaryFolder folder_;
  std::string keys_ = folder_ / "keys", server_;
  std::ostringstream out_, err_;
};

TEST_F(KeyCommandsTest, KeygenPrintsThePublicKeyAloneAndKeepsThePair) {
  ASSERT_EQ(Run({"keygen", folder_ / "me.key"}), kExitOk) << err_.str();
  const auto pair = keys::ReadPair(folder_ / "me.key");
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  EXPECT_EQ(out_.str(), pair.value().public_key + "\n");
  EXPECT_EQ(Run({"keygen", folder_ / "me.key"}), kExitRefused);
  EXPECT_THAT(err_.str(), HasSubstr("is there already"));
  EXPECT_EQ(Run({"keygen"}), kExitUsage);
  EXPECT_EQ(Run({"keygen", folder_ / "no/such/folder.key"}), kExitRefused);
  EXPECT_THAT(err_.str(), HasSubstr("No such file"));
}

TEST_F(KeyCommandsTest, ClientsAreLetInShownAndRevoked) {
  const std::string anna = keys::MakePair().value().public_key;
  const auto bob = keys::MakePair().value();
  ASSERT_TRUE(keys::WritePair(folder_ / "bob.key", bob).ok());
  EXPECT_EQ(RunAt({"allow", "anna", anna, "--role", "operator"}), kExitOk) << err_.str();
  EXPECT_EQ(out_.str(), "anna is allowed as operator\n");
  EXPECT_EQ(RunAt({"allow", "bob", folder_ / "bob.key"}), kExitOk) << "a file, and no role";
  EXPECT_EQ(RunAt({"keys"}), kExitOk);
  EXPECT_EQ(out_.str(), "daemon: " + server_ +
                            "\n\nNAME  ROLE        PUBLIC KEY\nanna  operator    " + anna +
                            "\nbob   subscriber  " + bob.public_key + "\n");
  EXPECT_EQ(RunAt({"keys", "--json"}), kExitOk);
  const auto listed = nlohmann::json::parse(out_.str());
  EXPECT_EQ(listed["serverKey"], server_);
  EXPECT_EQ(listed["clients"][1]["name"], "bob");
  EXPECT_EQ(out_.str().find(bob.secret_key), std::string::npos);
  EXPECT_EQ(RunAt({"revoke", "anna"}), kExitOk);
  EXPECT_EQ(RunAt({"revoke", "anna"}), kExitRefused);
  EXPECT_THAT(err_.str(), HasSubstr("'anna' is not allowed"));
  EXPECT_EQ(keys::ReadClients(keys_).value().allowed.size(), 1U);
}

TEST_F(KeyCommandsTest, WhatIsWrongIsSaidAndNothingChanges) {
  const std::string key = keys::MakePair().value().public_key;
  EXPECT_EQ(RunAt({"allow", "anna", "nonsense"}), kExitRefused);
  EXPECT_THAT(err_.str(), HasSubstr("'nonsense' is not a public key; expected 40 characters"));
  EXPECT_EQ(RunAt({"allow", "an na", key}), kExitRefused);
  EXPECT_EQ(RunAt({"allow", "anna", key, "--role", "king"}), kExitUsage);
  EXPECT_EQ(RunAt({"allow", "anna"}), kExitUsage);
  EXPECT_EQ(Run({"allow", "anna", key, "--keys", folder_ / "nowhere"}), kExitRefused);
  EXPECT_THAT(err_.str(), HasSubstr("is not a folder; expected the daemon's security.keys"));
  EXPECT_EQ(Run({"keys", "--keys", folder_ / "nowhere", "--json"}), kExitRefused);
  EXPECT_FALSE(nlohmann::json::parse(out_.str())["ok"]);
  EXPECT_TRUE(keys::ReadClients(keys_).value().allowed.empty());
}

TEST_F(KeyCommandsTest, TheFolderIsGivenByAnOptionOrTheEnvironment) {
  EXPECT_EQ(Run({"keys", "--keys", keys_}), kExitOk) << err_.str();
  EXPECT_EQ(Run({"--keys", keys_, "keys"}), kExitOk) << "before the command, too: " << err_.str();
  ASSERT_EQ(setenv("STYLED_SECURITY_KEYS", keys_.c_str(), 1), 0);
  EXPECT_EQ(Run({"keys"}), kExitOk) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("daemon: " + server_));
  EXPECT_EQ(Run({"keys", "--keys", folder_ / "none"}), kExitRefused) << "the option goes before";
  ASSERT_EQ(unsetenv("STYLED_SECURITY_KEYS"), 0);
}

TEST_F(KeyCommandsTest, OptionsOfProgramsNameFilesAndKeys) {
  const auto pair = keys::MakePair().value();
  const std::string file = folder_ / "me.key";
  ASSERT_TRUE(keys::WritePair(file, pair).ok());
  EXPECT_FALSE(client::ReadKeys({}).value());
  for (const std::string& server : {server_, keys::ServerPublicFile(keys_)}) {
    const auto curve = client::ReadKeys({file, server});
    ASSERT_TRUE(curve.ok()) << curve.status().message();
    EXPECT_EQ(curve.value()->server_key, server_);
    EXPECT_EQ(curve.value()->public_key, pair.public_key);
    EXPECT_EQ(curve.value()->secret_key, pair.secret_key);
  }
  const auto complaint = [](const std::string& key, const std::string& server) {
    return client::ReadKeys({key, server}).status().message();
  };
  EXPECT_THAT(complaint(file, ""), HasSubstr("--key: expected --server-key"));
  EXPECT_THAT(complaint("", server_), HasSubstr("--server-key: expected --key"));
  EXPECT_THAT(complaint(folder_ / "none", server_), HasSubstr("--key " + (folder_ / "none")));
  EXPECT_THAT(complaint(file, "nonsense"), HasSubstr("expected a key, 40 characters"));
  std::filesystem::permissions(file, std::filesystem::perms(0644));
  EXPECT_THAT(complaint(file, server_), HasSubstr("others may read it"));
  EXPECT_EQ(Run({"status", "--key", file, "--server-key", server_}), kExitUsage);
}

}  // namespace
}  // namespace styled::stylectl
