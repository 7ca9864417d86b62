// A pair of daemons, a rig that sends to both, and a subscriber of both: the frames that the
// subscriber receives when one daemon is killed, stopped, restarted or must give up the lead. A
// third daemon that runs undisturbed gives the expected frames. STYLED_ROUNDS: the number of kills.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "clients/cpp/subscriber.h"
#include "clients/stylectl/cli.h"
#include "proto/keys/key_folder.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

using Clock = std::chrono::steady_clock;
using testing::HasSubstr;

// Rigs on a thread of their own, at 120 Hz.
class Sender {
 public:
  explicit Sender(const std::vector<std::string>& addresses,
                  const std::vector<std::string>& performers = {"a"}) {
    for (const auto& address : addresses) links_.push_back(std::make_unique<UdpLink>(address));
    thread_ = std::jthread([this, performers](const std::stop_token& stop) {
      std::vector<Rig> rigs;
      for (const std::string& performer : performers) rigs.emplace_back(performer);
      auto due = Clock::now();
      for (int i = 0; !stop.stop_requested(); ++i) {
        for (Rig& rig : rigs) {
          const Bytes body = i % 120 == 0 ? rig.Body() : Bytes();
          const Bytes frame = rig.Frame();
          for (const auto& link : links_) {
            if (!body.empty()) link->Send(body);
            link->Send(frame);
          }
        }
        due += std::chrono::nanoseconds(1'000'000'000 / 120);
        std::this_thread::sleep_until(due);
      }
    });
  }

 private:
  std::vector<std::unique_ptr<UdpLink>> links_;
  std::jthread thread_;
};

// The shipped client library, at both daemons.
class Viewer {
 public:
  explicit Viewer(const std::vector<std::string>& endpoints) {
    client::SubscriberOptions options;
    options.endpoints = endpoints;
    auto subscriber = client::Subscriber::Connect(options);
    EXPECT_TRUE(subscriber.ok());
    subscriber_ = std::move(subscriber.value());
    thread_ = std::jthread([this](const std::stop_token& stop) {
      client::Update update;
      while (!stop.stop_requested()) {
        connected_ = subscriber_->connected();
        if (!subscriber_->Receive(std::chrono::milliseconds(20), update)) continue;
        if (update.kind != client::Update::Kind::kFrame) continue;
        const std::lock_guard lock(mutex_);
        const auto now = Clock::now();
        if (!frames_.empty()) longest_ = std::max(longest_, now - last_);
        last_ = now;
        missed_ += update.missed;
        epochs_ += update.new_epoch ? 1 : 0;
        frames_.push_back(update.frame);
      }
    });
  }
  // By source time.
  std::map<std::uint64_t, v1::Frame> frames() const {
    std::map<std::uint64_t, v1::Frame> by_time;
    for (const v1::Frame& frame : all()) by_time[frame.source_time_ns()] = frame;
    return by_time;
  }
  std::vector<v1::Frame> all() const {
    const std::lock_guard lock(mutex_);
    return frames_;
  }
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return frames_.size();
  }
  std::uint64_t missed() const {
    const std::lock_guard lock(mutex_);
    return missed_;
  }
  int epochs() const {
    const std::lock_guard lock(mutex_);
    return epochs_;
  }
  // Whether it has both daemons: one that was started again is found after up to 0.25 s.
  bool HasBoth() const {
    for (int i = 0; i < 1000 && connected_ < 2; ++i) Sleep(0.01);
    return connected_ == 2;
  }
  // The longest time between two frames since the last call, ms.
  double PopLongest_ms() {
    const std::lock_guard lock(mutex_);
    return std::chrono::duration<double, std::milli>(std::exchange(longest_, {})).count();
  }

 private:
  std::unique_ptr<client::Subscriber> subscriber_;
  mutable std::mutex mutex_;
  std::vector<v1::Frame> frames_;
  std::atomic<int> connected_{0};
  std::uint64_t missed_ = 0;
  int epochs_ = 0;
  Clock::time_point last_;
  Clock::duration longest_{};
  std::jthread thread_;
};

class StandbyTest : public testing::Test {
 protected:
  // The addresses stay the same over restarts.
  static std::vector<std::string> Fixed(const Daemon& daemon) {
    return {"source.0.listen=" + daemon.udp, "publish.address=" + daemon.publish,
            "control.address=" + daemon.control};
  }
  std::string Standby(int own) const {
    const std::string name = folder_ / "journal";
    return "[standby]\naddress = \"ipc://" + name + std::to_string(own) + "\"\npeer = \"ipc://" +
           name + std::to_string(1 - own) + "\"\nfirst = " + (own == 0 ? "true" : "false") + "\n";
  }
  std::unique_ptr<Daemon> Pair(int own) const {
    Daemon probe;  // finds free ports
    auto fixed = Fixed(probe);
    probe.Stop();
    fixed.emplace_back("publish.high_water_mark=64");  // a user's setting
    return std::make_unique<Daemon>(fixed, Standby(own));
  }
  static v1::StandbyState State(const Daemon& daemon) {
    ControlClient control(daemon.control);
    control.SetPatience(1);
    return control.Status().stats().standby();
  }
  static bool Becomes(const Daemon& daemon, const std::string& role, double seconds = 20) {
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (Clock::now() < end) {
      const v1::StandbyState state = State(daemon);
      if (state.role() == role && (state.ready() || role == "leading")) return true;
      Sleep(0.02);
    }
    ADD_FAILURE() << role << ": " << State(daemon).role() << " " << State(daemon).why_not() << "\n"
                  << daemon.Log();
    return false;
  }
  // The pair: 0 leads, 1 follows.
  void Settle() {
    ASSERT_TRUE(Becomes(*pair_[0], "leading"));
    ASSERT_TRUE(Becomes(*pair_[1], "following"));
  }
  Daemon& Leader() { return State(*pair_[0]).role() == "leading" ? *pair_[0] : *pair_[1]; }
  Daemon& Other(const Daemon& one) { return &one == pair_[0].get() ? *pair_[1] : *pair_[0]; }
  int Stylectl(const Daemon& daemon, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--endpoint", daemon.control});
    std::ostringstream out, err;
    const int code = stylectl::Run(std::move(arguments), out, err);
    printed_ = out.str() + err.str();
    return code;
  }

  // Every frame that the third daemon has published between the viewer's first and last one must be
  // there, with the same pose.
  static void ExpectWhole(const Viewer& viewer, const Viewer& whole) {
    const auto seen = viewer.frames(), all = whole.frames();
    ASSERT_FALSE(seen.empty());
    int lost = 0, other = 0, compared = 0;
    for (const auto& [time_ns, frame] : all) {
      if (time_ns < seen.begin()->first || time_ns > seen.rbegin()->first) continue;
      ++compared;
      const auto found = seen.find(time_ns);
      if (found == seen.end()) {
        ++lost;
        continue;
      }
      const auto& a = frame.rotations();
      const auto& b = found->second.rotations();
      other += std::equal(a.begin(), a.end(), b.begin(), b.end()) ? 0 : 1;
    }
    std::printf("%d frames, %d lost, %d with another pose\n", compared, lost, other);
    EXPECT_EQ(lost, 0);
    EXPECT_EQ(other, 0);
    EXPECT_GT(compared, 100);
  }

  TemporaryFolder folder_;
  std::array<std::unique_ptr<Daemon>, 2> pair_{Pair(0), nullptr};
  std::string printed_;
};

TEST_F(StandbyTest, ALeaderThatIsKilledAgainAndAgainTakesNoFrameWithIt) {
  const char* const asked = std::getenv("STYLED_ROUNDS");
  const int rounds = asked == nullptr ? 4 : std::atoi(asked);
  pair_[1] = Pair(1);
  Settle();
  Daemon whole;
  // Before the first frame, so that it is the same one for both.
  for (Daemon* const daemon : {pair_[0].get(), &whole}) {
    ASSERT_EQ(ControlClient(daemon->control).SetStyle("*", "style2", 1, 0).code(), v1::CODE_OK);
  }
  Viewer viewer({pair_[0]->publish, pair_[1]->publish}), witness({whole.publish});
  Sender sender({pair_[0]->udp, pair_[1]->udp, whole.udp});
  ASSERT_TRUE(Becomes(*pair_[1], "following"));
  while (viewer.size() < 60) Sleep(0.02);
  for (int round = 0; round < rounds; ++round) {
    Daemon& leader = Leader();
    Daemon& standby = Other(leader);
    ASSERT_TRUE(Becomes(standby, "following"));
    ASSERT_TRUE(viewer.HasBoth());
    (void)viewer.PopLongest_ms();
    const std::size_t before = viewer.size();
    leader.child->Signal(SIGKILL);
    leader.child->Wait(5);
    ASSERT_TRUE(Becomes(standby, "leading"));
    for (int i = 0; i < 500 && viewer.size() < before + 60; ++i) Sleep(0.01);
    EXPECT_GE(viewer.size(), before + 60) << standby.Log();
    std::printf("kill %d: %.0f ms without a frame\n", round + 1, viewer.PopLongest_ms());
    EXPECT_THAT(standby.Log(), HasSubstr("leads from now on"));
    leader.Start();
  }
  EXPECT_EQ(viewer.epochs(), 0);
  EXPECT_EQ(viewer.missed(), 0U);
  ExpectWhole(viewer, witness);
  EXPECT_EQ(viewer.frames().rbegin()->second.styles(0).style(), "style2");
}

// With the shortest queues that a user has: what the standby sends at once is four times as much.
TEST_F(StandbyTest, OfFourPerformersNoFrameIsLostEither) {
  std::vector<std::string> performers;
  for (int i = 0; i < 4; ++i) performers.push_back("p" + std::to_string(i));
  pair_[0].reset();
  for (int own = 0; own < 2; ++own) pair_[static_cast<std::size_t>(own)] = Pair(own);
  Settle();
  Viewer viewer({pair_[0]->publish, pair_[1]->publish});
  Sender sender({pair_[0]->udp, pair_[1]->udp}, performers);
  while (viewer.size() < 60 * performers.size()) Sleep(0.02);
  for (int round = 0; round < 2; ++round) {
    Daemon& leader = Leader();
    Daemon& standby = Other(leader);
    ASSERT_TRUE(Becomes(standby, "following"));
    ASSERT_TRUE(viewer.HasBoth());
    Sleep(0.3);  // its subscriptions come behind the connection
    const std::size_t before = viewer.size();
    leader.child->Signal(SIGKILL);
    leader.child->Wait(5);
    ASSERT_TRUE(Becomes(standby, "leading"));
    for (int i = 0; i < 500 && viewer.size() < before + 60 * performers.size(); ++i) Sleep(0.01);
    leader.Start();
  }
  EXPECT_EQ(viewer.missed(), 0U);
  std::map<std::string, std::set<std::uint64_t>> seen;
  for (const v1::Frame& frame : viewer.all()) seen[frame.performer()].insert(frame.sequence());
  EXPECT_EQ(seen.size(), performers.size());
  for (const auto& [performer, sequences] : seen) {
    EXPECT_EQ(*sequences.rbegin() - *sequences.begin() + 1, sequences.size()) << performer;
  }
}

TEST_F(StandbyTest, AGoodbyeAndAWishTakeNoFrameEither) {
  pair_[1] = Pair(1);
  Settle();
  Daemon whole;
  Viewer viewer({pair_[0]->publish, pair_[1]->publish}), witness({whole.publish});
  Sender sender({pair_[0]->udp, pair_[1]->udp, whole.udp});
  while (viewer.size() < 60) Sleep(0.02);
  EXPECT_NE(Stylectl(*pair_[1], {"set", "rig.a", "--style", "style1"}), 0);
  EXPECT_THAT(printed_, HasSubstr("standby of ipc://"));
  ASSERT_TRUE(Becomes(*pair_[1], "following"));
  ASSERT_TRUE(viewer.HasBoth());
  EXPECT_EQ(Stylectl(*pair_[1], {"lead"}), 0) << printed_;
  ASSERT_TRUE(Becomes(*pair_[1], "leading"));
  ASSERT_TRUE(Becomes(*pair_[0], "following"));
  for (const auto& daemon : {pair_[0].get(), pair_[1].get()}) {
    EXPECT_EQ(Stylectl(*daemon, {"status"}), 0);
    EXPECT_THAT(printed_, HasSubstr("standby: "));
  }
  EXPECT_EQ(pair_[1]->Stop(), 0);  // SIGTERM
  ASSERT_TRUE(Becomes(*pair_[0], "leading"));
  const std::size_t before = viewer.size();
  for (int i = 0; i < 500 && viewer.size() < before + 60; ++i) Sleep(0.01);
  EXPECT_EQ(viewer.missed(), 0U);
  EXPECT_EQ(viewer.epochs(), 0);
  ExpectWhole(viewer, witness);
}

TEST_F(StandbyTest, ALeaderThatStandsStillIsReplacedAndComesBackAsTheStandby) {
  pair_[1] = Pair(1);
  Settle();
  Viewer viewer({pair_[0]->publish, pair_[1]->publish});
  Sender sender({pair_[0]->udp, pair_[1]->udp});
  while (viewer.size() < 60) Sleep(0.02);
  ASSERT_TRUE(Becomes(*pair_[1], "following"));
  pair_[0]->child->Signal(SIGSTOP);
  ASSERT_TRUE(Becomes(*pair_[1], "leading"));
  Sleep(0.5);
  pair_[0]->child->Signal(SIGCONT);
  ASSERT_TRUE(Becomes(*pair_[0], "following"));
  const std::size_t before = viewer.size();
  for (int i = 0; i < 500 && viewer.size() < before + 60; ++i) Sleep(0.01);
  EXPECT_EQ(viewer.missed(), 0U);
  const v1::StandbyState state = State(*pair_[0]);
  EXPECT_GT(state.compared(), 20U);
  EXPECT_EQ(state.different(), 0U);
}

// Each daemon shows its own key, and admits only its peer's.
TEST_F(StandbyTest, WithKeysTheyFollowEachOtherAndAStrangerHearsNothing) {
  const std::string folders[] = {folder_ / "keys0", folder_ / "keys1"};
  std::array<std::string, 2> keys;
  for (std::size_t i = 0; i < 2; ++i) {
    bool made = false;
    std::filesystem::create_directory(folders[i]);
    const auto pair = keys::ServerPair(folders[i], made);
    ASSERT_TRUE(pair.ok()) << pair.status().message();
    keys[i] = pair.value().public_key;
  }
  Daemon probe[2];
  std::array<std::string, 2> at;
  for (std::size_t i = 0; i < 2; ++i) at[i] = probe[i].publish;
  probe[0].Stop();
  probe[1].Stop();
  const auto start = [&](std::size_t own, const std::string& peer_key) {
    return std::make_unique<Daemon>(std::vector<std::string>{},
                                    "[security]\nkeys = \"" + folders[own] +
                                        "\"\n[standby]\naddress = \"" + at[own] + "\"\npeer = \"" +
                                        at[1 - own] + "\"\npeer_key = \"" + peer_key +
                                        "\"\nfirst = " + (own == 0 ? "true" : "false") + "\n");
  };
  const auto leader = start(0, keys[1]), standby = start(1, keys[0]);
  Sleep(1.5);
  EXPECT_FALSE(State(*standby).heard()) << "nobody is allowed yet";
  for (std::size_t i = 0; i < 2; ++i) {
    const Status allowed = keys::Allow(folders[i], {"peer", keys[1 - i], keys::Role::kOperator});
    ASSERT_TRUE(allowed.ok()) << allowed.message();
  }
  // Both have led meanwhile: either may stay.
  const auto follows = [](const v1::StandbyState& state) {
    return state.role() == "following" && state.ready();
  };
  const auto settled = [&] {
    const v1::StandbyState one = State(*leader), other = State(*standby);
    return follows(one) != follows(other) && one.heard() && other.heard();
  };
  for (int i = 0; i < 500 && !settled(); ++i) Sleep(0.02);
  EXPECT_TRUE(settled()) << leader->Log() << standby->Log();
  EXPECT_THAT(standby->Log() + leader->Log(), testing::Not(HasSubstr("secret")));
}

// By how much the joint that turns most turns from one frame to the next, degrees.
std::vector<double> Steps(const std::vector<v1::Frame>& frames) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto& a = frames[i - 1].rotations();
    const auto& b = frames[i].rotations();
    double most = 0;
    for (int j = 0; j + 3 < std::min(a.size(), b.size()); j += 4) {
      double dot = 0;
      for (int k = 0; k < 4; ++k) dot += static_cast<double>(a[j + k]) * b[j + k];
      most = std::max(most, 2 * std::acos(std::min(1.0, std::abs(dot))) * 57.29577951);
    }
    steps.push_back(most);
  }
  return steps;
}

// Rigs whose translators count and time on their own in each daemon.
class StandbyOfRigTest : public StandbyTest, public testing::WithParamInterface<const char*> {};

TEST_P(StandbyOfRigTest, ItGoesOnInTheSameSessionWithoutALossOrAJump) {
  const std::string rig = GetParam();
  pair_[0].reset();
  std::array<std::unique_ptr<Daemon>, 2> pair;
  for (int own = 0; own < 2; ++own) {
    pair[static_cast<std::size_t>(own)] = std::make_unique<Daemon>(
        std::vector<std::string>{}, "[[source]]\nname = \"suit\"\ntype = \"" + rig +
                                        "\"\nlisten = \"127.0.0.1:0\"\n" + Standby(own));
  }
  ASSERT_TRUE(Becomes(*pair[0], "leading"));
  Viewer viewer({pair[0]->publish, pair[1]->publish});
  const Child sender({STYLESIM_BINARY, "--as", rig, "--rate", "120", "--script", "walk:600", "--to",
                      "udp://" + pair[0]->listens[2], "--to", "udp://" + pair[1]->listens[2]},
                     folder_ / "stylesim.txt");
  while (viewer.size() < 150) Sleep(0.02);
  ASSERT_TRUE(Becomes(*pair[1], "following"));
  ASSERT_TRUE(viewer.HasBoth());
  const std::size_t before = viewer.size();
  pair[0]->child->Signal(SIGKILL);
  for (int i = 0; i < 500 && viewer.size() < before + 150; ++i) Sleep(0.01);
  const std::vector<v1::Frame> frames = viewer.all();
  EXPECT_GE(frames.size(), before + 150);
  EXPECT_EQ(viewer.missed(), 0U);
  EXPECT_EQ(viewer.epochs(), 0);
  // From the second second on, the performer walks.
  const auto walking = std::vector(frames.begin() + 60, frames.end());
  for (const v1::Frame& frame : walking) {
    ASSERT_EQ(frame.flags() & (v1::FLAG_NEW_SESSION | v1::FLAG_CONCEALED), 0U) << frame.sequence();
  }
  std::vector<double> steps = Steps(walking);
  const double worst = *std::max_element(steps.begin(), steps.end());
  std::nth_element(steps.begin(),
                   steps.begin() + static_cast<std::ptrdiff_t>(steps.size() * 9 / 10), steps.end());
  std::printf("%s: largest step %.2f degrees, nine tenths below %.2f\n", rig.c_str(), worst,
              steps[steps.size() * 9 / 10]);
  EXPECT_LT(worst, 3 * steps[steps.size() * 9 / 10] + 1);
}

INSTANTIATE_TEST_SUITE_P(Rigs, StandbyOfRigTest, testing::Values("vmc", "mvn", "rokoko", "mocopi"));

}  // namespace
}  // namespace styled::support
