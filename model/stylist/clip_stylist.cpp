#include "model/stylist/clip_stylist.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace styled::stylist {
namespace {

using net::Prediction;
using net::StepJob;

// The styles of both stylists' model, whatever the network's are.
enum Role : int { kNeutralRole, kTargetRole, kOwnRole };

net::Model RolesOf(const net::Model& model) {
  net::Model roles = model;
  roles.styles.clear();
  for (const char* const name : {"neutral", "target", "own"}) {
    roles.styles.emplace_back().name = name;
  }
  return roles;
}

// The data that the steps of one recurrent state read or write. Start does not clear it: a state's
// steps count from the first frame on, in both stylists alike.
class Track final : public net::Stream {
 public:
  std::span<const std::byte> memory() const noexcept override { return {}; }

  // For the stylist ahead: the poses of its current frame.
  std::array<body::Pose, kMaxStepsPerFrame> poses;
  std::size_t noted = 0;
  // For the stylist behind: the predictions that it has not yet taken, from `next` on.
  std::vector<Prediction> predictions;
  std::size_t next = 0;
};

// Gives Tracks to a stylist's states in the order in which they are made.
class Player : public net::Stylizer {
 public:
  Player(const net::Model& model, std::vector<Track*>& tracks)
      : model_(RolesOf(model)), tracks_(tracks) {}
  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override {
    auto track = std::make_unique<Track>();
    tracks_.push_back(track.get());
    return track;
  }
  void Start(net::Stream&) const noexcept override {}

  // The next prediction of each state. There is always one; without it the pose would not be sound,
  // and the frame would be the performer's own.
  void Step(std::span<const StepJob> jobs) const noexcept override {
    for (const StepJob& job : jobs) {
      auto& track = static_cast<Track&>(*job.stream);
      if (track.next == track.predictions.size()) {
        job.out->heading_rad = std::numeric_limits<float>::quiet_NaN();
        continue;
      }
      *job.out = track.predictions[track.next++];
      const bool styled = std::any_of(job.styles.begin(), job.styles.end(),
                                      [](const net::StyleWeight& one) { return one.weight > 0; });
      if (!styled && job.input_style == 0) job.out->styled = job.out->reconstruction;
    }
  }

 protected:
  net::Model model_;
  std::vector<Track*>& tracks_;
};

// The same for the stylist ahead: records the pose and changes nothing.
class Recorder final : public Player {
 public:
  using Player::Player;
  void Step(std::span<const StepJob> jobs) const noexcept override {
    for (const StepJob& job : jobs) {
      auto& track = static_cast<Track&>(*job.stream);
      track.poses[track.noted++] = *job.pose;
      Prediction& out = *job.out;
      out.heading_rad = 0;
      out.reconstruction.rotations = job.pose->rotations;
      out.reconstruction.velocities_m_s.fill(0);
      out.reconstruction.hips_height_m = job.pose->hips_position_m.y();
      out.styled = out.reconstruction;
    }
  }
};

Options WithoutFeet(Options options) {
  options.feet = options.ground = options.knees = false;
  return options;
}

}  // namespace

struct ClipStylist::Impl {
  Impl(std::shared_ptr<const net::ClipStylizer> the_network, ClipStyle the_style,
       const std::shared_ptr<const rig::Binding>& binding, const Options& options,
       ClipFrames the_frames)
      : network(std::move(the_network)),
        style(std::move(the_style)),
        frames(std::move(the_frames)),
        ahead(std::make_shared<Recorder>(network->model(), noted), binding, WithoutFeet(options)),
        behind(std::make_shared<Player>(network->model(), played), binding, options),
        scratch(binding->skeleton()) {
    streams.resize(noted.size());
    Settings settings;
    settings.transition_s = 0;
    settings.absolute = style.absolute;
    settings.parts = style.parts;
    if (style.input_style > 0) settings.input_style = kOwnRole;
    if (style.weight > 0) settings.mix[0] = {kTargetRole, style.weight};
    behind.Set(settings);
  }

  std::int64_t Time_ns(std::size_t index) const {
    return static_cast<std::int64_t>(static_cast<double>(index) / frames.rate_hz * 1e9);
  }
  bool Ready() const;
  void Feed();

  std::shared_ptr<const net::ClipStylizer> network;
  ClipStyle style;
  ClipFrames frames;
  std::vector<Track*> noted, played;  // of ahead's and behind's states, which own them
  std::vector<std::unique_ptr<net::ClipStream>> streams;  // of the states that have stepped
  Stylist ahead, behind;
  Output scratch;
  std::size_t fed = 0, given = 0;  // frames
};

// Whether the next frame's steps have their predictions.
bool ClipStylist::Impl::Ready() const {
  if (fed == frames.count) return true;  // all streams have ended
  if (fed <= given) return false;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const Track& track = *played[i];
    if (streams[i] && track.predictions.size() - track.next < kMaxStepsPerFrame) return false;
  }
  return true;
}

void ClipStylist::Impl::Feed() {
  ahead.Process(Time_ns(fed), frames.frame(fed), scratch);
  ++fed;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    Track& from = *noted[i];
    if (from.noted > 0 && !streams[i]) {
      streams[i] = network->MakeStream(style.code, style.input_style, style.extent);
    }
    if (!streams[i]) continue;
    for (std::size_t k = 0; k < from.noted; ++k) streams[i]->Add(from.poses[k]);
    from.noted = 0;
    if (fed == frames.count) streams[i]->End();
    Track& to = *played[i];
    Prediction prediction;
    while (streams[i]->Pop(prediction)) {
      // Taken predictions are removed before the rest grows beyond them.
      if (to.next > to.predictions.size() / 2) {
        to.predictions.erase(to.predictions.begin(),
                             to.predictions.begin() + static_cast<std::ptrdiff_t>(to.next));
        to.next = 0;
      }
      to.predictions.push_back(prediction);
    }
  }
}

ClipStylist::ClipStylist(std::shared_ptr<const net::ClipStylizer> network, ClipStyle style,
                         const std::shared_ptr<const rig::Binding>& binding, const Options& options,
                         ClipFrames frames)
    : impl_(std::make_unique<Impl>(std::move(network), std::move(style), binding, options,
                                   std::move(frames))) {}
ClipStylist::~ClipStylist() = default;

void ClipStylist::Know(const neutral::Known& known) {
  impl_->ahead.Know(known);
  impl_->behind.Know(known);
}

void ClipStylist::Next(Output& out) {
  while (!impl_->Ready()) impl_->Feed();
  impl_->behind.Process(impl_->Time_ns(impl_->given), impl_->frames.frame(impl_->given), out);
  ++impl_->given;
}

}  // namespace styled::stylist
