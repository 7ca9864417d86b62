// Keys, roles and locks of the real daemon, on an address other than loopback, with the real
// stylectl. Every refusal has a positive control: each refused client becomes an accepted one in
// some test.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <set>

#include "proto/keys/key_folder.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

struct Said {
  int code = -1;
  std::string out;  // stdout and stderr
};

Said RunProgram(const std::vector<std::string>& arguments,
                const std::map<std::string, std::string>& environment = {}) {
  const TemporaryFolder folder;
  std::vector<std::string> all{"/bin/sh", "-c", "exec \"$@\" >&2", "sh"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Child child(all, folder / "said.txt", environment);
  const int code = child.Wait(30).value_or(-1);
  return {code, ReadText(folder / "said.txt")};
}

Said Stylectl(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), STYLECTL_BINARY);
  return RunProgram(arguments);
}

// The address to connect to for a daemon that binds every interface.
std::string Here(const std::string& endpoint) {
  return "tcp://127.0.0.1" + endpoint.substr(endpoint.rfind(':'));
}

// A daemon that requires keys, and its clients.
class Guarded {
 public:
  explicit Guarded(std::vector<std::string> settings = {})
      : daemon(With(std::move(settings), Folder())) {
    publish = Here(daemon.publish);
    control = Here(daemon.control);
    // The test's own observer.
    const CurveKeys keys = Allow("watcher", "operator");
    eyes = std::make_unique<ControlClient>(control, keys);
  }

  CurveKeys NewClient(const std::string& name) {
    const std::string file = daemon.folder / (name + ".key");
    const Said made = Stylectl({"keygen", file});
    EXPECT_EQ(made.code, 0) << made.out;
    const auto pair = keys::ReadPair(file);
    EXPECT_TRUE(pair.ok()) << pair.status().message();
    EXPECT_EQ(made.out, pair.value().public_key + "\n");
    return {daemon.server_key, pair.value().public_key, pair.value().secret_key};
  }
  void Allow(const std::string& name, const CurveKeys& keys, const std::string& role) const {
    const Said said =
        Stylectl({"allow", name, keys.public_key, "--role", role, "--keys", Folder()});
    EXPECT_EQ(said.code, 0) << said.out;
  }
  CurveKeys Allow(const std::string& name, const std::string& role) {
    const CurveKeys keys = NewClient(name);
    Allow(name, keys, role);
    return keys;
  }
  void Revoke(const std::string& name) const {
    const Said said = Stylectl({"revoke", name, "--keys", Folder()});
    EXPECT_EQ(said.code, 0) << said.out;
  }
  std::string Folder() const { return place_ / "keys"; }

 private:
  TemporaryFolder place_;

 public:
  Daemon daemon;
  std::string publish, control;
  std::unique_ptr<ControlClient> eyes;

 private:
  static std::vector<std::string> With(std::vector<std::string> settings,
                                       const std::string& folder) {
    settings.insert(settings.begin(), {"security.keys=" + folder, "publish.address=tcp://0.0.0.0:0",
                                       "control.address=tcp://0.0.0.0:0"});
    return settings;
  }
};

// The sequences of each performer must be contiguous, from any start.
void ExpectNoGap(const Subscriber& subscriber, const std::string& who) {
  std::map<std::string, std::uint64_t> last;
  for (const auto& frame : subscriber.Frames("styled/")) {
    std::uint64_t& before = last[frame.performer()];
    if (before != 0) {
      ASSERT_EQ(frame.sequence(), before + 1) << who << " " << frame.performer();
    }
    before = frame.sequence();
  }
}

const std::vector<std::string> kRigTopics{"body/", "styled/rig.a/rig/"};

TEST(SecurityTest, OnlyClientsWithAKeyGetFrames) {
  Guarded guarded;
  const CurveKeys anna = guarded.Allow("anna", "subscriber");
  const CurveKeys stranger = guarded.NewClient("stranger");
  CurveKeys misled = anna;
  misled.server_key = stranger.public_key;
  Subscriber with_key(guarded.publish, kRigTopics, anna);
  Subscriber without(guarded.publish, kRigTopics);
  Subscriber unknown(guarded.publish, kRigTopics, stranger);
  Subscriber elsewhere(guarded.publish, kRigTopics, misled);
  ControlClient no_key(guarded.control);
  no_key.SetPatience(0.3);
  const UdpLink link(guarded.daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(with_key.WaitForBody());
  Paced(240, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(with_key.WaitForFrames(240, "styled/"));
  ExpectNoGap(with_key, "anna");
  EXPECT_EQ(no_key.SetStyle("*", "style1").reason(), "no reply");
  for (const Subscriber* refused : {&without, &unknown, &elsewhere}) {
    EXPECT_EQ(refused->Count(""), 0U);
  }
  EXPECT_GE(guarded.eyes->Counter("security.refused"), 1U);
  EXPECT_GE(guarded.eyes->Counter("security.handshakes_failed"), 2U);
  EXPECT_EQ(guarded.eyes->Counter("publish.subscriptions"), 2U) << "anna's; a stranger's never";
  EXPECT_NE(guarded.daemon.Log().find(stranger.public_key), std::string::npos)
      << "says whose key to allow";
  EXPECT_EQ(guarded.daemon.Log().find(anna.secret_key), std::string::npos);
  EXPECT_EQ(guarded.daemon.Stop(), 0);
}

TEST(SecurityTest, ASubscribersKeyDoesNotOpenTheControlSocket) {
  Guarded guarded;
  const CurveKeys anna = guarded.Allow("anna", "subscriber");
  ControlClient control(guarded.control, anna);
  control.SetPatience(2);
  EXPECT_EQ(control.SetStyle("*", "style1").reason(), "no reply");
  EXPECT_GE(guarded.eyes->Counter("security.refused"), 1U);
  EXPECT_EQ(guarded.eyes->SetStyle("*", "style1").code(), v1::CODE_OK) << "an operator";
  // The same key in another role, at the connection's next attempt.
  guarded.Allow("anna", anna, "operator");
  control.SetPatience(10);
  v1::Request status;
  status.mutable_status();
  EXPECT_EQ(control.Ask(status).code(), v1::CODE_OK);
}

TEST(SecurityTest, AllowAndRevokeAreInForceWithoutARestart) {
  Guarded guarded;
  const CurveKeys anna = guarded.Allow("anna", "subscriber");
  const CurveKeys bob = guarded.NewClient("bob");
  Subscriber annas(guarded.publish, kRigTopics, anna);
  Subscriber bobs(guarded.publish, kRigTopics, bob);
  const UdpLink link(guarded.daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(annas.WaitForBody());
  const auto send_until = [&](const std::function<bool()>& done) {
    for (int i = 0; i < 3600 && !done(); ++i) Paced(4, 120, [&](int) { link.Send(rig.Frame()); });
    return done();
  };
  const std::uint64_t before = rig.sequence;
  ASSERT_TRUE(send_until([&] { return rig.sequence > before + 120; }));
  EXPECT_EQ(bobs.Count(""), 0U);

  guarded.Allow("bob", bob, "subscriber");
  ASSERT_TRUE(send_until([&] { return bobs.Count("styled/") > 60; })) << guarded.daemon.Log();

  guarded.Revoke("bob");
  ASSERT_EQ(guarded.eyes->CounterSoon("security.cut", 1), 1U) << guarded.daemon.Log();
  // Frames in transit before the cut have arrived once the count has not changed for a second.
  std::size_t stood = 0;
  std::uint64_t since = rig.sequence;
  ASSERT_TRUE(send_until([&] {
    if (bobs.Count("") != stood) since = rig.sequence;
    stood = bobs.Count("");
    return rig.sequence > since + 120;
  }));
  const std::size_t count = bobs.Count("");
  const std::uint64_t refused = guarded.eyes->Counter("security.refused");
  ASSERT_TRUE(send_until([&] { return guarded.eyes->Counter("security.refused") >= refused + 2; }))
      << "he tries again";
  EXPECT_EQ(bobs.Count(""), count);

  guarded.Allow("bob", bob, "subscriber");
  ASSERT_TRUE(send_until([&] { return bobs.Count("styled/") > count + 60; }));
  ExpectNoGap(annas, "anna, who was let in all the time");
  const auto seen = annas.Frames("styled/");
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().sequence() - seen.front().sequence() + 1, seen.size());
}

TEST(SecurityTest, AnOperatorWhoIsRevokedOrDemotedIsRefusedAtHisNextRequest) {
  Guarded guarded;
  const CurveKeys anna = guarded.Allow("anna", "operator");
  ControlClient control(guarded.control, anna);
  ASSERT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  const auto soon = [&](v1::Code code) {
    v1::Reply reply = control.SetStyle("rig.a", "style2");
    for (int i = 0; i < 500 && reply.code() != code; ++i) {
      reply = control.SetStyle("rig.a", "style2");
      Sleep(0.01);
    }
    return reply;
  };
  guarded.Allow("anna", anna, "subscriber");
  EXPECT_EQ(soon(v1::CODE_UNAUTHORIZED).reason(),
            "this key is a subscriber's; expected an operator's");
  guarded.Revoke("anna");
  v1::Reply reply;
  for (int i = 0; i < 500 && reply.reason() != "this key is no longer allowed"; ++i) {
    reply = control.SetStyle("rig.a", "style2");
    Sleep(0.01);
  }
  EXPECT_EQ(reply.code(), v1::CODE_UNAUTHORIZED);
  EXPECT_EQ(reply.reason(), "this key is no longer allowed");
  guarded.Allow("anna", anna, "operator");
  EXPECT_EQ(soon(v1::CODE_OK).code(), v1::CODE_OK);
}

TEST(SecurityTest, StylectlReachesADaemonOnAnotherMachineByItsKeys) {
  Guarded guarded;
  (void)guarded.Allow("anna", "operator");
  const std::string key = guarded.daemon.folder / "anna.key";
  const auto ask = [&](const std::vector<std::string>& keys) {
    std::vector<std::string> all{"--endpoint", guarded.control, "status"};
    all.insert(all.end(), keys.begin(), keys.end());
    return Stylectl(all);
  };
  EXPECT_EQ(ask({"--key", key, "--server-key", guarded.daemon.server_key}).code, 0);
  EXPECT_EQ(ask({"--key", key, "--server-key", keys::ServerPublicFile(guarded.Folder())}).code, 0);
  const Said by_environment =
      RunProgram({STYLECTL_BINARY, "--endpoint", guarded.control, "status"},
                 {{"STYLED_KEY", key}, {"STYLED_SERVER_KEY", guarded.daemon.server_key}});
  EXPECT_EQ(by_environment.code, 0) << by_environment.out;
  const Said without = ask({"--timeout", "0.5"});
  EXPECT_EQ(without.code, 3);
  EXPECT_NE(without.out.find("needs --key and --server-key"), std::string::npos) << without.out;
  // Invalid keys, each with its own error message.
  (void)guarded.NewClient("stranger");
  (void)guarded.Allow("bob", "subscriber");
  const auto refused = [&](const std::string& name, const std::string& server,
                           const std::string& endpoint) {
    const Said said =
        Stylectl({"--endpoint", endpoint, "--timeout", "0.5", "--key",
                  guarded.daemon.folder / (name + ".key"), "--server-key", server, "status"});
    EXPECT_EQ(said.code, 3) << said.out;
    return said.out;
  };
  for (const std::string name : {"stranger", "bob"}) {
    const std::string said = refused(name, guarded.daemon.server_key, guarded.control);
    EXPECT_NE(said.find("it does not accept this client's key"), std::string::npos) << said;
    EXPECT_NE(said.find("stylectl allow NAME 'PUBLICKEY' --role operator"), std::string::npos);
  }
  const std::string other = keys::ReadPair(guarded.daemon.folder / "bob.key").value().public_key;
  const std::string misled = refused("anna", other, guarded.control);
  EXPECT_NE(misled.find("its key differs from"), std::string::npos) << misled;
  const std::string elsewhere = refused("anna", guarded.daemon.server_key, guarded.publish);
  EXPECT_NE(elsewhere.find("but not its control socket"), std::string::npos) << elsewhere;
  const Said listed = Stylectl({"keys", "--keys", guarded.Folder()});
  EXPECT_NE(listed.out.find("daemon: " + guarded.daemon.server_key), std::string::npos);
  EXPECT_NE(listed.out.find("anna     operator"), std::string::npos) << listed.out;
}

TEST(SecurityTest, EightPerformersReachEightSubscribersWithoutALoss) {
  Guarded guarded({"publish.high_water_mark=20000"});
  std::vector<std::unique_ptr<Subscriber>> subscribers;
  for (int i = 0; i < 8; ++i) {
    const CurveKeys keys = guarded.Allow("client" + std::to_string(i), "subscriber");
    subscribers.push_back(std::make_unique<Subscriber>(
        guarded.publish, std::vector<std::string>{"body/", "styled/"}, keys));
  }
  const UdpLink link(guarded.daemon.udp);
  std::vector<Rig> rigs;
  for (int i = 0; i < 8; ++i) {
    rigs.emplace_back("p" + std::to_string(i), 10 + i);
    link.Send(rigs.back().Body());
  }
  for (const auto& subscriber : subscribers) ASSERT_TRUE(subscriber->WaitForBody());
  constexpr int kFrames = 480;
  Paced(kFrames, 120, [&](int) {
    for (auto& rig : rigs) link.Send(rig.Frame());
  });
  for (const auto& subscriber : subscribers) {
    ASSERT_TRUE(
        subscriber->WaitFor([&] { return subscriber->Count("styled/") >= 2UL * 8 * kFrames; }, 60))
        << subscriber->Count("styled/");
    std::map<std::string, std::set<std::uint64_t>> sequences;
    std::map<std::string, std::uint64_t> last;
    for (const auto& frame : subscriber->Frames("styled/")) {
      const std::string stream = frame.performer() + std::to_string(frame.output());
      EXPECT_TRUE(last[stream] == 0 || frame.sequence() == last[stream] + 1) << stream;
      last[stream] = frame.sequence();
      sequences[stream].insert(frame.sequence());
    }
    ASSERT_EQ(sequences.size(), 16U);
    for (const auto& [stream, seen] : sequences) {
      EXPECT_EQ(seen.size(), static_cast<std::size_t>(kFrames)) << stream;
    }
  }
  EXPECT_EQ(guarded.eyes->Counter("publish.failed"), 0U);
  EXPECT_EQ(guarded.eyes->Counter("source.kernel_dropped"), 0U);
}

TEST(SecurityTest, GarbageAndHalfOpenConnectionsHarmNobody) {
  Guarded guarded;
  const CurveKeys anna = guarded.Allow("anna", "subscriber");
  Subscriber annas(guarded.publish, kRigTopics, anna);
  const UdpLink link(guarded.daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(annas.WaitForBody());
  const std::string publish = guarded.publish.substr(6), control = guarded.control.substr(6);
  std::vector<std::unique_ptr<TcpLink>> hanging;
  Paced(240, 120, [&](int i) {
    link.Send(rig.Frame());
    hanging.push_back(std::make_unique<TcpLink>(i % 2 == 0 ? publish : control));
    if (i % 3 == 0) return;  // sends nothing at all
    Bytes garbage(static_cast<std::size_t>(1 + i * 7));
    for (std::size_t k = 0; k < garbage.size(); ++k) {
      garbage[k] = static_cast<std::byte>((k * 131 + static_cast<std::size_t>(i)) & 0xFFU);
    }
    hanging.back()->Send(garbage);
  });
  ASSERT_TRUE(annas.WaitForFrames(240, "styled/"));
  ExpectNoGap(annas, "anna");
  EXPECT_EQ(guarded.eyes->SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  for (const auto& connection : hanging) {
    bool closed = false;  // after the greeting, which ZeroMQ sends first
    for (int i = 0; i < 100 && !closed; ++i) closed = connection->Closed(1);
    ASSERT_TRUE(closed);
  }
}

TEST(SecurityTest, AKeyThatOthersCanReadKeepsTheDaemonFromStarting) {
  Guarded guarded;
  ASSERT_EQ(guarded.daemon.Stop(), 0);
  const std::string file = keys::ServerKeyFile(guarded.Folder());
  const auto start = [&] {
    return RunProgram({Binary(), "--config", guarded.daemon.folder / "styled.toml", "--weights",
                       guarded.daemon.folder / "weights.safetensors", "--set",
                       "publish.address=tcp://0.0.0.0:0", "--set",
                       "security.keys=" + guarded.Folder()});
  };
  ASSERT_EQ(chmod(file.c_str(), 0644), 0);
  Said said = start();
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.out.find("security.keys: " + file + ": others may read it (mode 0644)"),
            std::string::npos)
      << said.out;
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  ASSERT_EQ(chmod(keys::ClientsFolder(guarded.Folder()).c_str(), 0777), 0);
  said = start();
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.out.find("others may write to it"), std::string::npos) << said.out;
}

TEST(SecurityTest, ALocalAddressNeedsNoKeysAndAWordOpensAnother) {
  const TemporaryFolder keys;
  Daemon daemon({"security.keys=" + keys / "keys", "publish.allow_unauthenticated_remote=true",
                 "publish.address=tcp://0.0.0.0:0"});
  EXPECT_EQ(daemon.server_key, "");
  EXPECT_FALSE(std::filesystem::exists(keys / "keys")) << "nobody is asked for one";
  Subscriber subscriber(Here(daemon.publish), kRigTopics);
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  EXPECT_TRUE(subscriber.WaitForBody());
  EXPECT_EQ(control.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
}

// --- ipc

std::string IpcOf(const TemporaryFolder& folder, const std::string& name) {
  return "ipc://" + folder / name;
}

TEST(SecurityTest, ASecondDaemonDoesNotTakeALivePath) {
  const TemporaryFolder folder;
  const std::string publish = IpcOf(folder, "p"), control = IpcOf(folder, "c");
  Daemon daemon({"publish.address=" + publish, "control.address=" + control});
  Subscriber subscriber(publish, kRigTopics);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  for (const auto& [key, address] :
       {std::pair{"publish.address", publish}, std::pair{"control.address", control}}) {
    const Said second = RunProgram({Binary(), "--config", daemon.folder / "styled.toml",
                                    "--weights", daemon.folder / "weights.safetensors", "--set",
                                    std::string(key) + "=" + address});
    EXPECT_EQ(second.code, 1);
    EXPECT_NE(second.out.find(key), std::string::npos) << second.out;
    EXPECT_NE(second.out.find("in use (another styled?)"), std::string::npos) << second.out;
  }
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(60, "styled/"));
  ControlClient asked(control);
  EXPECT_EQ(asked.SetStyle("rig.a", "style1").code(), v1::CODE_OK);
  struct stat about {};
  ASSERT_EQ(stat((folder / "c").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  EXPECT_EQ(daemon.Stop(), 0);
  daemon.Start();  // the lock ends with the daemon
}

TEST(SecurityTest, OnlyTheUsersNamedGetThroughAnIpcSocketThatAllMayWriteTo) {
  if (geteuid() != 0) GTEST_SKIP() << "skipped, only root can be somebody else";
  const TemporaryFolder folder;
  ASSERT_EQ(chmod(folder.path().c_str(), 0755), 0);
  const std::string tool = folder / "stylectl";
  std::filesystem::copy_file(STYLECTL_BINARY, tool);
  ASSERT_EQ(chmod(tool.c_str(), 0755), 0);
  const auto as_nobody = [&](const std::vector<std::string>& settings, const std::string& name) {
    const std::string control = IpcOf(folder, name);
    std::vector<std::string> all = settings;
    all.push_back("control.address=" + control);
    const Daemon daemon(all);
    ControlClient own(control);
    EXPECT_EQ(own.SetStyle("rig.a", "style1").code(), v1::CODE_OK) << "the daemon's own user";
    return RunProgram({"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", tool,
                       "--endpoint", control, "--timeout", "1.5", "status"});
  };
  const Said open = as_nobody({"control.ipc_mode=\"0666\""}, "open");
  EXPECT_EQ(open.code, 0) << open.out << ": the mode lets everybody in";
  EXPECT_EQ(as_nobody({}, "closed").code, 3) << "the mode does not";
  const std::string all = "control.ipc_mode=\"0666\"";
  EXPECT_EQ(as_nobody({all, "control.ipc_users=[\"root\", 4711]"}, "named").code, 3);
  EXPECT_EQ(as_nobody({all, "control.ipc_users=[\"nobody\"]"}, "nobody").code, 0);
}

// --- a limit for each sender

TEST(SecurityTest, ASenderBeyondItsLimitIsCountedAndAnotherIsServed) {
  Daemon daemon({"source.0.sender_limit_hz=200"});
  ControlClient control(daemon.control);
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.b/rig/"});
  // A second loopback address.
  class Elsewhere {
   public:
    explicit Elsewhere(const std::string& to) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
      sockaddr_in from{};
      from.sin_family = AF_INET;
      inet_pton(AF_INET, "127.0.0.2", &from.sin_addr);
      EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&from), sizeof from), 0);
      from.sin_port = htons(static_cast<std::uint16_t>(std::stoi(to.substr(to.rfind(':') + 1))));
      inet_pton(AF_INET, "127.0.0.1", &from.sin_addr);
      EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&from), sizeof from), 0);
    }
    ~Elsewhere() { close(fd_); }
    Elsewhere(const Elsewhere&) = delete;
    Elsewhere& operator=(const Elsewhere&) = delete;
    void Send(const Bytes& bytes) const { (void)send(fd_, bytes.data(), bytes.size(), 0); }

   private:
    int fd_;
  };
  const UdpLink flood(daemon.udp);
  const Elsewhere link(daemon.udp);
  Rig loud("a", 1), quiet("b", 2);
  link.Send(quiet.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  flood.Send(loud.Body());
  int sent = 2;
  Paced(120, 120, [&](int) {
    link.Send(quiet.Frame());
    for (int k = 0; k < 20; ++k) flood.Send(loud.Frame());
    sent += 21;
  });
  EXPECT_TRUE(subscriber.WaitForFrames(120, "styled/rig.b/"));
  std::uint64_t received = 0, limited = 0;
  for (int i = 0; i < 500 && received + limited < static_cast<std::uint64_t>(sent); ++i) {
    received = control.Counter("source.received");
    limited = control.Counter("source.rate_limited");
    Sleep(0.01);
  }
  EXPECT_EQ(received + limited, static_cast<std::uint64_t>(sent)) << "none is lost uncounted";
  EXPECT_GT(limited, 1000U);
  EXPECT_GT(received, 120U + 82U) << "the quiet one's, and what the limit leaves";
}

}  // namespace
}  // namespace styled::support
