#include "model/net/several.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace styled::net {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// The calls of a test's networks.
struct Asked {
  int starts = 0, steps = 0;
  int input_style = -1;
  int content = kContentRecognized;
  std::vector<int> variations;
};

struct FakeStream final : Stream {
  std::span<const std::byte> memory() const noexcept override { return {}; }
  int since_start = -1;
};

// Codes of one number: the turn of the head about X, radians.
class FakeSpace final : public StyleSpace {
 public:
  explicit FakeSpace(std::vector<float> means) : means_(std::move(means)) {}
  int least_frames() const noexcept override { return 10; }
  StyleCode MakeCode(const StyleRequest& request) const override {
    float sum = 0;
    for (const StyleSource& source : request.sources) {
      sum += source.style < 0 ? 5.0F : means_[static_cast<std::size_t>(source.style)];
    }
    return {sum};
  }
  NearestStyle Nearest(const StyleCode& code) const override {
    return {code[0] > 0 ? static_cast<int>(means_.size()) - 1 : 0, 0.5F};
  }

 private:
  std::vector<float> means_;
};

// Turns the head about an axis of its own, by `turns` of each style, on top of a reconstruction
// that is off by `off_rad`.
class Fake final : public Stylizer {
 public:
  Fake(std::vector<std::string> names, std::vector<float> turns, body::Vec3 axis, float off_rad,
       std::shared_ptr<Asked> asked, float rate_hz = 30, bool space = false)
      : turns_(std::move(turns)), axis_(axis), off_rad_(off_rad), asked_(std::move(asked)) {
    model_.family = "fake";
    model_.rate_hz = rate_hz;
    for (std::string& name : names) model_.styles.push_back({.name = std::move(name)});
    if (space) space_ = std::make_shared<const FakeSpace>(turns_);
  }
  const Model& model() const noexcept override { return model_; }
  const StyleSpace* space() const noexcept override { return space_.get(); }
  std::shared_ptr<const Stylizer> With(int number, const StyleInfo& style,
                                       const StyleCode& code) const override {
    auto with = Copy();
    const auto at = static_cast<std::size_t>(number);
    with->model_.styles.resize(std::max(with->model_.styles.size(), at + 1));
    with->turns_.resize(with->model_.styles.size());
    with->model_.styles[at] = style;
    with->turns_[at] = code[0];
    return with;
  }
  std::shared_ptr<const Stylizer> Retired(int number) const override {
    auto without = Copy();
    without->model_.styles[static_cast<std::size_t>(number)].retired = true;
    return without;
  }
  bool SharesStreams(const Stylizer& other) const noexcept override {
    const auto* const fake = dynamic_cast<const Fake*>(&other);
    return fake != nullptr && fake->asked_ == asked_;
  }
  std::unique_ptr<Stream> MakeStream() const override { return std::make_unique<FakeStream>(); }
  void Start(Stream& stream) const noexcept override {
    static_cast<FakeStream&>(stream).since_start = 0;
    ++asked_->starts;
  }
  void Step(std::span<const StepJob> jobs) const noexcept override {
    for (const StepJob& job : jobs) {
      EXPECT_GE(static_cast<FakeStream&>(*job.stream).since_start++, 0) << "not started";
      ++asked_->steps;
      seen = *job.pose;
      asked_->input_style = job.input_style;
      asked_->content = job.content;
      asked_->variations.clear();
      for (const VariationWeight& one : job.variations) asked_->variations.push_back(one.variation);
      float turn = 0;
      for (const StyleWeight& style : job.styles) {
        turn += style.weight * turns_[static_cast<std::size_t>(style.style)];
      }
      Decoded& rec = job.out->reconstruction;
      rec.rotations = job.pose->rotations;
      rec.rotations[body::kHead] =
          rec.rotations[body::kHead] * body::Exp(body::Vec3(off_rad_, 0, 0));
      rec.velocities_m_s.fill(0);
      rec.hips_height_m = 1;
      job.out->styled = rec;
      job.out->styled.rotations[body::kHead] =
          rec.rotations[body::kHead] * body::Exp(body::Vec3(turn * axis_));
      job.out->styled.hips_height_m = 1 + turn;
      job.out->styled.velocities_m_s[0] = velocity;
      job.out->heading_rad = off_rad_;
    }
  }

  // Its performers hold their spine so.
  void KnowSpine(float rad) {
    model_.reference.emplace().walking.rotations[body::kSpine] = body::Exp(body::Vec3(rad, 0, 0));
  }
  void Gate(const GateBounds& bounds) { model_.gate = bounds; }
  void SetContents(Contents contents) { model_.contents = std::move(contents); }

  float velocity = 0;
  mutable body::Pose seen;  // of the last step

 private:
  std::shared_ptr<Fake> Copy() const {
    auto copy = std::make_shared<Fake>(std::vector<std::string>(), turns_, axis_, off_rad_, asked_);
    copy->model_ = model_;
    copy->space_ = space_;
    return copy;
  }

  Model model_;
  std::vector<float> turns_;
  body::Vec3 axis_;
  float off_rad_;
  std::shared_ptr<Asked> asked_;
  std::shared_ptr<const FakeSpace> space_;
};

class SeveralTest : public testing::Test {
 protected:
  SeveralTest() {
    first = std::make_shared<Fake>(std::vector<std::string>{"neutral", "old", "proud"},
                                   std::vector<float>{0, 0.2F, 0.4F}, body::Vec3::UnitX(), 0.01F,
                                   asked_first);
    second = std::make_shared<Fake>(std::vector<std::string>{"neutral", "pirate", "OLD"},
                                    std::vector<float>{0, 0.3F, 0.5F}, body::Vec3::UnitY(), 0.02F,
                                    asked_second, 30.0F, true);
    both = Combine({{"v2", first}, {"graph", second}}).value();
    stream = both->MakeStream();
    both->Start(*stream);
    for (body::Quat& q : pose.rotations) q = body::Quat::Identity();
  }

  Prediction Step(std::vector<StyleWeight> styles, int input_style = 0) {
    return StepOn(*both, std::move(styles), input_style);
  }
  Prediction StepOn(const Stylizer& network, std::vector<StyleWeight> styles, int input_style) {
    Prediction out;
    const StepJob job{&pose, input_style, styles, stream.get(), &out};
    network.Step({&job, 1});
    return out;
  }
  void StepVaried(std::vector<StyleWeight> styles, std::vector<VariationWeight> variations) {
    Prediction out;
    const StepJob job{&pose, 0, styles, stream.get(), &out, variations};
    both->Step({&job, 1});
  }
  static body::Vec3 Turn(const Prediction& out) {
    return body::Log(out.reconstruction.rotations[body::kHead].conjugate() *
                     out.styled.rotations[body::kHead]);
  }

  std::shared_ptr<Asked> asked_first = std::make_shared<Asked>();
  std::shared_ptr<Asked> asked_second = std::make_shared<Asked>();
  std::shared_ptr<Fake> first, second;
  std::shared_ptr<const Stylizer> both;
  std::unique_ptr<Stream> stream;
  body::Pose pose;
};

// The numbers in `both`: 0 neutral, 1 old, 2 proud, 3 pirate, 4 graph-OLD.
constexpr int kOld = 1, kPirate = 3, kGraphOld = 4;

TEST_F(SeveralTest, NetworksThatCannotWorkTogetherAreRefused) {
  const auto fast =
      std::make_shared<Fake>(std::vector<std::string>{"neutral"}, std::vector<float>{0},
                             body::Vec3::UnitX(), 0.0F, asked_first, 60.0F);
  const auto rates = Combine({{"v2", first}, {"fast", fast}});
  ASSERT_FALSE(rates.ok());
  EXPECT_THAT(rates.status().message(), HasSubstr("fast: works at 60"));
  const auto names = Combine({{"v2", first}, {"v2", second}});
  ASSERT_FALSE(names.ok());
  EXPECT_THAT(names.status().message(), HasSubstr("two networks have the name v2"));
  std::vector<NamedNetwork> many;
  for (std::size_t i = 0; i <= kMaxNetworks; ++i) many.push_back({std::to_string(i), first});
  EXPECT_THAT(Combine(many).status().message(), HasSubstr("found 5 networks, expected at most 4"));
}

TEST_F(SeveralTest, OneNetworkIsItself) { EXPECT_EQ(Combine({{"v2", first}}).value(), first); }

// Poses come with the carriage of the first network's performers; each network sees its own's.
TEST_F(SeveralTest, EachNetworkSeesThePerformersThatItKnows) {
  first->KnowSpine(0.1F);
  second->KnowSpine(0.3F);
  both = Combine({{"v2", first}, {"graph", second}}).value();
  ASSERT_TRUE(both->model().reference);
  stream = both->MakeStream();
  both->Start(*stream);
  pose.rotations[body::kSpine] = body::Exp(body::Vec3(0.1F, 0, 0));
  const Prediction out = Step({{kPirate, 1}});
  const auto spine = [](const auto& rotations) {
    return static_cast<double>(body::Log(rotations[body::kSpine]).x());
  };
  EXPECT_NEAR(spine(second->seen.rotations), 0.3, 1e-5);
  EXPECT_NEAR(spine(out.reconstruction.rotations), 0.1, 1e-5) << "of the pose that was given";
  EXPECT_NEAR(Turn(out).y(), 0.3, 1e-5) << "the change of style is the same";
  (void)Step({{kOld, 1}});
  EXPECT_NEAR(spine(first->seen.rotations), 0.1, 1e-5);
}

TEST_F(SeveralTest, TheNarrowestBoundsOfTheLimbGatesApply) {
  first->Gate({.arms = {0.1F, 0.5F}, .trunk = {0.2F, 0.3F}, .legs = {0.3F, 0.6F}});
  second->Gate({.arms = {0.2F, 0.4F}, .trunk = {0.1F, 0.2F}, .legs = {0.4F, 0.7F}});
  both = Combine({{"v2", first}, {"graph", second}}).value();
  const GateBounds expected{.arms = {0.1F, 0.4F}, .trunk = {0.1F, 0.2F}, .legs = {0.3F, 0.6F}};
  EXPECT_EQ(both->model().gate, expected);
}

TEST_F(SeveralTest, ANetworkWithoutAReferenceSeesThePoseAsItIs) {
  first->KnowSpine(0.1F);
  both = Combine({{"v2", first}, {"graph", second}}).value();
  stream = both->MakeStream();
  both->Start(*stream);
  (void)Step({{kPirate, 1}});
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    EXPECT_EQ(second->seen.rotations[j].coeffs(), pose.rotations[j].coeffs());
  }
}

TEST_F(SeveralTest, EachStyleIsListedOnceUnderANameOfItsOwn) {
  std::vector<std::string> names, models;
  for (const StyleInfo& style : both->model().styles) {
    names.push_back(style.name);
    models.push_back(style.model);
  }
  EXPECT_THAT(names, ElementsAre("neutral", "old", "proud", "pirate", "graph-OLD"));
  EXPECT_THAT(models, ElementsAre("v2", "v2", "v2", "graph", "graph"));
  EXPECT_EQ(both->model().styles[kGraphOld].original, "OLD");
}

TEST_F(SeveralTest, OneNetworksStyleIsItsPredictionBitForBit) {
  for (const int style : {kOld, kPirate}) {
    both->Start(*stream);
    const Prediction out = Step({{style, 0.7F}});
    const Stylizer& alone = style == kOld ? *first : *second;
    Prediction expected;
    FakeStream own;
    own.since_start = 0;
    const StyleWeight theirs[] = {{1, 0.7F}};
    const StepJob job{&pose, 0, theirs, &own, &expected};
    alone.Step({&job, 1});
    EXPECT_EQ(out.heading_rad, expected.heading_rad);
    EXPECT_EQ(out.styled.hips_height_m, expected.styled.hips_height_m);
    for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
      EXPECT_EQ(out.styled.rotations[joint].coeffs(), expected.styled.rotations[joint].coeffs());
    }
  }
}

TEST_F(SeveralTest, ChangesOfSeveralNetworksAddUp) {
  const Prediction out = Step({{kOld, 0.5F}, {kPirate, 0.4F}});
  EXPECT_NEAR((Turn(out) - body::Vec3(0.1F, 0.12F, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR(out.styled.hips_height_m - out.reconstruction.hips_height_m, 0.1F + 0.12F, 1e-6);
  // The reconstruction is that of the network with the larger share.
  EXPECT_EQ(out.heading_rad, 0.01F);
  EXPECT_EQ(Step({{kOld, 0.4F}, {kPirate, 0.5F}}).heading_rad, 0.02F);
}

TEST_F(SeveralTest, WithoutAStyleTheFirstNetworkWorksAlone) {
  const Prediction out = Step({});
  EXPECT_NEAR(Turn(out).norm(), 0, 1e-6);
  EXPECT_EQ(asked_first->steps, 1);
  EXPECT_EQ(asked_second->steps, 0);
}

TEST_F(SeveralTest, ANetworkSleepsSomeTimeAfterItsLastStyle) {
  const int stay = static_cast<int>(kStayAwake_s * 30);
  Step({{kPirate, 1.0F}});
  EXPECT_EQ(asked_second->steps, 1);
  EXPECT_EQ(asked_first->steps, 0);
  for (int i = 0; i < stay + 50; ++i) Step({});
  EXPECT_EQ(asked_second->steps, stay);
  EXPECT_EQ(asked_first->steps, stay + 50);
}

// A network that begins in the middle of a stream shows its change by and by; one that begins with
// it, at once.
TEST_F(SeveralTest, ANetworkThatWakesUpFadesIn) {
  EXPECT_NEAR(Turn(Step({{kOld, 1.0F}})).norm(), 0.2, 1e-5);
  float last = 0;
  for (int i = 1; i <= kWakeSteps; ++i) {
    const float turn = Turn(Step({{kPirate, 1.0F}})).norm();
    EXPECT_GT(turn, last);
    EXPECT_LT(turn - last, 0.3F / 3);
    last = turn;
  }
  EXPECT_NEAR(last, 0.3, 1e-5);
  EXPECT_EQ(asked_second->starts, 1);
}

TEST_F(SeveralTest, TheInputStyleIsEachNetworksOwn) {
  Step({{kPirate, 1.0F}}, kOld);
  EXPECT_EQ(asked_second->input_style, 2);  // its OLD
  Step({{kOld, 1.0F}}, kGraphOld);
  EXPECT_EQ(asked_first->input_style, 1);
  Step({{kPirate, 1.0F}}, 2);  // proud, which it lacks
  EXPECT_EQ(asked_second->input_style, 0);
}

TEST_F(SeveralTest, TheContentIsEachNetworksOwn) {
  first->SetContents({"walk", "run"});
  second->SetContents({"kick", "Walk"});
  both = Combine({{"v2", first}, {"graph", second}}).value();
  EXPECT_THAT(both->model().contents, ElementsAre("walk", "run", "kick"));
  stream = both->MakeStream();
  both->Start(*stream);
  const std::vector<StyleWeight> styles{{kOld, 0.5F}, {kPirate, 0.5F}};
  const auto step = [&](int content) {
    Prediction out;
    const StepJob job{&pose, 0, styles, stream.get(), &out, {}, nullptr, content};
    both->Step({&job, 1});
    return std::pair(asked_first->content, asked_second->content);
  };
  EXPECT_EQ(step(0), std::pair(0, 1));
  EXPECT_EQ(step(1), std::pair(1, kContentUnknown));
  EXPECT_EQ(step(2), std::pair(kContentUnknown, 0));
  EXPECT_EQ(step(kContentUnknown), std::pair(kContentUnknown, kContentUnknown));
  EXPECT_EQ(step(kContentRecognized), std::pair(kContentRecognized, kContentRecognized));
  // With(), too: a copy of the networks.
  auto with = both->With(static_cast<int>(both->model().styles.size()), {}, {0.1F});
  Prediction out;
  const StepJob job{&pose, 0, styles, stream.get(), &out, {}, nullptr, 2};
  with->Step({&job, 1});
  EXPECT_EQ(asked_second->content, 0);
}

TEST_F(SeveralTest, AnInvalidStyleIsIgnored) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Prediction out = Step({{-1, 1.0F}, {99, 1.0F}, {kPirate, nan}, {kOld, 1.0F}}, 77);
  EXPECT_NEAR(Turn(out).norm(), 0.2, 1e-5);
}

TEST_F(SeveralTest, AnInfiniteValueOfOneNetworkIsNotHidden) {
  second->velocity = std::numeric_limits<float>::infinity();
  const Prediction out = Step({{kOld, 0.6F}, {kPirate, 0.4F}});
  EXPECT_FALSE(std::isfinite(out.styled.velocities_m_s[0]));
}

TEST_F(SeveralTest, StylesOfExamplesBelongToTheNetworkThatTakesThem) {
  const StyleSpace& space = *both->space();
  EXPECT_EQ(space.MakeCode({.sources = {{.style = kPirate}}}), StyleCode{0.3F});
  // A style that the network lacks is its own of the same name.
  EXPECT_EQ(space.MakeCode({.sources = {{.style = kOld}}}), StyleCode{0.5F});
  EXPECT_EQ(space.Nearest({1.0F}).style, kGraphOld);
  EXPECT_EQ(space.Nearest({-1.0F}).style, 0);

  const auto more = both->With(5, {.name = "mine"}, {0.25F});
  ASSERT_EQ(more->model().styles.size(), 6U);
  EXPECT_EQ(more->model().styles[5].name, "mine");
  EXPECT_EQ(more->model().styles[5].model, "graph");
  EXPECT_TRUE(more->SharesStreams(*both));
  EXPECT_NEAR((Turn(StepOn(*more, {{5, 1.0F}}, 0)) - body::Vec3(0, 0.25F, 0)).norm(), 0, 1e-5);
  const auto other = more->With(5, {.name = "next"}, {0.1F});
  EXPECT_NEAR(Turn(StepOn(*other, {{5, 1.0F}}, 0)).y(), 0.1F, 1e-5);
  EXPECT_TRUE(other->Retired(5)->model().styles[5].retired);
  EXPECT_EQ(both->model().styles.size(), 5U);
}

TEST_F(SeveralTest, VariationsReachEachNetwork) {
  StepVaried({{1, 0.5F}, {3, 0.5F}}, {{7, 0.5F}, {8, 0.25F}});
  EXPECT_THAT(asked_first->variations, ElementsAre(7, 8));
  EXPECT_THAT(asked_second->variations, ElementsAre(7, 8));
  StepVaried({{3, 1}}, {});
  EXPECT_THAT(asked_second->variations, ElementsAre());
}

}  // namespace
}  // namespace styled::net
