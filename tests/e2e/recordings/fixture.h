#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "proto/recording/reader.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

// Shared by the tests of recordings: stylerec, stylesim and the daemon as children, and styled
// frames that are compared bit by bit.
namespace styled::support {

using recording::Reader;
using recording::Record;

// The paths of the programs.
std::string StylerecBinary();
std::string StylesimBinary();

inline constexpr const char* kId = "rig.sim";
inline constexpr const char* kStyled = "styled/rig.sim/rig/";

// The parts of a styled frame that do not depend on the wall clock.
struct Styled {
  std::uint64_t source_time_ns = 0;
  std::string pose;    // bits
  std::string styles;  // and weights
  std::uint32_t flags = 0, contacts = 0;
  friend bool operator==(const Styled&, const Styled&) = default;
};

template <typename Repeated>
std::string Bits(const Repeated& floats) {
  return {reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)};
}

inline Styled Digest(const v1::Frame& frame) {
  Styled styled;
  styled.source_time_ns = frame.source_time_ns();
  styled.pose = Bits(frame.root_position()) + Bits(frame.rotations());
  for (const auto& style : frame.styles()) styled.styles += style.SerializeAsString();
  styled.flags = frame.flags() & ~static_cast<std::uint32_t>(v1::FLAG_LATE);
  styled.contacts = frame.contacts();
  return styled;
}

inline std::vector<Styled> Digests(const std::vector<v1::Frame>& frames) {
  std::vector<Styled> digests;
  for (const auto& frame : frames) {
    if ((frame.flags() & v1::FLAG_STALE) == 0) digests.push_back(Digest(frame));
  }
  return digests;
}

inline void ExpectSame(const std::vector<Styled>& found, const std::vector<Styled>& expected,
                       const std::string& what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].source_time_ns, expected[i].source_time_ns) << what << ", frame " << i;
    ASSERT_TRUE(found[i].pose == expected[i].pose) << what << ", frame " << i;
    ASSERT_TRUE(found[i] == expected[i]) << what << ", frame " << i;
  }
}

class RecordingsTest : public testing::Test {
 protected:
  std::unique_ptr<Daemon> MakeDaemon(const std::string& style = "style2") const {
    auto daemon = std::make_unique<Daemon>(
        std::vector<std::string>{"performers.takeover_ms=10", "performers.stale_ms=3000"});
    ControlClient control(daemon->control);
    EXPECT_EQ(control.SetStyle(kId, style, 0.9F, 300).code(), v1::CODE_OK);
    return daemon;
  }

  std::unique_ptr<Child> Start(std::vector<std::string> arguments, const std::string& log) const {
    arguments.insert(arguments.begin(), StylerecBinary());
    return std::make_unique<Child>(arguments, folder_ / log);
  }
  int Run(const std::vector<std::string>& arguments) {
    const std::string log = "log" + std::to_string(runs_++) + ".txt";
    const int code = Start(arguments, log)->Wait(60).value_or(-1);
    output_ = ReadText(folder_ / log);
    return code;
  }
  void Simulate(const std::string& to, const std::string& faults,
                const std::string& seconds) const {
    Child sim({StylesimBinary(), "--to", to, "--seconds", seconds, "--script",
               "walk:2,wave-left:1,run:2", "--faults", faults},
              folder_ / "sim.txt");
    ASSERT_EQ(sim.Wait(60).value_or(-1), 0) << ReadText(folder_ / "sim.txt");
  }
  // Waits until `log` contains the address that stylerec has bound.
  std::string Bound(const std::string& log, const std::string& word) const {
    for (int i = 0; i < 1000; ++i) {
      const std::string text = ReadText(folder_ / log);
      const std::size_t at = text.find(word), end = text.find('\n', at);
      if (at != std::string::npos && end != std::string::npos) {
        return text.substr(at + word.size(), end - at - word.size());
      }
      Sleep(0.01);
    }
    return "";
  }
  // Ends a recording with SIGINT.
  void Stop(Child& child) {
    child.Signal(SIGINT);
    EXPECT_EQ(child.Wait(10).value_or(-1), 0);
  }

  // The output of a fresh daemon for a recording.
  std::vector<Styled> Replay(const std::string& file, std::size_t count, bool flat_out,
                             std::uint64_t* lost = nullptr, const std::string& style = "style2") {
    const auto daemon = MakeDaemon(style);
    const Subscriber subscriber(daemon->publish, {"styled/", "body/"});
    ControlClient control(daemon->control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 2), 2U);
    std::vector<std::string> arguments{"play", file, "--to", "udp://" + daemon->udp};
    for (const char* more : {"--speed", "max", "--control"}) {
      if (flat_out) arguments.emplace_back(more);
    }
    if (flat_out) arguments.push_back(daemon->control);
    EXPECT_EQ(Run(arguments), 0) << output_;
    EXPECT_TRUE(subscriber.WaitForFrames(count, kStyled)) << daemon->Log();
    if (lost != nullptr) *lost = control.Counter("pipeline.lost");
    return Digests(subscriber.Frames(kStyled));
  }

  std::vector<Record> ReadAll(const std::string& file) const {
    std::vector<Record> records;
    const auto reader = Reader::Open(file);
    EXPECT_TRUE(reader.ok()) << reader.status().message();
    Record record;
    while (reader.ok() && reader.value()->Next(record)) records.push_back(record);
    if (!reader.ok()) return records;
    EXPECT_EQ(recording::DamageText(reader.value()->counts()), "");
    return records;
  }

  // Records what a daemon publishes while the simulator plays.
  std::string RecordPublished(const std::string& faults, const std::string& seconds) {
    const auto daemon = MakeDaemon();
    const std::string file = folder_ / "published.styrec";
    const auto recorder = Start({"record", "--from", daemon->publish, file}, "record.txt");
    ControlClient control(daemon->control);
    EXPECT_EQ(control.CounterSoon("publish.subscriptions", 4), 4U);
    Simulate("udp://" + daemon->udp, faults, seconds);
    Stop(*recorder);
    return file;
  }

  TemporaryFolder folder_;
  std::string output_;

 private:
  int runs_ = 0;
};

}  // namespace styled::support
