#include "model/net/several.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>
#include <utility>

#include "model/base/smooth.h"
#include "model/net/several_space.h"

namespace styled::net {
namespace {

// The turns that convert the carriage of one network's performers to that of another's.
using Turns = std::array<body::Quat, body::kJointCount>;

// The hips are unchanged: theirs is relative to a heading that each family finds by itself.
void Turn(const Turns& turns, std::array<body::Quat, body::kJointCount>& rotations) noexcept {
  for (std::size_t joint = 1; joint < turns.size(); ++joint) {
    rotations[joint] = (turns[joint] * rotations[joint]).normalized();
  }
}

// One network's part of a stream.
struct Part {
  std::unique_ptr<Stream> stream;
  body::Pose pose;  // the input with this network's carriage
  int awake = 0;    // remaining steps without a style; 0: it does not run
  int steps = 0;    // steps since it began to run, at most kWakeSteps
  Prediction out;
};

class Parts final : public Stream {
 public:
  std::span<const std::byte> memory() const noexcept override {
    const auto working =
        std::find_if(parts.begin(), parts.end(), [](const Part& part) { return part.awake > 0; });
    return (working == parts.end() ? parts.front() : *working).stream->memory();
  }

  std::vector<Part> parts;
  bool fresh = true;  // no step since the start
};

// A style of the list: its number in each network that has it, or -1. Two networks: the first one
// has the style in gaits, the second otherwise.
struct Homes {
  std::array<int, kMaxNetworks> numbers;
  std::array<std::size_t, 2> networks{};
  std::size_t count = 1;

  explicit Homes(Place place = {}) {
    numbers.fill(-1);
    numbers[place.network] = place.number;
    networks[0] = place.network;
  }
};

// One network's part of a job.
struct Share {
  std::array<StyleWeight, kMaxActive> styles;
  std::size_t count = 0;
  float weight = 0;  // of its styles, neutral not counted

  void Add(int style, float of) noexcept {
    if (count == styles.size()) return;
    styles[count++] = {style, of};
    if (style > 0) weight += of;
  }
};

class Several final : public Stylizer {
 public:
  explicit Several(std::vector<NamedNetwork> networks) : networks_(std::move(networks)) {
    stay_awake_ = static_cast<int>(kStayAwake_s * networks_.front().network->model().rate_hz);
    ListStyles();
    ListContents();
    FindSame();
    FindTurns();
    FindGate();
    std::vector<SeveralSpace::Member> members;
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      if (networks_[n].network->space() == nullptr) continue;
      members.push_back({n, networks_[n].name, networks_[n].network});
    }
    if (members.empty()) return;
    std::vector<Place> places;
    places.reserve(homes_.size());
    for (const Homes& homes : homes_) {
      places.push_back({homes.networks[0], homes.numbers[homes.networks[0]]});
    }
    space_ = std::make_shared<const SeveralSpace>(std::move(members), std::move(places), same_);
  }

  const Model& model() const noexcept override { return model_; }
  const StyleSpace* space() const noexcept override { return space_.get(); }

  std::shared_ptr<const Stylizer> With(int number, const StyleInfo& style,
                                       const StyleCode& code) const override {
    if (!space_) return nullptr;
    const auto at = static_cast<std::size_t>(number);
    assert(at <= homes_.size());
    std::shared_ptr<Several> with(new Several(*this));
    if (at == homes_.size()) {
      with->homes_.emplace_back().numbers.fill(-1);
      with->same_.emplace_back(networks_.size(), 0);
      with->model_.styles.emplace_back();
    }
    Homes& homes = with->homes_[at];
    with->same_[at].assign(networks_.size(), 0);
    homes.count = 0;
    for (const SeveralSpace::Part& part : space_->Split(code)) {
      auto& network = with->networks_[part.network].network;
      int& theirs = homes.numbers[part.network];
      if (theirs < 0) theirs = static_cast<int>(network->model().styles.size());
      network = network->With(theirs, style, part.code);
      with->same_[at][part.network] = theirs;
      homes.networks[homes.count++] = part.network;
    }
    assert(homes.count > 0);
    const std::size_t first = homes.networks[0];
    StyleInfo& info = with->model_.styles[at];
    info = with->networks_[first].network->model().styles[static_cast<std::size_t>(
        homes.numbers[first])];
    info.model = networks_[first].name;
    return with;
  }

  std::shared_ptr<const Stylizer> Retired(int number) const override {
    if (!space_) return nullptr;
    const auto at = static_cast<std::size_t>(number);
    assert(at < homes_.size());
    std::shared_ptr<Several> without(new Several(*this));
    const Homes& homes = homes_[at];
    for (std::size_t i = 0; i < homes.count; ++i) {
      auto& network = without->networks_[homes.networks[i]].network;
      network = network->Retired(homes.numbers[homes.networks[i]]);
    }
    without->model_.styles[at].retired = true;
    return without;
  }

  bool SharesStreams(const Stylizer& other) const noexcept override {
    const auto* const several = dynamic_cast<const Several*>(&other);
    if (several == nullptr || several->networks_.size() != networks_.size()) return false;
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      if (!networks_[n].network->SharesStreams(*several->networks_[n].network)) return false;
    }
    return true;
  }

  std::unique_ptr<Stream> MakeStream() const override {
    auto stream = std::make_unique<Parts>();
    for (const NamedNetwork& named : networks_) {
      stream->parts.emplace_back().stream = named.network->MakeStream();
    }
    return stream;
  }

  void Start(Stream& stream) const noexcept override {
    auto& own = static_cast<Parts&>(stream);
    for (Part& part : own.parts) part.awake = part.steps = 0;
    own.fresh = true;
  }

  // The streams of networks that do not run are reset before they do.
  void Carry(Stream& stream, Checkpoint& c) const noexcept override {
    auto& own = static_cast<Parts&>(stream);
    c(own.fresh);
    c.Same(networks_.size());
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      Part& part = own.parts[n];
      c.Within(part.awake, 0, stay_awake_);
      c.Within(part.steps, 0, kWakeSteps);
      if (part.awake > 0) networks_[n].network->Carry(*part.stream, c);
    }
  }

  void Step(std::span<const StepJob> jobs) const noexcept override {
    while (!jobs.empty()) {
      const std::size_t count = std::min(jobs.size(), kTogether);
      StepSome(jobs.first(count));
      jobs = jobs.subspan(count);
    }
  }

 private:
  Several(const Several& other)  // Stylizers are not copied from outside
      : Stylizer(),
        networks_(other.networks_),
        model_(other.model_),
        homes_(other.homes_),
        same_(other.same_),
        contents_of_(other.contents_of_),
        turns_(other.turns_),
        space_(other.space_),
        stay_awake_(other.stay_awake_) {}

  // All styles of the networks, under unique names.
  void ListStyles() {
    model_ = networks_.front().network->model();
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      const Model& own = networks_[n].network->model();
      if (n > 0) {
        model_.family += " + " + own.family;
        if (own.licence != model_.licence) model_.licence += "; " + own.licence;
      }
      for (std::size_t s = n == 0 ? 0 : 1; s < own.styles.size(); ++s) {
        StyleInfo style = own.styles[s];
        style.model = networks_[n].name;
        style.original = style.name;
        if (n > 0) Rename(networks_[n].name, style);
        if (n == 0) {
          model_.styles[s] = style;
        } else {
          model_.styles.push_back(style);
        }
        homes_.emplace_back(Place{n, static_cast<int>(s)});
      }
    }
  }

  void Rename(const std::string& network, StyleInfo& style) const {
    const auto taken = [this](const std::string& name) {
      return FindStyle(model_.styles, name) >= 0;
    };
    if (taken(style.name)) style.name = network + "-" + style.name;
    std::erase_if(style.aliases, taken);
  }

  // All contents of the networks, each name once.
  void ListContents() {
    model_.contents.clear();
    for (const NamedNetwork& named : networks_) {
      for (const std::string& content : named.network->model().contents) {
        if (!FindContent(model_.contents, content).ok()) model_.contents.push_back(content);
      }
    }
    for (const NamedNetwork& named : networks_) {
      std::vector<int>& theirs = contents_of_.emplace_back();
      for (const std::string& content : model_.contents) {
        const auto own = FindContent(named.network->model().contents, content);
        theirs.push_back(own.ok() ? own.value() : kContentUnknown);
      }
    }
  }

  void FindSame() {
    for (std::size_t s = 0; s < homes_.size(); ++s) {
      std::vector<int>& same = same_.emplace_back(networks_.size(), 0);
      for (std::size_t n = 0; n < networks_.size(); ++n) {
        const int own = homes_[s].numbers[n];
        same[n] = own >= 0 ? own
                           : std::max(0, FindStyle(networks_[n].network->model().styles,
                                                   model_.styles[s].original));
      }
    }
  }

  // The narrowest bounds of all networks, because the active style changes while limbs are held. A
  // family that follows gaits reconstructs every pose, so that its bounds say nothing.
  void FindGate() {
    const auto says = [](const NamedNetwork& named) {
      const auto& reference = named.network->model().reference;
      return !reference || !reference->gaits;
    };
    const auto first = std::find_if(networks_.begin(), networks_.end(), says);
    if (first == networks_.end()) return;
    model_.gate = first->network->model().gate;
    const auto narrow = [](GateBounds::Range& to, const GateBounds::Range& from) {
      to = {std::min(to.begin_m, from.begin_m), std::min(to.end_m, from.end_m)};
    };
    for (const NamedNetwork& named : networks_) {
      if (!says(named)) continue;
      const GateBounds& own = named.network->model().gate;
      narrow(model_.gate.arms, own.arms);
      narrow(model_.gate.trunk, own.trunk);
      narrow(model_.gate.legs, own.legs);
    }
  }

  // Poses arrive with the carriage of the first network that has one.
  void FindTurns() {
    turns_.resize(networks_.size());
    for (const NamedNetwork& named : networks_) {
      const auto& reference = named.network->model().reference;
      if (!model_.reference) model_.reference = reference;
      if (reference && reference->gaits && !model_.reference->gaits) {
        model_.reference->gaits = reference->gaits;
      }
    }
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      const auto& own = networks_[n].network->model().reference;
      // A family that follows gaits knows the performer's own carriage.
      if (!own || own->gaits || own->walking == model_.reference->walking) continue;
      turns_[n].emplace();
      for (std::size_t joint = 0; joint < turns_[n]->size(); ++joint) {
        (*turns_[n])[joint] =
            own->walking.rotations[joint] * model_.reference->walking.rotations[joint].conjugate();
      }
    }
  }

  // Divides a job's styles among the networks that have them; a style of two, by how sure the
  // performer's gait is. Neutral belongs to the input style's network.
  void Divide(const StepJob& job, std::span<Share> shares) const noexcept {
    const std::size_t home = Home(job.input_style);
    const float gait =
        job.performer == nullptr
            ? 0
            : SmoothStep(job.performer->neutral->phase().confidence, kGaitBegins, kGaitIsSure);
    for (const StyleWeight& style : job.styles) {
      if (style.style < 0 || static_cast<std::size_t>(style.style) >= homes_.size()) continue;
      const float weight = style.weight > 0 ? std::min(style.weight, kMaxStrength) : 0.0F;
      if (style.style == 0) {
        shares[home].Add(0, weight);
        continue;
      }
      const Homes& homes = homes_[static_cast<std::size_t>(style.style)];
      const auto add = [&](std::size_t i, float share) {
        const std::size_t network = homes.networks[i];
        if (share > 0) shares[network].Add(homes.numbers[network], share * weight);
      };
      add(0, homes.count == 1 ? 1 : gait);
      if (homes.count > 1) add(1, 1 - gait);
    }
  }

  // Determines which networks run in this step.
  void Wake(const StepJob& job, std::span<const Share> shares, Parts& stream) const noexcept {
    const bool any = std::any_of(shares.begin(), shares.end(),
                                 [](const Share& share) { return share.weight > 0; });
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      Part& part = stream.parts[n];
      const bool wanted = shares[n].weight > 0 || (!any && n == Home(job.input_style));
      if (part.awake == 0 && wanted) {
        networks_[n].network->Start(*part.stream);
        // A network that starts in the middle of a stream shows its change gradually (Join); in a
        // stream's first step it shows all of it.
        part.steps = stream.fresh ? kWakeSteps : 0;
      }
      part.awake = wanted ? stay_awake_ : std::max(0, part.awake - 1);
      if (part.awake > 0) part.steps = std::min(part.steps + 1, kWakeSteps);
    }
    stream.fresh = false;
  }

  // A content's number in a network; unknown, if the network lacks it.
  int ContentOf(int content, std::size_t network) const noexcept {
    const std::vector<int>& theirs = contents_of_[network];
    const auto at = static_cast<std::size_t>(content);
    return content >= 0 && at < theirs.size() ? theirs[at] : content;
  }

  // The network whose reconstruction counts while no style is active: that of the input style,
  // otherwise the first.
  std::size_t Home(int input_style) const noexcept {
    const auto at = static_cast<std::size_t>(input_style);
    return input_style > 0 && at < homes_.size() ? homes_[at].networks[0] : 0;
  }

  // Steps at most kTogether streams. The networks run one after the other, each for all jobs, so
  // that its weights are read once.
  void StepSome(std::span<const StepJob> jobs) const noexcept {
    // 1. Divide each job's styles among the networks, and decide which networks run for it.
    std::array<std::array<Share, kMaxNetworks>, kTogether> shares{};
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      const auto own = std::span(shares[j]).first(networks_.size());
      Divide(jobs[j], own);
      Wake(jobs[j], own, static_cast<Parts&>(*jobs[j].stream));
    }
    // 2. Step each network for the jobs in which it runs.
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      std::array<StepJob, kTogether> theirs;
      std::size_t count = 0;
      for (std::size_t j = 0; j < jobs.size(); ++j) {
        Part& part = static_cast<Parts&>(*jobs[j].stream).parts[n];
        if (part.awake == 0) continue;
        const Share& share = shares[j][n];
        // Each network has its own numbers: same_ finds its style of the input style's name, or
        // neutral.
        const auto input = static_cast<std::size_t>(std::max(0, jobs[j].input_style));
        const body::Pose* pose = jobs[j].pose;
        // The network sees the pose with the carriage of the performers that it was trained on.
        if (turns_[n]) {
          part.pose = *pose;
          Turn(*turns_[n], part.pose.rotations);
          pose = &part.pose;
        }
        theirs[count++] = {pose,
                           input < same_.size() ? same_[input][n] : 0,
                           std::span(share.styles).first(share.count),
                           part.stream.get(),
                           &part.out,
                           jobs[j].variations,
                           jobs[j].performer,
                           ContentOf(jobs[j].content, n)};
      }
      if (count > 0) networks_[n].network->Step(std::span(theirs).first(count));
      if (turns_[n]) TurnBack(jobs, n);
    }
    // 3. Combine the predictions of each job's networks into one.
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      Join(static_cast<const Parts&>(*jobs[j].stream), shares[j], Home(jobs[j].input_style),
           *jobs[j].out);
    }
  }

  // Turns the predictions back to the carriage of the given pose. The change of style is
  // unaffected.
  void TurnBack(std::span<const StepJob> jobs, std::size_t network) const noexcept {
    Turns back = *turns_[network];
    for (body::Quat& turn : back) turn = turn.conjugate();
    for (const StepJob& job : jobs) {
      Part& part = static_cast<Parts&>(*job.stream).parts[network];
      if (part.awake == 0) continue;
      Turn(back, part.out.reconstruction.rotations);
      Turn(back, part.out.styled.rotations);
    }
  }

  // Combines the predictions. The reconstruction is that of the network with the largest share; the
  // changes of all networks with an active style are added to it as rotation vectors.
  void Join(const Parts& stream, std::span<const Share> shares, std::size_t home,
            Prediction& out) const noexcept {
    std::size_t first = home, count = 0;
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      if (shares[n].weight <= 0) continue;
      if (count++ == 0 || shares[n].weight > shares[first].weight) first = n;
    }
    out = stream.parts[first].out;
    // The usual case: the prediction of a single network is passed on, bit for bit.
    if (count <= 1 && stream.parts[first].steps == kWakeSteps) return;
    std::array<body::Vec3, body::kJointCount> change;
    change.fill(body::Vec3::Zero());
    float rise_m = 0;
    for (std::size_t n = 0; n < networks_.size(); ++n) {
      const Part& part = stream.parts[n];
      if (shares[n].weight <= 0 && n != first) continue;
      const float shown =
          SmoothStep(static_cast<float>(part.steps) / static_cast<float>(kWakeSteps));
      const Decoded &from = part.out.reconstruction, &to = part.out.styled;
      for (std::size_t joint = 0; joint < change.size(); ++joint) {
        change[joint] += shown * body::Log(from.rotations[joint].conjugate() * to.rotations[joint]);
      }
      rise_m += shown * (to.hips_height_m - from.hips_height_m);
      // A value that is not finite anywhere must remain visible.
      if (n == first) continue;
      for (std::size_t i = 0; i < out.styled.velocities_m_s.size(); ++i) {
        out.styled.velocities_m_s[i] += to.velocities_m_s[i];
        out.reconstruction.velocities_m_s[i] += from.velocities_m_s[i];
      }
    }
    for (std::size_t joint = 0; joint < change.size(); ++joint) {
      out.styled.rotations[joint] =
          (out.reconstruction.rotations[joint] * body::Exp(change[joint])).normalized();
    }
    out.styled.hips_height_m = out.reconstruction.hips_height_m + rise_m;
  }

  std::vector<NamedNetwork> networks_;
  Model model_;
  std::vector<Homes> homes_;                   // of model_.styles
  std::vector<std::vector<int>> same_;         // of each style, the networks' styles of that name
  std::vector<std::vector<int>> contents_of_;  // by network, its number of each content
  std::vector<std::optional<Turns>> turns_;    // by network; empty: its carriage is model_'s
  std::shared_ptr<const SeveralSpace> space_;
  int stay_awake_ = 0;
};

}  // namespace

Result<std::shared_ptr<const Stylizer>> Combine(std::vector<NamedNetwork> networks) {
  assert(!networks.empty());
  if (networks.size() == 1) return networks.front().network;
  if (networks.size() > kMaxNetworks) {
    return Status::Error("found " + std::to_string(networks.size()) +
                         " networks, expected at most " + std::to_string(kMaxNetworks));
  }
  const NamedNetwork& first = networks.front();
  for (std::size_t n = 1; n < networks.size(); ++n) {
    const float rate_hz = networks[n].network->model().rate_hz;
    const float expected_hz = first.network->model().rate_hz;
    if (rate_hz != expected_hz) {
      return Status::Error(networks[n].name + ": works at " + std::to_string(rate_hz) +
                           " Hz, expected that of " + first.name + ", " +
                           std::to_string(expected_hz) + " Hz");
    }
    for (std::size_t other = 0; other < n; ++other) {
      if (networks[other].name != networks[n].name) continue;
      return Status::Error("two networks have the name " + networks[n].name +
                           "; expected different ones");
    }
  }
  return std::shared_ptr<const Stylizer>(std::make_shared<Several>(std::move(networks)));
}

}  // namespace styled::net
