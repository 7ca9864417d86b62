#include "clients/nats/frame_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <thread>

namespace styled::stylenats {
namespace {

using namespace std::chrono_literals;
using Pushed = FrameQueue::Pushed;

constexpr FrameQueue::Clock::time_point kStart{};

std::optional<QueuedFrame> Next(FrameQueue& queue) {
  QueuedFrame frame;
  if (!queue.Pop(frame, {}, 0ms)) return std::nullopt;
  return frame;
}

TEST(FrameQueue, RefusesANewStreamWhileAllSlotsAreInUse) {
  FrameQueue queue("s", {.slots = 2, .bytes = 1000, .idle = 10s});
  EXPECT_EQ(queue.Push("a.a", "rig", "1", 1, 1, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.b", "rig", "1", 1, 1, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.c", "rig", "1", 1, 1, kStart + 60s), Pushed::kRefused) << "they wait";
  Next(queue), Next(queue);
  EXPECT_EQ(queue.Push("a.c", "rig", "1", 1, 1, kStart + 9s), Pushed::kRefused) << "in use";
  EXPECT_EQ(queue.Push("a.b", "rig", "2", 1, 2, kStart + 9s), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.c", "rig", "1", 1, 1, kStart + 10s), Pushed::kQueued) << "a.a's slot";
  EXPECT_EQ(queue.Push("a.a", "rig", "1", 1, 2, kStart + 10s), Pushed::kRefused);
  EXPECT_EQ(queue.counts().refused, 3U);
  EXPECT_EQ(queue.waiting(), 2U);
}

TEST(FrameQueue, RefusesWhatExceedsItsBytes) {
  FrameQueue queue("s", {.slots = 10, .bytes = 10, .idle = 10s, .depth = 1});
  EXPECT_EQ(queue.Push("a.a", "rig", "12345678", 1, 1, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.b", "rig", "123", 1, 1, kStart), Pushed::kRefused);
  EXPECT_EQ(queue.Push("a.a", "rig", "1234567890", 1, 2, kStart), Pushed::kReplaced);
  EXPECT_EQ(queue.Push("a.a", "rig", "12345678901", 1, 3, kStart), Pushed::kRefused);
  EXPECT_EQ(Next(queue)->payload, "1234567890");
  EXPECT_EQ(queue.Push("a.b", "rig", "1234567890", 1, 1, kStart), Pushed::kQueued);
}

// Whatever names come: no more frames wait than there are slots, and the rest is counted.
TEST(FrameQueue, StaysBoundedWhileNamesAreMadeUp) {
  FrameQueue queue("s", {.slots = 64, .bytes = 100000, .idle = 1s});
  std::mt19937 random(3);
  auto now = kStart;
  for (int i = 0; i < 20000; ++i, now += 1ms) {
    queue.Push("rig." + std::to_string(random()), "rig", "payload", 1, 1, now);
    ASSERT_LE(queue.waiting(), 64U);
    if (random() % 3 == 0) Next(queue);
  }
  const auto counts = queue.counts();
  EXPECT_EQ(counts.pushed, 20000U);
  EXPECT_GT(counts.refused, 15000U);
  EXPECT_LT(counts.refused, 20000U - 64U) << "idle slots are used again";
}

// A machine that stands still for a moment loses none.
TEST(FrameQueue, AFewFramesOfAStreamWaitInOrder) {
  FrameQueue queue("s");
  queue.Push("a.a", "rig", "1", 7, 1);
  queue.Push("a.b", "rig", "b", 7, 1);
  for (int i = 2; i <= 6; ++i) {
    EXPECT_EQ(queue.Push("a.a", "rig", std::to_string(i), 7, static_cast<std::uint64_t>(i)),
              i <= 4 ? Pushed::kQueued : Pushed::kReplaced);
  }
  EXPECT_EQ(queue.waiting(), 5U);
  std::string came;
  while (const auto frame = Next(queue)) came += frame->payload;
  EXPECT_EQ(came, "b3456") << "the oldest gave way";
  EXPECT_EQ(queue.counts().replaced, 2U);
}

TEST(FrameQueue, TheNewestWinsAndComesInItsTurn) {
  FrameQueue queue("s", {.depth = 1});
  queue.Push("a.a", "rig", "a1", 7, 1);
  queue.Push("a.b", "rig", "b1", 7, 1);
  EXPECT_EQ(queue.Push("a.a", "rig", "a2", 7, 2), Pushed::kReplaced);
  EXPECT_EQ(queue.Push("a.a", "canonical", "c2", 7, 2), Pushed::kQueued) << "another stream";
  const auto first = Next(queue), second = Next(queue), third = Next(queue);
  EXPECT_EQ(first->payload, "b1");
  EXPECT_EQ(second->subject, "styled.s.a=2Ea.rig");
  EXPECT_EQ(second->payload, "a2");
  EXPECT_EQ(second->epoch, 7U);
  EXPECT_EQ(second->sequence, 2U);
  EXPECT_EQ(third->payload, "c2");
  EXPECT_FALSE(Next(queue));
  EXPECT_THAT(queue.replaced(), testing::ElementsAre(testing::Pair("styled.s.a=2Ea.rig", 1U)));
}

// A seeded order of pushes and takes against the plain statement of what is to come out.
TEST(FrameQueue, GivesEachStreamsNewestInTheOrderInWhichTheyCame) {
  FrameQueue queue("s", {.depth = 1});
  std::mt19937 random(4);
  std::vector<std::pair<std::string, std::uint64_t>> model;  // performer, its newest sequence
  std::map<std::string, std::uint64_t> sequences, sent;
  std::uint64_t replaced = 0;
  for (int i = 0; i < 50000; ++i) {
    if (random() % 5 < 3) {
      const std::string performer = "rig.p" + std::to_string(random() % 12);
      const std::uint64_t sequence = ++sequences[performer];
      queue.Push(performer, "rig", performer + "/" + std::to_string(sequence), 1, sequence);
      const auto waiting = std::find_if(model.begin(), model.end(),
                                        [&](const auto& row) { return row.first == performer; });
      if (waiting != model.end()) {
        model.erase(waiting);
        ++replaced;
      }
      model.emplace_back(performer, sequence);
    } else {
      const auto frame = Next(queue);
      ASSERT_EQ(frame.has_value(), !model.empty());
      if (!frame) continue;
      const auto [performer, sequence] = model.front();
      model.erase(model.begin());
      ASSERT_EQ(frame->payload, performer + "/" + std::to_string(sequence));
      ASSERT_GT(sequence, sent[performer]) << "in order";
      sent[performer] = sequence;
    }
  }
  EXPECT_EQ(queue.counts().replaced, replaced);
  EXPECT_GT(replaced, 1000U);
}

TEST(FrameQueue, WakesTheThreadThatWaits) {
  FrameQueue queue("s");
  QueuedFrame frame;
  std::jthread taker(
      [&](const std::stop_token& stop) { EXPECT_TRUE(queue.Pop(frame, stop, 20s)); });
  queue.Push("a.a", "rig", "1", 1, 1);
  taker.join();
  EXPECT_EQ(frame.payload, "1");
  std::jthread stopped(
      [&](const std::stop_token& stop) { EXPECT_FALSE(queue.Pop(frame, stop, 20s)); });
  stopped.request_stop();
}

TEST(AudienceTier, TakesTheFirstAndEveryFourthFrameOfEachPerformer) {
  AudienceTier tier;
  std::vector<int> taken;
  for (int i = 0; i < 12; ++i) {
    if (tier.Picks("rig.a")) taken.push_back(i);
    if (i == 5) {
      EXPECT_TRUE(tier.Picks("rig.b")) << "a count of their own";
    }
  }
  EXPECT_THAT(taken, testing::ElementsAre(0, 4, 8));
}

TEST(AudienceTier, IsBounded) {
  AudienceTier tier;
  for (std::size_t i = 0; i < AudienceTier::kMaxPerformers; ++i) {
    EXPECT_TRUE(tier.Picks("rig.p" + std::to_string(i)));
  }
  EXPECT_FALSE(tier.Picks("rig.p0"));
  EXPECT_TRUE(tier.Picks("rig.one_more"));
  EXPECT_TRUE(tier.Picks("rig.p0")) << "the counts began anew";
}

TEST(FrameQueue, ABodyHasAPlaceOfItsOwnBeforeItsFrame) {
  FrameQueue queue("hall.1");
  EXPECT_EQ(queue.PushBody("rig.a", "canonical", "body"), Pushed::kQueued);
  EXPECT_EQ(queue.Push("rig.a", "canonical", "frame", 1, 2), Pushed::kQueued);
  EXPECT_EQ(queue.PushBody("rig.a", "canonical", "body"), Pushed::kReplaced) << "the same again";
  EXPECT_EQ(queue.PushBody("rig.a", "canonical", "newer"), Pushed::kQueued);
  EXPECT_EQ(queue.counts().replaced, 0U) << "only frames are lost";
  const auto body = Next(queue), frame = Next(queue);
  ASSERT_TRUE(body && frame);
  EXPECT_EQ(body->subject, "styled.hall=2E1.rig=2Ea.canonical.body");
  EXPECT_EQ(body->payload, "body");
  EXPECT_TRUE(body->body);
  EXPECT_EQ(frame->subject, "styled.hall=2E1.rig=2Ea.canonical");
  EXPECT_FALSE(frame->body);
  const auto newer = Next(queue);
  ASSERT_TRUE(newer);
  EXPECT_EQ(newer->payload, "newer");
}

// A frame must not overtake the body that it needs, whatever is dropped.
TEST(FrameQueue, AFrameComesBehindItsBodyWhenOlderOnesGiveWay) {
  FrameQueue queue("s");
  for (int i = 1; i <= 4; ++i) queue.Push("a.a", "rig", "f" + std::to_string(i), 1, 1);
  queue.PushBody("a.a", "rig", "body");
  queue.Push("a.a", "rig", "f5", 1, 5);
  std::string came;
  while (const auto message = Next(queue)) came += message->payload + " ";
  EXPECT_EQ(came, "f2 f3 f4 body f5 ");
}

TEST(FrameQueue, AStreamsOwnFramesGiveWayWhereThereIsNoRoom) {
  FrameQueue queue("s", {.slots = 10, .bytes = 10, .idle = 10s});
  EXPECT_EQ(queue.Push("a.a", "rig", "123", 1, 1, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.b", "rig", "456", 1, 1, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.a", "rig", "789", 1, 2, kStart), Pushed::kQueued);
  EXPECT_EQ(queue.Push("a.a", "rig", "abcdef", 1, 3, kStart), Pushed::kReplaced);
  EXPECT_EQ(queue.counts().replaced, 2U);
  EXPECT_EQ(Next(queue)->payload, "456");
  EXPECT_EQ(Next(queue)->payload, "abcdef");
}

TEST(BodyBeat, IsDueAtFirstOnChangeAndOnceASecond) {
  BodyBeat beat;
  EXPECT_TRUE(beat.IsDue("rig.a", "rig", 5, kStart));
  EXPECT_FALSE(beat.IsDue("rig.a", "rig", 5, kStart + 999ms));
  EXPECT_TRUE(beat.IsDue("rig.a", "canonical", 5, kStart + 999ms)) << "of each stream";
  EXPECT_TRUE(beat.IsDue("rig.a", "rig", 5, kStart + 1000ms));
  EXPECT_TRUE(beat.IsDue("rig.a", "rig", 6, kStart + 1001ms)) << "another body";
  EXPECT_TRUE(beat.IsDue("rig.a", "rig", 5, kStart + 1002ms)) << "and back";
  EXPECT_FALSE(beat.IsDue("rig.a", "rig", 5, kStart + 1003ms));
}

}  // namespace
}  // namespace styled::stylenats
