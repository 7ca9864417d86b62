#pragma once

#include <gtest/gtest.h>
#include <nats/nats.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {

// Whether Debian's nats-server is installed; without it the tests are skipped.
bool HasNatsServer();
// Finds a port that is free at this moment.
std::string FreePort();

// The shipped servers (systemd/nats) on free ports of loopback, with passwords of the test.
class NatsServers {
 public:
  NatsServers();
  void StartHub();   // waits until it listens
  void StartLeaf();  // the same
  void StartRec();   // the same
  // Replaces text of "hub", "leaf" or "rec", before it is started.
  void Edit(const std::string& name, const std::string& from, const std::string& to);
  std::string hub_port, leaf_port, hub_leaf_port;
  std::string leaf_reaches;  // the port of the hub that the leaf server connects to
  std::string leaf_scheme = "nats";
  // In front of the hub's command line, such as unshare.
  std::vector<std::string> hub_under;
  std::string rec_port;
  std::unique_ptr<Child> hub, leaf, rec;
  std::string Log() const;
  std::string Folder() const { return folder_ / "jetstream"; }  // of the hub

 private:
  std::unique_ptr<Child> Start(const std::string& name, const std::string& port,
                               std::vector<std::string> command = {});
  TemporaryFolder folder_;
};

// A test with hub and leaf; skipped where nats-server is not installed.
class OnNatsServers : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasNatsServer()) GTEST_SKIP() << "skipped, no nats-server (Debian: nats-server)";
    servers_.StartHub();
    servers_.StartLeaf();
  }
  NatsServers servers_;
};

// stylenats as a child, at the leaf server, for the site "hall".
class Stylenats {
 public:
  Stylenats(const Daemon& daemon, const std::string& port,
            const std::vector<std::string>& more = {"--domain", "hub"})
      : Stylenats("bridge", port, daemon.publish, daemon.control, more) {}
  // As that user; the password is the name and "word". `port`: or a broker's whole address.
  Stylenats(const std::string& user, const std::string& port, const std::string& publish,
            const std::string& control, const std::vector<std::string>& more,
            const std::string& site = "hall");
  std::string Log() const { return ReadText(folder_ / "stderr.txt"); }
  std::string Counters() const;  // the last line of them
  // The number before `words` in that line; -1 if the line does not have them.
  long Count(const std::string& words) const;
  bool WaitForLog(const std::string& text, double seconds = 10) const;

 private:
  TemporaryFolder folder_;

 public:
  std::unique_ptr<Child> child;
};

// One message of a NATS subscription.
struct Heard {
  std::string subject, payload;
  std::uint64_t epoch = 0, sequence = 0;  // of the headers; 0: none
  std::chrono::steady_clock::time_point at;
};

// A user of the hub, by libnats; it collects what it hears.
class NatsUser {
 public:
  NatsUser(const std::string& port, const std::string& user, const std::string& subject = "");
  ~NatsUser();
  NatsUser(const NatsUser&) = delete;
  NatsUser& operator=(const NatsUser&) = delete;

  std::vector<Heard> All(const std::string& subject = "") const;  // "": all subjects
  std::size_t Size(const std::string& subject = "") const;
  bool WaitFor(std::size_t count, const std::string& subject = "", double seconds = 10) const;
  void Clear();
  natsConnection* get() const { return connection_; }
  // The Reply to `bytes`, sent to styledctl.hall; empty: none within `seconds`.
  std::optional<v1::Reply> Ask(const std::string& bytes, double seconds = 5);
  std::optional<v1::Reply> Ask(const v1::Request& request) {
    return Ask(request.SerializeAsString());
  }
  // The value of a key of the bucket; empty: none.
  std::optional<std::string> Get(const std::string& key);
  bool WaitForKey(const std::string& key, double seconds = 10);

 private:
  void Loop(const std::stop_token& stop);
  natsConnection* connection_ = nullptr;
  natsSubscription* subscription_ = nullptr;
  mutable std::mutex mutex_;
  std::vector<Heard> heard_;
  std::jthread thread_;
};

// Sends a rig's frames at 120 Hz on a thread of its own.
class Walker {
 public:
  // `extra`: bytes that each frame carries beside the pose.
  explicit Walker(const Daemon& daemon, std::vector<std::string> performers = {"a"},
                  std::size_t extra = 0);

 private:
  std::jthread thread_;
};

bool WaitUntil(const std::function<bool()>& done, double seconds);

// What to put in front of a program so that `folder` is a small file system for it alone, and full
// from the beginning if `full`. Where that is not permitted the program does not start (CanMount).
std::vector<std::string> OnSmallDisk(const std::string& folder, bool full);
bool CanMount();

}  // namespace styled::support
