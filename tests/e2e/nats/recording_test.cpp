// The shipped recording server records the sites, and stylerec reads its recordings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <iostream>
#include <map>
#include <set>
#include <sstream>

#include "clients/rec/cli.h"
#include "clients/rec/time_text.h"
#include "proto/recording/reader.h"
#include "proto/recording/writer.h"
#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

using testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string out, err;
};

// By topic, then epoch and sequence, the bytes of frames; and the bodies.
struct Contents {
  std::map<std::string, std::map<std::pair<std::uint64_t, std::uint64_t>, std::string>> frames;
  std::map<std::string, std::vector<std::int64_t>> times_ns;  // of the frames, by topic
  std::set<std::string> bodies, topics;
  std::uint64_t missed = 0;  // by the steps of the sequences
  std::uint64_t without_body = 0;
  std::int64_t first_ns = 0, last_ns = 0;
};

Contents Read(const std::string& file) {
  Contents taken;
  auto reader = recording::Reader::Open(file);
  if (!reader.ok()) {
    ADD_FAILURE() << reader.status().message();
    return taken;
  }
  std::set<std::pair<std::string, std::uint64_t>> known;  // performer and hash
  std::map<std::string, std::uint64_t> last;
  recording::Record record;
  while (reader.value()->Next(record)) {
    const std::string& topic = record.published().topic();
    if (topic == "stats/") continue;
    taken.topics.insert(topic);
    if (taken.first_ns == 0) taken.first_ns = record.time_ns();
    taken.last_ns = record.time_ns();
    if (topic.starts_with("body/")) {
      v1::Body body;
      EXPECT_TRUE(body.ParseFromString(record.published().payload()));
      EXPECT_EQ(topic, "body/" + body.performer() + "/");
      known.emplace(body.performer(), body.hash());
      taken.bodies.insert(record.published().payload());
      continue;
    }
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(record.published().payload()));
    taken.without_body += known.contains({frame.performer(), frame.body_hash()}) ? 0 : 1;
    EXPECT_TRUE(
        taken.frames[topic]
            .emplace(std::pair(frame.epoch(), frame.sequence()), record.published().payload())
            .second)
        << "twice";
    taken.times_ns[topic].push_back(record.time_ns());
    const auto [before, first] = last.emplace(topic, frame.sequence());
    EXPECT_TRUE(first || frame.sequence() > before->second) << "in order";
    if (!first) taken.missed += frame.sequence() - before->second - 1;
    before->second = frame.sequence();
  }
  EXPECT_EQ(recording::DamageText(reader.value()->counts()), "");
  return taken;
}

std::int64_t UnixNow_ns() { return recording::BeginningNow("", "").created_unix_ns(); }

class NatsRecordingTest : public OnNatsServers {
 protected:
  void SetUp() override {
    OnNatsServers::SetUp();
    if (!IsSkipped()) servers_.StartRec();
  }
  // stylerec, as a user of the recording server.
  Outcome Stylerec(const std::string& user, std::vector<std::string> arguments,
                   const std::string& port = "") {
    const std::string login = folder_ / ("login-" + user);
    WriteText(login, user + "\n" + user + "word\n");
    chmod(login.c_str(), 0600);
    arguments.insert(arguments.end(),
                     {"--nats-login", login, "--nats",
                      "nats://127.0.0.1:" + (port.empty() ? servers_.rec_port : port)});
    const std::atomic<bool> stop{false};
    std::ostringstream out, err;
    const int code = rec::Run(std::move(arguments), stop, out, err);
    return {code, out.str(), err.str()};
  }
  void Create(const std::vector<std::string>& more = {"--max-gb", "0.5"}) {
    std::vector<std::string> arguments{"jetstream", "create"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome made = Stylerec("operator", arguments);
    ASSERT_EQ(made.code, 0) << made.err << servers_.Log();
  }
  std::uint64_t RecordedMessages() {
    const Outcome status = Stylerec("viewer", {"jetstream", "status"});
    const std::size_t at = status.out.find(" GB, ");
    return at == std::string::npos ? 0 : std::stoull(status.out.substr(at + 5));
  }
  TemporaryFolder folder_;
};

TEST_F(NatsRecordingTest, TwoSitesSurviveAKilledServerBitByBit) {
  Create();
  Daemon hall, studio;
  TemporaryFolder apart;
  const Stylenats hall_bridge(hall, servers_.leaf_port);
  const Stylenats studio_bridge("bridge", servers_.leaf_port, studio.publish, studio.control,
                                {"--domain", "hub"}, "studio");
  NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  std::atomic<bool> stop{false};
  const std::string beside = folder_ / "beside.styrec";
  std::ostringstream ignored;
  std::jthread tap([&] {
    rec::Run({"record", "--from", hall.publish, beside}, stop, ignored, ignored);
  });
  std::int64_t middle_ns = 0;
  {
    const Walker walker(hall, {"a", "b"});
    const Walker other(studio, {"c"});
    ASSERT_TRUE(viewer.WaitFor(60, "styled.hall.rig=2Eb.canonical", 30)) << servers_.Log();
    ASSERT_TRUE(viewer.WaitFor(60, "styled.studio.rig=2Ec.rig", 30)) << studio_bridge.Log();
    middle_ns = UnixNow_ns();
    servers_.rec->Signal(SIGKILL);
    ASSERT_TRUE(servers_.rec->Wait(5));
    Sleep(0.3);
    servers_.StartRec();
    const std::uint64_t before = RecordedMessages();
    EXPECT_GT(before, 200U) << "on the disk";
    ASSERT_TRUE(WaitUntil([&] { return RecordedMessages() > before + 400; }, 20)) << servers_.Log();
  }
  Sleep(0.3);
  stop = true;
  tap.join();

  const std::string file = folder_ / "hall.styrec";
  const Outcome fetched = Stylerec("viewer", {"fetch", "--site", "hall", file});
  ASSERT_EQ(fetched.code, 0) << fetched.err << servers_.Log();
  std::cout << fetched.out;
  const Contents original = Read(beside), taken = Read(file);
  EXPECT_THAT(taken.topics,
              testing::UnorderedElementsAre("body/rig.a/", "body/rig.b/", "styled/rig.a/rig/",
                                            "styled/rig.b/rig/", "styled/rig.a/canonical/",
                                            "styled/rig.b/canonical/"));
  std::size_t compared = 0;
  for (const auto& [topic, frames] : taken.frames) {
    const auto& all = original.frames.at(topic);
    for (const auto& [place, bytes] : frames) {
      const auto same = all.find(place);
      ASSERT_NE(same, all.end()) << topic << place.second;
      ASSERT_EQ(bytes, same->second) << "the daemon's bytes";
      ++compared;
    }
    EXPECT_GE(frames.rbegin()->first.second + 5, all.rbegin()->first.second) << "to the end";
  }
  EXPECT_GE(compared, 400U);
  for (const std::string& body : taken.bodies) EXPECT_TRUE(original.bodies.contains(body));
  EXPECT_EQ(taken.bodies.size(), 4U);
  EXPECT_EQ(taken.without_body, 0U);
  EXPECT_GT(taken.missed, 10U) << "while the server was away";
  EXPECT_THAT(fetched.out, HasSubstr("frames=" + std::to_string(compared) + " "));
  EXPECT_THAT(fetched.out, HasSubstr(" missed=" + std::to_string(taken.missed) + " restarts=0 "));

  // The other site only; a performer's motion comes out of it.
  const std::string studio_file = folder_ / "studio.styrec", bvh = folder_ / "c.bvh";
  const Outcome second = Stylerec("operator", {"fetch", "--site", "studio", studio_file});
  ASSERT_EQ(second.code, 0) << second.err;
  EXPECT_THAT(
      Read(studio_file).topics,
      testing::UnorderedElementsAre("body/rig.c/", "styled/rig.c/rig/", "styled/rig.c/canonical/"));
  std::ostringstream out, err;
  EXPECT_EQ(rec::Run({"export", studio_file, "--performer", "rig.c", "--out", bvh},
                     std::atomic<bool>(false), out, err),
            0)
      << err.str();

  // A span that begins between two repetitions of the bodies has them nevertheless.
  const std::string part = folder_ / "part.styrec";
  constexpr std::int64_t kMillisecond_ns = 1'000'000;  // of TimeText
  middle_ns -= middle_ns % kMillisecond_ns;
  const std::int64_t from_ns = middle_ns - 700 * kMillisecond_ns;
  const Outcome span =
      Stylerec("viewer", {"fetch", "--site", "hall", "--performer", "rig.b", "--from",
                          rec::TimeText(from_ns), "--to", rec::TimeText(middle_ns), part});
  ASSERT_EQ(span.code, 0) << span.err;
  const Contents some = Read(part);
  EXPECT_EQ(some.without_body, 0U);
  EXPECT_THAT(some.topics, testing::UnorderedElementsAre("body/rig.b/", "styled/rig.b/rig/",
                                                         "styled/rig.b/canonical/"));
  EXPECT_GE(some.first_ns, from_ns);
  EXPECT_LE(some.last_ns, middle_ns);
  const auto& times_ns = taken.times_ns.at("styled/rig.b/rig/");
  const auto within = std::count_if(times_ns.begin(), times_ns.end(), [&](std::int64_t time_ns) {
    return time_ns >= from_ns && time_ns <= middle_ns;
  });
  EXPECT_EQ(some.frames.at("styled/rig.b/rig/").size(), static_cast<std::size_t>(within));
  const Outcome again = Stylerec("viewer", {"fetch", "--site", "hall", part});
  EXPECT_THAT(again.err, HasSubstr("part.styrec: exists already"));

  const Outcome status = Stylerec("viewer", {"jetstream", "status"});
  EXPECT_THAT(status.out, HasSubstr("streams: rig, canonical\n"));
  EXPECT_THAT(status.out, HasSubstr("\nhall rig.b: canonical "));
  EXPECT_THAT(status.out, HasSubstr("\nstudio rig.c: canonical "));
  EXPECT_EQ(status.out.find("canonical30"), std::string::npos) << "not the audience tier";
}

// Messages of a user who may publish, numbered like frames.
void Publish(NatsUser& user, std::uint64_t from, std::uint64_t to, std::size_t size) {
  const std::string payload(size, 'x');
  for (std::uint64_t i = from; i <= to; ++i) {
    natsMsg* message = nullptr;
    ASSERT_EQ(natsMsg_Create(&message, "styled.hall.rig=2Ea.rig", nullptr, payload.data(),
                             static_cast<int>(payload.size())),
              NATS_OK);
    natsMsgHeader_Set(message, "Styled-Epoch", "7");
    natsMsgHeader_Set(message, "Styled-Sequence", std::to_string(i).c_str());
    EXPECT_EQ(natsConnection_PublishMsg(user.get(), message), NATS_OK);
    natsMsg_Destroy(message);
    // As a bridge at some thousand a second: the hub closes one that sends all at once.
    if (i % 200 == 0) ASSERT_EQ(natsConnection_Flush(user.get()), NATS_OK);
  }
  ASSERT_EQ(natsConnection_Flush(user.get()), NATS_OK);
}

TEST_F(NatsRecordingTest, TheOldestGoFirstByBytesAndByAge) {
  Create({"--max-gb", "0.002"});
  NatsUser bridge(servers_.hub_port, "bridge");
  Publish(bridge, 1, 3000, 1000);
  const std::string file = folder_ / "tail.styrec";
  ASSERT_TRUE(WaitUntil([&] { return RecordedMessages() > 1500; }, 10));
  Sleep(0.5);  // until the last have arrived
  ASSERT_EQ(Stylerec("viewer", {"fetch", "--site", "hall", file}).code, 0);
  auto reader = recording::Reader::Open(file);
  ASSERT_TRUE(reader.ok());
  std::size_t count = 0;
  for (recording::Record record; reader.value()->Next(record);) ++count;
  EXPECT_GT(count, 1500U) << "of 2 MB";
  EXPECT_LT(count, 2000U);
  // Without a gap, and to the newest.
  const Outcome again = Stylerec("viewer", {"fetch", "--site", "hall", folder_ / "again.styrec"});
  EXPECT_THAT(again.out, HasSubstr("frames=" + std::to_string(count) + " bodies=0 missed=0 "));
  const Outcome changed = Stylerec("operator", {"jetstream", "create", "--max-gb", "0.002",
                                                "--max-hours", "0.0003", "--streams", "rig"});
  EXPECT_THAT(changed.out, HasSubstr("limits changed")) << changed.err;
  EXPECT_TRUE(WaitUntil(
      [&] {
        const Outcome status = Stylerec("viewer", {"jetstream", "status"});
        return status.out.find(
                   "streams: rig\nsize: 0 of 0.002 GB, 0 messages\nage: at most 0.0003 h\n") == 0;
      },
      6));
  const Outcome nothing = Stylerec("viewer", {"fetch", "--site", "hall", folder_ / "0.styrec"});
  EXPECT_EQ(nothing.code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("nothing of site hall"));
  EXPECT_THAT(nothing.err, HasSubstr("the recording is empty"));
}

// Messages of 60 kB: more than a broker lets wait for one client.
TEST_F(NatsRecordingTest, LargeMessagesComeInPortions) {
  Create();
  NatsUser bridge(servers_.hub_port, "bridge");
  for (std::uint64_t i = 1; i <= 400; i += 20) {
    Publish(bridge, i, i + 19, 60'000);
    Sleep(0.03);  // less than the hub lets wait for the recording server
  }
  const std::string file = folder_ / "large.styrec";
  Outcome fetched;
  EXPECT_TRUE(WaitUntil(
      [&] {
        std::filesystem::remove(file);
        fetched = Stylerec("viewer", {"fetch", "--site", "hall", file});
        return fetched.out.find("frames=400 bodies=0 missed=0 ") != std::string::npos;
      },
      10))
      << fetched.out << fetched.err << servers_.Log();
  const Outcome elsewhere =
      Stylerec("viewer", {"fetch", "--site", "hal", folder_ / "elsewhere.styrec"});
  EXPECT_THAT(elsewhere.err, HasSubstr("nothing of site hal"));
  EXPECT_THAT(elsewhere.err, HasSubstr(" and has hall rig.a\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "elsewhere.styrec"));
}

// As a server whose disk is full or stands still. Frames of 16 kB fill the kernel's buffers soon.
TEST_F(NatsRecordingTest, AServerThatStandsStillTakesNothingFromViewers) {
  Create();
  Daemon hall;
  NatsUser viewer(servers_.hub_port, "viewer", "styled.hall.*.rig");
  const Stylenats bridge(hall, servers_.leaf_port);
  const Walker walker(hall, {"a", "b"}, 15000);
  ASSERT_TRUE(viewer.WaitFor(60, "", 30)) << bridge.Log() << servers_.Log();
  ASSERT_TRUE(WaitUntil([this] { return RecordedMessages() > 100; }, 10));
  servers_.rec->Signal(SIGSTOP);
  viewer.Clear();
  ASSERT_TRUE(WaitUntil(
      [this] { return servers_.Log().find("Slow Consumer Detected") != std::string::npos; }, 20))
      << "the hub closes it";
  ASSERT_TRUE(viewer.WaitFor(viewer.Size() + 240, "", 10)) << "and goes on";
  std::chrono::duration<double> longest{};
  const auto heard = viewer.All();
  for (std::size_t i = 1; i < heard.size(); ++i) {
    longest = std::max<std::chrono::duration<double>>(longest, heard[i].at - heard[i - 1].at);
  }
  std::cout << heard.size() << " frames, longest pause " << longest.count() << " s\n";
  EXPECT_LT(longest.count(), 1.0) << "a hub that waits is silent for seconds";
  EXPECT_EQ(bridge.Count("slow calls,"), 0) << bridge.Counters();
  servers_.rec->Signal(SIGCONT);
  const std::uint64_t before = RecordedMessages();
  EXPECT_TRUE(WaitUntil([&] { return RecordedMessages() > before + 200; }, 20)) << servers_.Log();
}

TEST_F(NatsRecordingTest, AViewerReadsAndOnlyAnOperatorBeginsAndDeletes) {
  const Outcome none = Stylerec("viewer", {"fetch", "--site", "hall", folder_ / "0.styrec"});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("`stylerec jetstream create` begins one"));
  Create();
  const Outcome refused = Stylerec("viewer", {"jetstream", "delete", "--yes"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("ermissions Violation"));
  EXPECT_THAT(refused.err, HasSubstr("expected the login of a user with that permission"));
  // Without the wait for an answer that does not come.
  const auto asks = [](NatsUser& user, const std::string& subject) {
    natsMsg* answer = nullptr;
    natsConnection_RequestString(&answer, user.get(), subject.c_str(), "", 300);
    const bool answered = answer != nullptr && !natsMsg_IsNoResponders(answer);
    natsMsg_Destroy(answer);
    return answered;
  };
  NatsUser viewer(servers_.rec_port, "viewer");
  for (const char* what : {"UPDATE", "DELETE"}) {
    EXPECT_FALSE(asks(viewer, std::string("$JS.API.STREAM.") + what + ".STYLED_REC")) << what;
    // Nor does a login of the hub, or of a site, reach that server.
    for (const auto& [port, who] : {std::pair{servers_.hub_port, "bridge"},
                                    {servers_.hub_port, "operator"},
                                    {servers_.leaf_port, "bridge"}}) {
      NatsUser user(port, who);
      EXPECT_FALSE(asks(user, std::string("$JS.rec.API.STREAM.") + what + ".STYLED_REC")) << who;
    }
  }
  EXPECT_TRUE(asks(viewer, "$JS.API.STREAM.INFO.STYLED_REC")) << "it is still there";
  EXPECT_EQ(Stylerec("operator", {"jetstream", "delete"}).code, 2) << "--yes is missing";
  EXPECT_EQ(Stylerec("operator", {"jetstream", "delete", "--yes"}).code, 0);
  EXPECT_EQ(Stylerec("operator", {"jetstream", "status"}).code, 1);
}

TEST_F(NatsRecordingTest, MissingFramesAreReported) {
  const Outcome large = Stylerec("operator", {"jetstream", "create", "--max-gb", "100000"});
  EXPECT_EQ(large.code, 1);
  EXPECT_THAT(large.err, HasSubstr("expected fewer --max-gb, or more max_file"));
  const Outcome guest = Stylerec("guest", {"jetstream", "status"});
  EXPECT_EQ(guest.code, 1);
  EXPECT_THAT(guest.err, HasSubstr("refuses the connection"));
  const std::string port = FreePort();
  const Outcome away = Stylerec("viewer", {"jetstream", "status"}, port);
  EXPECT_EQ(away.code, 1);
  EXPECT_THAT(away.err, HasSubstr("no broker answers at nats://127.0.0.1:" + port));
  Child plain({NATS_SERVER, "-a", "127.0.0.1", "-p", port}, folder_ / "plain.log");
  Outcome without;
  EXPECT_TRUE(WaitUntil(
      [&] {
        without = Stylerec("viewer", {"jetstream", "status"}, port);
        return without.err.find("no JetStream answers") != std::string::npos;
      },
      10))
      << without.err;
  EXPECT_THAT(without.err, HasSubstr("--domain NAME"));
  EXPECT_EQ(Stylerec("operator", {"jetstream", "create", "--streams", "canonical30"}).code, 2);
}

}  // namespace
}  // namespace styled::support
