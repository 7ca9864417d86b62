#include "daemon/pipeline/performer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/publish/body_message.h"
#include "daemon/runtime/clock.h"
#include "model/rig/calibration.h"
#include "model/stylist/avatar.h"

namespace styled::pipeline {

using runtime::Counter;

// An avatar that the performer drives, and its topic.
struct Performer::RetargetStream {
  RetargetStream(std::shared_ptr<const RetargetOutput> the_output, const BoundBody& body,
                 const std::string& id, std::uint64_t epoch, const RuntimeConfig& config,
                 publish::Subscriptions& the_subscriptions)
      : output(std::move(the_output)),
        avatar(body.binding, output->skeleton.binding, output->skeleton.rest, config.stylist),
        rotations(output->skeleton.rest.rotations),
        message(id, epoch, output->body, body.binding->skeleton().joint_count(),
                config.network->model().styles),
        subscriptions(the_subscriptions) {
    v1::Body message_body = output->body;
    message_body.set_performer(id);
    bytes = message_body.SerializeAsString();
    topic.name = "styled/" + id + "/" + output->name + "/";
    subscriptions.Register(topic);
  }
  ~RetargetStream() { subscriptions.Unregister(topic); }
  RetargetStream(const RetargetStream&) = delete;
  RetargetStream& operator=(const RetargetStream&) = delete;

  // Computed only while somebody subscribes; then the first frame is a first one.
  void Process(std::int64_t time_ns, const stylist::Output& out) noexcept {
    if (topic.wanted == 0) {
      has_frame = failed = false;
      return;
    }
    if (!has_frame) avatar.Reset();
    has_frame = true;
    failed = !avatar.Process(time_ns, out);
    root = output->skeleton.RootInFile(output->skeleton.binding->RootPosition(avatar.pose()));
    std::copy(avatar.pose().rotations.begin(), avatar.pose().rotations.end(), rotations.begin());
    rotations.front() = output->skeleton.RootInFile(rotations.front());
  }

  std::shared_ptr<const RetargetOutput> output;
  stylist::Avatar avatar;
  bool has_frame = false;  // `root` and `rotations` hold a frame
  bool failed = false;     // of the performer's own motion: the styled pose was none
  rig::Vec3 root = rig::Vec3::Zero();
  std::vector<rig::Quat> rotations;
  publish::FrameMessage message;
  publish::Topic topic;
  publish::Subscriptions& subscriptions;
  std::string bytes;                 // its body
  std::span<const std::byte> ready;  // serialized; empty: not wanted
};

// All that depends on the body; made anew when it changes.
struct Performer::Bound {
  Bound(BoundBody the_body, const v1::Body& given, const std::string& id, std::uint64_t epoch,
        const RuntimeConfig& config, publish::Subscriptions& subscriptions)
      : body(std::move(the_body)),
        network(config.network),
        stylist(config.network, body.binding, config.stylist),
        rehearsal(config.network, body.binding, config.stylist),
        in(body.binding->skeleton()),
        out(body.binding->skeleton()),
        rig_body(publish::RigBody(id, *body.binding, body.left_handed, given.metres_per_unit(),
                                  body.dialect)),
        canonical_body(publish::CanonicalBody(id)),
        rig_bytes(rig_body.SerializeAsString()),
        canonical_bytes(canonical_body.SerializeAsString()) {
    face.reserve(kMaxFace);
    MakeMessages(id, epoch);
    MakeOutputs(id, epoch, config, subscriptions);
  }

  void MakeOutputs(const std::string& id, std::uint64_t epoch, const RuntimeConfig& config,
                   publish::Subscriptions& subscriptions) {
    outputs.clear();
    for (const auto& output : config.outputs) {
      if (!output->IsFor(id)) continue;
      outputs.push_back(
          std::make_unique<RetargetStream>(output, body, id, epoch, config, subscriptions));
    }
  }

  void MakeMessages(const std::string& id, std::uint64_t epoch) {
    const int joints = body.binding->skeleton().joint_count();
    const auto& styles = network->model().styles;
    messages[kRigTopic].emplace(id, epoch, rig_body, joints, styles);
    messages[kCanonicalTopic].emplace(id, epoch, canonical_body, joints, styles);
    messages[kSourceTopic].emplace(id, epoch, rig_body, joints, styles);
  }

  BoundBody body;
  std::shared_ptr<const net::Stylizer> network;  // the messages refer to its style names
  stylist::Stylist stylist;
  stylist::Rehearsal rehearsal;  // of the stylist, before a frame is due
  rig::RigPose in;
  stylist::Output out;
  bool styled = false;          // `out` holds a frame
  std::vector<std::byte> face;  // what is passed on beside the pose
  Timecode timecode;
  bool has_timecode = false;
  std::uint64_t source_time_ns = 0, source_sequence = 0;
  v1::Body rig_body, canonical_body;
  std::string rig_bytes, canonical_bytes;
  std::array<std::optional<publish::FrameMessage>, 3> messages;
  rig::Vec3 rig_root = rig::Vec3::Zero();  // of out.rig, as it is sent
  std::vector<std::unique_ptr<RetargetStream>> outputs;
};

Performer::Performer(Profile& the_profile, int the_source, std::string the_name,
                     std::uint64_t epoch, publish::Subscriptions& subscriptions,
                     runtime::Counters& counters)
    : source(the_source),
      name(std::move(the_name)),
      profile(the_profile),
      epoch_(epoch),
      subscriptions_(subscriptions),
      counters_(counters) {
  topics[kRigTopic].name = "styled/" + profile.id + "/rig/";
  topics[kCanonicalTopic].name = "styled/" + profile.id + "/canonical/";
  topics[kSourceTopic].name = "source/" + profile.id + "/";
  topics[kBodyTopic].name = "body/" + profile.id + "/";
  for (auto& topic : topics) subscriptions_.Register(topic);
}

Performer::~Performer() {
  for (auto& topic : topics) subscriptions_.Unregister(topic);
}

Status Performer::AcceptBody(const source::SourceFrame& given, const RuntimeConfig& config) {
  v1::Body body;
  if (!source::ReadBody(given, body)) {
    return Status::Error("body: not a styled.v1.Body");
  }
  auto skeleton = ReadSkeleton(body);
  if (!skeleton.ok()) return skeleton.status();
  std::swap(given_, body);
  Status status = Bind(config);
  const bool wait =
      !status.ok() && bound_ == nullptr && rig::CanCalibrate(skeleton.value(), Names(config)).ok();
  if (!status.ok() && !wait) {
    std::swap(given_, body);
    return status;
  }
  history_ = std::make_unique<PoseHistory>(skeleton.value());
  received_ = rig::RigPose(skeleton.value());
  body_crc_ = given.body_crc;
  if (!wait) return status;
  return Status::Error(status.message() +
                       "; the performer is not styled until stylectl calibrate " + profile.id +
                       " --pose t");
}

const rig::JointNames& Performer::Names(const RuntimeConfig& config) const {
  static const rig::JointNames kNone;
  const auto index = static_cast<std::size_t>(source);
  return index < config.joints.size() ? config.joints[index] : kNone;
}

// By the body as it was given and the calibration as it is kept. An error changes nothing.
Status Performer::Bind(const RuntimeConfig& config) {
  auto bound = BindBody(given_, profile.rest, Names(config));
  if (!bound.ok()) return bound.status();
  bound_ = std::make_unique<Bound>(std::move(bound.value()), given_, profile.id, epoch_, config,
                                   subscriptions_);
  ready_ = {};
  (void)ApplyLook(config);
  return Status::Ok();
}

v1::Code Performer::Calibrate(const v1::Calibrate& request, const RuntimeConfig& config,
                              std::int64_t now_ns, v1::Reply& reply) {
  const auto refuse = [&reply](v1::Code code, std::string reason) {
    reply.set_reason(std::move(reason));
    return code;
  };
  constexpr std::int64_t kLive_ns = 300 * runtime::kMillisecond_ns;  // rigs send at 24 Hz or more
  if (!has_body() || now_ns - history_->last_ns() > kLive_ns) {
    return refuse(v1::CODE_NOT_READY,
                  profile.id + ": no frame in the last 0.3 s, expected a performer who is live");
  }
  const auto before = profile.rest;
  if (request.clear()) {
    profile.rest.reset();
    if (const Status status = Bind(config); !status.ok()) {
      profile.rest = before;
      return refuse(v1::CODE_BAD_POSE, "without a calibration " + status.message());
    }
    return v1::CODE_OK;
  }
  constexpr float kStill_rad = 0.09F;  // 5 degrees
  const auto moved = history_->Moved();
  if (moved.radians > kStill_rad) {
    return refuse(v1::CODE_NOT_READY,
                  given_.names(static_cast<int>(moved.joint)) + " turned by " +
                      std::to_string(std::lround(moved.radians * 57.3F)) +
                      " degrees within 0.4 s, expected a performer who stands still");
  }
  const auto skeleton = ReadSkeleton(given_);
  auto made = rig::Calibrate(
      skeleton.value(), history_->pose(),
      request.pose() == v1::Calibrate::POSE_N ? rig::StandingPose::kN : rig::StandingPose::kT,
      Names(config));
  if (!made.ok()) return refuse(v1::CODE_BAD_POSE, made.status().message());
  const rig::Calibrated& calibrated = made.value();
  profile.rest = KeptRest{SkeletonHash(skeleton.value()), calibrated.mirrored,
                          calibrated.spec.canonical_from_source, calibrated.spec.rest_rotations};
  if (const Status status = Bind(config); !status.ok()) {
    profile.rest = before;
    return refuse(v1::CODE_BAD_POSE, status.message());
  }
  auto& result = *reply.mutable_calibrate();
  result.set_worst_joint(calibrated.bones.front().joint);
  result.set_worst_degrees(calibrated.bones.front().degrees);
  result.set_left_handed(calibrated.mirrored);
  return v1::CODE_OK;
}

std::vector<std::string> Performer::ApplyLook(const RuntimeConfig& config) {
  std::vector<std::string> unknown;
  const net::Styles& styles = config.network->model().styles;
  const auto settings = Resolve(profile.look, styles, unknown);
  const auto error = stylist::Validate(settings, static_cast<int>(styles.size()));
  if (bound_ != nullptr && error == stylist::SettingsError::kNone) {
    bound_->stylist.Set(settings);
  }
  return unknown;
}

void Performer::Rebuild(const RuntimeConfig& config) {
  if (bound_ == nullptr) return;
  bound_->network = config.network;
  bound_->stylist = stylist::Stylist(config.network, bound_->body.binding, config.stylist);
  bound_->rehearsal = stylist::Rehearsal(config.network, bound_->body.binding, config.stylist);
  bound_->MakeMessages(profile.id, epoch_);
  bound_->MakeOutputs(profile.id, epoch_, config, subscriptions_);
  bound_->styled = false;
  ready_ = {};
}

void Performer::Restart() noexcept {
  if (bound_ != nullptr) bound_->stylist.Reset();
  facing_.Reset();
}

Performer::Accepted Performer::Accept(const source::SourceFrame& frame,
                                      const FrameContext& context) noexcept {
  const auto joints = static_cast<int>(received_.rotations.size());
  if (!source::CopyPose(frame, joints, received_)) return Accepted::kWrongSize;
  history_->Add(received_, context.receive_ns);
  if (bound_ == nullptr) return Accepted::kUncalibrated;
  Bound& b = *bound_;
  std::swap(b.in, received_);  // both of the skeleton's size
  if (b.body.left_handed) rig::Mirror(b.in);
  b.source_time_ns = frame.source_time_ns;
  b.source_sequence = context.source_sequence;
  b.has_timecode = frame.has_timecode;
  b.timecode = frame.timecode;
  b.face.assign(frame.face.begin(), frame.face.end());
  context_ = context;
  return Accepted::kOk;
}

stylist::Stylist::Job Performer::Style() noexcept {
  Bound& b = *bound_;
  return {&b.stylist, context_.elapsed_ns, &b.in, &b.out};
}

void Performer::Finish(std::int64_t publish_ns) noexcept {
  Bound& b = *bound_;
  context_.publish_ns = publish_ns;
  std::uint32_t flags = b.out.flags;
  for (const auto& stream : b.outputs) {
    stream->Process(context_.elapsed_ns, b.out);
    if (stream->failed) flags |= stylist::kFailed;
  }
  b.rig_root = b.body.binding->RootPosition(b.out.rig);
  if (b.body.left_handed) {
    rig::Mirror(b.out.rig);
    rig::Mirror(b.out.source);
    b.rig_root = rig::Mirrored(b.rig_root);
  }
  b.styled = true;
  CountFlags(flags);
  counters_.Add(Counter::kStylistSteps, static_cast<std::uint64_t>(b.out.steps));
  measured_ = true;
  facing_.Sample(
      b.out.canonical_input,
      static_cast<double>(context_.elapsed_ns - std::exchange(faced_ns_, context_.elapsed_ns)) *
          1e-9);
  backwards_ = b.body.toes_backwards || facing_.backwards();
  if (backwards_) {
    context_.extra_flags |= v1::FLAG_BACKWARDS;
    counters_.Add(Counter::kPipelineBackwards);
  }
  Serialize(b.out.flags | context_.extra_flags, context_);
}

void Performer::Prewarm() noexcept {
  if (bound_ != nullptr) bound_->rehearsal.Prewarm(bound_->stylist);
}

bool Performer::Repeat(FrameContext context) noexcept {
  if (bound_ == nullptr || !bound_->styled) return false;
  measured_ = false;
  const std::uint32_t once = v1::FLAG_CONCEALED | v1::FLAG_NEW_SESSION;
  const std::uint32_t backwards = backwards_ ? v1::FLAG_BACKWARDS : v1::FLAG_NONE;
  Serialize((bound_->out.flags & ~once) | backwards | v1::FLAG_STALE, context);
  return true;
}

void Performer::Serialize(std::uint32_t flags, const FrameContext& context) noexcept {
  Bound& b = *bound_;
  publish::FrameHeader header;
  header.sequence = profile.next_sequence++;
  header.source_sequence = b.source_sequence;
  header.source_time_ns = b.source_time_ns;
  header.receive_time_ns = context.receive_ns;
  header.publish_time_ns = context.publish_ns;
  header.wall_time_ns = context.wall_ns;
  header.has_timecode = b.has_timecode;
  header.timecode = b.timecode;
  header.contacts = b.out.contacts;
  receive_ns_ = context.receive_ns;
  ready_ = {};
  const auto fill = [&](publish::FrameMessage& message, std::uint32_t frame_flags) {
    message.SetHeader(header, frame_flags);
    message.SetStyles({b.out.in_force.data(), static_cast<std::size_t>(b.out.in_force_count)});
    for (std::size_t j = 0; b.out.held.any() && j < b.in.rotations.size(); ++j) {
      if (b.out.held.test(j)) message.AddHeld(static_cast<int>(j));
    }
  };
  for (std::size_t i = 0; i < ready_.size(); ++i) {
    if (topics[i].wanted == 0) continue;
    publish::FrameMessage& message = *b.messages[i];
    // What is received and not held is bit for bit the source's.
    const std::uint32_t own = i == kSourceTopic && !b.out.held.any() ? v1::FLAG_BYPASS : 0;
    fill(message, flags | own);
    if (i == kRigTopic) message.SetPose(b.rig_root, b.out.rig.rotations);
    if (i == kSourceTopic)
      message.SetPose(b.out.source.translations.front(), b.out.source.rotations);
    if (i == kCanonicalTopic)
      message.SetPose(b.out.canonical.hips_position_m, b.out.canonical.rotations);
    ready_[i] = message.Serialize(b.face);
  }
  for (const auto& stream : b.outputs) {
    stream->ready = {};
    if (stream->topic.wanted == 0 || !stream->has_frame) continue;
    const std::uint32_t own = stream->failed ? v1::FLAG_FAILED : 0;
    fill(stream->message, (flags & ~std::uint32_t{v1::FLAG_BYPASS}) | own);
    stream->message.SetPose(stream->root, stream->rotations);
    stream->ready = stream->message.Serialize(b.face);
  }
}

void Performer::CountFlags(std::uint32_t flags) noexcept {
  if ((flags & stylist::kConcealed) != 0) counters_.Add(Counter::kStylistConcealed);
  if ((flags & stylist::kHeld) != 0) counters_.Add(Counter::kStylistHeld);
  if ((flags & stylist::kOutOfDomain) != 0) counters_.Add(Counter::kStylistOutOfDomain);
  if ((flags & stylist::kFading) != 0) counters_.Add(Counter::kStylistFading);
  if ((flags & stylist::kNewSession) != 0) counters_.Add(Counter::kStylistNewSession);
  if ((flags & stylist::kFailed) != 0) counters_.Add(Counter::kStylistFailed);
}

void Performer::Send(publish::Publisher& publisher, std::int64_t now_ns) {
  for (std::size_t i = 0; i < ready_.size(); ++i) {
    if (!ready_[i].empty()) publisher.Send(topics[i].name, ready_[i]);
  }
  ready_ = {};
  if (bound_ != nullptr) {
    for (const auto& stream : bound_->outputs) {
      if (!stream->ready.empty()) publisher.Send(stream->topic.name, stream->ready);
      stream->ready = {};
    }
  }
  last_send_ns = now_ns;
  if (!measured_) return;  // a repetition
  ++published_;
  latency_.Add(now_ns - receive_ns_);
}

void Performer::MarkLive(std::int64_t now_ns) noexcept {
  if (last_frame_ns > 0) intervals_ns_ = {intervals_ns_[1], now_ns - last_frame_ns};
  last_frame_ns = now_ns;
  if (!std::exchange(live, true)) {
    since_ns_ = now_ns;
    fresh_ = true;
    rate_hz_ = 0;
  }
}

bool Performer::MayChangeBody(std::int64_t now_ns) noexcept {
  const std::int64_t earned = (now_ns - body_changed_ns_) / kBodyChange_ns;
  if (earned > 0) {
    body_changes_left_ =
        static_cast<int>(std::min<std::int64_t>(kBodyChanges, body_changes_left_ + earned));
    body_changed_ns_ = now_ns;
  }
  if (body_changes_left_ == 0) return false;
  --body_changes_left_;
  return true;
}

// The shorter of two intervals: one silence does not make a rig slow.
std::int64_t Performer::Patience_ns(std::int64_t stale_ns) const noexcept {
  constexpr std::int64_t kMost_ns = 10 * runtime::kSecond_ns;
  const std::int64_t period_ns = std::min(intervals_ns_[0], intervals_ns_[1]);
  return std::max(stale_ns, std::min(3 * period_ns, kMost_ns));
}

std::string Performer::Warning() const {
  if (waits()) {
    return "nobody knows the rig's rest pose: let the performer stand in T-pose, and stylectl "
           "calibrate " +
           profile.id + " --pose t";
  }
  if (bound_ != nullptr && bound_->body.toes_backwards) {
    return "the toes point backwards: left and right are exchanged, or the axes are mirrored; "
           "mend it in the rig, or by stylectl calibrate " +
           profile.id + " --pose t";
  }
  if (backwards_) {
    return "walks against where the toes point; if that is not meant, left and right are "
           "exchanged, or the axes are mirrored: mend it in the rig, or by stylectl calibrate " +
           profile.id + " --pose t";
  }
  return "";
}

bool Performer::FacingChanged() noexcept {
  return std::exchange(backwards_logged_, backwards_) != backwards_;
}

bool Performer::Asked() const {
  const auto asked = [](const publish::Topic& topic) { return topic.asked; };
  return std::any_of(topics.begin(), topics.end(), asked) ||
         (bound_ != nullptr &&
          std::any_of(bound_->outputs.begin(), bound_->outputs.end(),
                      [&](const auto& stream) { return asked(stream->topic); }));
}

void Performer::SendBodies(publish::Publisher& publisher) {
  for (auto& topic : topics) topic.asked = false;
  if (bound_ == nullptr) return;
  for (const auto& stream : bound_->outputs) stream->topic.asked = false;
  if (topics[kBodyTopic].wanted == 0) return;
  const auto send = [&](const std::string& bytes) {
    publisher.Send(topics[kBodyTopic].name, std::as_bytes(std::span(bytes)));
    counters_.Add(Counter::kPublishBodies);
  };
  send(bound_->rig_bytes);
  send(bound_->canonical_bytes);
  for (const auto& stream : bound_->outputs) send(stream->bytes);
}

// The rate is between frames, not between samples: a rig of 1 Hz would have none or two a second.
void Performer::Sample() {
  const std::uint64_t frames = published_ - published_at_sample_;
  const std::int64_t span_ns = last_frame_ns - since_ns_;
  refusing_ = refused_ > refused_at_sample_;
  refused_at_sample_ = refused_;
  // Live again since the last sample: the first frame only begins the time.
  const std::uint64_t intervals = frames - (fresh_ && frames > 0 ? 1 : 0);
  if (intervals > 0 && span_ns > 0) {
    rate_hz_ = static_cast<float>(intervals) * 1e9F / static_cast<float>(span_ns);
  }
  published_at_sample_ = published_;
  if (frames > 0) {
    since_ns_ = last_frame_ns;
    fresh_ = false;
  }
  if (live && frames == 0) return;  // a slow rig's figures stay
  p50_us_ = latency_.Percentile_us(0.5F);
  p99_us_ = latency_.Percentile_us(0.99F);
  max_us_ = latency_.Max_us();
  latency_.Clear();
}

void Performer::Describe(v1::PerformerStats& stats) const {
  stats.set_rate_hz(live ? rate_hz_ : 0);
  stats.set_latency_p50_us(p50_us_);
  stats.set_latency_p99_us(p99_us_);
  stats.set_latency_max_us(max_us_);
  stats.set_received(received);
  stats.set_published(published_);
  stats.set_lost(session.lost());
  stats.set_live(live);
  stats.set_refused(refused_);
  if (refusing_) {
    const std::string_view why = runtime::Name(refused_as_);
    stats.set_refused_as(why.data(), why.size());
  }
  stats.set_warning(Warning());
  if (bound_ != nullptr) {
    stats.set_joints(static_cast<std::uint32_t>(bound_->in.rotations.size()));
    stats.set_dialect(bound_->body.dialect);
  }
}

}  // namespace styled::pipeline
