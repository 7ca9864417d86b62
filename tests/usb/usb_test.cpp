#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>

#include "model/body/pose.h"
#include "proto/recording/reader.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/usb/fake_usb.h"
#include "tests/usb/worn_trackers.h"

// The real daemon, libusb and all, and devices of umockdev's. By hand: STYLED_USB_SECONDS=30.
namespace styled::support {
namespace {

using Kind = FakeDevice::Kind;

// As many transfers as the daemon keeps under way.
constexpr int kInterrupt = 8, kBulk = 4;
constexpr std::uint16_t kVendor = 0x1234, kProduct = 0x0001;

class UsbTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!FakeUsb::Available()) GTEST_SKIP() << "skipped, no umockdev";
    usb_ = std::make_unique<FakeUsb>();
  }

  FakeDevice Suit(const std::string& serial = "SUIT-1") {
    return {*usb_, Kind::kVendor, kVendor, kProduct, serial};
  }
  FakeDevice Receiver(const std::string& serial = "DONGLE-1") {
    return {*usb_, Kind::kReceiver, 0x1209, 0x7690, serial};
  }
  // Sources "suit" and "dongle", each with these further lines. All is recorded.
  Daemon Start(const std::string& suit = "", const std::string& dongle = "") {
    return Daemon({"performers.takeover_ms=20", "record.file=" + folder_ / "usb.styrec"},
                  "[[source]]\nname = \"suit\"\ntype = \"usb\"\nusb_id = \"1234:0001\"\n" + suit +
                      "[[source]]\nname = \"dongle\"\ntype = \"slimevr-usb\"\n" + dongle);
  }

  static double Seconds() {
    const char* const seconds = std::getenv("STYLED_USB_SECONDS");
    return seconds == nullptr ? 5 : std::atof(seconds);
  }
  static std::uint64_t Received(ControlClient& control, const std::string& name) {
    const auto status = control.Status();
    for (const auto& source : status.sources()) {
      if (source.name() == name) return source.received();
    }
    ADD_FAILURE() << "no source " << name;
    return 0;
  }
  static bool Receives(ControlClient& control, const std::string& name, std::uint64_t count) {
    for (int i = 0; i < 1000 && Received(control, name) < count; ++i) Sleep(0.01);
    return Received(control, name) == count;
  }
  // Ends the daemon; so many transfers of the first device that `source` opened were recorded.
  void ExpectRecorded(Daemon& daemon, const std::string& source, std::uint64_t count) const {
    EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
    const auto reader = recording::Reader::Open(folder_ / "usb.styrec");
    ASSERT_TRUE(reader.ok()) << reader.status().message();
    recording::Record record;
    std::uint64_t found = 0;
    while (reader.value()->Next(record)) {
      if (!record.has_arrival()) continue;
      ASSERT_EQ(record.arrival().source(), source);
      ASSERT_EQ(record.arrival().peer(), "device 1");
      ++found;
    }
    EXPECT_EQ(found, count);
  }
  static void ExpectUnbroken(const std::vector<v1::Frame>& frames) {
    for (std::size_t i = 1; i < frames.size(); ++i) {
      ASSERT_EQ(frames[i].sequence(), frames[i - 1].sequence() + 1);
    }
  }
  static std::size_t OpenFiles(const Daemon& daemon) {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(daemon.child->pid()) +
                                                    "/fd");
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }

  std::unique_ptr<FakeUsb> usb_;
  TemporaryFolder folder_;
};

TEST_F(UsbTest, OurOwnRecordsFromAVendorDeviceComeOutStyledHoweverTheTransfersCutThem) {
  FakeDevice suit = Suit();
  suit.Plug();  // before the daemon
  Daemon daemon = Start();
  Subscriber subscriber(daemon.publish, {"body/suit.a/", "styled/suit.a/"});
  ControlClient control(daemon.control);
  ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  EXPECT_EQ(suit.counts().driver_detached, 1) << "the kernel's driver steps aside";
  Rig rig("a");
  suit.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody()) << daemon.Log();
  ASSERT_EQ(control.SetStyle("suit.a", "style2", 1, 0).code(), v1::CODE_OK);
  Bytes stream;
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    const Bytes frame = rig.Frame();
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  for (std::size_t at = 0, size = 1; at < stream.size(); at += size, size = size % 997 + 100) {
    suit.Send(std::span(stream).subspan(at, std::min(size, stream.size() - at)));
  }
  ASSERT_TRUE(subscriber.WaitForFrames(kFrames, "styled/suit.a/canonical/")) << daemon.Log();
  const auto frames = subscriber.Frames("styled/suit.a/canonical/");
  ExpectUnbroken(frames);
  EXPECT_EQ(frames.back().styles(0).style(), "style2");
  EXPECT_EQ(control.Counter("pipeline.lost"), 0U);
  EXPECT_EQ(control.Counter("usb.bad_reports"), 0U);
}

// Arms down and bent, a knee up: parts that wear trackers, so that the whole pose can be known.
body::Pose Bent() {
  body::Pose pose;
  const auto turn = [&pose](body::Joint joint, float x, float z) {
    pose.rotations[static_cast<std::size_t>(joint)] = body::Exp(body::Vec3(x, 0, z));
  };
  turn(body::kLeftUpperArm, 0.3F, -1.1F);
  turn(body::kRightUpperArm, -0.4F, 1.2F);
  turn(body::kRightLowerArm, 0.0F, 0.8F);
  turn(body::kLeftUpperLeg, -0.7F, 0.1F);
  turn(body::kLeftLowerLeg, 0.9F, 0.0F);
  turn(body::kRightFoot, 0.2F, 0.0F);
  return pose;
}

float WorstDegrees(const v1::Frame& frame, const body::Pose& pose) {
  float worst = 0;
  for (int j = 0; j < body::kJointCount; ++j) {
    const auto& r = frame.rotations();
    const body::Quat got(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
    const float rad = got.angularDistance(pose.rotations[static_cast<std::size_t>(j)]);
    worst = std::max(worst, rad * 57.29578F);
  }
  return worst;
}

TEST_F(UsbTest, AStyledSkeletonComesOutOfTheTrackersOfAReceiver) {
  const std::string canonical = "styled/dongle.dongle/canonical/";
  FakeDevice dongle = Receiver();
  dongle.Plug();
  WornTrackers trackers;
  Daemon daemon = Start("", trackers.Config());
  Subscriber subscriber(daemon.publish, {"body/", canonical});
  ControlClient control(daemon.control);
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  const auto play = [&](const body::Pose& pose, const std::function<bool()>& enough) {
    for (int i = 0; i < 1000 && !enough(); ++i) {
      for (const auto& report : trackers.Next(pose)) dongle.Send(report);
      Sleep(0.01);
    }
    return enough();
  };
  v1::Request calibrate;
  calibrate.set_performer("dongle.dongle");
  calibrate.mutable_calibrate()->set_sensors(v1::Calibrate::SENSORS_FULL);
  EXPECT_TRUE(play(body::Pose(), [&] { return Received(control, "dongle") > 40; }));
  const v1::Reply reply = control.Ask(calibrate);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason() << "\n" << daemon.Log();

  const body::Pose bent = Bent();
  const auto newest = [&] {
    const auto frames = subscriber.Frames(canonical);
    return frames.empty() ? std::optional<v1::Frame>() : frames.back();
  };
  EXPECT_TRUE(play(bent, [&] { return newest() && WorstDegrees(*newest(), bent) < 0.1F; }))
      << (newest() ? WorstDegrees(*newest(), bent) : -1) << "\n"
      << daemon.Log();
  ASSERT_EQ(control.SetStyle("dongle.dongle", "style2", 1, 0).code(), v1::CODE_OK);
  EXPECT_TRUE(play(bent, [&] { return newest()->styles_size() > 0; }));
  ASSERT_EQ(newest()->styles(0).style(), "style2");
  EXPECT_TRUE(play(bent, [&] { return WorstDegrees(*newest(), bent) > 1; })) << "it changes him";
  const v1::Frame last = *newest();
  for (const float value : last.rotations()) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(control.Counter("usb.bad_reports"), 0U);
}

TEST_F(UsbTest, AThousandTransfersASecondArriveWithoutALostRecord) {
  FakeDevice suit = Suit();
  Daemon daemon = Start();
  suit.Plug();  // behind the daemon
  ControlClient control(daemon.control);
  ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  std::vector<Rig> rigs;
  for (int i = 0; i < 8; ++i) {
    rigs.emplace_back("p" + std::to_string(i));
    suit.Send(rigs.back().Body());
  }
  const int frames = static_cast<int>(1000 * Seconds());
  Paced(frames, 1000, [&](int i) { suit.Send(rigs[static_cast<std::size_t>(i) % 8].Frame()); });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", static_cast<std::uint64_t>(frames)),
            static_cast<std::uint64_t>(frames));
  EXPECT_TRUE(Receives(control, "suit", static_cast<std::uint64_t>(frames + 8)));
  for (const char* counter : {"pipeline.lost", "pipeline.duplicate", "pipeline.reordered",
                              "usb.ring_full", "usb.bad_reports", "usb.transfers_failed"}) {
    EXPECT_EQ(control.Counter(counter), 0U) << counter;
  }
  ExpectRecorded(daemon, "suit", static_cast<std::uint64_t>(frames + 8));
}

TEST_F(UsbTest, AThousandReportsASecondArriveWithoutALostReport) {
  FakeDevice dongle = Receiver();
  WornTrackers trackers;
  Daemon daemon = Start("", trackers.Config());
  dongle.Plug();
  ControlClient control(daemon.control);
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  const int count = static_cast<int>(1000 * Seconds());
  std::vector<WornTrackers::Report> reports;
  Paced(count, 1000, [&](int) {
    if (reports.empty()) reports = trackers.Next(body::Pose());
    dongle.Send(reports.back());
    reports.pop_back();
  });
  EXPECT_TRUE(Receives(control, "dongle", static_cast<std::uint64_t>(count)))
      << Received(control, "dongle");
  for (const char* counter : {"usb.ring_full", "usb.bad_reports", "usb.transfers_failed"}) {
    EXPECT_EQ(control.Counter(counter), 0U) << counter;
  }
  ExpectRecorded(daemon, "dongle", static_cast<std::uint64_t>(count));
}

TEST_F(UsbTest, UnpluggedInMidTransferTwentyTimesItComesBackTwentyTimes) {
  FakeDevice suit = Suit();
  Daemon daemon = Start();
  Subscriber subscriber(daemon.publish, {"body/", "styled/suit.a/rig/"});
  ControlClient control(daemon.control);
  suit.Plug();
  ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  const std::size_t open_files = OpenFiles(daemon);
  constexpr int kReplugs = 20;
  for (int i = 0; i <= kReplugs; ++i) {
    Rig rig("a", 100 + static_cast<std::uint64_t>(i));  // its firmware restarts
    const std::size_t before = subscriber.Frames("styled/").size();
    // The first are refused, because the session before was live a moment ago.
    ASSERT_TRUE(subscriber.WaitFor(
        [&] {
          suit.Send(rig.Body());
          for (int k = 0; k < 10; ++k) suit.Send(rig.Frame());
          return subscriber.Frames("styled/").size() >= before + 10;
        },
        10))
        << i << "\n"
        << daemon.Log();
    if (i == kReplugs) break;
    // Much under way, and half a record, when the plug is pulled.
    const Bytes frame = rig.Frame();
    for (int k = 0; k < 20; ++k) suit.Send(frame);
    suit.Send(std::span(frame).first(40));
    suit.Unplug();
    suit.Plug();
    ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << i << "\n" << daemon.Log();
  }
  EXPECT_EQ(control.CounterSoon("usb.lost_devices", kReplugs), kReplugs);
  EXPECT_EQ(control.Counter("usb.opened"), kReplugs + 1U);
  EXPECT_EQ(suit.counts().claims, kReplugs + 1);
  EXPECT_EQ(control.Counter("pipeline.performers"), 1U);
  EXPECT_EQ(control.Counter("usb.bad_reports"), 0U) << "the halves were forgotten";
  EXPECT_LE(OpenFiles(daemon), open_files) << "descriptors leak";
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
}

TEST_F(UsbTest, AStalledEndpointIsClearedAndNothingIsLost) {
  FakeDevice suit = Suit();
  suit.Plug();
  Daemon daemon = Start();
  ControlClient control(daemon.control);
  ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  Rig rig("a");
  suit.Send(rig.Body());
  constexpr int kStalls = 5;
  for (int i = 0; i < kStalls; ++i) {
    for (int k = 0; k < 10; ++k) suit.Send(rig.Frame());
    suit.Stall();
    for (int k = 0; k < 10; ++k) suit.Send(rig.Frame());
    ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  }
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 20 * kStalls), 20U * kStalls);
  EXPECT_EQ(suit.counts().halts_cleared, kStalls);
  EXPECT_EQ(control.Counter("usb.transfers_failed"), static_cast<std::uint64_t>(kStalls));
  EXPECT_EQ(control.Counter("pipeline.lost"), 0U);
  EXPECT_EQ(suit.counts().claims, 1) << "it is not opened anew for that";
}

TEST_F(UsbTest, TransfersThatFailAreTriedAgainAndADeviceThatFailsForGoodIsOpenedAnew) {
  FakeDevice dongle = Receiver();
  dongle.Plug();
  WornTrackers trackers;
  Daemon daemon = Start();
  ControlClient control(daemon.control);
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  dongle.Send(trackers.KeepAlive());
  dongle.Fail(10, EPROTO);
  dongle.Send(trackers.KeepAlive());
  dongle.Fail(10, EOVERFLOW);
  dongle.Send(trackers.KeepAlive());
  EXPECT_TRUE(Receives(control, "dongle", 3)) << Received(control, "dongle");
  EXPECT_EQ(control.Counter("usb.transfers_failed"), 20U);
  EXPECT_EQ(control.Counter("usb.lost_devices"), 0U);
  dongle.Fail(16, EPROTO);
  EXPECT_EQ(control.CounterSoon("usb.lost_devices", 1), 1U);
  EXPECT_EQ(control.CounterSoon("usb.opened", 2), 2U);
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  dongle.Send(trackers.KeepAlive());
  EXPECT_TRUE(Receives(control, "dongle", 4)) << Received(control, "dongle");
  EXPECT_NE(daemon.Log().find("lost, its transfers fail"), std::string::npos) << daemon.Log();
}

TEST_F(UsbTest, ShortAndGarbageReportsAreCountedAndHarmNobody) {
  FakeDevice dongle = Receiver();
  dongle.Plug();
  WornTrackers trackers;
  Daemon daemon = Start("", trackers.Config());
  ControlClient control(daemon.control);
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  const auto good = trackers.KeepAlive();
  dongle.Send(good);
  EXPECT_TRUE(Receives(control, "dongle", 1));
  EXPECT_EQ(control.Counter("usb.bad_reports"), 0U);
  dongle.Send({});  // an empty packet says nothing
  dongle.Send(std::span(good).first(1));
  dongle.Send(std::span(good).first(63));
  dongle.Send(Bytes(64, std::byte{0x55}));  // four records of no known type
  EXPECT_TRUE(Receives(control, "dongle", 4));
  EXPECT_EQ(control.Counter("usb.bad_reports"), 3U);
  dongle.Send(std::span(good).first(48));  // three records
  EXPECT_TRUE(Receives(control, "dongle", 5));
  EXPECT_EQ(control.Counter("usb.bad_reports"), 3U);
  EXPECT_EQ(control.Counter("usb.lost_devices"), 0U);
}

TEST_F(UsbTest, AfterABrokenRecordTheNextTransferIsReadAgain) {
  FakeDevice suit = Suit();
  suit.Plug();
  Daemon daemon = Start();
  ControlClient control(daemon.control);
  ASSERT_TRUE(suit.WaitForTransfers(kBulk)) << daemon.Log();
  Rig rig("a");
  suit.Send(rig.Body());
  suit.Send(rig.Frame());
  Bytes broken = rig.Frame();
  broken[0] = std::byte{'X'};
  suit.Send(broken);
  suit.Send(rig.Frame());
  Bytes bad_sum = rig.Frame();  // refused alone
  bad_sum.back() ^= std::byte{1};
  const Bytes next = rig.Frame();
  bad_sum.insert(bad_sum.end(), next.begin(), next.end());
  suit.Send(bad_sum);
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 3), 3U);
  EXPECT_EQ(control.Counter("usb.bad_reports"), 1U);
  EXPECT_EQ(control.Counter("source.bad_magic"), 1U);
  EXPECT_EQ(control.Counter("source.bad_checksum"), 1U);
}

TEST_F(UsbTest, ASecondReceiverIsReadBesideTheFirstAndOneAloneWhereItsSerialNumberIsGiven) {
  FakeDevice first = Receiver("DONGLE-1"), second = Receiver("DONGLE-2");
  first.Plug();
  WornTrackers trackers;
  {
    Daemon daemon = Start();
    ControlClient control(daemon.control);
    ASSERT_TRUE(first.WaitForTransfers(kInterrupt)) << daemon.Log();
    second.Plug();
    ASSERT_TRUE(second.WaitForTransfers(kInterrupt)) << daemon.Log();
    for (int i = 0; i < 50; ++i) {
      first.Send(trackers.KeepAlive());
      second.Send(trackers.KeepAlive());
    }
    EXPECT_TRUE(Receives(control, "dongle", 100)) << Received(control, "dongle");
    first.Unplug();
    second.Send(trackers.KeepAlive());
    EXPECT_TRUE(Receives(control, "dongle", 101)) << "the other goes on";
    EXPECT_EQ(control.CounterSoon("usb.lost_devices", 1), 1U);
    EXPECT_EQ(daemon.Stop(), 0);
  }
  first.Plug();
  const int claims = first.counts().claims;
  Daemon daemon = Start("", "serial = \"DONGLE-2\"\n");
  ControlClient control(daemon.control);
  ASSERT_TRUE(second.WaitForTransfers(kInterrupt)) << daemon.Log();
  EXPECT_EQ(control.CounterSoon("usb.opened", 1), 1U);
  EXPECT_EQ(first.counts().claims, claims) << "it is another performer's";
}

TEST_F(UsbTest, ADeviceThatAnotherProgramHasIsTakenWhenItIsFree) {
  FakeDevice dongle = Receiver();
  dongle.RefuseClaims(2);
  dongle.Plug();
  Daemon daemon = Start();
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt)) << daemon.Log();
  EXPECT_EQ(dongle.counts().refused_claims, 2);
  const std::string log = daemon.Log();
  const auto said = log.find("another program uses it");
  ASSERT_NE(said, std::string::npos) << log;
  EXPECT_EQ(log.find("another program uses it", said + 1), std::string::npos) << "said once";
}

TEST_F(UsbTest, ADaemonThatStopsGivesTheDeviceBackToTheKernel) {
  FakeDevice dongle = Receiver(), suit = Suit();
  dongle.Plug();
  suit.Plug();
  Daemon daemon = Start();
  ASSERT_TRUE(dongle.WaitForTransfers(kInterrupt) && suit.WaitForTransfers(kBulk)) << daemon.Log();
  EXPECT_EQ(daemon.Stop(), 0) << daemon.Log();
  for (const FakeDevice* device : {&dongle, &suit}) {
    EXPECT_FALSE(device->counts().claimed);
    EXPECT_EQ(device->counts().driver_attached, 1);
    EXPECT_EQ(device->counts().under_way, 0);
  }
}

}  // namespace
}  // namespace styled::support

int main(int argc, char** argv) {
  styled::support::FakeUsb::Preload(argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
