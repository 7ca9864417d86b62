#include "sim/player/stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "model/base/crc32c.h"
#include "tests/unit/sim/fakes.h"

namespace styled::player {
namespace {

using native::DecodeResult;
using testing::FakeLink;
using testing::FakeMotion;
using testing::Received;

struct Played {
  FakeLink link;
  std::vector<Received> received;
  faults::Counts faults{};
  StreamCounts counts;

  std::uint64_t fault(faults::Fault fault) const { return faults[static_cast<std::size_t>(fault)]; }
  std::uint64_t frames() const {
    return static_cast<std::uint64_t>(std::count_if(
        received.begin(), received.end(), [](const Received& r) { return r.is_frame(); }));
  }
};

Played Play(int frames, std::string_view spec = "", int parts = 1, double rate_hz = 120) {
  const auto parsed = faults::Parse(spec);
  EXPECT_TRUE(parsed.ok());
  std::uint64_t next_session = 100;
  Stream stream({"amy", rate_hz, [&next_session] { return next_session++; }},
                std::make_unique<FakeMotion>(frames, parts), faults::Faults(parsed.value()));
  Played played;
  Stream::Step step{};
  while ((step = stream.Tick(played.link)) != Stream::Step::kEnd) {
    EXPECT_NE(step, Stream::Step::kError);
  }
  EXPECT_TRUE(stream.Flush(played.link).ok());
  played.received = testing::Receive(played.link);
  played.faults = stream.faults().counts();
  played.counts = stream.counts();
  return played;
}

TEST(Stream, SendsTheBodyFirstAndAgainOnceASecond) {
  const Played played = Play(300);
  ASSERT_EQ(played.received.size(), 303U);
  for (std::size_t i = 0; i < played.received.size(); ++i) {
    EXPECT_EQ(played.received[i].is_body(), i % 121 == 0) << i;
    EXPECT_EQ(played.received[i].header.sequence, i);
    EXPECT_EQ(played.received[i].header.session, 100U);
  }
  EXPECT_EQ(played.counts.frames, 300U);
  EXPECT_EQ(played.counts.bodies, 3U);
  EXPECT_EQ(played.counts.datagrams, 303U);
  EXPECT_EQ(played.counts.sessions, 1U);
}

TEST(Stream, DescribesTheSkeletonAndPointsEachFrameToIt) {
  const Played played = Play(2);
  const v1::Body& body = played.received[0].body;
  EXPECT_EQ(body.performer(), "amy");
  ASSERT_EQ(body.names_size(), 2);
  EXPECT_EQ(body.names(1), "tip");
  EXPECT_EQ(body.parents(0), -1);
  EXPECT_EQ(body.parents(1), 0);
  ASSERT_EQ(body.offsets_size(), 6);
  EXPECT_EQ(body.offsets(4), 0.5F);
  EXPECT_EQ(body.rest_size(), 0);
  EXPECT_EQ(body.dialect(), "fake");
  const v1::SourceFrame& frame = played.received[2].frame;
  EXPECT_EQ(frame.performer(), "amy");
  EXPECT_EQ(frame.root_position(0), 1.0F);
  ASSERT_EQ(frame.rotations_size(), 8);
  EXPECT_EQ(frame.rotations(3), 1.0F);
  EXPECT_EQ(frame.body_crc(), Crc32c(played.received[0].header.payload));
}

TEST(Stream, TakesSourceTimeFromTheFrameIndexWithoutDrift) {
  const Played played = Play(1000, "", 1, 119.88);
  std::uint64_t index = 0;
  for (const Received& r : played.received) {
    if (!r.is_frame()) continue;
    EXPECT_EQ(r.frame.source_time_ns(),
              static_cast<std::uint64_t>(std::llround(static_cast<double>(index) * 1e9 / 119.88)));
    ++index;
  }
}

TEST(Stream, BeginsASessionAfterSilenceWhenTheBodyChanges) {
  const Played played = Play(50, "", 3);
  std::set<std::uint64_t> sessions;
  for (const Received& r : played.received) {
    if (sessions.insert(r.header.session).second) {
      EXPECT_TRUE(r.is_body());
      EXPECT_EQ(r.header.sequence, 0U);
    }
    if (r.is_frame() && r.header.sequence == 1) {
      EXPECT_EQ(r.frame.source_time_ns(), 0U);
    }
  }
  EXPECT_EQ(sessions.size(), 3U);
  EXPECT_EQ(played.counts.sessions, 3U);
  EXPECT_EQ(played.frames(), 150U);
}

TEST(Stream, IsSilentBetweenTwoSessionsForThePauseOfItsSpec) {
  Stream stream({"amy", 100, [] { return 1; }}, std::make_unique<FakeMotion>(1, 2),
                faults::Faults(faults::Parse("restart-pause-ms=150").value()));
  FakeLink link;
  EXPECT_EQ(stream.Tick(link), Stream::Step::kSent);
  int silent = 0;
  while (stream.Tick(link) == Stream::Step::kSilent) ++silent;
  EXPECT_EQ(silent, 15);
}

TEST(Stream, EachFaultAloneDoesWhatItSays) {
  using faults::Fault;
  constexpr std::uint64_t kFrames = 3000;
  const auto count = [](const Played& p, DecodeResult result) {
    return static_cast<std::uint64_t>(
        std::count_if(p.received.begin(), p.received.end(),
                      [result](const Received& r) { return r.result == result; }));
  };
  const Played loss = Play(kFrames, "loss=0.1");
  EXPECT_GT(loss.fault(Fault::kLoss), 200U);
  EXPECT_EQ(loss.frames(), kFrames - loss.fault(Fault::kLoss));

  const Played duplicate = Play(kFrames, "duplicate=0.1");
  EXPECT_EQ(duplicate.frames(), kFrames + duplicate.fault(Fault::kDuplicate));

  const Played corrupt = Play(kFrames, "corrupt=0.1");
  EXPECT_EQ(count(corrupt, DecodeResult::kBadChecksum), corrupt.fault(Fault::kCorrupt));
  EXPECT_EQ(corrupt.frames(), kFrames - corrupt.fault(Fault::kCorrupt));

  const Played truncate = Play(kFrames, "truncate=0.1");
  EXPECT_EQ(count(truncate, DecodeResult::kLengthMismatch), truncate.fault(Fault::kTruncate));

  for (const auto& [spec, fault] :
       {std::pair{"reorder=0.1", Fault::kReorder}, {"late=0.1", Fault::kLate}}) {
    const Played behind = Play(kFrames, spec);
    EXPECT_EQ(behind.frames(), kFrames);
    std::uint64_t overtaken = 0;
    std::uint64_t newest = 0;
    for (const Received& r : behind.received) {
      overtaken += r.header.sequence < newest;
      newest = std::max(newest, r.header.sequence);
    }
    // Of the very last frames nothing newer is sent.
    EXPECT_NEAR(static_cast<double>(overtaken), static_cast<double>(behind.fault(fault)), 3);
  }

  const Played restart = Play(kFrames, "restart=0.002");
  EXPECT_GT(restart.fault(Fault::kRestart), 0U);
  EXPECT_EQ(restart.counts.sessions, 1 + restart.fault(Fault::kRestart));
  EXPECT_EQ(restart.frames(), kFrames - restart.fault(Fault::kRestart));
}

TEST(Stream, SpoilsOneJointOfAFrameOrSendsFarTooMany) {
  using faults::Fault;
  const Played played = Play(2000, "nan=0.1,oversized=0.02");
  std::uint64_t spoiled = 0, oversized = 0;
  for (std::size_t i = 0; i < played.received.size(); ++i) {
    const Received& r = played.received[i];
    if (!r.is_frame()) continue;
    if (r.frame.rotations_size() > 8) {
      ++oversized;
      EXPECT_GT(played.link.sent[i].size(), 65000U);
      continue;
    }
    int bad = 0;
    for (int joint = 0; joint < 2; ++joint) {
      const float w = r.frame.rotations(4 * joint + 3);
      bad += !std::isfinite(w) || w == 0;
    }
    EXPECT_LE(bad, 1);
    spoiled += static_cast<std::uint64_t>(bad);
  }
  EXPECT_EQ(spoiled, played.fault(Fault::kNan));
  EXPECT_EQ(oversized, played.fault(Fault::kOversized));
  EXPECT_GT(oversized, 0U);
}

TEST(Stream, SendsABurstAtOnceAndInOrder) {
  Stream stream({"amy", 10, [] { return 1; }}, std::make_unique<FakeMotion>(300),
                faults::Faults(faults::Parse("burst=0.05,burst-frames=6").value()));
  FakeLink link;
  std::uint64_t held_ticks = 0, bursts = 0, frames = 0;
  while (stream.Tick(link) == Stream::Step::kSent) {
    std::uint64_t sent = 0;
    for (const Received& r : testing::Receive(link)) {
      EXPECT_EQ(r.header.sequence, frames + sent++);  // bodies keep their place among the frames
    }
    frames += sent;
    link.sent.clear();
    if (sent == 0) ++held_ticks;
    if (sent > 2) {
      ++bursts;
      EXPECT_GE(held_ticks, 4U);  // five, or four where a body left with the first of them
      held_ticks = 0;
      EXPECT_GE(sent, 6U);  // and a body where a second ended within
      EXPECT_LE(sent, 7U);
    }
  }
  ASSERT_TRUE(stream.Flush(link).ok());
  frames += link.sent.size();
  EXPECT_EQ(frames, 300 + stream.counts().bodies);
  EXPECT_GT(bursts, 3U);
  const std::uint64_t drawn = stream.faults().counts()[std::size_t(faults::Fault::kBurst)];
  EXPECT_LE(bursts, drawn);
  EXPECT_GE(bursts + 1, drawn);  // the last may be cut by the end
}

TEST(Stream, ClockDriftsAndStepsInSourceTime) {
  using faults::Fault;
  const Played drifting = Play(1200, "drift-ppm=200");
  std::uint64_t index = 0;
  for (const Received& r : drifting.received) {
    if (!r.is_frame()) continue;
    const double expected_ns = static_cast<double>(index++) * 1e9 / 120 * 1.0002;
    EXPECT_NEAR(static_cast<double>(r.frame.source_time_ns()), expected_ns, 2);
  }
  EXPECT_EQ(index, 1200U);
  for (const auto& [spec, step_s] :
       {std::pair{"step=0.01", 1.0}, {"step=0.01,step-s=-0.5", -0.5}}) {
    const Played stepping = Play(3000, spec);
    std::uint64_t steps = 0, to_zero = 0;
    double last_s = -1.0 / 120;
    for (const Received& r : stepping.received) {
      if (!r.is_frame()) continue;
      const double time_s = static_cast<double>(r.frame.source_time_ns()) * 1e-9;
      const double jump_s = time_s - last_s - 1.0 / 120;
      last_s = time_s;
      if (std::abs(jump_s) < 1e-6) continue;
      ++steps;
      if (time_s == 0) {
        ++to_zero;
        EXPECT_GE(jump_s, step_s);
      } else {
        EXPECT_NEAR(jump_s, step_s, 1e-6);
      }
    }
    EXPECT_EQ(steps, stepping.fault(Fault::kStep));
    EXPECT_GT(steps, 10U);
    EXPECT_LT(to_zero, steps);
  }
}

TEST(Stream, OccludesOneJointForItsFrames) {
  using faults::Fault;
  const Played played = Play(2000, "occlude=0.002,occlude-frames=20,seed=2");
  std::uint64_t runs = 0, unseen = 0;
  bool was_unseen = false;
  for (const Received& r : played.received) {
    if (!r.is_frame()) continue;
    EXPECT_TRUE(std::isfinite(r.frame.rotations(3)));  // the root is always seen
    const bool is_unseen = std::isnan(r.frame.rotations(4));
    for (int i = 5; i < 8; ++i) EXPECT_EQ(std::isnan(r.frame.rotations(i)), is_unseen);
    unseen += is_unseen;
    runs += is_unseen && !was_unseen;
    was_unseen = is_unseen;
  }
  const std::uint64_t drawn = played.fault(Fault::kOcclude);
  ASSERT_GT(runs, 0U);
  EXPECT_LE(runs, drawn);
  EXPECT_LE(unseen, 20 * drawn);
  EXPECT_GE(unseen, 20 * runs - 19);  // the last may be cut by the end
}

TEST(Stream, CountsExactlyWithAllFaultsAtOnce) {
  using faults::Fault;
  const Played p = Play(5000,
                        "loss=0.05,duplicate=0.05,reorder=0.05,corrupt=0.05,truncate=0.05,"
                        "nan=0.05,oversized=0.01,restart=0.002,late=0.05,burst=0.02,step=0.01,"
                        "occlude=0.01,jitter-ms=5,drift-ppm=80,seed=9");
  EXPECT_EQ(p.counts.frames, 5000U);
  EXPECT_EQ(p.counts.datagrams, p.received.size());
  EXPECT_EQ(p.frames(), 5000 - p.fault(Fault::kLoss) - p.fault(Fault::kCorrupt) -
                            p.fault(Fault::kTruncate) - p.fault(Fault::kRestart) +
                            p.fault(Fault::kDuplicate));
}

TEST(Stream, StopsWithTheLinksReason) {
  Stream stream({"amy", 120, [] { return 1; }}, std::make_unique<FakeMotion>(1),
                faults::Faults(faults::Spec{}));
  FakeLink link;
  link.fail = true;
  EXPECT_EQ(stream.Tick(link), Stream::Step::kError);
  EXPECT_EQ(stream.error().message(), "no link");
}

TEST(Stream, NamesOfPerformersFollowTheRule) {
  for (const char* good : {"a", "Amy-2_x", "12345678901234567890123456789012"}) {
    EXPECT_TRUE(IsPerformerName(good)) << good;
  }
  for (const char* bad :
       {"", "a.b", "a b", "\xC3\xA4", "123456789012345678901234567890123", "a/"}) {
    EXPECT_FALSE(IsPerformerName(bad)) << bad;
  }
}

}  // namespace
}  // namespace styled::player
