#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "proto/keys/key_folder.h"
#include "tests/e2e/web/browser.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using nlohmann::json;

// The real styleweb, on a port chosen by the system.
class Web {
 public:
  Web(const std::string& publish, const std::string& control,
      const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments{STYLEWEB_BINARY,      "--publish", publish,
                                       "--control",          control,     "--ready-file",
                                       folder / "ready.json"};
    if (std::find(options.begin(), options.end(), "--listen") == options.end()) {
      arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0"});
    }
    arguments.insert(arguments.end(), options.begin(), options.end());
    child = std::make_unique<Child>(arguments, folder / "stderr.txt");
    const std::string ready = folder / "ready.json";
    for (int i = 0; i < 2000 && !std::filesystem::exists(ready) && child->Running(); ++i) {
      Sleep(0.01);
    }
    EXPECT_TRUE(std::filesystem::exists(ready)) << ReadText(folder / "stderr.txt");
    address = json::parse(ReadText(ready))["listen"];
  }
  explicit Web(const Daemon& daemon, const std::vector<std::string>& options = {})
      : Web(daemon.publish, daemon.control, options) {}

  double Metric(const std::string& name) const {
    const std::string text = "\n" + Ask(address, "/metrics").body;
    const std::size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
  }

  TemporaryFolder folder;
  std::unique_ptr<Child> child;
  std::string address;
};

// Writes a file that only its owner can read.
void WriteSecret(const std::string& file, const std::string& text) {
  WriteText(file, text);
  EXPECT_EQ(chmod(file.c_str(), 0600), 0);
}

// Runs styleweb until it exits; returns exit code and output.
std::pair<int, std::string> Refused(const std::vector<std::string>& options) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments{STYLEWEB_BINARY};
  arguments.insert(arguments.end(), options.begin(), options.end());
  Child child(arguments, folder / "stderr.txt");
  const auto code = child.Wait(10);
  return {code.value_or(-1), ReadText(folder / "stderr.txt")};
}

// A performer that sends until the destructor.
class Walking {
 public:
  Walking(const std::string& address, const std::string& name)
      : thread_([this, address, name](const std::stop_token& stop) {
          const UdpLink link(address);
          Rig rig(name);
          while (!stop.stop_requested()) {
            if (rig.sequence % 60 == 0) link.Send(rig.Body());
            link.Send(rig.Frame());
            sent = static_cast<int>(rig.sequence);
            Sleep(1.0 / 120);
          }
        }) {}
  std::atomic<int> sent = 0;

 private:
  std::jthread thread_;
};

// Reads until `wanted` accepts a message; empty after `seconds`.
template <typename Wanted>
std::optional<Received> Await(BrowserLink& link, const Wanted& wanted, double seconds = 20) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end && !link.closed()) {
    auto received = link.Receive(0.5);
    if (received && wanted(*received)) return received;
  }
  return std::nullopt;
}

auto IsNotice(const std::string& key) {
  return [key](const Received& r) { return r.text && json::parse(r.payload).contains(key); };
}
auto IsTopic(const std::string& topic) {
  return [topic](const Received& r) { return !r.text && r.topic == topic; };
}
auto SaysDaemonIs(bool up) {
  return [up](const Received& r) {
    if (!r.text) return false;
    const json notice = json::parse(r.payload);
    return notice.contains("daemon") && notice["daemon"]["up"] == up;
  };
}

v1::Reply AskThrough(BrowserLink& link, v1::Request request) {
  static std::uint64_t id = 100;
  request.set_id(++id);
  link.SendBinary(request.SerializeAsString());
  v1::Reply reply;
  const auto received = Await(link, [&](const Received& r) {
    return !r.text && r.topic.empty() && reply.ParseFromString(r.payload) &&
           reply.id() == request.id();
  });
  if (!received) reply.set_code(v1::CODE_BUSY);
  return reply;
}

v1::Request SetStyle(const std::string& performer, const std::string& style) {
  v1::Request request;
  request.set_performer(performer);
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style(style);
  mix.set_weight(1);
  return request;
}

std::uint64_t ResidentBytes(pid_t pid) {
  std::istringstream statm(ReadText("/proc/" + std::to_string(pid) + "/statm"));
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * 4096;
}

TEST(GatewayTest, ABrowserGetsWhatTheDaemonPublishesByteForByte) {
  Daemon daemon;
  const Web web(daemon);
  const Walking a(daemon.udp, "a"), b(daemon.udp, "b");
  Subscriber direct(daemon.publish, {"source/rig.a/"});
  BrowserLink link(web.address);
  ASSERT_EQ(link.status(), 101);
  const auto hello = link.Receive();
  ASSERT_TRUE(hello && hello->text);
  EXPECT_TRUE(json::parse(hello->payload).contains("styleweb"));
  ASSERT_TRUE(Await(link, SaysDaemonIs(true)));
  link.SendText(
      R"({"subscribe": ["stats/", "body/", "source/rig.a/", "styled/rig.a/canonical/"]})");
  std::map<std::string, int> counts;
  std::vector<v1::Body> bodies;
  std::map<std::uint64_t, std::string> sources;
  std::uint64_t last = 0;
  ASSERT_TRUE(Await(link, [&](const Received& r) {
    EXPECT_FALSE(r.text) << r.payload;
    ++counts[r.topic];
    if (r.topic.starts_with("body/")) {
      EXPECT_TRUE(bodies.emplace_back().ParseFromString(r.payload));
    }
    if (r.topic == "source/rig.a/") {
      v1::Frame frame;
      EXPECT_TRUE(frame.ParseFromString(r.payload));
      EXPECT_GT(frame.sequence(), last);
      last = frame.sequence();
      sources[last] = r.payload;
    }
    return counts["stats/"] >= 2 && counts["source/rig.a/"] >= 60 && bodies.size() >= 4 &&
           counts["styled/rig.a/canonical/"] >= 60;
  }));
  EXPECT_EQ(bodies.size(), 4U) << "two of each performer, once";
  EXPECT_FALSE(counts.contains("source/rig.b/"));
  ASSERT_TRUE(direct.WaitFor(
      [&] {
        const auto frames = direct.Frames();
        return !frames.empty() && frames.back().sequence() >= last;
      },
      10));
  int compared = 0;
  for (const v1::Frame& frame : direct.Frames()) {
    const auto same = sources.find(frame.sequence());
    if (same == sources.end()) continue;
    EXPECT_EQ(same->second, frame.SerializeAsString());
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(GatewayTest, TheDaemonIsAskedOnlyForWhatSomeBrowserWants) {
  Daemon daemon;
  const Web web(daemon);
  ControlClient control(daemon.control);
  EXPECT_EQ(control.CounterSoon("publish.subscriptions", 1), 1U) << "stats/";
  {
    BrowserLink one(web.address), two(web.address);
    one.SendText(R"({"subscribe": ["source/rig.a/", "body/rig.a/"]})");
    two.SendText(R"({"subscribe": ["source/rig.a/"]})");
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 3), 3U);
    one.SendText(R"({"unsubscribe": ["body/rig.a/"]})");
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
  }
  EXPECT_EQ(control.CounterSoon("publish.subscriptions", 1), 1U) << "the browsers went";
}

TEST(GatewayTest, BrowsersControlTheDaemonAndRefusalsReachThem) {
  Daemon daemon;
  const Web web(daemon);
  const Walking a(daemon.udp, "a");
  BrowserLink link(web.address);
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(AskThrough(link, list).list().styles_size(), 5);
  const v1::Reply set = AskThrough(link, SetStyle("rig.a", "style2"));
  EXPECT_EQ(set.code(), v1::CODE_OK) << set.reason();
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Performer("rig.a").styles(0).style(), "style2");
  const v1::Reply refused = AskThrough(link, SetStyle("rig.a", "pirate"));
  EXPECT_EQ(refused.code(), v1::CODE_UNKNOWN_STYLE);
  EXPECT_NE(refused.reason().find("pirate"), std::string::npos);
  // Two browsers may use the same id.
  BrowserLink other(web.address);
  for (BrowserLink* each : {&link, &other}) {
    v1::Request status;
    status.set_id(7);
    status.mutable_status();
    each->SendBinary(status.SerializeAsString());
  }
  for (BrowserLink* each : {&link, &other}) {
    v1::Reply reply;
    EXPECT_TRUE(Await(*each, [&](const Received& r) {
      return !r.text && r.topic.empty() && reply.ParseFromString(r.payload) && reply.id() == 7;
    }));
    EXPECT_TRUE(reply.has_status());
  }
}

TEST(GatewayTest, WatchOnlyLetsNobodyChangeAnything) {
  Daemon daemon;
  const Web web(daemon, {"--watch-only"});
  BrowserLink link(web.address);
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(AskThrough(link, list).code(), v1::CODE_OK);
  EXPECT_EQ(AskThrough(link, SetStyle("rig.a", "style1")).code(), v1::CODE_UNAUTHORIZED);
  v1::Request panic;
  panic.mutable_panic();
  EXPECT_EQ(AskThrough(link, panic).code(), v1::CODE_UNAUTHORIZED);
  v1::Request remove;
  remove.mutable_remove_style()->set_name("pirate");
  EXPECT_EQ(AskThrough(link, remove).code(), v1::CODE_UNAUTHORIZED);
  v1::Request preview;
  preview.mutable_preview()->set_style("style1");
  EXPECT_NE(AskThrough(link, preview).code(), v1::CODE_UNAUTHORIZED);
  EXPECT_EQ(AskThrough(link, v1::Request()).code(), v1::CODE_UNAUTHORIZED);
  ControlClient control(daemon.control);
  EXPECT_EQ(control.Status().stats().performers_size(), 0);
}

TEST(GatewayTest, OtherSitesAndWhoeverHasNoTokenStayOutside) {
  const Daemon daemon;
  const std::string token = "a-token.of_24~characters";
  const TemporaryFolder folder;
  WriteSecret(folder / "token", token + "\n");
  std::filesystem::create_directories(folder / "page");
  WriteText(folder / "page/index.html", "<p>the page</p>");
  const Web web(daemon, {"--token-file", folder / "token", "--origin", "http://stage.lan", "--page",
                         folder / "page"});
  EXPECT_EQ(BrowserLink(web.address).status(), 401);
  EXPECT_EQ(BrowserLink(web.address, "/ws?token=wrong").status(), 401);
  EXPECT_EQ(BrowserLink(web.address, "/ws?token=" + token).status(), 101);
  EXPECT_EQ(BrowserLink(web.address, "/ws", {{"Authorization", "Bearer " + token}}).status(), 101);
  const auto from = [&](const std::string& origin) {
    return BrowserLink(web.address, "/ws?token=" + token, {{"Origin", origin}}).status();
  };
  EXPECT_EQ(from(web.address), 101);
  EXPECT_EQ(from("http://stage.lan"), 101);
  EXPECT_EQ(from("http://evil.example"), 403);
  EXPECT_EQ(from("null"), 403);
  const auto named = [&](const std::string& host) {
    return Ask(web.address, "/healthz", {{"Host", host}}).status;
  };
  EXPECT_NE(named("localhost:7080"), 403);
  EXPECT_EQ(named("evil.example"), 403) << "a name that was made to point here";
  EXPECT_EQ(Ask(web.address, "/").body, "<p>the page</p>");
  EXPECT_EQ(Ask(web.address, "/metrics").status, 401);
  EXPECT_EQ(Ask(web.address, "/metrics", {{"Authorization", "Bearer " + token}}).status, 200);
  EXPECT_NE(Ask(web.address, "/ws").body.find("token"), std::string::npos) << "says why";
  EXPECT_EQ(Ask(web.address, "/ws?token=" + token).status, 426);
}

TEST(GatewayTest, AStalledBrowserCostsNobodyAnythingAndSeesThePresentWhenItReads) {
  Daemon daemon;
  const Web web(daemon);
  const Walking a(daemon.udp, "a");
  BrowserLink stalled(web.address, "/ws", {}, 4096), healthy(web.address);
  const std::string wish = R"({"subscribe": ["source/rig.a/", "styled/rig.a/rig/"]})";
  stalled.SendText(wish);
  healthy.SendText(wish);
  // Frames are superseded only after the sockets' buffers are full.
  std::uint64_t last = 0, missed = 0, frames = 0;
  v1::Frame frame;
  const auto count = [&](const Received& r) {
    if (r.topic != "source/rig.a/" || !frame.ParseFromString(r.payload)) return false;
    if (last != 0) missed += frame.sequence() - last - 1;
    last = frame.sequence();
    return ++frames % 120 == 0;
  };
  double superseded = 0;
  for (int i = 0; i < 60 && superseded < 200; ++i) {
    ASSERT_TRUE(Await(healthy, count));
    superseded = web.Metric("styleweb_superseded_messages_total");
  }
  ASSERT_GE(superseded, 200);
  const std::uint64_t before = ResidentBytes(web.child->pid());
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(Await(healthy, count));
  EXPECT_LT(ResidentBytes(web.child->pid()), before + (4U << 20U));
  EXPECT_EQ(missed, 0U) << "the healthy one got every frame";
  // The buffers hold old frames; current ones follow.
  const std::uint64_t now = last;
  EXPECT_TRUE(Await(stalled, [&](const Received& r) {
    return r.topic == "source/rig.a/" && frame.ParseFromString(r.payload) &&
           frame.sequence() >= now;
  }));
}

TEST(GatewayTest, ADaemonThatGoesAndComesBackIsSeenToDoSo) {
  const TemporaryFolder folder;
  Daemon daemon({"publish.address=ipc://" + folder / "publish",
                 "control.address=ipc://" + folder / "control"});
  const Web web(daemon.publish, daemon.control);
  BrowserLink link(web.address);
  link.SendText(R"({"subscribe": ["source/rig.a/", "stats/"]})");
  ASSERT_TRUE(Await(link, SaysDaemonIs(true)));
  EXPECT_EQ(Ask(web.address, "/healthz").status, 200);
  daemon.child->Signal(SIGKILL);
  daemon.child->Wait(5);
  const auto away = Await(link, SaysDaemonIs(false));
  ASSERT_TRUE(away);
  EXPECT_NE(away->payload.find(folder / "publish"), std::string::npos) << "names the place";
  const HttpReply health = Ask(web.address, "/healthz");
  EXPECT_EQ(health.status, 503);
  EXPECT_NE(health.body.find(folder / "publish"), std::string::npos);
  EXPECT_EQ(web.Metric("styled_up"), 0);
  EXPECT_EQ(web.Metric("styled_source_received_total"), -1) << "no numbers of the dead";
  v1::Request request;
  request.set_id(5);
  request.mutable_status();
  link.SendBinary(request.SerializeAsString());
  const auto unanswered = Await(link, IsNotice("unanswered"));
  ASSERT_TRUE(unanswered);
  EXPECT_EQ(json::parse(unanswered->payload)["unanswered"], "5");
  daemon.Start();
  ASSERT_TRUE(Await(link, SaysDaemonIs(true)));
  const Walking a(daemon.udp, "a");
  EXPECT_TRUE(Await(link, IsTopic("source/rig.a/"))) << "still subscribed";
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(AskThrough(link, list).code(), v1::CODE_OK);
}

TEST(GatewayTest, HostileBrowsersAreAnsweredOrDroppedAndNobodyElseNotices) {
  Daemon daemon;
  const Web web(daemon, {"--max-connections", "8"});
  BrowserLink good(web.address);
  good.SendText(R"({"subscribe": ["stats/"]})");
  ASSERT_TRUE(Await(good, IsTopic("stats/")));
  BrowserLink bad(web.address);
  const auto complains = [&bad](const std::string& text) {
    bad.SendText(text);
    return Await(bad, IsNotice("error")).has_value();
  };
  for (const char* text :
       {"", "{}", "[]", "nonsense", R"({"subscribe": "stats/"})", R"({"subscribe": [1]})",
        R"({"subscribe": ["s"]})", R"({"jump": 1})", R"({"subscribe": ["styled/../rig/"]})",
        "\"\\ud800\"", "{\"\\u0000\": []}"}) {
    EXPECT_TRUE(complains(text)) << text;
  }
  EXPECT_TRUE(complains(std::string(30000, '[')));
  // Valid topics next to invalid ones are subscribed all the same.
  EXPECT_TRUE(complains(R"({"subscribe": ["styled/no such name/rig/", 1, "stats/"]})"));
  EXPECT_TRUE(Await(bad, IsTopic("stats/")));
  bad.SendBinary("\x12\xFF garbage");
  EXPECT_TRUE(Await(bad, IsNotice("error")));
  for (int i = 0; i < 40; ++i) {
    v1::Request request;
    request.mutable_status();
    bad.SendBinary(request.SerializeAsString());
  }
  EXPECT_TRUE(Await(bad, IsNotice("unanswered"))) << "too many at once";
  bad.SendText(std::string(70000, 'x'));
  EXPECT_FALSE(Await(bad, IsNotice("nothing"), 5));
  EXPECT_TRUE(bad.closed()) << "a message that is too large";
  EXPECT_EQ(Ask(web.address, "/", {}, "POST").status, 405);
  EXPECT_EQ(Ask(web.address, "/nothing").status, 404);
  EXPECT_EQ(Ask(web.address, "/../../etc/passwd").status, 404);
  EXPECT_EQ(Ask(web.address, "/", {{"X-Long", std::string(20000, 'x')}}).status, 400);
  EXPECT_EQ(Ask(web.address, "/healthz", {}, "HEAD").status, 200);
  {
    std::vector<std::unique_ptr<BrowserLink>> crowd;
    for (int i = 0; i < 12; ++i) crowd.push_back(std::make_unique<BrowserLink>(web.address));
    EXPECT_EQ(crowd.back()->status(), 0) << "closed at once";
    EXPECT_EQ(crowd.front()->status(), 101);
  }
  for (int i = 0; i < 200 && Ask(web.address, "/healthz").status == 0; ++i) Sleep(0.02);
  EXPECT_GT(web.Metric("styleweb_refused_total{reason=\"full\"}"), 0);
  EXPECT_TRUE(Await(good, IsTopic("stats/")));
  web.child->Signal(SIGTERM);
  EXPECT_EQ(web.child->Wait(5), 0);
}

// More unfinished requests than the limit, each replaced as soon as it is closed.
TEST(GatewayTest, UnfinishedRequestsKeepNobodyOut) {
  Daemon daemon;
  const Web web(daemon, {"--max-connections", "8"});
  BrowserLink good(web.address);
  good.SendText(R"({"subscribe": ["stats/"]})");
  ASSERT_TRUE(Await(good, IsTopic("stats/")));
  const std::string address = web.address.substr(std::string("http://").size());
  std::vector<std::unique_ptr<TcpLink>> crowd;
  const auto crowd_in = [&] {
    for (int i = 0; i < 16; ++i) {
      crowd.push_back(std::make_unique<TcpLink>(address));
      const std::string part = i % 2 == 0 ? "" : "GET /healthz HTTP/1.1\r\nHost: loc";
      crowd.back()->Send(std::string_view(part));
    }
  };
  for (int round = 0; round < 5; ++round) {
    crowd_in();
    EXPECT_EQ(Ask(web.address, "/healthz").status, 200) << round;
    crowd_in();
    BrowserLink late(web.address);
    EXPECT_EQ(late.status(), 101) << round;
    late.SendText(R"({"subscribe": ["stats/"]})");
    EXPECT_TRUE(Await(late, IsTopic("stats/"))) << round;
  }
  EXPECT_TRUE(Await(good, IsTopic("stats/"))) << "a WebSocket never gives way";
  EXPECT_GT(web.Metric("styleweb_gave_way_total"), 0);
  EXPECT_EQ(web.Metric("styleweb_refused_total{reason=\"full\"}"), 0);
}

TEST(GatewayTest, ASecondHostOrOriginIsABadRequest) {
  const Web web("tcp://127.0.0.1:9", "tcp://127.0.0.1:9");
  const std::string address = web.address.substr(std::string("http://").size());
  const auto first_line = [&](const std::string& fields) {
    TcpLink link(address);
    const std::string request = "GET / HTTP/1.1\r\n" + fields + "Connection: close\r\n\r\n";
    link.Send(std::string_view(request));
    const std::string reply = link.ReadToEnd();
    return reply.substr(0, reply.find('\r'));
  };
  EXPECT_EQ(first_line("Host: LOCALHOST\r\n"), "HTTP/1.1 200 OK");
  EXPECT_EQ(first_line("Host: localhost\r\nHost: localhost\r\n"), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(first_line("Host: localhost\r\nOrigin: http://localhost\r\n"), "HTTP/1.1 200 OK");
  EXPECT_EQ(first_line("Host: localhost\r\nOrigin: http://localhost\r\norigin: null\r\n"),
            "HTTP/1.1 400 Bad Request");
}

TEST(GatewayTest, ADaemonThatAsksForKeysIsShownWithThem) {
  const TemporaryFolder folder;
  const std::string keys = folder / "keys", file = folder / "gateway.key";
  const Daemon daemon({"security.keys=" + keys, "publish.address=tcp://0.0.0.0:0",
                       "control.address=tcp://0.0.0.0:0"});
  const auto pair = keys::MakePair();
  ASSERT_TRUE(pair.ok() && keys::WritePair(file, pair.value()).ok());
  ASSERT_TRUE(keys::Allow(keys, {"web", pair.value().public_key, keys::Role::kOperator}).ok());
  const Web blind(daemon);
  const Web web(daemon, {"--key", file, "--server-key", keys::ServerPublicFile(keys)});
  const Walking a(daemon.udp, "a");
  BrowserLink link(web.address);
  link.SendText(R"({"subscribe": ["styled/rig.a/rig/"]})");
  EXPECT_TRUE(Await(link, IsTopic("styled/rig.a/rig/")));
  EXPECT_EQ(AskThrough(link, SetStyle("rig.a", "style1")).code(), v1::CODE_OK);
  // The first statistics show that the daemon is up, within about a second.
  for (int i = 0; i < 1000 && Ask(web.address, "/healthz").status != 200; ++i) Sleep(0.01);
  EXPECT_EQ(Ask(web.address, "/healthz").status, 200);
  HttpReply health = Ask(blind.address, "/healthz");
  EXPECT_EQ(health.status, 503) << "without a key nothing comes";
  const auto says_why = [&health] {
    return health.body.find("it requires keys, and none were given") != std::string::npos;
  };
  for (int i = 0; i < 1000 && !says_why(); ++i) {
    Sleep(0.01);
    health = Ask(blind.address, "/healthz");
  }
  EXPECT_TRUE(says_why()) << health.body;
}

TEST(GatewayTest, OptionsThatAreWrongAreNamed) {
  const TemporaryFolder folder;
  WriteSecret(folder / "token", "short\n");
  WriteSecret(folder / "good-token", "long-enough-to-be-one\n");
  WriteText(folder / "open-token", "long-enough-to-be-one\n");
  ASSERT_EQ(chmod((folder / "open-token").c_str(), 0644), 0);
  const Web taken("tcp://127.0.0.1:9", "tcp://127.0.0.1:9");
  const std::string port = taken.address.substr(7);
  struct Case {
    std::vector<std::string> options;
    std::string word;
  };
  for (const auto& [options, word] : std::vector<Case>{
           {{"--listen", "nonsense"}, "--listen nonsense"},
           {{"--listen", "127.0.0.1"}, "HOST:PORT"},
           {{"--listen", "127.0.0.1:x"}, "HOST:PORT"},
           {{"--listen", "127.0.0.1:70000"}, "HOST:PORT"},
           {{"--listen", "stage.lan:7080"}, "numeric"},
           {{"--listen", port}, "Address already in use"},
           {{"--listen", "0.0.0.0:0"}, "--token-file"},
           {{"--listen", "[::]:0"}, "--token-file"},
           {{"--listen", "127.0.0.1:0", "--publish", "nonsense"}, "--publish nonsense"},
           {{"--listen", "127.0.0.1:0", "--control", "nonsense"}, "nonsense"},
           {{"--listen", "127.0.0.1:0", "--page", folder / "none"}, "--page"},
           {{"--listen", "127.0.0.1:0", "--token-file", folder / "token"}, "16 to 256"},
           {{"--listen", "127.0.0.1:0", "--token-file", folder / "none"}, "--token-file"},
           {{"--listen", "127.0.0.1:0", "--token-file", folder / "open-token"},
            "open-token: others may read it (mode 0644)"},
           {{"--listen", "127.0.0.1:0", "--key", folder / "none"}, "--server-key"},
           {{"--listen", "127.0.0.1:0", "--key", folder / "none", "--server-key", "x"}, "--key"},
           {{"--max-connections", "0"}, "--max-connections"},
           {{"--listen", "127.0.0.1:0", "--host", "stage.lan:7080"}, "--host \"stage.lan:7080\""},
           {{"--bogus"}, "--bogus"}}) {
    const auto [code, said] = Refused(options);
    EXPECT_EQ(code, 2) << word;
    EXPECT_NE(said.find(word), std::string::npos) << said;
  }
  // With the explicit option, or with a token, other machines may connect.
  const Web open(
      "tcp://127.0.0.1:9", "tcp://127.0.0.1:9",
      {"--listen", "0.0.0.0:0", "--allow-unauthenticated-remote", "--host", "stage.lan"});
  const auto named = [&open](const std::string& host) {
    return Ask("http://127.0.0.1:" + open.address.substr(open.address.rfind(':') + 1), "/healthz",
               {{"Host", host}})
        .status;
  };
  EXPECT_EQ(named("stage.lan"), 503);
  EXPECT_EQ(named("192.168.1.5:7080"), 503);
  EXPECT_EQ(named("evil.example"), 403) << "a site that points its name at this machine";
  const Web guarded("tcp://127.0.0.1:9", "tcp://127.0.0.1:9",
                    {"--listen", "0.0.0.0:0", "--token-file", folder / "good-token"});
  EXPECT_TRUE(guarded.child->Running());
}

}  // namespace
}  // namespace styled::support
