#include "tests/e2e/nats/stage.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>

namespace styled::support {
namespace {

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool Listens(const std::string& port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = Loopback(std::stoi(port));
  const bool there = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return there;
}

void Replace(std::string& text, const std::string& from, const std::string& to) {
  std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from << " is not in the shipped configuration";
  for (; at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

bool HasNatsServer() { return access(NATS_SERVER, X_OK) == 0; }

std::string FreePort() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), size), 0);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  close(fd);
  return std::to_string(ntohs(address.sin_port));
}

bool WaitUntil(const std::function<bool()>& done, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    Sleep(0.01);
  }
  return true;
}

NatsServers::NatsServers()
    : hub_port(FreePort()),
      leaf_port(FreePort()),
      hub_leaf_port(FreePort()),
      leaf_reaches(hub_leaf_port),
      rec_port(FreePort()) {
  std::string text = ReadText(NATS_CONFIG_FOLDER "/hub.conf");
  Replace(text, "listen: 127.0.0.1:4223", "listen: 127.0.0.1:" + hub_port);
  Replace(text, "listen: 127.0.0.1:7422", "listen: 127.0.0.1:" + hub_leaf_port);
  Replace(text, "/var/lib/nats/styled", folder_ / "jetstream");
  WriteText(folder_ / "hub.conf", text);
  text = ReadText(NATS_CONFIG_FOLDER "/leaf.conf");
  Replace(text, "listen: 127.0.0.1:4222", "listen: 127.0.0.1:" + leaf_port);
  WriteText(folder_ / "leaf.conf", text);
  text = ReadText(NATS_CONFIG_FOLDER "/rec.conf");
  Replace(text, "listen: 127.0.0.1:4225", "listen: 127.0.0.1:" + rec_port);
  Replace(text, "/var/lib/nats/styled_rec", folder_ / "recording");
  WriteText(folder_ / "rec.conf", text);
}

void NatsServers::Edit(const std::string& name, const std::string& from, const std::string& to) {
  std::string text = ReadText(folder_ / (name + ".conf"));
  Replace(text, from, to);
  WriteText(folder_ / (name + ".conf"), text);
}

std::unique_ptr<Child> NatsServers::Start(const std::string& name, const std::string& port,
                                          std::vector<std::string> command) {
  command.insert(command.end(), {NATS_SERVER, "-c", folder_ / (name + ".conf")});
  auto child = std::make_unique<Child>(
      command, folder_ / (name + ".log"),
      std::map<std::string, std::string>{
          {"STYLED_NATS_BRIDGE", "bridgeword"},
          {"STYLED_NATS_LEAF", "leafword"},
          {"STYLED_NATS_RECORDER", "recorderword"},
          {"STYLED_NATS_OPERATOR", "operatorword"},
          {"STYLED_NATS_VIEWER", "viewerword"},
          {"STYLED_NATS_GUEST", "guestword"},
          {"STYLED_NATS_HUB", name == "rec"
                                  ? "nats://recorder:recorderword@127.0.0.1:" + hub_leaf_port
                                  : leaf_scheme + "://leaf:leafword@127.0.0.1:" + leaf_reaches}});
  EXPECT_TRUE(WaitUntil([&port] { return Listens(port); }, 10)) << Log();
  return child;
}

void NatsServers::StartHub() { hub = Start("hub", hub_port, hub_under); }

void NatsServers::StartLeaf() { leaf = Start("leaf", leaf_port); }

void NatsServers::StartRec() { rec = Start("rec", rec_port); }

std::string NatsServers::Log() const {
  return ReadText(folder_ / "hub.log") + ReadText(folder_ / "leaf.log") +
         (rec ? ReadText(folder_ / "rec.log") : "");
}

Stylenats::Stylenats(const std::string& user, const std::string& port, const std::string& publish,
                     const std::string& control, const std::vector<std::string>& more,
                     const std::string& site) {
  WriteText(folder_ / "login", user + "\n" + user + "word\n");
  chmod((folder_ / "login").c_str(), 0600);
  std::string command = "exec '" STYLENATS_BINARY "' --site " + site +
                        " --stats-every 0.2 --nats-login '" + (folder_ / "login") + "' --nats " +
                        (port.find(':') == std::string::npos ? "nats://127.0.0.1:" + port : port) +
                        " --publish " + publish + " --control " + control;
  for (const std::string& word : more) command += " " + word;
  child = std::make_unique<Child>(
      std::vector<std::string>{"/bin/sh", "-c", command + " > '" + (folder_ / "out.txt") + "'"},
      folder_ / "stderr.txt");
}

std::string Stylenats::Counters() const {
  std::istringstream lines(ReadText(folder_ / "out.txt"));
  std::string line, last;
  while (std::getline(lines, line)) {
    if (!lines.eof()) last = line;
  }
  return last;
}

long Stylenats::Count(const std::string& words) const {
  const std::string line = Counters();
  const std::size_t end = line.find(" " + words);
  if (end == std::string::npos) return -1;
  return std::stol(line.substr(line.rfind(' ', end - 1) + 1));
}

bool Stylenats::WaitForLog(const std::string& text, double seconds) const {
  return WaitUntil([&] { return Log().find(text) != std::string::npos; }, seconds);
}

NatsUser::NatsUser(const std::string& port, const std::string& user, const std::string& subject) {
  natsOptions* options = nullptr;
  natsOptions_Create(&options);
  natsOptions_SetURL(options, ("nats://127.0.0.1:" + port).c_str());
  natsOptions_SetUserInfo(options, user.c_str(), (user + "word").c_str());
  natsOptions_SetCustomInboxPrefix(options, ("_INBOX_" + user).c_str());
  natsOptions_SetMaxReconnect(options, -1);
  natsOptions_SetReconnectWait(options, 50);
  natsOptions_SetErrorHandler(
      options, [](natsConnection*, natsSubscription*, natsStatus, void*) {}, nullptr);
  EXPECT_EQ(natsConnection_Connect(&connection_, options), NATS_OK) << user;
  natsOptions_Destroy(options);
  if (subject.empty() || connection_ == nullptr) return;
  EXPECT_EQ(natsConnection_SubscribeSync(&subscription_, connection_, subject.c_str()), NATS_OK);
  natsSubscription_SetPendingLimits(subscription_, -1, -1);
  EXPECT_EQ(natsConnection_Flush(connection_), NATS_OK);
  thread_ = std::jthread([this](const std::stop_token& stop) { Loop(stop); });
}

NatsUser::~NatsUser() {
  thread_ = {};
  natsSubscription_Destroy(subscription_);
  natsConnection_Destroy(connection_);
}

void NatsUser::Loop(const std::stop_token& stop) {
  const auto number = [](natsMsg* message, const char* name) {
    const char* value = nullptr;
    return natsMsgHeader_Get(message, name, &value) == NATS_OK ? std::stoull(value) : 0ULL;
  };
  while (!stop.stop_requested()) {
    natsMsg* message = nullptr;
    if (natsSubscription_NextMsg(&message, subscription_, 50) != NATS_OK) continue;
    Heard heard{
        natsMsg_GetSubject(message),
        {natsMsg_GetData(message), static_cast<std::size_t>(natsMsg_GetDataLength(message))},
        number(message, "Styled-Epoch"),
        number(message, "Styled-Sequence"),
        std::chrono::steady_clock::now()};
    natsMsg_Destroy(message);
    const std::scoped_lock lock(mutex_);
    heard_.push_back(std::move(heard));
  }
}

std::vector<Heard> NatsUser::All(const std::string& subject) const {
  const std::scoped_lock lock(mutex_);
  std::vector<Heard> found;
  for (const Heard& heard : heard_) {
    if (subject.empty() || heard.subject == subject) found.push_back(heard);
  }
  return found;
}

std::size_t NatsUser::Size(const std::string& subject) const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      heard_.begin(), heard_.end(),
      [&subject](const Heard& heard) { return subject.empty() || heard.subject == subject; }));
}

bool NatsUser::WaitFor(std::size_t count, const std::string& subject, double seconds) const {
  return WaitUntil([&] { return Size(subject) >= count; }, seconds);
}

void NatsUser::Clear() {
  const std::scoped_lock lock(mutex_);
  heard_.clear();
}

std::optional<v1::Reply> NatsUser::Ask(const std::string& bytes, double seconds) {
  natsMsg* answer = nullptr;
  const natsStatus status = natsConnection_Request(&answer, connection_, "styledctl.hall",
                                                   bytes.data(), static_cast<int>(bytes.size()),
                                                   static_cast<std::int64_t>(1000 * seconds));
  if (status != NATS_OK) return std::nullopt;
  v1::Reply reply;
  const bool parsed = reply.ParseFromArray(natsMsg_GetData(answer), natsMsg_GetDataLength(answer));
  natsMsg_Destroy(answer);
  EXPECT_TRUE(parsed);
  return reply;
}

std::optional<std::string> NatsUser::Get(const std::string& key) {
  jsCtx* jetstream = nullptr;
  kvStore* bucket = nullptr;
  kvEntry* entry = nullptr;
  std::optional<std::string> value;
  if (natsConnection_JetStream(&jetstream, connection_, nullptr) == NATS_OK &&
      js_KeyValue(&bucket, jetstream, "styled") == NATS_OK &&
      kvStore_Get(&entry, bucket, key.c_str()) == NATS_OK) {
    value.emplace(static_cast<const char*>(kvEntry_Value(entry)),
                  static_cast<std::size_t>(kvEntry_ValueLen(entry)));
  }
  kvEntry_Destroy(entry);
  kvStore_Destroy(bucket);
  jsCtx_Destroy(jetstream);
  return value;
}

bool NatsUser::WaitForKey(const std::string& key, double seconds) {
  return WaitUntil([&] { return Get(key).has_value(); }, seconds);
}

Walker::Walker(const Daemon& daemon, std::vector<std::string> performers, std::size_t extra)
    : thread_([udp = daemon.udp, performers = std::move(performers),
               extra](const std::stop_token& stop) {
        const UdpLink link(udp);
        std::vector<Rig> rigs;
        for (const std::string& performer : performers) rigs.emplace_back(performer);
        auto next = std::chrono::steady_clock::now();
        for (int i = 0; !stop.stop_requested(); ++i) {
          for (Rig& rig : rigs) {
            if (i % 60 == 0) link.Send(rig.Body());
            link.Send(rig.Frame([extra](v1::SourceFrame& frame) {
              if (extra > 0) frame.add_thru(std::string(extra, 'x'));
            }));
          }
          next += std::chrono::nanoseconds(1'000'000'000 / 120);
          std::this_thread::sleep_until(next);
        }
      }) {}

std::vector<std::string> OnSmallDisk(const std::string& folder, bool full) {
  std::vector<std::string> words{"/usr/bin/unshare", "-m"};
  if (geteuid() != 0) words.emplace_back("-r");
  const std::string fill = full ? "{ cat /dev/zero > \"$0/full\"; } 2>/dev/null; " : "";
  words.insert(
      words.end(),
      {"/bin/sh", "-c", "mount -t tmpfs -o size=2m tmpfs \"$0\" || exit 1; " + fill + "exec \"$@\"",
       folder});
  return words;
}

bool CanMount() {
  const TemporaryFolder folder;
  std::vector<std::string> words = OnSmallDisk(folder.path(), false);
  words.emplace_back("/bin/true");
  Child child(words, folder / "log.txt");
  return child.Wait(5).value_or(-1) == 0;
}

}  // namespace styled::support
