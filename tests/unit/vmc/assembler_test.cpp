#include "proto/rigs/vmc/assembler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/unit/vmc/bytes.h"

namespace styled::vmc {
namespace {

using testing::ApplyMessage;
using testing::BlendMessage;
using testing::BoneMessage;
using testing::Bundle;
using testing::Bytes;
using testing::OkMessage;
using testing::RootMessage;
using testing::TimeMessage;
using Packets = std::vector<Bytes>;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod_ns = 16 * kMs;
const std::vector<std::string> kNames{"Hips",         "Spine",    "Head",          "LeftUpperLeg",
                                      "LeftLowerLeg", "LeftFoot", "RightUpperLeg", "RightFoot"};

// The habits of senders. Every frame's values carry its number, so that a mix of two shows.
Bytes Number(const std::string& name, int frame) {
  return BoneMessage(name, static_cast<float>(frame));
}
float TimeOf(int frame) { return 10 + 0.016F * static_cast<float>(frame); }

// SlimeVR: one bundle, T first.
Packets TimeFirst(int frame) {
  std::vector<Bytes> messages{TimeMessage(TimeOf(frame)), OkMessage(), RootMessage()};
  for (const auto& name : kNames) messages.push_back(Number(name, frame));
  return {Bundle(messages)};
}
// VirtualMotionCapture: bones, expressions, and the rest of the bones in a bundle within the last.
Packets TimeLast(int frame) {
  std::vector<Bytes> bones[3];
  for (std::size_t i = 0; i < kNames.size(); ++i) bones[i / 3].push_back(Number(kNames[i], frame));
  return {Bundle(bones[0]), Bundle(bones[1]), Bundle({BlendMessage("Joy", 0.5F), ApplyMessage()}),
          Bundle({RootMessage(static_cast<float>(frame)), Bundle(bones[2]), OkMessage(),
                  TimeMessage(TimeOf(frame))})};
}
Packets SinglesTimeLast(int frame) {
  Packets datagrams{RootMessage(static_cast<float>(frame))};
  for (const auto& name : kNames) datagrams.push_back(Number(name, frame));
  datagrams.push_back(TimeMessage(TimeOf(frame)));
  return datagrams;
}
Packets SinglesTimeFirst(int frame) {
  Packets datagrams{TimeMessage(TimeOf(frame)), RootMessage(static_cast<float>(frame))};
  for (const auto& name : kNames) datagrams.push_back(Number(name, frame));
  return datagrams;
}
// OK first, T in the middle, Apply last.
Packets SinglesOkFirst(int frame) {
  Packets datagrams{OkMessage(), RootMessage(static_cast<float>(frame)),
                    TimeMessage(TimeOf(frame))};
  for (const auto& name : kNames) datagrams.push_back(Number(name, frame));
  datagrams.push_back(BlendMessage("A", 1));
  datagrams.push_back(ApplyMessage());
  return datagrams;
}
Packets SinglesWithoutTime(int frame) {
  Packets datagrams{RootMessage(static_cast<float>(frame))};
  for (const auto& name : kNames) datagrams.push_back(Number(name, frame));
  return datagrams;
}
struct Habit {
  std::string name;
  Packets (*send)(int);
};
const std::vector<Habit> kHabits{{"T first in one bundle", TimeFirst},
                                 {"T last of several datagrams", TimeLast},
                                 {"single messages, T last", SinglesTimeLast},
                                 {"single messages, T first", SinglesTimeFirst},
                                 {"single messages, OK first", SinglesOkFirst},
                                 {"single messages without T", SinglesWithoutTime}};

// An assembler, and copies of the frames that came out of it.
class Feed {
 public:
  // All frames that this datagram, arriving then, brings.
  std::vector<Frame> operator()(const Bytes& datagram, std::int64_t now_ns) {
    std::vector<Frame> frames = Until(now_ns);
    const auto bytes = std::make_unique<std::byte[]>(datagram.size());  // ends where it ends
    std::copy(datagram.begin(), datagram.end(), bytes.get());
    result = assembler->Begin({bytes.get(), datagram.size()}, now_ns);
    while (result == osc::Result::kOk && assembler->Next()) frames.push_back(assembler->frame());
    return frames;
  }
  std::vector<Frame> operator()(const Packets& datagrams, std::int64_t now_ns) {
    std::vector<Frame> frames;
    for (const Bytes& datagram : datagrams) {
      for (const Frame& frame : (*this)(datagram, now_ns)) frames.push_back(frame);
    }
    return frames;
  }
  // Frames that time alone completes.
  std::vector<Frame> Until(std::int64_t now_ns) {
    if (!ticks || assembler->deadline_ns() > now_ns) return {};
    if (!assembler->Flush(assembler->deadline_ns())) return {};
    return {assembler->frame()};
  }

  bool ticks = true;
  osc::Result result = osc::Result::kOk;
  std::unique_ptr<Assembler> assembler = std::make_unique<Assembler>();
};

float Value(const Frame& frame, int bone) {
  return frame.transforms[static_cast<std::size_t>(bone)].position[0];
}
// The number that all its bones carry, or -1 where two differ.
int NumberOf(const Frame& frame) {
  float number = -2;
  for (int bone = 0; bone < kBoneCount; ++bone) {
    if (!Has(frame.bones, bone)) continue;
    if (number != -2 && Value(frame, bone) != number) return -1;
    number = Value(frame, bone);
  }
  return static_cast<int>(number);
}
BoneSet Set(const std::vector<std::string>& names) {
  BoneSet set = 0;
  for (const auto& name : names) set |= Bit(FindBone(name, false));
  return set;
}

TEST(Assembler, RefusesWhatIsNotOscAndGoesOn) {
  Feed feed;
  const Bytes whole = TimeFirst(0)[0];
  EXPECT_TRUE(feed(Bytes(whole.begin(), whole.end() - 4), 0).empty());
  EXPECT_EQ(feed.result, osc::Result::kBadElement);
  EXPECT_EQ(feed.assembler->deadline_ns(), Assembler::kNever);
  feed(TimeFirst(0), kPeriod_ns);
  EXPECT_EQ(feed(TimeFirst(1), 2 * kPeriod_ns).size(), 2U);
}

TEST(Assembler, CountsMessagesThatItCannotUse) {
  Feed feed;
  feed(Bundle({testing::S("/VMC/Ext/T") + testing::S(",i") + testing::I(1), BoneMessage("LastBone"),
               BoneMessage("Hip"), TimeMessage(std::nanf("")),
               testing::S("/VMC/Ext/Cam") + testing::S(",")}),
       0);
  EXPECT_EQ(feed.assembler->counts().refused, 4U);
  EXPECT_EQ(feed.assembler->counts().ignored, 1U);
  EXPECT_EQ(feed.assembler->deadline_ns(), Assembler::kNever);
}

TEST(Assembler, TakesTimeAndOkAloneForNoFrame) {
  Feed feed;
  EXPECT_TRUE(feed(Bundle({OkMessage(), TimeMessage(1)}), 0).empty());
  EXPECT_TRUE(feed(Bundle({OkMessage(), TimeMessage(2)}), kPeriod_ns).empty());
  EXPECT_TRUE(feed.Until(2 * kPeriod_ns).empty());
  EXPECT_EQ(feed.assembler->deadline_ns(), Assembler::kNever);
}

TEST(Assembler, GivesEveryFrameOfEveryHabitWholeAndOnce) {
  for (const Habit& habit : kHabits) {
    Feed feed;
    std::vector<Frame> frames;
    for (int i = 0; i < 10; ++i) {
      for (auto& frame : feed(habit.send(i), i * kPeriod_ns)) frames.push_back(frame);
    }
    for (auto& frame : feed.Until(10 * kPeriod_ns)) frames.push_back(frame);
    ASSERT_EQ(frames.size(), 10U) << habit.name;
    for (int i = 0; i < 10; ++i) {
      const Frame& frame = frames[static_cast<std::size_t>(i)];
      EXPECT_EQ(NumberOf(frame), i) << habit.name;
      EXPECT_EQ(frame.bones, Set(kNames)) << habit.name;
      EXPECT_EQ(frame.missing, 0U) << habit.name;
      EXPECT_TRUE(frame.has_root) << habit.name;
      EXPECT_FALSE(frame.restarted) << habit.name;
      EXPECT_EQ(frame.received_ns, i * kPeriod_ns) << habit.name;
      EXPECT_EQ(frame.has_time, habit.send != SinglesWithoutTime) << habit.name;
      if (frame.has_time) {
        EXPECT_EQ(frame.time_s, TimeOf(i)) << habit.name;
      }
    }
  }
}

// The first frame waits for a silence; then the sender's last message is known.
TEST(Assembler, GivesAFrameWithItsLastDatagramFromTheSecondOn) {
  for (const Habit& habit : kHabits) {
    Feed feed;
    feed(habit.send(0), 0);
    for (int i = 1; i < 5; ++i) {
      std::vector<Frame> before = feed.Until(i * kPeriod_ns);
      EXPECT_EQ(before.size(), i == 1 ? 1U : 0U) << habit.name;
      const Packets datagrams = habit.send(i);
      for (std::size_t d = 0; d < datagrams.size(); ++d) {
        EXPECT_EQ(feed(datagrams[d], i * kPeriod_ns).size(), d + 1 == datagrams.size() ? 1U : 0U)
            << habit.name << ", datagram " << d;
      }
    }
  }
}

// A daemon that was late reads all at once: no silence tells anything.
TEST(Assembler, TellsFramesApartThatArriveAtOneTime) {
  for (const Habit& habit : kHabits) {
    if (habit.send == SinglesOkFirst) continue;  // OK alone does not begin a frame
    Feed feed;
    std::vector<Frame> frames;
    for (int i = 0; i < 10; ++i) {
      for (auto& frame : feed(habit.send(i), 0)) frames.push_back(frame);
    }
    for (auto& frame : feed.Until(kPeriod_ns)) frames.push_back(frame);
    ASSERT_EQ(frames.size(), 10U) << habit.name;
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(NumberOf(frames[static_cast<std::size_t>(i)]), i) << habit.name;
    }
  }
}

TEST(Assembler, FindsInStepWhereverItBegins) {
  for (const Habit& habit : kHabits) {
    const std::size_t count = habit.send(0).size();
    for (std::size_t first = 1; first < count; ++first) {
      Feed feed;
      std::vector<Frame> frames;
      for (int i = 0; i < 8; ++i) {
        Packets datagrams = habit.send(i);
        if (i == 0) datagrams.erase(datagrams.begin(), datagrams.begin() + first);
        for (auto& frame : feed(datagrams, i * kPeriod_ns)) frames.push_back(frame);
      }
      for (const Frame& frame : frames) {
        EXPECT_NE(NumberOf(frame), -1) << habit.name << " from datagram " << first;
      }
      EXPECT_EQ(frames.back().bones, Set(kNames)) << habit.name << " from datagram " << first;
      EXPECT_EQ(NumberOf(frames.back()), 7) << habit.name << " from datagram " << first;
    }
  }
}

TEST(Assembler, FindsInStepAgainAfterALostDatagram) {
  for (const Habit& habit : kHabits) {
    const std::size_t count = habit.send(0).size();
    for (std::size_t lost = 0; lost < count; ++lost) {
      Feed feed;
      std::vector<Frame> frames;
      for (int i = 0; i < 8; ++i) {
        Packets datagrams = habit.send(i);
        if (i == 3) datagrams.erase(datagrams.begin() + static_cast<std::ptrdiff_t>(lost));
        for (auto& frame : feed(datagrams, i * kPeriod_ns)) frames.push_back(frame);
      }
      for (const Frame& frame : frames) {
        EXPECT_NE(NumberOf(frame), -1) << habit.name << " without " << lost;
      }
      EXPECT_EQ(NumberOf(frames.back()), 7) << habit.name << " without " << lost;
      EXPECT_EQ(frames.back().bones, Set(kNames)) << habit.name << " without " << lost;
      const auto numbers = [&frames](int number) {
        return std::count_if(frames.begin(), frames.end(),
                             [number](const Frame& f) { return NumberOf(f) == number; });
      };
      for (int i = 4; i < 8; ++i) EXPECT_EQ(numbers(i), 1) << habit.name << " without " << lost;
    }
  }
}

TEST(Assembler, GivesNoFrameTwiceForDatagramsThatCameTwice) {
  for (const Habit& habit : kHabits) {
    if (habit.send == SinglesWithoutTime) continue;  // nothing tells a copy from a frame
    const std::size_t count = habit.send(0).size();
    for (std::size_t twice = 0; twice < count; ++twice) {
      Feed feed;
      std::vector<Frame> frames;
      for (int i = 0; i < 8; ++i) {
        Packets datagrams = habit.send(i);
        if (i == 3)
          datagrams.insert(datagrams.begin() + static_cast<std::ptrdiff_t>(twice),
                           datagrams[twice]);
        for (auto& frame : feed(datagrams, i * kPeriod_ns)) frames.push_back(frame);
      }
      std::vector<int> numbers;
      for (const Frame& frame : frames) {
        if (frame.bones != 0) numbers.push_back(NumberOf(frame));
      }
      EXPECT_THAT(numbers, ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7))
          << habit.name << ", twice " << twice;
    }
  }
}

TEST(Assembler, LearnsAnotherEndWhereTheOldOneNoLongerComes) {
  for (const Habit& habit : kHabits) {
    if (habit.send(0).size() == 1) continue;
    Feed feed;
    std::size_t early = 0;
    for (int i = 0; i < 10; ++i) {
      feed.Until(i * kPeriod_ns);
      Packets datagrams = habit.send(i);
      if (i >= 4) datagrams.pop_back();
      const auto frames = feed(datagrams, i * kPeriod_ns);
      for (const Frame& frame : frames) EXPECT_EQ(NumberOf(frame), i) << habit.name;
      if (i >= 7) early += frames.size();
    }
    EXPECT_EQ(early, 3U) << habit.name;
  }
}

TEST(Assembler, EndsAFrameWhereASecondTimeComes) {
  Feed feed;
  const auto frames = feed(Bundle({TimeMessage(1), BoneMessage("Hips", 1), TimeMessage(2),
                                   BoneMessage("Hips", 2), TimeMessage(3), BoneMessage("Hips", 3)}),
                           0);
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].time_s, static_cast<float>(i + 1));
    EXPECT_EQ(NumberOf(frames[static_cast<std::size_t>(i)]), i + 1);
  }
}

TEST(Assembler, TakesARepeatedBoneInOneDatagramForACorrection) {
  Feed feed;
  EXPECT_TRUE(
      feed(Bundle({TimeMessage(1), BoneMessage("Hips", 1), BoneMessage("Hips", 2), RootMessage(3),
                   RootMessage(4), BlendMessage("Joy", 0), BlendMessage("Joy", 1)}),
           0)
          .empty());
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(NumberOf(frames[0]), 2);
  EXPECT_EQ(frames[0].root.position[0], 4);
  ASSERT_EQ(frames[0].blend_count, 1U);
  EXPECT_EQ(frames[0].blends[0].value, 1);
}

TEST(Assembler, TakesARepeatInALaterDatagramForTheNextFrame) {
  for (const auto& [first, second] : {std::pair{BoneMessage("Hips", 1), BoneMessage("Hips", 2)},
                                      std::pair{RootMessage(1), RootMessage(2)},
                                      std::pair{BlendMessage("Joy", 0), BlendMessage("Joy", 1)}}) {
    Feed feed;
    EXPECT_TRUE(feed(first, 0).empty());
    EXPECT_FALSE(feed(second, 0).empty());
  }
}

// Some send every part of a frame with the frame's T.
TEST(Assembler, TakesPartsWithTheSameTimeForOneFrame) {
  Feed feed;
  EXPECT_TRUE(feed(Bundle({TimeMessage(1), BoneMessage("Hips", 1)}), 0).empty());
  EXPECT_TRUE(feed(Bundle({TimeMessage(1), BoneMessage("Spine", 1)}), 0).empty());
  const auto frames = feed(Bundle({TimeMessage(2), BoneMessage("Hips", 2)}), 0);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].bones, Set({"Hips", "Spine"}));
}

TEST(Assembler, RefusesWhatIsNotLaterThanTheLastFrame) {
  Feed feed;
  feed(TimeFirst(50), 0);
  EXPECT_EQ(feed(TimeFirst(51), kPeriod_ns).size(), 2U);
  EXPECT_TRUE(feed(TimeFirst(51), 2 * kPeriod_ns).empty());
  EXPECT_TRUE(feed(TimeFirst(50), 3 * kPeriod_ns).empty());
  EXPECT_TRUE(feed(TimeFirst(0), 4 * kPeriod_ns).empty());  // 0.8 s back
  EXPECT_EQ(feed.assembler->counts().duplicate, 1U);
  EXPECT_EQ(feed.assembler->counts().late, 2U);
  EXPECT_EQ(feed(TimeFirst(52), 5 * kPeriod_ns).size(), 1U);
}

TEST(Assembler, TakesATimeThatIsMoreThanASecondBackForARestart) {
  for (const Habit& habit : kHabits) {
    if (habit.send == SinglesWithoutTime) continue;
    Feed feed;
    std::vector<Frame> frames;
    for (int i = 0; i < 8; ++i) {
      for (auto& frame : feed(habit.send(i < 4 ? 200 + i : i), i * kPeriod_ns)) {
        frames.push_back(frame);
      }
    }
    ASSERT_EQ(frames.size(), 8U) << habit.name;
    for (int i = 0; i < 8; ++i) {
      EXPECT_EQ(frames[static_cast<std::size_t>(i)].restarted, i == 4) << habit.name;
    }
  }
}

// One that was stopped and started within its first second.
TEST(Assembler, TakesATimeThatIsBackAfterAPauseForARestart) {
  for (const Habit& habit : kHabits) {
    if (habit.send == SinglesWithoutTime) continue;
    Feed feed;
    std::vector<Frame> frames;
    for (int i = 0; i < 8; ++i) {
      const std::int64_t pause_ns = i < 4 ? 0 : 300 * kMs;
      for (auto& frame : feed(habit.send(i < 4 ? 10 + i : i), i * kPeriod_ns + pause_ns)) {
        frames.push_back(frame);
      }
    }
    ASSERT_EQ(frames.size(), 8U) << habit.name;
    for (int i = 0; i < 8; ++i) {
      EXPECT_EQ(frames[static_cast<std::size_t>(i)].restarted, i == 4) << habit.name;
    }
  }
}

TEST(Assembler, PassesOverAWholeFrameThatComesLate) {
  for (const Habit& habit : kHabits) {
    if (habit.send == SinglesWithoutTime || habit.send == SinglesOkFirst) continue;
    Feed feed;
    std::vector<int> numbers;
    const auto send = [&](int number, int tick) {
      for (auto& frame : feed(habit.send(number), tick * kPeriod_ns)) {
        numbers.push_back(NumberOf(frame));
      }
    };
    for (int i = 0; i < 4; ++i) send(i, i);
    send(5, 5);
    send(4, 5);
    for (int i = 6; i < 9; ++i) send(i, i);
    EXPECT_THAT(numbers, ::testing::ElementsAre(0, 1, 2, 3, 5, 6, 7, 8)) << habit.name;
  }
}

TEST(Assembler, DoesWithoutAClockThatIsNegative) {
  Feed feed;
  std::vector<Frame> frames;
  for (int i = 0; i < 4; ++i) {
    const auto number = static_cast<float>(i);
    for (auto& frame :
         feed(Bundle({TimeMessage(-5 + number), BoneMessage("Hips", number)}), i * kPeriod_ns)) {
      EXPECT_FALSE(frame.has_time);
      frames.push_back(frame);
    }
  }
  EXPECT_EQ(frames.size(), 4U);
}

TEST(Assembler, ForgetsTheBonesOfBeforeARestart) {
  Feed feed;
  feed(Bundle({TimeMessage(50), BoneMessage("Hips", 1), BoneMessage("Jaw", 1)}), 0);
  feed(Bundle({TimeMessage(1), BoneMessage("Hips", 2)}), kPeriod_ns);
  const auto frames = feed(Bundle({TimeMessage(1.1F), BoneMessage("Hips", 3)}), 2 * kPeriod_ns);
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames.back().missing, 0U);
}

TEST(Assembler, NamesTheMissingAtOnceAndTheStaleAfterHalfASecond) {
  Feed feed;
  feed(Bundle({TimeMessage(0), BoneMessage("Hips", 1), BoneMessage("Head", 1)}), 0);
  bool stale = false;
  for (int i = 1; i < 60; ++i) {
    const std::int64_t now_ns = i * kPeriod_ns;
    for (const Frame& frame :
         feed(Bundle({TimeMessage(0.016F * static_cast<float>(i)), BoneMessage("Hips", 1)}),
              now_ns)) {
      if (frame.received_ns == 0) continue;
      EXPECT_EQ(frame.missing, Set({"Head"}));
      EXPECT_EQ(frame.stale != 0, frame.received_ns > 500 * kMs);
      stale = stale || frame.stale == Set({"Head"});
    }
  }
  EXPECT_TRUE(stale);
  const auto frames = feed(Bundle({TimeMessage(1), BoneMessage("Hips", 1), BoneMessage("Head", 1)}),
                           60 * kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].missing, 0U);
  EXPECT_EQ(frames[0].stale, 0U);
}

TEST(Assembler, DoesWithoutAClockThatStands) {
  Feed feed;
  std::vector<Frame> frames;
  for (int i = 0; i < 60; ++i) {
    for (auto& frame : feed(Bundle({TimeMessage(7), BoneMessage("Hips", static_cast<float>(i))}),
                            i * kPeriod_ns)) {
      frames.push_back(frame);
    }
  }
  ASSERT_GT(frames.size(), 40U);
  EXPECT_TRUE(frames.front().has_time);
  EXPECT_FALSE(frames.back().has_time);
  EXPECT_EQ(NumberOf(frames.back()), 59);
  // And with it again when it goes.
  feed(Bundle({TimeMessage(8), BoneMessage("Hips", 60)}), 60 * kPeriod_ns);
  frames = feed(Bundle({TimeMessage(9), BoneMessage("Hips", 61)}), 61 * kPeriod_ns);
  ASSERT_FALSE(frames.empty());
  EXPECT_TRUE(frames.back().has_time);
}

// From 36 hours on a float's steps are as long as a frame.
TEST(Assembler, DoesWithoutAClockTooOldForAFloat) {
  Feed feed;
  std::vector<Frame> frames;
  for (int i = 0; i < 10; ++i) {
    const auto time_s = static_cast<float>(1.7e9 + 0.016 * i);
    for (auto& frame :
         feed(Bundle({TimeMessage(time_s), BoneMessage("Hips", static_cast<float>(i))}),
              i * kPeriod_ns)) {
      frames.push_back(frame);
    }
  }
  ASSERT_EQ(frames.size(), 10U);
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(frames[static_cast<std::size_t>(i)].has_time);
    EXPECT_EQ(NumberOf(frames[static_cast<std::size_t>(i)]), i);
  }
}

// The same without a caller that keeps its deadlines: its frames depend on arrival alone.
TEST(Assembler, NeedsNobodyToKeepItsDeadlinesButForTheLastFrame) {
  for (const Habit& habit : kHabits) {
    Feed feed;
    feed.ticks = false;
    std::vector<Frame> frames;
    for (int i = 0; i < 10; ++i) {
      for (auto& frame : feed(habit.send(i), i * kPeriod_ns)) frames.push_back(frame);
    }
    ASSERT_EQ(frames.size(), 10U) << habit.name;
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(NumberOf(frames[static_cast<std::size_t>(i)]), i) << habit.name;
    }
  }
}

TEST(Assembler, HasADeadlineOnlyWhileAFrameIsOpen) {
  Feed feed;
  EXPECT_EQ(feed.assembler->deadline_ns(), Assembler::kNever);
  feed(TimeFirst(0), 100 * kMs);
  const std::int64_t deadline_ns = feed.assembler->deadline_ns();
  EXPECT_GT(deadline_ns, 100 * kMs);
  EXPECT_LE(deadline_ns, 150 * kMs);
  EXPECT_FALSE(feed.assembler->Flush(deadline_ns - 1));
  EXPECT_TRUE(feed.assembler->Flush(deadline_ns));
  EXPECT_EQ(feed.assembler->deadline_ns(), Assembler::kNever);
  EXPECT_FALSE(feed.assembler->Flush(deadline_ns + kPeriod_ns));
}

TEST(Assembler, KeepsExpressionsByTheirNames) {
  Feed feed;
  feed(Bundle({TimeMessage(1), BoneMessage("Hips"), BlendMessage("Joy", 0.25F),
               BlendMessage("joy", 0.5F), BlendMessage(std::string(65, 'x'), 1), ApplyMessage()}),
       0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  ASSERT_EQ(frames[0].blend_count, 2U);
  EXPECT_EQ(frames[0].blends[0].name(), "Joy");
  EXPECT_EQ(frames[0].blends[0].value, 0.25F);
  EXPECT_EQ(frames[0].blends[1].name(), "joy");
  EXPECT_TRUE(frames[0].blends_applied);
  EXPECT_EQ(feed.assembler->counts().left_out, 1U);
}

TEST(Assembler, LeavesOutExpressionsBeyondItsRoom) {
  Feed feed;
  std::vector<Bytes> messages{BoneMessage("Hips")};
  for (std::size_t i = 0; i < Frame::kMaxBlends + 3; ++i) {
    messages.push_back(BlendMessage("e" + std::to_string(i), 1));
  }
  feed(Bundle(messages), 0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].blend_count, Frame::kMaxBlends);
  EXPECT_EQ(feed.assembler->counts().left_out, 3U);
}

TEST(Assembler, GivesExpressionsThatComeWithoutBones) {
  Feed feed;
  feed(Bundle({BlendMessage("A", 1), ApplyMessage()}), 0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].bones, 0U);
  EXPECT_EQ(frames[0].blend_count, 1U);
}

TEST(Assembler, PassesThruMessagesOnByteForByte) {
  Feed feed;
  const Bytes thru =
      testing::S("/VMC/Thru/a/b") + testing::S(",sf") + testing::S("x") + testing::F(2);
  std::vector<Bytes> messages{BoneMessage("Hips"), thru};
  const Bytes large =
      testing::S("/VMC/Thru/a/b") + testing::S(",s") + testing::S(std::string(600, 'x'));
  messages.push_back(large);
  for (std::size_t i = 0; i < Frame::kMaxThrus; ++i) messages.push_back(thru);
  feed(Bundle(messages), 0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  ASSERT_EQ(frames[0].thru_count, Frame::kMaxThrus);
  for (const auto& passed : frames[0].thrus) {
    EXPECT_TRUE(std::ranges::equal(passed.bytes(), thru));
  }
  EXPECT_EQ(feed.assembler->counts().left_out, 2U);
}

TEST(Assembler, TellsOfOkAsItCame) {
  Feed feed;
  feed(
      Bundle({BoneMessage("Hips"), testing::S("/VMC/Ext/OK") + testing::S(",iiii") + testing::I(1) +
                                       testing::I(2) + testing::I(1) + testing::I(0)}),
      0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  ASSERT_TRUE(frames[0].has_available);
  EXPECT_EQ(frames[0].available.calibration_state, 2);
  EXPECT_EQ(frames[0].available.tracking, 0);
}

TEST(Assembler, UnderstandsTheThumbsOfVrm1) {
  Feed feed;
  feed(Bundle({BoneMessage("hips", 1), BoneMessage("leftThumbMetacarpal", 1),
               BoneMessage("leftThumbProximal", 2), BoneMessage("leftThumbDistal", 3)}),
       0);
  const auto frames = feed.Until(kPeriod_ns);
  ASSERT_EQ(frames.size(), 1U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(Value(frames[0], kLeftThumbProximal + i), static_cast<float>(i + 1));
  }
}

TEST(Assembler, CountsFramesThatLackABone) {
  Feed feed;
  feed(Bundle({TimeMessage(1), BoneMessage("Hips", 1), BoneMessage("Head", 1)}), 0);
  feed(Bundle({TimeMessage(2), BoneMessage("Hips", 1)}), kPeriod_ns);
  feed.Until(2 * kPeriod_ns);
  EXPECT_EQ(feed.assembler->counts().incomplete, 1U);
}

}  // namespace
}  // namespace styled::vmc
