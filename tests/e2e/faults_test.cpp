#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "proto/rigs/native/header.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

// A faulty performer "bad" beside a healthy one "good", on the same socket. Afterwards the counters
// must contain every fault exactly, and "good" must not miss a frame.
class FaultsTest : public testing::Test {
 protected:
  void SetUp() override {
    subscriber_ = std::make_unique<Subscriber>(
        daemon_.publish,
        std::vector<std::string>{"body/", "styled/rig.good/rig/", "styled/rig.bad/rig/"});
    good_link_.Send(good_.Body());
    link_.Send(bad_.Body());
    ASSERT_TRUE(subscriber_->WaitFor([&] { return subscriber_->Bodies().size() >= 4; }, 10));
  }

  // `step` sends the datagrams of "bad" for one instant.
  void Run(int count, const std::function<void(int)>& step) {
    std::thread healthy([&] { Paced(count, 120, [&](int) { good_link_.Send(good_.Frame()); }); });
    Paced(count, 120, step);
    healthy.join();
    good_count_ += count;
  }

  std::uint64_t Count(const std::string& counter) { return control_.Counter(counter); }

  // Expects these values; every other fault counter must be 0.
  void ExpectCounts(std::map<std::string, std::uint64_t> expected) {
    for (const auto& [name, value] : expected)
      EXPECT_EQ(control_.CounterSoon(name, value), value) << name;
    const v1::StatusReply status = control_.Status();
    static const std::vector<std::string> kFaults{
        "source.too_short",         "source.too_long",        "source.bad_magic",
        "source.bad_version",       "source.length_mismatch", "source.bad_checksum",
        "source.bad_reserved",      "source.bad_kind",        "source.no_session",
        "source.malformed",         "source.bad_name",        "source.kernel_dropped",
        "pipeline.bodies_refused",  "pipeline.before_body",   "pipeline.wrong_size",
        "pipeline.wrong_body",      "pipeline.duplicate",     "pipeline.reordered",
        "pipeline.old_time",        "pipeline.lost",          "pipeline.second_sender",
        "pipeline.backlog_dropped", "pipeline.clock_jumps",   "stylist.held"};
    for (const auto& counter : status.stats().counters()) {
      const bool fault = std::find(kFaults.begin(), kFaults.end(), counter.name()) != kFaults.end();
      if (!fault || expected.contains(counter.name())) continue;
      EXPECT_EQ(counter.value(), 0U) << counter.name();
    }
  }

  void ExpectGoodUnharmed() {
    const auto wanted = static_cast<std::size_t>(good_count_);
    ASSERT_TRUE(subscriber_->WaitForFrames(wanted, "styled/rig.good/"));
    const auto frames = subscriber_->Frames("styled/rig.good/");
    ASSERT_EQ(frames.size(), wanted);
    for (std::size_t i = 1; i < frames.size(); ++i) {
      ASSERT_EQ(frames[i].sequence(), frames[i - 1].sequence() + 1);
      ASSERT_EQ(frames[i].source_sequence(), frames[i - 1].source_sequence() + 1);
      ASSERT_EQ(frames[i].flags() & v1::FLAG_CONCEALED, 0U);
    }
  }

  std::vector<v1::Frame> BadFrames(std::size_t count) {
    EXPECT_TRUE(subscriber_->WaitForFrames(count, "styled/rig.bad/"));
    return subscriber_->Frames("styled/rig.bad/");
  }

  Daemon daemon_;
  ControlClient control_{daemon_.control};
  UdpLink link_{daemon_.udp}, good_link_{daemon_.udp};
  Rig good_{"good", 1}, bad_{"bad", 2};
  int good_count_ = 0;
  std::unique_ptr<Subscriber> subscriber_;
};

TEST_F(FaultsTest, DuplicatesAreDroppedAndCounted) {
  Run(120, [&](int i) {
    const Bytes bytes = bad_.Frame();
    link_.Send(bytes);
    if (i % 4 == 0) link_.Send(bytes);
  });
  ExpectCounts({{"pipeline.duplicate", 30}, {"pipeline.frames", 240}});
  EXPECT_EQ(BadFrames(120).size(), 120U);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, LostFramesAreCountedAndTheGapIsConcealed) {
  std::mt19937 random(5);
  std::uint64_t lost = 0;
  std::uint64_t gaps = 0;
  bool in_gap = false;
  Run(240, [&](int i) {
    const Bytes bytes = bad_.Frame();
    const bool drop = i > 10 && i < 239 && random() % 10 == 0;
    if (drop) {
      ++lost;
      gaps += in_gap ? 0 : 1;
    } else {
      link_.Send(bytes);
    }
    in_gap = drop;
  });
  ASSERT_GT(lost, 10U);
  ExpectCounts({{"pipeline.lost", lost}, {"stylist.concealed", gaps}});
  std::uint64_t concealed = 0;
  for (const auto& frame : BadFrames(240 - lost)) {
    concealed += (frame.flags() & v1::FLAG_CONCEALED) != 0 ? 1 : 0;
  }
  EXPECT_EQ(concealed, gaps);
  EXPECT_EQ(control_.Performer("rig.bad").lost(), lost);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, ReorderedFramesAreDroppedAndCounted) {
  Run(120, [&](int i) {
    if (i % 10 != 0) return link_.Send(bad_.Frame());
    const Bytes first = bad_.Frame();
    const Bytes second = bad_.Frame();
    link_.Send(second);
    link_.Send(first);
  });
  ExpectCounts({{"pipeline.reordered", 12}, {"pipeline.lost", 12}});
  EXPECT_EQ(BadFrames(120).size(), 120U);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, AFrameWhoseTimeDoesNotAdvanceIsDropped) {
  Run(60, [&](int i) {
    link_.Send(bad_.Frame([i](v1::SourceFrame& frame) {
      if (i % 6 == 5) frame.set_source_time_ns(frame.source_time_ns() - 50'000'000);
    }));
  });
  ExpectCounts({{"pipeline.old_time", 10}});
  EXPECT_EQ(BadFrames(50).size(), 50U);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, ALateFrameIsDropped) {
  Bytes late;
  Run(60, [&](int i) {
    if (i == 20) late = bad_.Frame();
    link_.Send(bad_.Frame());
    if (i == 40) link_.Send(late);
  });
  ExpectCounts({{"pipeline.reordered", 1}, {"pipeline.lost", 1}});
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, CorruptedDatagramsAreRefusedEachWithItsReason) {
  namespace header = native::header;
  int step = 0;
  Run(100, [&](int) {
    Bytes bytes = bad_.Frame();
    switch (step++ % 10) {
      case 0:
        bytes[100] ^= std::byte{4};
        break;
      case 1:
        bytes[header::kMagic] = std::byte{'X'};
        break;
      case 2:
        bytes[header::kVersion] = std::byte{9};
        break;
      case 3:
        bytes.resize(bytes.size() - 7);
        break;  // truncated
      case 4:
        bytes.resize(20);
        break;  // not even a header
      case 5:
        bytes.resize(bytes.size() + 5000);
        break;  // oversized
      case 6:
        header::Write(std::span(bytes), header::kLength, 1U << 30U);
        break;  // the header claims to be oversized
      default:
        break;
    }
    link_.Send(bytes);
  });
  ExpectCounts({{"source.bad_checksum", 10},
                {"source.bad_magic", 10},
                {"source.bad_version", 10},
                {"source.length_mismatch", 20},
                {"source.too_short", 10},
                {"source.too_long", 10},
                {"pipeline.lost", 70}});
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, WellFormedDatagramsWithNonsenseInsideAreRefused) {
  Run(60, [&](int i) {
    switch (i % 6) {
      case 0:
        link_.Send(bad_.Datagram(native::Kind::kSourceFrame, "\x0Fgarbage"));
        break;
      case 1:
        link_.Send(bad_.Frame([](v1::SourceFrame& f) { f.set_performer("no spaces please"); }));
        break;
      case 2:
        link_.Send(bad_.Frame([](v1::SourceFrame& f) { f.mutable_rotations()->RemoveLast(); }));
        break;
      case 3:
        link_.Send(bad_.Frame([](v1::SourceFrame& f) { f.add_root_position(1); }));
        break;
      case 4:
        link_.Send(bad_.Frame([](v1::SourceFrame& f) { f.set_body_crc(1234); }));
        break;
      default:
        link_.Send(bad_.Frame());
        break;
    }
  });
  // Of each six, sequences 1 (garbage) and 2 (invalid name) never reach the performer.
  ExpectCounts({{"source.malformed", 10},
                {"source.bad_name", 10},
                {"pipeline.wrong_size", 20},
                {"pipeline.wrong_body", 10},
                {"pipeline.lost", 20}});
  EXPECT_EQ(BadFrames(10).size(), 10U);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, BadJointsAreHeldAndNamed) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Run(90, [&](int i) {
    link_.Send(bad_.Frame([i](v1::SourceFrame& frame) {
      if (i % 9 == 3) frame.set_rotations(4 * 5, kNan);
      if (i % 9 == 6) frame.set_rotations(4 * 7 + 2, kInfinity);
      if (i % 9 == 8) {
        for (int k = 0; k < 4; ++k) frame.set_rotations(4 * 9 + k, 0);
      }
    }));
  });
  ExpectCounts({{"stylist.held", 30}});
  int held = 0;
  for (const auto& frame : BadFrames(90)) {
    const bool flagged = (frame.flags() & v1::FLAG_HELD) != 0;
    EXPECT_EQ(flagged, frame.held_joints_size() > 0);
    held += flagged ? 1 : 0;
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
  EXPECT_EQ(held, 30);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, BodiesThatCannotBeBoundAreRefusedAndFramesBeforeABodyToo) {
  Rig early("early", 3);
  Rig broken("broken", 4);
  v1::Body loop = broken.MakeBody();
  loop.set_parents(4, 17);
  Run(30, [&](int) {
    link_.Send(early.Frame());
    link_.Send(broken.Datagram(native::Kind::kBody, loop.SerializeAsString()));
    link_.Send(broken.Frame());
    link_.Send(bad_.Frame());
  });
  ExpectCounts({{"pipeline.before_body", 60}, {"pipeline.bodies_refused", 30}});
  EXPECT_EQ(Count("pipeline.performers"), 2U);
  EXPECT_NE(daemon_.Log().find("rig.broken: body: joint 4: parent 17"), std::string::npos);
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, ABrokenTcpStreamIsClosedAndOthersGoOn) {
  const TcpLink tcp(daemon_.tcp);
  const TcpLink cut(daemon_.tcp);
  Rig rig("t", 9);
  tcp.Send(rig.Body());
  tcp.Send(rig.Frame());
  tcp.Send(Bytes(100, std::byte{'x'}));
  EXPECT_TRUE(tcp.Closed(5));
  {
    const TcpLink short_lived(daemon_.tcp);
    Bytes half = rig.Frame();
    half.resize(half.size() / 2);
    short_lived.Send(half);
  }
  Run(30, [&](int) { link_.Send(bad_.Frame()); });
  ExpectCounts({{"source.tcp_broken", 1},
                {"source.bad_magic", 1},
                {"source.tcp_cut_short", 1},
                {"source.tcp_accepted", 3}});
  ExpectGoodUnharmed();
}

TEST_F(FaultsTest, IdleTcpConnectionsDoNotLockARigOut) {
  std::vector<std::unique_ptr<TcpLink>> idle;
  for (int i = 0; i < 64; ++i) idle.push_back(std::make_unique<TcpLink>(daemon_.tcp));
  EXPECT_EQ(control_.CounterSoon("source.tcp_accepted", 64), 64U);
  const TcpLink tcp(daemon_.tcp);
  Rig rig("t", 9);
  tcp.Send(rig.Body());
  tcp.Send(rig.Frame());
  EXPECT_TRUE(subscriber_->WaitFor(
      [&] {
        return std::ranges::any_of(subscriber_->Bodies(),
                                   [](const auto& body) { return body.performer() == "tcp.t"; });
      },
      10));
  Run(120, [&](int) {
    link_.Send(bad_.Frame());
    tcp.Send(rig.Frame());
  });
  ExpectGoodUnharmed();
  // No other connection arrives, and these send nothing: only the time limit closes them.
  for (const auto& link : idle) EXPECT_TRUE(link->Closed(20));
  EXPECT_FALSE(tcp.Closed(0));
  ExpectCounts({{"source.tcp_gave_way", 1}, {"source.tcp_silent", 63}, {"source.tcp_refused", 0}});
}

}  // namespace
}  // namespace styled::support
