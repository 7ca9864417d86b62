// Fuzzes the pipeline with several simultaneous senders: their clocks, sequence numbers, sessions,
// machines, bodies and values. The input is a script (script.h), executed on a fake clock. A victim
// beside them sends at 120 Hz. Whatever the others do:
// - published values are finite, and rotations have unit length;
// - the victim's frames are bit-identical to those of a victim alone, and none is missing;
// - a batch takes no more network steps than stylist.h states.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>

#include "model/stylist/stylist.h"
#include "proto/rigs/native/header.h"
#include "tests/fuzz/pipeline/script.h"
#include "tests/fuzz/sane_frame.h"
#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace {

using namespace styled;
using fuzz::Action;
using fuzz::Require;
using fuzz::RequireSane;
using fuzz::Script;
using support::Bytes;

// A network that costs next to nothing, so that the time goes into the pipeline. It remembers its
// stream's poses, so that streams that were exchanged would show.
class TinyNetwork final : public net::Stylizer {
 public:
  const net::Model& model() const noexcept override { return model_; }
  std::unique_ptr<net::Stream> MakeStream() const override { return std::make_unique<Memory>(); }
  void Start(net::Stream& stream) const noexcept override {
    static_cast<Memory&>(stream).mean.setZero();
  }
  void Step(std::span<const net::StepJob> jobs) const noexcept override {
    for (const net::StepJob& job : jobs) {
      const body::Pose& pose = *job.pose;
      body::Vec3& mean = static_cast<Memory&>(*job.stream).mean;
      mean += 0.1F * (pose.rotations[body::kRightUpperLeg].vec() - mean);
      body::Vec3 turn = mean;
      for (const net::StyleWeight& style : job.styles) {
        const float weight = std::clamp(style.weight, 0.0F, net::kMaxStrength);
        turn.x() += 0.05F * static_cast<float>(style.style) * weight;
      }
      job.out->heading_rad = 0;
      job.out->reconstruction.rotations = pose.rotations;
      job.out->reconstruction.velocities_m_s.fill(0);
      job.out->reconstruction.hips_height_m = pose.hips_position_m.y();
      job.out->styled = job.out->reconstruction;
      for (body::Quat& rotation : job.out->styled.rotations) {
        rotation = (rotation * body::Exp(turn)).normalized();
      }
    }
  }

 private:
  struct Memory final : net::Stream {
    std::span<const std::byte> memory() const noexcept override {
      return std::as_bytes(std::span(&mean, 1));
    }
    body::Vec3 mean = body::Vec3::Zero();
  };
  net::Model model_ = erd::RandomStylizer(5, 1)->model();
};

std::shared_ptr<const pipeline::RuntimeConfig> MakeConfig() {
  static const auto live = [] {
    auto made = std::make_shared<pipeline::RuntimeConfig>();
    made->network = std::make_shared<TinyNetwork>();
    made->performers.max_performers = 6;
    return made;
  }();
  return live;
}

v1::Request StyleOf(const std::string& performer, int style) {
  v1::Request request;
  request.set_performer(performer);
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("style" + std::to_string(style));
  mix.set_weight(1);
  request.mutable_set()->set_transition_ms(100);
  return request;
}

constexpr source::Machine kVictims{1};
constexpr std::int64_t kPeriod_ns = runtime::kSecond_ns / 120;

// The victim and the pipeline that it sends to.
class Stage {
 public:
  Stage() : pipeline_(MakeConfig(), "") {
    (void)pipeline_.Ask(StyleOf("rig.victim", 1));
    pipeline_.Deliver({victim_.Body()}, kVictims);
  }

  // Delivers one batch: the others' datagrams, with the victim's next frame among them.
  void Deliver(const std::vector<Bytes>& others, const std::vector<source::Machine>& machines) {
    pipeline_.clock.now_ns += kPeriod_ns;
    std::vector<Bytes> batch(others);
    std::vector<source::Machine> senders(machines);
    const auto middle = static_cast<std::ptrdiff_t>(others.size() / 2);
    batch.insert(batch.begin() + middle, victim_.Frame());
    senders.insert(senders.begin() + middle, kVictims);
    const std::vector<std::span<const std::byte>> spans(batch.begin(), batch.end());
    const std::uint64_t before = pipeline_.Count(runtime::Counter::kStylistSteps);
    support::HandOn(spans, senders, pipeline_.counters, pipeline_.pipeline());
    const std::uint64_t steps = pipeline_.Count(runtime::Counter::kStylistSteps) - before;
    REQUIRE(steps <= batch.size() * stylist::kMaxStepsPerFrame);
    batches_ += batch.size();
    steps_ += steps;
    // Each of at most seven performers may use up its allowance once.
    REQUIRE(steps_ <= 64U * 64 + batches_ * stylist::kMeanStepsPerFrame);
    pipeline_.Work();
    (void)pipeline_.Lines();
    std::unique_ptr<std::vector<pipeline::Profile>> kept;
    while (pipeline_.mailboxes.profiles.Pop(kept)) {
    }
  }
  // The frames published since the last call.
  std::vector<v1::Frame> Drain() { return std::exchange(pipeline_.publisher.frames, {}); }
  support::FakePipeline& pipeline() { return pipeline_; }

 private:
  support::FakePipeline pipeline_;
  support::Rig victim_{"victim", 1001};
  std::uint64_t steps_ = 0, batches_ = 0;
};

bool IsVictims(const v1::Frame& frame) { return frame.performer() == "rig.victim"; }

// The victim's frame `index` (of three topics: rig, canonical, source) without any other sender.
const v1::Frame& Undisturbed(std::size_t index) {
  static Stage alone;
  static std::vector<v1::Frame> frames;
  while (frames.size() <= index) {
    alone.Deliver({}, {});
    for (v1::Frame& frame : alone.Drain()) frames.push_back(std::move(frame));
  }
  return frames[index];
}

bool Same(const v1::Frame& a, const v1::Frame& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), static_cast<std::size_t>(x.size()) * 4) == 0;
  };
  return equal(a.rotations(), b.rotations()) && equal(a.root_position(), b.root_position()) &&
         a.flags() == b.flags() && a.sequence() == b.sequence() && a.output() == b.output() &&
         a.source_sequence() == b.source_sequence();
}

// The other senders.
class Others {
 public:
  explicit Others(Script& script) : script_(script) {
    for (std::size_t k = 0; k < rigs_.size(); ++k) {
      rigs_[k].time_ns = 1'000'000'000 * (k + 1);
      machines_[k] = source::Machine{k + 2};
    }
  }

  void Act(Action action, Stage& stage) {
    const std::size_t who = script_.Below(rigs_.size());
    support::Rig& rig = rigs_[who];
    switch (action) {
      case Action::kWait:
        for (std::size_t i = script_.Below(8); i > 0; --i) Flush(stage);
        break;
      case Action::kBody:
        Send(who, Body(rig), stage);
        break;
      case Action::kFrame:
        Send(who, Frame(rig), stage);
        break;
      case Action::kFrames:
        for (std::size_t i = script_.Below(12); i > 0; --i) Send(who, rig.Frame(), stage);
        break;
      case Action::kDamaged: {
        Bytes bytes = script_.Below(2) == 0 ? rig.Frame() : rig.Body();
        for (std::size_t i = 1 + script_.Below(4); i > 0; --i) {
          bytes[script_.Word() % bytes.size()] = std::byte{script_.Byte()};
        }
        if (script_.Below(4) > 0) Seal(bytes);
        Send(who, bytes, stage);
        break;
      }
      case Action::kSession:
        rig.session = std::array<std::uint64_t, 5>{rig.session + 1, rig.session + 2, 1001, 1003,
                                                   script_.Word() | 1U}[script_.Below(5)];
        rig.performer =
            std::array{rig.performer, std::string("victim"), std::string("b"),
                       std::string("c" + std::to_string(script_.Below(9)))}[script_.Below(4)];
        break;
      case Action::kSequence:
        rig.sequence = Change(rig.sequence);
        break;
      case Action::kMachine:
        // Never the victim's machine: a sender there may claim any identity.
        machines_[who] = source::Machine{2 + script_.Below(4)};
        break;
      case Action::kClock:
        if (script_.Below(2) == 0) {
          rig.time_ns = Change(rig.time_ns);
        } else {
          rig.period_ns = script_.Magnitude();
        }
        break;
      case Action::kControl: {
        if (script_.Below(2) == 0) {
          REQUIRE(stage.pipeline().StatsOf("rig.victim").lost() == 0);
        } else {
          (void)stage.pipeline().Ask(StyleOf("rig.b", static_cast<int>(1 + script_.Below(4))));
        }
        break;
      }
      case Action::kSubscribe:
        stage.pipeline().publisher.events.push_back(
            {script_.Below(2) == 0, "styled/rig." + std::to_string(script_.Below(3))});
        break;
      case Action::kCount:
        break;
    }
  }
  void Flush(Stage& stage) {
    stage.Deliver(waiting_, from_);
    waiting_.clear();
    from_.clear();
  }

 private:
  static void Seal(Bytes& bytes) {
    if (bytes.size() < native::kHeaderSize) return;
    namespace header = native::header;
    header::Write<std::uint32_t>(bytes, header::kCrc, 0);
    native::Datagram datagram{native::Kind::kBody,
                              header::Read<std::uint64_t>(bytes, header::kSession),
                              header::Read<std::uint64_t>(bytes, header::kSequence),
                              std::span<const std::byte>(bytes).subspan(native::kHeaderSize)};
    if (bytes[header::kKind] == std::byte{2}) datagram.kind = native::Kind::kSourceFrame;
    Bytes sealed(bytes.size());
    if (native::Encode(datagram, sealed) == bytes.size()) bytes = std::move(sealed);
  }
  std::uint64_t Change(std::uint64_t value) {
    switch (script_.Below(4)) {
      case 0:
        return value + script_.Magnitude();
      case 1:
        return value - script_.Magnitude();
      case 2:
        return script_.Word();
      default:
        return 0;
    }
  }
  Bytes Body(support::Rig& rig) {
    v1::Body body = rig.MakeBody();
    const std::size_t kind = script_.Below(10);
    if (kind == 1) body.set_metres_per_unit(script_.Strange());
    if (kind == 2) body.set_offsets(static_cast<int>(script_.Below(63)), script_.Strange());
    if (kind == 3 || kind == 4) {
      for (int j = 0; j < body.names_size(); ++j) {
        for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) body.add_rest(value);
      }
      if (kind == 4) body.set_rest(static_cast<int>(script_.Below(84)), script_.Strange());
      body.set_dialect("");
    }
    if (kind == 5) {  // one more joint
      body.add_names("extra");
      body.add_parents(static_cast<int>(script_.Below(30)));
      for (int k = 0; k < 3; ++k) body.add_offsets(0.1F);
    }
    if (kind == 6) body.set_dialect("auto");
    if (kind == 7) {
      for (int j = 0; j < 63; ++j) body.set_offsets(j, body.offsets(j) * script_.Strange());
    }
    if (kind == 8) {
      for (int j = 0; j < 63; j += 3) body.set_offsets(j, -body.offsets(j));
    }
    return rig.Datagram(native::Kind::kBody, body.SerializeAsString());
  }
  Bytes Frame(support::Rig& rig) {
    return rig.Frame([this](v1::SourceFrame& frame) {
      switch (script_.Below(6)) {
        case 0:
          frame.set_rotations(static_cast<int>(script_.Below(84)), script_.Strange());
          break;
        case 1:
          frame.set_root_position(static_cast<int>(script_.Below(3)), script_.Strange());
          break;
        case 2:
          for (int i = 0; i < frame.rotations_size(); ++i) {
            frame.set_rotations(i, frame.rotations(i) * script_.Strange());
          }
          break;
        case 3:
          frame.add_rotations(0);
          frame.set_body_crc(static_cast<std::uint32_t>(script_.Word()));
          break;
        case 4:
          frame.set_source_time_ns(Change(frame.source_time_ns()));
          break;
        default:
          frame.mutable_timecode()->set_hours(static_cast<std::uint32_t>(script_.Word()));
          frame.mutable_timecode()->set_rate(script_.Strange());
          frame.add_expressions()->set_value(script_.Strange());
          AddProp(frame);
          break;
      }
    });
  }
  void AddProp(v1::SourceFrame& frame) {
    for (std::size_t k = script_.Below(19); k > 0; --k) {
      v1::Prop& prop = *frame.add_props();
      prop.set_name(std::string(script_.Below(70), 'p') + std::to_string(k));
      for (int i = 0; i < 3; ++i) prop.add_position(script_.Strange());
      for (int i = 0; i < 4; ++i) prop.add_rotation(script_.Strange());
    }
  }
  void Send(std::size_t who, const Bytes& bytes, Stage& stage) {
    waiting_.push_back(bytes);
    from_.push_back(machines_[who]);
    if (waiting_.size() + 1 >= source::kBatch) Flush(stage);
  }

  Script& script_;
  std::array<support::Rig, 3> rigs_{support::Rig("a", 11), support::Rig("b", 22),
                                    support::Rig("b", 33)};
  std::array<source::Machine, 3> machines_{};
  std::vector<Bytes> waiting_;
  std::vector<source::Machine> from_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  [[maybe_unused]] static auto* const quiet = google::protobuf::SetLogHandler(nullptr);
  constexpr std::size_t kMostBytes = 1024;  // longer scripts find nothing new
  Script script({data, std::min(size, kMostBytes)});
  Stage stage;
  Others others(script);
  std::size_t victims = 0;
  while (!script.done()) {
    others.Act(static_cast<Action>(script.Below(static_cast<std::size_t>(Action::kCount))), stage);
    others.Flush(stage);
    std::size_t before = victims;
    for (const v1::Frame& frame : stage.Drain()) {
      RequireSane(frame);
      if (!IsVictims(frame)) continue;
      REQUIRE(Same(frame, Undisturbed(victims)));
      ++victims;
    }
    REQUIRE(victims > before);
  }
  return 0;
}
