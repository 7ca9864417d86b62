#include "model/net/phase/stylizer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "model/base/flush_subnormals.h"
#include "model/base/smooth.h"
#include "model/gait/tuning.h"
#include "model/net/phase/space.h"
#include "model/net/phase/tables.h"
#include "model/net/phase/tuning.h"
#include "model/net/safetensors.h"

namespace styled::phase {
namespace {

using gait::FromLanes;
using gait::Lane;
using gait::ToLanes;
using gait::TurnLanes;
using gait::VectorLanes;

// A limb whose upper or lower part is far from where it is in neutral does something of its own.
struct Limb {
  int first, last;   // joints
  int upper, lower;  // joints whose angles count
  bool arm;
};
constexpr std::array<Limb, 4> kLimbs{
    {{body::kLeftShoulder, body::kLeftHand, body::kLeftUpperArm, body::kLeftLowerArm, true},
     {body::kRightShoulder, body::kRightHand, body::kRightUpperArm, body::kRightLowerArm, true},
     {body::kLeftUpperLeg, body::kLeftToes, body::kLeftUpperLeg, body::kLeftLowerLeg, false},
     {body::kRightUpperLeg, body::kRightToes, body::kRightUpperLeg, body::kRightLowerLeg, false}}};

class PhaseStream final : public net::Stream {
 public:
  std::span<const std::byte> memory() const noexcept override {
    return std::as_bytes(std::span(shares));
  }

  // Per limb: the share of the style that it shows, and the same smoothed.
  std::array<std::array<float, 2>, kLimbs.size()> shares;
  bool started = false;
  Dynamics dynamics;
};

// A style's weight within the limits that Stylizer::Step states.
float Clamped(float weight) noexcept {
  return weight > 0 ? std::min(weight, net::kMaxStrength) : 0.0F;  // 0 also for NaN
}

// Advances the limbs' shares by a step, and scales the turns by them. A limb counts by its angle
// beyond what a gait has.
void Gate(const TurnLanes& rotations, const Own& own, float dt_s, PhaseStream& stream,
          VectorLanes& turns) noexcept {
  const Lane away_rad =
      AnglesOf(own.Mean().Inverse() * rotations) - tuning::kSpreads * own.Spread_rad();
  Lane shares = Lane::Ones();
  for (std::size_t i = 0; i < kLimbs.size(); ++i) {
    const Limb& limb = kLimbs[i];
    const float limb_rad = std::max({0.0F, away_rad[limb.upper], away_rad[limb.lower]});
    const float target = 1 - SmoothStep(limb_rad, tuning::kOwnBegin_rad, tuning::kOwnEnd_rad);
    auto& [share, smooth] = stream.shares[i];
    if (!stream.started) share = smooth = target;
    share +=
        DecayShare(dt_s, target < share ? tuning::kFall_s : tuning::kRise_s) * (target - share);
    smooth += DecayShare(dt_s, tuning::kSmooth_s) * (share - smooth);
    const float shown = limb.arm ? tuning::kLeastArm + (1 - tuning::kLeastArm) * smooth
                                 : std::max(smooth, own.confidence());
    shares.segment(limb.first, limb.last + 1 - limb.first) = shown;
  }
  turns *= shares;
  stream.started = true;
}

void Add(float weight, const DynamicValues& more, DynamicValues& to) noexcept {
  to.energy += weight * more.energy;
  to.lag_s += weight * more.lag_s;
  to.tremor_rad += weight * more.tremor_rad;
  to.wander_rad += weight * more.wander_rad;
  to.hold_s += weight * more.hold_s;
}

// The part that all copies of With share.
struct Weights {
  net::Model model;
  std::shared_ptr<const Space> space;
};

class PhaseStylizer final : public net::Stylizer {
 public:
  PhaseStylizer(std::shared_ptr<const Weights> weights, net::Model model,
                std::vector<std::shared_ptr<const Table>> tables)
      : weights_(std::move(weights)), model_(std::move(model)), tables_(std::move(tables)) {}

  const net::Model& model() const noexcept override { return model_; }
  const net::StyleSpace* space() const noexcept override { return weights_->space.get(); }

  std::shared_ptr<const net::Stylizer> With(int number, const net::StyleInfo& info,
                                            const net::StyleCode& code) const override {
    const auto at = static_cast<std::size_t>(number);
    assert(at <= tables_.size());
    const Style style = FromCode(code);
    auto with = std::make_shared<PhaseStylizer>(weights_, model_, tables_);
    if (at == tables_.size()) {
      with->tables_.emplace_back();
      with->model_.styles.emplace_back();
    }
    with->tables_[at] = std::make_shared<const Table>(style);
    with->model_.styles[at] = WithSpeeds(info, style);
    return with;
  }

  std::shared_ptr<const net::Stylizer> Retired(int number) const override {
    auto without = std::make_shared<PhaseStylizer>(weights_, model_, tables_);
    without->model_.styles[static_cast<std::size_t>(number)].retired = true;
    return without;
  }

  bool SharesStreams(const net::Stylizer& other) const noexcept override {
    const auto* const phase = dynamic_cast<const PhaseStylizer*>(&other);
    return phase != nullptr && phase->weights_ == weights_;
  }

  std::unique_ptr<net::Stream> MakeStream() const override {
    auto stream = std::make_unique<PhaseStream>();
    Start(*stream);
    return stream;
  }

  void Start(net::Stream& stream) const noexcept override {
    auto& own = static_cast<PhaseStream&>(stream);
    for (auto& share : own.shares) share.fill(1);
    own.started = false;
    own.dynamics.Reset();
  }

  void Carry(net::Stream& stream, Checkpoint& c) const noexcept override {
    auto& own = static_cast<PhaseStream&>(stream);
    c(own.shares, own.started, own.dynamics);
    if (!c.reads() || !c.ok()) return;
    for (const auto& [share, smooth] : own.shares) {
      if (!(share >= 0 && share <= 1 && smooth >= 0 && smooth <= 1)) return c.Refuse();
    }
  }

  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    const FlushSubnormals flush;
    for (const net::StepJob& job : jobs) StepOne(job);
  }

  // The style's speeds and cadences, where the example walks or runs over the floor.
  static net::StyleInfo WithSpeeds(net::StyleInfo info, const Style& style) {
    const auto add = [](const std::optional<gait::Gait>& gait, float& mps, float& spm) {
      if (!gait || gait->speed_mps < gait::tuning::kOnTheSpot_mps) return;
      mps = gait->speed_mps;
      spm = 2 * 60 * gait->rate_rad_s / gait::tuning::kTurn_rad;
    };
    add(style.walk, info.walk_mps, info.walk_spm);
    add(style.run, info.run_mps, info.run_spm);
    info.designable = true;
    return info;
  }

 private:
  // Whether nothing is requested that could turn a joint.
  bool IsIdle(const net::StepJob& job) const noexcept {
    const auto count = static_cast<int>(tables_.size());
    return !(job.input_style > 0 && job.input_style < count) &&
           std::none_of(job.styles.begin(), job.styles.end(), [count](const net::StyleWeight& one) {
             return one.style > 0 && one.style < count && one.weight > 0;
           });
  }

  // The input, as both poses of the prediction.
  static void PassThrough(const net::StepJob& job) noexcept {
    net::Prediction& out = *job.out;
    out.heading_rad = 0;
    out.reconstruction.rotations = job.pose->rotations;
    out.reconstruction.velocities_m_s.fill(0);
    out.reconstruction.hips_height_m = job.pose->hips_position_m.y();
    out.styled = out.reconstruction;
  }

  // styled = input exp(sum of weight turn(style) - turn(input style)).
  void StepOne(const net::StepJob& job) const noexcept {
    auto& stream = static_cast<PhaseStream&>(*job.stream);
    if (IsIdle(job)) {
      stream.started = false;  // the next style starts afresh
      stream.dynamics.Reset();
      return PassThrough(job);
    }
    const Own own(job.performer, *model_.reference);
    VectorLanes turns{Lane::Zero(), Lane::Zero(), Lane::Zero()};
    DynamicValues dynamics;
    std::size_t used = 0;
    const auto count = static_cast<int>(tables_.size());
    for (const net::StyleWeight& style : job.styles) {
      if (used == net::kMaxActive) break;
      if (style.style <= 0 || style.style >= count) continue;
      ++used;
      const float weight = Clamped(style.weight);
      if (weight <= 0) continue;
      const Table& table = *tables_[static_cast<std::size_t>(style.style)];
      turns += weight * TurnOf(table, own);
      Add(weight, table.dynamics, dynamics);
    }
    if (job.input_style > 0 && job.input_style < count) {
      turns += -1.0F * TurnOf(*tables_[static_cast<std::size_t>(job.input_style)], own);
    }
    const body::Pose& input = *job.pose;
    const body::Pose& bound = job.performer == nullptr ? input : *job.performer->own;
    const float dt_s = 1 / model_.rate_hz;
    Gate(ToLanes(bound.rotations), own, dt_s, stream, turns);
    if (job.performer != nullptr && dynamics.any()) {
      gait::Vectors vectors = FromLanes(turns);
      stream.dynamics.Follow(bound.rotations, dynamics, job.performer->time_s, dt_s, vectors);
      turns = ToLanes(vectors);
    } else {
      stream.dynamics.Reset();
    }
    PassThrough(job);
    job.out->styled.rotations = FromLanes(ToLanes(input.rotations) * ExpOf(turns));
  }

  std::shared_ptr<const Weights> weights_;
  net::Model model_;
  std::vector<std::shared_ptr<const Table>> tables_;  // per style; [0] is null
};

constexpr const char* kStyles = "styles";

}  // namespace

Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file) {
  net::Faults faults(file.name);
  net::TensorReader tensors(file.view, faults);
  const auto count = static_cast<int>(file.model.styles.size());
  const auto columns = static_cast<int>(kCodeSize);
  const net::RowMajor rows = tensors.Matrix(kStyles, count, columns);
  tensors.Finish();
  if (!file.model.reference) faults.Key("reference", "that of the neutral", "none");
  if (!faults.none()) return faults.status();

  std::vector<Style> styles;
  for (int s = 0; s < count; ++s) {
    const net::StyleCode code(rows.row(s).data(), rows.row(s).data() + columns);
    if (!IsCode(code)) {
      faults.Add("tensor '" + std::string(kStyles) + "': row " + std::to_string(s) +
                 " is not a style; expected flags of 0 or 1 and finite numbers");
      return faults.status();
    }
    styles.push_back(FromCode(code));
  }
  const Style& neutral = styles.front();
  if (neutral.difference || !neutral.walk || !neutral.run) {
    faults.Add("tensor '" + std::string(kStyles) +
               "': row 0, the neutral: expected a walk and a run");
    return faults.status();
  }
  net::Model model = std::move(file.model);
  model.reference->gaits = neutral::Gaits{neutral.walk->curve, neutral.run->curve};
  std::vector<std::shared_ptr<const Table>> tables{nullptr};
  for (std::size_t s = 1; s < styles.size(); ++s) {
    tables.push_back(std::make_shared<const Table>(styles[s]));
    model.styles[s] = PhaseStylizer::WithSpeeds(model.styles[s], styles[s]);
  }
  auto weights = std::make_shared<Weights>();
  weights->model = model;
  weights->space = std::make_shared<const Space>(neutral, std::move(styles), model.rate_hz);
  return std::shared_ptr<const net::Stylizer>(
      std::make_shared<PhaseStylizer>(std::move(weights), std::move(model), std::move(tables)));
}

Status Write(const std::filesystem::path& file, const net::Model& model,
             const std::vector<net::StyleCode>& styles) {
  assert(styles.size() == model.styles.size());
  net::NamedTensor tensor{
      kStyles,
      {static_cast<std::int64_t>(styles.size()), static_cast<std::int64_t>(kCodeSize)},
      {}};
  for (const net::StyleCode& style : styles) {
    assert(IsCode(style));
    tensor.values.insert(tensor.values.end(), style.begin(), style.end());
  }
  net::Model written = model;
  written.family = kFamily;
  return net::WriteSafetensors(file, {&tensor, 1}, {{"styled", net::HeaderOf(written).dump()}});
}

}  // namespace styled::phase
