#include "model/stylist/clip_stylist.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <deque>
#include <limits>

#include "model/rig/dialects.h"
#include "model/synthetic/performer.h"
#include "model/synthetic/synthesis.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::stylist {
namespace {

// A clip network that is a live network in disguise: it steps it with each pose, but gives the
// predictions `delay` poses late, or all at the end (-1). The output of a ClipStylist with it must
// be that of a Stylist with the live network, bit for bit.
class Disguised final : public net::ClipStylizer {
 public:
  Disguised(std::shared_ptr<const net::Stylizer> network, int style, float weight, int delay)
      : network_(std::move(network)), active_{style, weight}, delay_(delay) {}

  const net::Model& model() const noexcept override { return network_->model(); }
  int least_frames() const noexcept override { return 1; }
  net::StyleCode MakeCode(const net::StyleRequest&) const override { return {}; }
  net::NearestStyle Nearest(const net::StyleCode&) const override { return {}; }
  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode&, int input_style,
                                              net::Extent) const override {
    return std::make_unique<Stream>(*this, input_style);
  }

  // The most predictions that ever waited in one stream.
  mutable std::size_t most_waiting = 0;
  mutable int streams = 0;
  int break_at = -1;  // the pose whose prediction is not a number

 private:
  class Stream final : public net::ClipStream {
   public:
    Stream(const Disguised& owner, int input_style)
        : owner_(owner), input_style_(input_style), stream_(owner.network_->MakeStream()) {
      ++owner.streams;
    }
    void Add(const body::Pose& pose) override {
      net::Prediction& out = waiting_.emplace_back();
      const net::StepJob job{&pose, input_style_, {&owner_.active_, 1}, stream_.get(), &out};
      owner_.network_->Step({&job, 1});
      if (added_++ == owner_.break_at) {
        out.styled.rotations[3].w() = std::numeric_limits<float>::quiet_NaN();
      }
      owner_.most_waiting = std::max(owner_.most_waiting, waiting_.size());
    }
    void End() override { ended_ = true; }
    bool Pop(net::Prediction& out) override {
      const bool late =
          owner_.delay_ >= 0 && waiting_.size() > static_cast<std::size_t>(owner_.delay_);
      if (waiting_.empty() || (!ended_ && !late)) return false;
      out = waiting_.front();
      waiting_.pop_front();
      return true;
    }

   private:
    const Disguised& owner_;
    int input_style_;
    std::unique_ptr<net::Stream> stream_;
    std::deque<net::Prediction> waiting_;
    int added_ = 0;
    bool ended_ = false;
  };

  std::shared_ptr<const net::Stylizer> network_;
  net::StyleWeight active_;
  int delay_;
};

struct ClipStylistTest : testing::Test {
  static constexpr int kStyle = 2;
  static constexpr float kWeight = 0.8F;

  std::vector<rig::RigPose> Walk(double rate_hz, int count) const {
    synthetic::Performer performer(synthetic::Options{});
    std::vector<rig::RigPose> frames;
    for (int i = 0; i < count; ++i) {
      body::Pose pose;
      performer.Pose(i / rate_hz, pose);
      rig::RigPose& frame = frames.emplace_back(skeleton);
      frame.translations[0] = pose.hips_position_m;
      std::copy(pose.rotations.begin(), pose.rotations.end(), frame.rotations.begin());
    }
    return frames;
  }
  static ClipFrames Of(const std::vector<rig::RigPose>& frames, double rate_hz) {
    return {frames.size(), rate_hz,
            [&frames](std::size_t i) -> const rig::RigPose& { return frames[i]; }};
  }
  ClipStyle Style() const {
    ClipStyle style;
    style.weight = kWeight;
    return style;
  }
  static void ExpectSame(const Output& a, const Output& b, std::size_t frame) {
    const std::size_t joints = a.rig.rotations.size();
    EXPECT_EQ(a.flags, b.flags) << frame;
    EXPECT_EQ(a.contacts, b.contacts) << frame;
    EXPECT_EQ(a.steps, b.steps) << frame;
    EXPECT_EQ(a.reconstruction_rad, b.reconstruction_rad) << frame;
    ASSERT_EQ(
        std::memcmp(a.rig.rotations.data(), b.rig.rotations.data(), joints * sizeof(rig::Quat)), 0)
        << frame;
    ASSERT_EQ(std::memcmp(a.rig.translations.data(), b.rig.translations.data(),
                          joints * sizeof(rig::Vec3)),
              0)
        << frame;
  }

  std::shared_ptr<const net::Stylizer> network = erd::RandomStylizer(5, 1);
  rig::Skeleton skeleton = synthetic::MakeSkeleton({});
  std::shared_ptr<const rig::Binding> binding =
      std::make_shared<const rig::Binding>(std::move(rig::BindDialect(skeleton, "auto").value()));
  Options options;
};

TEST_F(ClipStylistTest, GivesWhatTheStylistGivesBitForBit) {
  for (const double rate_hz : {30.0, 50.0, 60.0, 120.0}) {
    const std::vector<rig::RigPose> frames = Walk(rate_hz, 400);
    for (const int delay : {0, 7, 200, -1}) {
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, delay " << delay);
      Stylist live(network, binding, options);
      Settings settings;
      settings.transition_s = 0;
      settings.mix[0] = {kStyle, kWeight};
      live.Set(settings);
      const auto clip_network = std::make_shared<Disguised>(network, kStyle, kWeight, delay);
      ClipStylist clip(clip_network, Style(), binding, options, Of(frames, rate_hz));
      Output expected(skeleton), found(skeleton);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        live.Process(static_cast<std::int64_t>(static_cast<double>(i) / rate_hz * 1e9), frames[i],
                     expected);
        clip.Next(found);
        ExpectSame(found, expected, i);
        if (HasFatalFailure()) return;
      }
      EXPECT_EQ(clip_network->streams, std::max(1L, std::lround(rate_hz / 30)));
    }
  }
}

TEST_F(ClipStylistTest, AheadByNoMoreThanTheNetworkNeeds) {
  const std::vector<rig::RigPose> frames = Walk(60, 1000);
  const auto clip_network = std::make_shared<Disguised>(network, kStyle, kWeight, 20);
  std::size_t read = 0;
  ClipFrames source = Of(frames, 60);
  source.frame = [&](std::size_t i) -> const rig::RigPose& {
    read = std::max(read, i);
    return frames[i];
  };
  ClipStylist clip(clip_network, Style(), binding, options, source);
  Output out(skeleton);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    clip.Next(out);
    // Two streams at 30 Hz: 20 poses of delay, and as many predictions as one frame can take.
    EXPECT_LE(read, i + 2 * (20 + kMaxStepsPerFrame) + 10);
  }
  EXPECT_LE(clip_network->most_waiting, 21U);
}

TEST_F(ClipStylistTest, WithoutWeightTheInputComesBackBitForBit) {
  const std::vector<rig::RigPose> frames = Walk(60, 100);
  ClipStyle style;
  style.weight = 0;
  ClipStylist clip(std::make_shared<Disguised>(network, kStyle, 1, -1), style, binding, options,
                   Of(frames, 60));
  Output out(skeleton);
  for (const rig::RigPose& frame : frames) {
    clip.Next(out);
    EXPECT_NE(out.flags & kBypass, 0U);
    for (std::size_t joint = 0; joint < frame.rotations.size(); ++joint) {
      ASSERT_EQ(out.rig.rotations[joint].coeffs(), frame.rotations[joint].coeffs());
    }
  }
}

// A prediction that is not sound costs its frames, and no other prediction is given in its place.
TEST_F(ClipStylistTest, AFrameThatIsNotSoundIsThePerformersOwn) {
  const std::vector<rig::RigPose> frames = Walk(30, 200);
  std::vector<Output> whole, broken;
  for (const int break_at : {-1, 50}) {
    const auto clip_network = std::make_shared<Disguised>(network, kStyle, kWeight, -1);
    clip_network->break_at = break_at;
    ClipStylist clip(clip_network, Style(), binding, options, Of(frames, 30));
    std::vector<Output>& outputs = break_at < 0 ? whole : broken;
    for (std::size_t i = 0; i < frames.size(); ++i) clip.Next(outputs.emplace_back(skeleton));
  }
  EXPECT_EQ(whole[50].flags & kFailed, 0U);
  EXPECT_NE(broken[50].flags & kFailed, 0U);
  EXPECT_EQ(broken[50].rig.rotations[1].coeffs(), frames[50].rotations[1].coeffs());
  EXPECT_EQ(broken[51].flags & kFailed, 0U);
  // Long after, both are the same again: no step was lost.
  for (std::size_t joint = 0; joint < frames[0].rotations.size(); ++joint) {
    EXPECT_LT(broken[199].rig.rotations[joint].angularDistance(whole[199].rig.rotations[joint]),
              0.01F)
        << joint;
  }
}

TEST_F(ClipStylistTest, OneFrameIsEnough) {
  const std::vector<rig::RigPose> frames = Walk(30, 1);
  ClipStylist clip(std::make_shared<Disguised>(network, kStyle, kWeight, -1), Style(), binding,
                   options, Of(frames, 30));
  Output out(skeleton);
  clip.Next(out);
  EXPECT_EQ(out.flags & (kFailed | kBypass), 0U);
  EXPECT_EQ(out.steps, 1);
}

}  // namespace
}  // namespace styled::stylist
