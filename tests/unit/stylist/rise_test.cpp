// How far a style raises the hips.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {
namespace {

// Changes nothing but the hips' height: by `raise_m` + `bounce_m` sin(2π 2 Hz t) for each weight of
// style.
class Raising final : public net::Stylizer {
 public:
  Raising(float raise_m, float bounce_m) : raise_m_(raise_m), bounce_m_(bounce_m) {
    model_.styles = {{"neutral", {}}, {"high", {}}};
  }
  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override { return std::make_unique<Clock>(); }
  void Start(net::Stream& stream) const noexcept override { static_cast<Clock&>(stream).steps = 0; }
  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) {
      const auto time_s =
          static_cast<float>(static_cast<Clock&>(*job.stream).steps++) / model_.rate_hz;
      net::Prediction& out = *job.out;
      out.reconstruction.rotations = job.pose->rotations;
      out.reconstruction.velocities_m_s.fill(0);
      out.reconstruction.hips_height_m = job.pose->hips_position_m.y();
      out.styled = out.reconstruction;
      const float bounce_m = bounce_m_ * std::sin(4 * static_cast<float>(M_PI) * time_s);
      for (const net::StyleWeight& style : job.styles) {
        out.styled.hips_height_m += style.weight * (raise_m_ + bounce_m);
      }
    }
  }

 private:
  struct Clock final : net::Stream {
    std::span<const std::byte> memory() const noexcept override { return {}; }
    int steps = 0;
  };
  net::Model model_;
  float raise_m_, bounce_m_;
};

struct RiseTest : testing::Test {
  const std::shared_ptr<const rig::Binding> binding = [] {
    rig::Skeleton skeleton;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      skeleton.names.emplace_back(body::kHumanoid[static_cast<std::size_t>(joint)].name);
      skeleton.parents.push_back(body::kHumanoid[static_cast<std::size_t>(joint)].parent);
      skeleton.offsets.push_back(body::Offset(joint));
    }
    return std::make_shared<const rig::Binding>(
        std::move(rig::BindDialect(skeleton, "canonical").value()));
  }();
  Options options;
  Settings settings = [] {
    Settings high;
    high.mix[0] = {1, 1.0F};
    high.transition_s = 0;
    return high;
  }();

  // The rises of a standing performer's hips at 120 Hz, m; both skeletons agree.
  std::vector<float> Rises(float raise_m, float bounce_m, int frames) const {
    Stylist stylist(std::make_shared<Raising>(raise_m, bounce_m), binding, options);
    stylist.Set(settings);
    rig::RigPose standing(binding->skeleton());
    standing.translations[0].y() = 0.97F;
    Output out(binding->skeleton());
    std::vector<float> rises_m;
    for (int frame = 0; frame < frames; ++frame) {
      stylist.Process(std::llround(1e9 * frame / 120), standing, out);
      rises_m.push_back(out.canonical.hips_position_m.y() -
                        out.canonical_input.hips_position_m.y());
      EXPECT_NEAR((out.rig.translations[0].y() - standing.translations[0].y()) * binding->scale(),
                  rises_m.back(), 1e-4F);
    }
    return rises_m;
  }
  static float Swing(std::span<const float> of) {
    return *std::max_element(of.begin(), of.end()) - *std::min_element(of.begin(), of.end());
  }
};

TEST_F(RiseTest, TheHipsRiseByWhatTheNetworkChanges) {
  options.ground = options.feet = false;
  for (const float rise_m : Rises(0.04F, 0, 120)) EXPECT_NEAR(rise_m, 0.04F, 1e-4F);
  settings.strength = 0.5F;
  EXPECT_NEAR(Rises(0.04F, 0, 120).back(), 0.02F, 1e-4F);
  settings.parts = *body::FindParts("upper");
  EXPECT_EQ(Rises(0.04F, 0, 120).back(), 0) << "the legs are not styled";
}

TEST_F(RiseTest, OnTheGroundTheBounceRemains) {
  options.feet = false;
  EXPECT_NEAR(Rises(0.04F, 0, 240).back(), 0, 2e-3F) << "and the feet come down to the floor";
  const std::vector<float> bouncing = Rises(0, 0.02F, 480);
  EXPECT_NEAR(Swing(std::span(bouncing).last(240)), 0.04F, 0.01F);
}

}  // namespace
}  // namespace styled::stylist
