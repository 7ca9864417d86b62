#include "clients/web/access.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "clients/web/gateway.h"
#include "tests/support/child.h"

namespace styled::web {
namespace {

TEST(AccessTest, OnLoopbackOnlyLoopbackNamesAreAnswered) {
  const AccessRules rules;
  for (const char* host :
       {"localhost", "localhost:7080", "127.0.0.1:7080", "127.1.2.3", "[::1]:7080", "[::1]",
        "LocalHost:7080", "LOCALHOST", "localhost.", "localhost.:7080", "localhost:"}) {
    EXPECT_EQ(Judge(rules, {.host = host}, true), Verdict::kAllowed) << host;
  }
  for (const char* host :
       {"", "evil.example:7080", "localhost.evil.example", "127.0.0.1.evil.example",
        "192.168.1.5:7080", "[::2]:7080", "[::1].evil.example", "127.0.0.1:7080@evil.example",
        "localhost@evil.example", "localhost:7080:evil", "localhost:123456", "127.0.0.1/evil",
        "localhost..", "127.0.0.1 evil", "[::1", "[::1]evil", "[]", ":7080", "."}) {
    EXPECT_EQ(Judge(rules, {.host = host}, false), Verdict::kHost) << host;
  }
}

// The name of a site that points it at this machine has a letter in its last label.
TEST(AccessTest, WithoutATokenASiteThatPointsItsNameHereIsRefused) {
  AccessRules rules{.loopback = false, .hosts = {"Stage.lan"}};
  for (const char* host : {"192.168.1.5:7080", "[fe80::1]:7080", "localhost:7080", "stage.LAN:7080",
                           "stage.lan.", "127.0.0.1"}) {
    EXPECT_EQ(Judge(rules, {.host = host}, false), Verdict::kAllowed) << host;
  }
  for (const char* host :
       {"evil.example:7080", "stage.lan.evil.example", "192.168.1.5.evil.example",
        "192.168.1.5:7080@evil", "1e100.net", "", "[evil]"}) {
    EXPECT_EQ(Judge(rules, {.host = host, .origin = "http://" + std::string(host)}, false),
              Verdict::kHost)
        << host;
  }
  rules.token = "abcdefgh12345678";
  EXPECT_EQ(Judge(rules, {.host = "proxy.example"}, false), Verdict::kAllowed)
      << "such a site has no token";
  EXPECT_EQ(Judge(rules, {.host = "proxy.example:80@evil"}, false), Verdict::kHost);
}

TEST(AccessTest, TheGatewayIsOnLoopbackUnlessToldOtherwise) {
  EXPECT_EQ(Options().listen, "127.0.0.1:7080");
  EXPECT_FALSE(Options().allow_unauthenticated_remote);
}

TEST(AccessTest, PagesOfOtherSitesAreRefusedUnlessNamed) {
  AccessRules rules{.origins = {"http://stage.lan:5173"}};
  const auto judge = [&rules](const char* origin) {
    return Judge(rules, {.host = "127.0.0.1:7080", .origin = origin}, false);
  };
  EXPECT_EQ(judge(""), Verdict::kAllowed) << "no browser";
  EXPECT_EQ(judge("http://127.0.0.1:7080"), Verdict::kAllowed);
  EXPECT_EQ(judge("http://stage.lan:5173"), Verdict::kAllowed);
  for (const char* origin :
       {"http://evil.example", "null", "http://127.0.0.1", "http://localhost:7080",
        "http://127.0.0.1:7081", "ftp://127.0.0.1:7080", "127.0.0.1:7080",
        "http://stage.lan:5173.evil.example", "http://stage.lan:517"}) {
    EXPECT_EQ(judge(origin), Verdict::kOrigin) << origin;
  }
  rules.loopback = false;
  rules.hosts = {"stage.lan"};
  EXPECT_EQ(Judge(rules, {.host = "stage.lan", .origin = "https://stage.lan"}, false),
            Verdict::kAllowed);
  EXPECT_EQ(Judge(rules, {.host = "stage.lan", .origin = "http://"}, false), Verdict::kOrigin);
}

TEST(AccessTest, NamesAreTheSameInCapitals) {
  const AccessRules rules{
      .loopback = false, .hosts = {"stage.lan", "x"}, .origins = {"http://Stage.LAN:5173"}};
  EXPECT_EQ(Judge(rules, {.host = "STAGE.lan:7080", .origin = "http://stage.lan:7080"}, false),
            Verdict::kAllowed);
  EXPECT_EQ(Judge(rules, {.host = "x", .origin = "http://stage.lan:5173"}, false),
            Verdict::kAllowed);
  EXPECT_EQ(Judge(rules, {.host = "stage.lan", .origin = "http://stage.lam"}, false),
            Verdict::kOrigin);
}

TEST(AccessTest, ASecondHostOrOriginIsRefusedWhateverTheySay) {
  const AccessRules rules;
  EXPECT_EQ(Judge(rules, {.host = "localhost", .hosts = 2}, false), Verdict::kTwice);
  EXPECT_EQ(Judge(rules, {.host = "localhost", .origin = "http://localhost", .origins = 2}, false),
            Verdict::kTwice);
  EXPECT_EQ(Judge(rules, {.host = "localhost", .hosts = 1, .origins = 0}, false),
            Verdict::kAllowed);
}

TEST(AccessTest, TheTokenComesInTheAddressOrTheHeader) {
  const AccessRules rules{.loopback = false, .token = "abcdefgh12345678"};
  const auto with = [&rules](const char* authorization, const char* target) {
    return Judge(rules, {.host = "x", .authorization = authorization, .target = target}, true);
  };
  EXPECT_EQ(with("Bearer abcdefgh12345678", "/ws"), Verdict::kAllowed);
  EXPECT_EQ(with("", "/ws?token=abcdefgh12345678"), Verdict::kAllowed);
  EXPECT_EQ(with("", "/ws?a=b&token=abcdefgh12345678&c"), Verdict::kAllowed);
  EXPECT_EQ(with("", "/ws"), Verdict::kToken);
  EXPECT_EQ(with("", "/ws?token="), Verdict::kToken);
  EXPECT_EQ(with("", "/ws?xtoken=abcdefgh12345678"), Verdict::kToken);
  EXPECT_EQ(with("", "/ws?token=abcdefgh12345679"), Verdict::kToken);
  EXPECT_EQ(with("", "/ws?token=abcdefgh1234567"), Verdict::kToken);
  EXPECT_EQ(with("Basic abcdefgh12345678", "/ws"), Verdict::kToken);
  EXPECT_EQ(with("Bearer wrong", "/ws?token=abcdefgh12345678"), Verdict::kToken);
  EXPECT_EQ(Judge(rules, {.host = "x", .target = "/"}, false), Verdict::kAllowed) << "the page";
}

TEST(AccessTest, TokenFilesThatHoldNoTokenAreRefusedByName) {
  const support::TemporaryFolder folder;
  const auto read = [&folder](const std::string& text) {
    support::WriteText(folder / "token", text);
    EXPECT_EQ(chmod((folder / "token").c_str(), 0600), 0);
    return ReadToken(folder / "token");
  };
  const auto good = read("abcdefgh.1234_5678~-\nmore\n");
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(good.value(), "abcdefgh.1234_5678~-");
  EXPECT_TRUE(read("abcdefgh12345678\r\n").ok());
  for (const std::string& bad : {std::string(), std::string("\n"), std::string("short"),
                                 std::string("has spaces in between it"), std::string(257, 'a'),
                                 std::string("abcdefgh1234567&")}) {
    const auto result = read(bad);
    ASSERT_FALSE(result.ok()) << bad;
    EXPECT_NE(result.status().message().find(folder / "token"), std::string::npos);
  }
  EXPECT_FALSE(ReadToken(folder / "none").ok());
}

TEST(AccessTest, ATokenFileThatOthersCanReadIsRefusedAsAKeyFileIs) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "token";
  support::WriteText(file, "abcdefgh12345678\n");
  for (const mode_t mode : {0640U, 0604U, 0620U, 0644U, 0666U}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    const auto read = ReadToken(file);
    ASSERT_FALSE(read.ok()) << std::oct << mode;
    EXPECT_NE(read.status().message().find("--token-file " + file + ": others may read it (mode 0"),
              std::string::npos)
        << read.status().message();
    EXPECT_NE(read.status().message().find("expected 0600: chmod 600 " + file), std::string::npos);
    EXPECT_EQ(read.status().message().find("abcdefgh"), std::string::npos) << "never repeated";
  }
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  EXPECT_TRUE(ReadToken(file).ok());
  if (geteuid() == 0) {  // root can give a file to another user
    ASSERT_EQ(chown(file.c_str(), 65534, 65534), 0);
    const auto read = ReadToken(file);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.status().message().find("belongs to user 65534"), std::string::npos);
  }
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(ReadToken(pipe).ok()) << "and nobody is waited for";
}

}  // namespace
}  // namespace styled::web
