#include "proto/keys/key_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/support/child.h"

namespace styled::keys {
namespace {

using support::ReadText;
using support::WriteText;
using testing::HasSubstr;
namespace fs = std::filesystem;

class KeyFolderTest : public testing::Test {
 protected:
  void SetUp() override { umask(022); }  // whatever the user's: others are not to write
  std::string File(const std::string& name) const { return ClientsFolder(keys_) + "/" + name; }
  static mode_t ModeOf(const std::string& file) {
    struct stat about {};
    EXPECT_EQ(stat(file.c_str(), &about), 0) << file;
    return about.st_mode & 0777U;
  }
  static std::string NewKey() { return MakePair().value().public_key; }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    const auto clients = ReadClients(keys_);
    for (const auto& client : clients.value().allowed) names.push_back(client.name);
    return names;
  }
  std::string Complaint() const {
    const auto complaints = ReadClients(keys_).value().complaints;
    return complaints.size() == 1 ? complaints[0] : std::to_string(complaints.size());
  }

  support::TemporaryFolder folder_;
  std::string keys_ = folder_ / "keys";
};

TEST_F(KeyFolderTest, TheFirstStartMakesAPairThatIsTheDaemonsAlone) {
  bool made = false;
  const auto pair = ServerPair(keys_, made);
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  EXPECT_TRUE(made);
  EXPECT_EQ(ModeOf(ServerKeyFile(keys_)), 0600U);
  EXPECT_EQ(ModeOf(ServerPublicFile(keys_)), 0644U);
  EXPECT_EQ(ReadPublicKey(ServerPublicFile(keys_)).value(), pair.value().public_key);
  EXPECT_EQ(ReadText(ServerPublicFile(keys_)).find(pair.value().secret_key), std::string::npos);
  const auto again = ServerPair(keys_, made);
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(made);
  EXPECT_EQ(again.value().secret_key, pair.value().secret_key);
}

TEST_F(KeyFolderTest, ASecretThatOthersCanReadIsRefused) {
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  const std::string file = ServerKeyFile(keys_);
  for (const mode_t mode : {0640, 0604, 0644, 0620, 0666}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    const auto read = ServerPair(keys_, made);
    ASSERT_FALSE(read.ok()) << mode;
    EXPECT_THAT(read.status().message(), HasSubstr(file + ": others may read it (mode 0"));
    EXPECT_THAT(read.status().message(), HasSubstr("expected 0600"));
  }
  for (const mode_t mode : {0600, 0400}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    EXPECT_TRUE(ServerPair(keys_, made).ok()) << mode;
  }
}

TEST_F(KeyFolderTest, AFileOfSomebodyElseIsRefusedButRootsIsRead) {
  if (geteuid() != 0) GTEST_SKIP() << "skipped, only root can give files away";
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  ASSERT_EQ(chown(ServerKeyFile(keys_).c_str(), 4711, 4711), 0);
  EXPECT_THAT(ServerPair(keys_, made).status().message(), HasSubstr("belongs to user 4711"));
  ASSERT_EQ(chown(keys_.c_str(), 4711, 4711), 0);
  EXPECT_THAT(ServerPair(keys_, made).status().message(),
              HasSubstr("who could give anyone access"));
  // As stylectl of root sees the folder of a daemon that runs as another user.
  EXPECT_TRUE(Allow(keys_, {"anna", NewKey(), Role::kOperator}).ok());
  EXPECT_EQ(Names(), std::vector<std::string>{"anna"});
  ASSERT_EQ(chown(File("anna.key").c_str(), 815, 815), 0);
  EXPECT_THAT(Complaint(), HasSubstr("belongs to user 815"));
}

TEST_F(KeyFolderTest, AFolderThatOthersMayWriteToIsRefused) {
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  ASSERT_EQ(chmod(ClientsFolder(keys_).c_str(), 0777), 0);
  EXPECT_THAT(ServerPair(keys_, made).status().message(), HasSubstr("others may write to it"));
  ASSERT_TRUE(fs::exists(ClientsFolder(keys_)));
  WriteText(File("mallory.key"), Format({NewKey(), "", Role::kOperator}));
  EXPECT_TRUE(Names().empty());
  EXPECT_THAT(Complaint(), HasSubstr("give themselves access"));
  ASSERT_EQ(chmod(ClientsFolder(keys_).c_str(), 0755), 0);
  ASSERT_EQ(chmod(keys_.c_str(), 0775), 0);
  EXPECT_FALSE(ServerPair(keys_, made).ok());
}

TEST_F(KeyFolderTest, AServerKeyWithoutASecretOrWithoutSenseIsRefused) {
  fs::create_directories(keys_);
  bool made = false;
  WriteText(ServerKeyFile(keys_), Format({NewKey(), "", {}}));
  chmod(ServerKeyFile(keys_).c_str(), 0600);
  EXPECT_THAT(ServerPair(keys_, made).status().message(), HasSubstr("holds no secret-key"));
  WriteText(ServerKeyFile(keys_), std::string(5000, 'x'));
  EXPECT_THAT(ServerPair(keys_, made).status().message(), HasSubstr("larger than 4096"));
  fs::remove(ServerKeyFile(keys_));
  fs::create_directory(ServerKeyFile(keys_));
  fs::permissions(ServerKeyFile(keys_), fs::perms::owner_all);
  EXPECT_THAT(ServerPair(keys_, made).status().message(), HasSubstr("expected a file"));
  EXPECT_FALSE(made);
}

TEST_F(KeyFolderTest, ClientsAreAllowedInARoleAndRevoked) {
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  const std::string key = NewKey();
  ASSERT_TRUE(Allow(keys_, {"bob", NewKey(), Role::kSubscriber}).ok());
  ASSERT_TRUE(Allow(keys_, {"anna", key, Role::kSubscriber}).ok());
  EXPECT_EQ(Names(), (std::vector<std::string>{"anna", "bob"}));
  EXPECT_EQ(ReadClients(keys_).value().allowed[0], (Client{"anna", key, Role::kSubscriber}));
  EXPECT_EQ(ModeOf(File("anna.key")), 0644U);
  ASSERT_TRUE(Allow(keys_, {"anna", key, Role::kOperator}).ok());
  EXPECT_EQ(ReadClients(keys_).value().allowed[0].role, Role::kOperator);
  EXPECT_TRUE(Revoke(keys_, "anna").ok());
  EXPECT_EQ(Names(), std::vector<std::string>{"bob"});
  EXPECT_THAT(Revoke(keys_, "anna").message(), HasSubstr("'anna' is not allowed"));
  EXPECT_EQ(std::distance(fs::directory_iterator(ClientsFolder(keys_)), fs::directory_iterator()),
            1)
      << "nothing is left behind";
}

TEST_F(KeyFolderTest, NamesAndKeysThatAreNoneAreRefusedAndSoIsAKeyTwice) {
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  const std::string key = NewKey();
  for (const std::string name : {"", "../server", "a b", "a/b", ".", "anna.key"}) {
    EXPECT_THAT(Allow(keys_, {name, key, Role::kOperator}).message(),
                HasSubstr("not a client's name"));
    EXPECT_FALSE(Revoke(keys_, name).ok()) << name;
  }
  EXPECT_TRUE(fs::exists(ServerKeyFile(keys_)));
  EXPECT_THAT(Allow(keys_, {"anna", "key", Role::kOperator}).message(),
              HasSubstr("not a public key"));
  ASSERT_TRUE(Allow(keys_, {"anna", key, Role::kSubscriber}).ok());
  EXPECT_THAT(Allow(keys_, {"eve", key, Role::kOperator}).message(),
              HasSubstr("already allowed, as anna"));
  EXPECT_FALSE(Allow(folder_ / "nowhere", {"anna", key, Role::kOperator}).ok());
}

TEST_F(KeyFolderTest, AClientsFileThatIsWrongLetsNobodyInAndHarmsNoOther) {
  bool made = false;
  ASSERT_TRUE(ServerPair(keys_, made).ok());
  const std::string key = NewKey();
  ASSERT_TRUE(Allow(keys_, {"anna", key, Role::kSubscriber}).ok());
  const auto only_anna = [&](const std::string& complaint) {
    EXPECT_EQ(Names(), std::vector<std::string>{"anna"}) << complaint;
    EXPECT_THAT(Complaint(), HasSubstr(complaint));
    fs::remove(File("eve.key"));
  };
  WriteText(File("eve.key"), "garbage\n");
  only_anna("eve.key: holds no public-key");
  WriteText(File("eve.key"), Format({NewKey(), "", {}}));
  only_anna("says no role");
  WriteText(File("eve.key"), Format({key, "", Role::kOperator}));
  only_anna("has the key of anna");
  WriteText(File("eve.key"), Format({NewKey(), "", Role::kOperator}));
  ASSERT_EQ(chmod(File("eve.key").c_str(), 0666), 0);
  only_anna("others may write to it");
  ASSERT_EQ(mkfifo(File("eve.key").c_str(), 0600), 0);
  only_anna("expected a file");
  WriteText(File("no name.key"), Format({NewKey(), "", Role::kOperator}));
  EXPECT_THAT(Complaint(), HasSubstr("a client's name has"));
  fs::remove(File("no name.key"));
  WriteText(File("anna.key.new-1"), "half written");
  WriteText(File("README"), "not a client");
  EXPECT_TRUE(ReadClients(keys_).value().complaints.empty());
}

TEST_F(KeyFolderTest, APairIsNeverOverwritten) {
  const KeyFile pair = MakePair().value();
  ASSERT_TRUE(WritePair(folder_ / "me.key", pair).ok());
  EXPECT_EQ(ModeOf(folder_ / "me.key"), 0600U);
  EXPECT_THAT(WritePair(folder_ / "me.key", MakePair().value()).message(),
              HasSubstr("exists already"));
  EXPECT_EQ(ReadPair(folder_ / "me.key").value().secret_key, pair.secret_key);
}

TEST_F(KeyFolderTest, WithoutAFolderNobodyIsLetIn) {
  const auto clients = ReadClients(folder_ / "nowhere");
  ASSERT_TRUE(clients.ok());
  EXPECT_TRUE(clients.value().allowed.empty());
}

}  // namespace
}  // namespace styled::keys
