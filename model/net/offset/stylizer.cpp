#include "model/net/offset/stylizer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace styled::offset {
namespace {

constexpr const char* kTensor = "offset.rotation";
constexpr int kColumns = 4 * body::kJointCount;
constexpr float kUnitTolerance = 1e-3F;  // of a rotation's length

// Rotation vectors per joint, so that styles can be weighted and added.
using Turns = Eigen::Matrix<float, 3, body::kJointCount>;

// The family is stateless: no frame depends on an earlier one.
class NoMemory final : public net::Stream {
 public:
  std::span<const std::byte> memory() const noexcept override { return {}; }
};

// A style's weight within the limits that Stylizer::Step states.
float Clamped(float weight) noexcept {
  return weight > 0 ? std::min(weight, net::kMaxStrength) : 0.0F;  // 0 also for NaN
}

class OffsetStylizer final : public net::Stylizer {
 public:
  OffsetStylizer(net::Model model, std::vector<Turns> turns)
      : model_(std::move(model)), turns_(std::move(turns)) {}

  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override { return std::make_unique<NoMemory>(); }
  void Start(net::Stream&) const noexcept override {}
  void Carry(net::Stream&, Checkpoint&) const noexcept override {}

  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) StepOne(job);
  }

 private:
  // styled = input · exp(Σ_s α_s log o_s - log o_S), where S is the input style.
  void StepOne(const net::StepJob& job) const noexcept {
    const int count = static_cast<int>(turns_.size());
    std::array<net::StyleWeight, net::kMaxActive> active;
    std::size_t used = 0;
    for (const net::StyleWeight& style : job.styles) {
      if (style.style <= 0 || style.style >= count) continue;
      const auto begin = active.begin();
      const auto end = begin + static_cast<std::ptrdiff_t>(used);
      const auto known = std::find_if(
          begin, end, [&style](const net::StyleWeight& one) { return one.style == style.style; });
      if (known != end) {
        known->weight = Clamped(known->weight + Clamped(style.weight));
      } else if (used < active.size()) {
        active[used++] = {style.style, Clamped(style.weight)};
      }
    }
    Turns turn = Turns::Zero();
    for (std::size_t i = 0; i < used; ++i) {
      turn += active[i].weight * turns_[static_cast<std::size_t>(active[i].style)];
    }
    if (job.input_style > 0 && job.input_style < count) {
      turn -= turns_[static_cast<std::size_t>(job.input_style)];
    }
    net::Prediction& out = *job.out;
    out.heading_rad = 0;
    out.reconstruction.rotations = job.pose->rotations;
    out.reconstruction.velocities_m_s.fill(0);
    out.reconstruction.hips_height_m = job.pose->hips_position_m.y();
    out.styled = out.reconstruction;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      body::Quat& rotation = out.styled.rotations[static_cast<std::size_t>(joint)];
      rotation = (rotation * body::Exp(turn.col(joint))).normalized();
    }
  }

  net::Model model_;
  std::vector<Turns> turns_;  // per style; [0] is not used
};

}  // namespace

Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file) {
  net::Faults faults(file.name);
  net::TensorReader tensors(file.view, faults);
  const int styles = static_cast<int>(file.model.styles.size());
  const net::RowMajor rotations = tensors.Matrix(kTensor, styles, kColumns);
  tensors.Finish();
  if (!faults.none()) return faults.status();

  std::vector<Turns> turns(file.model.styles.size());
  for (int style = 0; style < styles; ++style) {
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const Eigen::Vector4f q = rotations.row(style).segment<4>(4 * joint);
      if (!(std::abs(q.norm() - 1) < kUnitTolerance)) {
        faults.Add("tensor '" + std::string(kTensor) + "': expected a rotation of length 1 for " +
                   std::string(body::kHumanoid[static_cast<std::size_t>(joint)].name) +
                   ", found one of length " + std::to_string(q.norm()));
      }
      turns[static_cast<std::size_t>(style)].col(joint) = body::Log(body::Quat(q.normalized()));
    }
  }
  if (!faults.none()) return faults.status();
  return std::shared_ptr<const net::Stylizer>(
      std::make_shared<OffsetStylizer>(file.model, std::move(turns)));
}

Status Write(const std::filesystem::path& file, const net::Model& model,
             const std::vector<Offsets>& offsets) {
  assert(offsets.size() == model.styles.size());
  net::NamedTensor tensor{kTensor, {static_cast<std::int64_t>(offsets.size()), kColumns}, {}};
  for (const Offsets& style : offsets) {
    for (const body::Quat& q : style) {
      tensor.values.insert(tensor.values.end(), q.coeffs().data(), q.coeffs().data() + 4);
    }
  }
  net::Model written = model;
  written.family = kFamily;
  return net::WriteSafetensors(file, {&tensor, 1}, {{"styled", net::HeaderOf(written).dump()}});
}

}  // namespace styled::offset
