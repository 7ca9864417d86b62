#include "clients/rec/take.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/base/crc32c.h"
#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using rig::Quat;
using rig::Vec3;
using ::testing::HasSubstr;
using testing::kMillisecond_ns;
using testing::kSecond_ns;
using testing::Published;

constexpr const char* kSource = "source/rig.a/";

class TakeTest : public ::testing::Test {
 protected:
  void AddBody(const styled::v1::Body& body) {
    records_.push_back(Published(now_ns_, "body/rig.a/", body.SerializeAsString()));
  }
  // A frame `number` metres high at this source time; 10 ms after the last record.
  void AddFrame(std::uint64_t number, double source_time_s, std::uint32_t flags = 0) {
    now_ns_ += 10 * kMillisecond_ns;
    auto frame = testing::MakeFrame(body_, number,
                                    static_cast<std::uint64_t>(std::llround(source_time_s * 1e9)));
    frame.set_flags(flags);
    records_.push_back(Published(now_ns_, kSource, frame.SerializeAsString()));
  }
  Result<Take> Read(What what = What::kSource) {
    const auto reader = testing::MakeReader(records_);
    return ReadTake(*reader, "rig.a", what);
  }
  Take ReadGood(What what = What::kSource) {
    auto take = Read(what);
    EXPECT_TRUE(take.ok()) << take.status().message();
    return take.ok() ? take.value() : Take{};
  }
  static std::vector<float> Heights(const std::vector<rig::RigPose>& frames) {
    std::vector<float> heights;
    for (const auto& frame : frames) heights.push_back(frame.translations[0].y());
    return heights;
  }

  styled::v1::Body body_ = testing::MakeBody("rig.a", styled::v1::OUTPUT_RIG, 5);
  std::vector<recording::Record> records_;
  std::int64_t now_ns_ = 0;
};

TEST_F(TakeTest, WithoutFramesItSaysWhatThereIs) {
  records_.push_back(testing::Arrival(0, "MXTP02", "suit"));
  records_.push_back(Published(0, "styled/rig.b/rig/", ""));
  EXPECT_EQ(Read(What::kRig).status().message(),
            "test.styrec: found no frames of styled/rig.a/rig/; it holds: arrivals of source suit "
            "(udp), styled/rig.b/rig/");
  records_.clear();
  EXPECT_THAT(Read().status().message(), HasSubstr("it holds: nothing to export"));
}

TEST_F(TakeTest, WithoutABodyOrAPoseItSaysSo) {
  AddFrame(1, 1);
  EXPECT_THAT(Read().status().message(),
              HasSubstr("found no body that the frames of source/rig.a/"));
  AddBody(body_);
  auto frame = testing::MakeFrame(body_, 1, 1);
  frame.add_rotations(0);
  records_[0] = Published(0, kSource, frame.SerializeAsString());
  EXPECT_THAT(Read().status().message(), HasSubstr("found no frame of source/rig.a/"));
}

TEST_F(TakeTest, ABodyThatIsImpossibleIsNone) {
  body_.set_parents(3, 7);
  AddBody(body_);
  AddFrame(1, 1);
  EXPECT_THAT(Read().status().message(), HasSubstr("found no body"));
}

TEST_F(TakeTest, FramesAreAtTheirSourceTimesFromZeroWhereverTheBodyIs) {
  AddFrame(1, 5);
  AddFrame(2, 5.25);
  AddBody(body_);
  AddFrame(3, 5.5);
  const Take take = ReadGood();
  EXPECT_THAT(take.times_s, ::testing::ElementsAre(0, 0.25, 0.5));
  EXPECT_THAT(Heights(take.frames), ::testing::ElementsAre(1, 2, 3));
  EXPECT_EQ(take.skeleton.names[4], "head");
  EXPECT_EQ(take.rest.size(), 21U);
}

TEST_F(TakeTest, RepeatedStaleAndOlderFramesAreLeftOut) {
  AddBody(body_);
  AddFrame(1, 5);
  AddFrame(2, 5.1);
  AddFrame(2, 5.1);
  AddFrame(1, 5.0);
  AddFrame(2, 5.2, styled::v1::FLAG_STALE);
  AddFrame(3, 5.3);
  EXPECT_THAT(Heights(ReadGood().frames), ::testing::ElementsAre(1, 2, 3));
}

TEST_F(TakeTest, AClockThatBeginsAnewGoesOnAsTimeDid) {
  AddBody(body_);
  AddFrame(1, 5);
  AddFrame(2, 5.1);
  now_ns_ += 2 * kSecond_ns - 10 * kMillisecond_ns;
  AddFrame(3, 0);
  AddFrame(4, 0.1);
  AddFrame(5, 20'000);  // more than an hour ahead
  const Take take = ReadGood();
  EXPECT_EQ(take.restarts, 2U);
  ASSERT_EQ(take.times_s.size(), 5U);
  EXPECT_NEAR(take.times_s[2], 2.1, 1e-9);
  EXPECT_NEAR(take.times_s[3], 2.2, 1e-9);
  EXPECT_NEAR(take.times_s[4], 2.21, 1e-9);
}

// At the rate of its frames such a pause has ten million, and the export ended by bad_alloc.
TEST_F(TakeTest, APauseOfADayIsShortened) {
  AddBody(body_);
  for (int i = 0; i < 50; ++i) AddFrame(1 + i, 5 + i / 120.0);
  for (int i = 0; i < 50; ++i) AddFrame(51 + i, 3000 + i / 120.0);
  now_ns_ += 82'000 * kSecond_ns;  // and the clock restarts
  for (int i = 0; i < 50; ++i) AddFrame(101 + i, i / 120.0);
  const Take take = ReadGood();
  ASSERT_EQ(take.times_s.size(), 150U);
  EXPECT_EQ(take.pauses, 2U);
  EXPECT_NEAR(take.times_s[50] - take.times_s[49], kLongestPause_s, 1e-6);
  EXPECT_NEAR(take.times_s[100] - take.times_s[99], kLongestPause_s, 1e-6);
  EXPECT_NEAR(take.times_s[149] - take.times_s[100], 49 / 120.0, 1e-6);
  EXPECT_NEAR(take.left_out_s, 3000 - 5 - 49 / 120.0 + 82'000 - 2 * kLongestPause_s, 1);
  const auto clip = ToClip(take, 0);
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_LT(clip.value().frames.size(), 2700U);
}

TEST_F(TakeTest, TheMostUsedOfSeveralBodiesIsChosen) {
  AddBody(body_);
  AddFrame(1, 1);
  body_.set_hash(6);
  AddBody(body_);
  AddFrame(2, 2);
  AddFrame(3, 3);
  body_.set_hash(77);  // never published
  for (int i = 4; i < 9; ++i) AddFrame(static_cast<std::uint64_t>(i), i);
  const Take take = ReadGood();
  EXPECT_THAT(Heights(take.frames), ::testing::ElementsAre(2, 3));
  EXPECT_EQ(take.on_other_bodies, 1U);
  EXPECT_EQ(take.unusable, 5U);
}

TEST_F(TakeTest, TheStyledMotionsAreToldApart) {
  const auto canonical = testing::MakeBody("rig.a", styled::v1::OUTPUT_CANONICAL, 6);
  AddBody(body_);
  AddBody(canonical);
  AddFrame(1, 1);
  records_.push_back(
      Published(0, "styled/rig.a/rig/", testing::MakeFrame(body_, 2, 1).SerializeAsString()));
  records_.push_back(Published(0, "styled/rig.a/canonical/",
                               testing::MakeFrame(canonical, 3, 1).SerializeAsString()));
  EXPECT_EQ(Heights(ReadGood(What::kSource).frames), std::vector<float>{1});
  EXPECT_EQ(Heights(ReadGood(What::kRig).frames), std::vector<float>{2});
  EXPECT_EQ(Heights(ReadGood(What::kCanonical).frames), std::vector<float>{3});
}

TEST_F(TakeTest, UnknownJointsStayAsTheyWereAndSignsAreContinuous) {
  AddBody(body_);
  const Quat turn(Eigen::AngleAxisf(1, Vec3::UnitX()));
  for (int i = 0; i < 3; ++i) {
    auto frame = testing::MakeFrame(body_, static_cast<std::uint64_t>(i), i * 1'000'000ULL + 1);
    for (int k = 0; k < 4; ++k) {
      const float value = i == 1 ? NAN : i == 2 ? -turn.coeffs()[k] : turn.coeffs()[k];
      frame.set_rotations(4 + k, value);
    }
    records_.push_back(Published(0, kSource, frame.SerializeAsString()));
  }
  const Take take = ReadGood();
  ASSERT_EQ(take.frames.size(), 3U);
  for (const auto& frame : take.frames) EXPECT_TRUE(frame.rotations[1].isApprox(turn));
}

TEST_F(TakeTest, TheSourceMayComeFromOurOwnDatagrams) {
  styled::v1::Body body = body_;
  body.set_performer("a");
  const std::string payload = body.SerializeAsString();
  using native::Kind;
  records_.push_back(testing::Arrival(0, testing::Datagram(Kind::kBody, 1, 0, payload)));
  for (std::uint64_t i = 1; i < 6; ++i) {
    styled::v1::SourceFrame frame;
    const auto published = testing::MakeFrame(body_, i, i * 10'000'000);
    frame.set_performer(i == 5 ? "b" : "a");
    frame.set_source_time_ns(published.source_time_ns());
    *frame.mutable_root_position() = published.root_position();
    *frame.mutable_rotations() = published.rotations();
    if (i > 1) frame.set_body_crc(Crc32c(std::as_bytes(std::span(payload))));
    records_.push_back(
        testing::Arrival(0, testing::Datagram(Kind::kSourceFrame, 1, i, frame.SerializeAsString()),
                         i == 4 ? "other" : "rig"));
  }
  EXPECT_THAT(Heights(ReadGood().frames), ::testing::ElementsAre(1, 2, 3));
}

TEST_F(TakeTest, AxesAndAnUnknownUnitAreThoseOfTheTPose) {
  // Z up, facing -Y, in inches.
  const Quat z_up(Eigen::AngleAxisf(1.57079633F, Vec3::UnitX()));
  body_.set_metres_per_unit(0);
  for (int j = 0; j < body::kJointCount; ++j) {
    const Vec3 offset = z_up * body::Offset(j) / 0.0254F;
    for (int k = 0; k < 3; ++k) body_.set_offsets(3 * j + k, offset[k]);
  }
  AddBody(body_);
  AddFrame(1, 1);
  const Take take = ReadGood();
  EXPECT_FALSE(take.unit_known);
  EXPECT_NEAR(take.metres_per_unit, 0.0254F, 1e-6F);
  EXPECT_LT(take.canonical_from_source.angularDistance(z_up.conjugate()), 1e-4F);
  const auto motion = ToMotion(take, 0, *clip::FindFormat("a.glb").value());
  ASSERT_TRUE(motion.ok());
  EXPECT_EQ(motion.value().metres_per_unit, take.metres_per_unit);
  EXPECT_TRUE(motion.value().canonical_from_source.isApprox(take.canonical_from_source));
}

TEST_F(TakeTest, OtherSkeletonsThanHumanoidsAreExportedUnchanged) {
  for (int j = 0; j < body_.names_size(); ++j) body_.set_names(j, "bone" + std::to_string(j));
  body_.set_metres_per_unit(0.5F);
  AddBody(body_);
  AddFrame(1, 1);
  const Take take = ReadGood();
  EXPECT_TRUE(take.unit_known);
  EXPECT_EQ(take.metres_per_unit, 0.5F);
  EXPECT_TRUE(take.canonical_from_source.isApprox(Quat::Identity()));
}

class ToClipTest : public ::testing::Test {
 protected:
  // Frames at these times; the hips' height is the time.
  static Take At(const std::vector<double>& times_s) {
    Take take;
    take.performer = "rig.a";
    take.skeleton = {{"hips", "spine"}, {-1, 0}, {Vec3(0, 9, 0), Vec3(0, 1, 0)}};
    take.times_s = times_s;
    for (const double time_s : times_s) {
      rig::RigPose pose(take.skeleton);
      pose.translations[0].y() = static_cast<float>(time_s);
      take.frames.push_back(pose);
    }
    return take;
  }
  static std::vector<double> Regular(int count, double rate_hz, double jitter = 0) {
    std::vector<double> times_s;
    for (int i = 0; i < count; ++i) {
      times_s.push_back((i + (i % 3 == 1 ? jitter : 0)) / rate_hz);
    }
    return times_s;
  }
};

TEST_F(ToClipTest, OneFrameRatesOutOfRangeAndEndlessSilencesAreRefused) {
  EXPECT_THAT(ToClip(At({0}), 0).status().message(), HasSubstr("found one frame"));
  EXPECT_THAT(ToClip(At({0, 1}), 2000).status().message(), HasSubstr("expected 1 to 1000"));
  EXPECT_THAT(ToClip(At({0, 0.01, 0.02, 1e6}), 0).status().message(),
              HasSubstr("found 4 frames in 1000000 s, expected at most 100064 at a constant rate"));
}

TEST_F(ToClipTest, TheRateIsTheOneThatIsMeant) {
  const double ntsc_hz = 60000.0 / 1001;
  for (const double rate_hz :
       {24.0, 30.0, ntsc_hz, 60.0, 100.0, 119.88011988, 120.0, 240.0, 33.3}) {
    EXPECT_NEAR(ToClip(At(Regular(50, rate_hz)), 0).value().rate_hz, rate_hz, 1e-6);
    EXPECT_NEAR(ToClip(At(Regular(50, rate_hz * 1.0001)), 0).value().rate_hz / rate_hz, 1, 2e-4);
  }
}

TEST_F(ToClipTest, ARigNearAUsualRateGetsThatRateAndKeepsItsTimes) {
  for (const auto [rate_hz, usual_hz] : {std::pair{59.6, 60.0}, {119.2, 120.0}, {98.5, 100.0}}) {
    const auto clip = ToClip(At(Regular(400, rate_hz)), 0).value();
    EXPECT_EQ(clip.rate_hz, usual_hz);
    // The hips' height is the time.
    for (std::size_t i = 0; i < clip.frames.size(); ++i) {
      ASSERT_NEAR(clip.frames[i].translations[0].y(), static_cast<double>(i) / usual_hz, 1e-5);
    }
    EXPECT_NEAR(static_cast<double>(clip.frames.size()), 399 / rate_hz * usual_hz, 1.01);
  }
  EXPECT_NEAR(ToClip(At(Regular(50, 33.3)), 0).value().rate_hz, 33.3, 1e-6);
}

TEST_F(ToClipTest, FramesThatKeepTheRateAreTakenAsTheyAre) {
  const Take take = At(Regular(50, 120, 0.2));
  const auto clip = ToClip(take, 0);
  ASSERT_TRUE(clip.ok());
  ASSERT_EQ(clip.value().frames.size(), 50U);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(clip.value().frames[i].translations[0], take.frames[i].translations[0]);
  }
  EXPECT_TRUE(clip.value().skeleton.offsets[0].isZero()) << "readers add it to the position";
}

TEST_F(ToClipTest, GapsAreBridgedSoThatTimeIsKept) {
  std::vector<double> times_s = Regular(20, 100);
  times_s.erase(times_s.begin() + 5, times_s.begin() + 9);
  const auto clip = ToClip(At(times_s), 0);
  ASSERT_TRUE(clip.ok());
  EXPECT_EQ(clip.value().rate_hz, 100);
  ASSERT_EQ(clip.value().frames.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(clip.value().frames[i].translations[0].y(), static_cast<double>(i) / 100, 1e-6);
  }
}

TEST_F(ToClipTest, AnotherRateKeepsTheTimeToo) {
  const Take take = At(Regular(101, 100));
  const auto clip = ToClip(take, 30);
  ASSERT_TRUE(clip.ok());
  EXPECT_EQ(clip.value().rate_hz, 30);
  ASSERT_EQ(clip.value().frames.size(), 31U);
  const auto motion = ToMotion(take, 30, *clip::FindFormat("a.glb").value()).value();
  EXPECT_TRUE(motion.times_s.empty());
  EXPECT_EQ(motion.rate_hz, 30);
  EXPECT_EQ(motion.skeleton.offsets[0], take.skeleton.offsets[0]);
  ASSERT_EQ(motion.frames.size(), 31U);
  for (std::size_t i = 0; i < 31; ++i) {
    EXPECT_NEAR(motion.frames[i].translations[0].y(), static_cast<double>(i) / 30, 1e-5);
  }
}

TEST_F(ToClipTest, AFormatKeepsTheFramesTimesOrTakesAConstantRate) {
  const Take take = At(Regular(50, 120, 0.2));
  const auto glb = ToMotion(take, 0, *clip::FindFormat("a.glb").value()).value();
  EXPECT_EQ(glb.times_s, take.times_s);
  EXPECT_EQ(glb.skeleton.offsets[0], take.skeleton.offsets[0]);
  const auto bvh = ToMotion(take, 0, *clip::FindFormat("a.bvh").value()).value();
  EXPECT_TRUE(bvh.times_s.empty());
  EXPECT_EQ(bvh.rate_hz, 120);
  EXPECT_TRUE(bvh.skeleton.offsets[0].isZero());
}

}  // namespace
}  // namespace styled::rec
