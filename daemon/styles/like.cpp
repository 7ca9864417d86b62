#include "daemon/styles/like.h"

#include <algorithm>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "daemon/styles/style_list.h"
#include "model/base/text.h"
#include "model/clip/any_clip.h"
#include "model/clip/clip.h"
#include "model/rig/dialects.h"

namespace styled::pipeline {
namespace {

constexpr std::size_t kMaxSource = 200;  // bytes of a source's name that are kept

// A clip in one of the formats, as canonical poses at its own rate.
struct Poses {
  std::deque<body::Pose> poses;
  double rate_hz = 0;
  std::string remark;  // clip::Clip's and clip::BoundClip's
};

// In the order of their names, so that the same request always does the same.
rig::JointNames JointsOf(const v1::Like& like) {
  rig::JointNames joints(like.joints().begin(), like.joints().end());
  std::sort(joints.begin(), joints.end());
  return joints;
}

Result<Poses> Read(const v1::Like& like, const std::string& name, const clip::ReadLimits& limits) {
  auto clip = clip::ParseAnyClip(like.clip(), name, limits, JointsOf(like));
  if (!clip.ok()) return clip.status();
  const std::string rig = like.rig().empty() ? "auto" : like.rig();
  const auto bound = clip::BindAnyClip(clip.value(), {rig, {}, JointsOf(like), {}});
  if (!bound.ok()) return Status::Error(name + ": " + bound.status().message());
  clip::Clip& read = clip.value().clip;
  std::string remark = std::move(read.remark);
  const std::string& own = bound.value().remark;
  remark += (remark.empty() || own.empty() ? "" : "; ") + own;
  const double rate_hz = read.rate_hz;
  auto poses = clip::ToCanonical(std::move(read), bound.value().binding, limits.work, name);
  if (!poses.ok()) return poses.status();
  return Poses{std::move(poses.value()), rate_hz, std::move(remark)};
}

// The clip's poses at the network's rate.
Status ReadClip(const v1::Like& like, const net::Model& model, const net::StyleSpace& space,
                const WorkLimit& work, std::vector<body::Pose>& poses, float& seconds,
                std::string& remark) {
  const std::string name = like.file().empty() ? "the clip" : Printable(like.file(), kMaxSource);
  const clip::ReadLimits limits{.longest_s = clip::kLongestExample_s, .work = work};
  const auto read = Read(like, name, limits);
  if (!read.ok()) return Malformed(read.status().message());
  const auto& [own, own_hz, own_remark] = read.value();
  remark = own_remark;
  const double length_s = static_cast<double>(own.size() - 1) / own_hz;
  auto resampled = clip::ResamplePoses(own, own_hz, static_cast<double>(model.rate_hz), work, name);
  if (!resampled.ok()) return Malformed(resampled.status().message());
  poses = std::move(resampled.value());
  if (static_cast<int>(poses.size()) < space.least_frames()) {
    return Malformed(name + ": found " + std::to_string(poses.size()) + " frames at " +
                     NumberText(model.rate_hz) + " Hz, expected at least " +
                     std::to_string(space.least_frames()));
  }
  seconds = static_cast<float>(length_s);
  return Status::Ok();
}

net::StyleCode CodeOf(const google::protobuf::RepeatedField<float>& numbers) {
  return {numbers.begin(), numbers.end()};
}

Status CheckExample(const v1::Like& like, const net::Stylizer& network) {
  if (network.space() == nullptr) {
    return NoEncoder(network.model());
  }
  const int examples = static_cast<int>(!like.clip().empty()) +
                       static_cast<int>(like.code_size() > 0) +
                       static_cast<int>(like.learn_s() != 0) + static_cast<int>(like.has_vary()) +
                       static_cast<int>(like.has_design());
  if (examples != 1) {
    return Malformed("expected one of clip, code, learn_s, vary and design, found " +
                     std::to_string(examples) + " of them");
  }
  const float learn_s = like.learn_s();
  if (learn_s != 0 && !(learn_s >= kShortestTake_s && learn_s <= clip::kLongestExample_s)) {
    return Malformed("learn_s: found " + NumberText(learn_s) + ", expected " +
                     NumberText(kShortestTake_s) + " to " + NumberText(clip::kLongestExample_s) +
                     " s");
  }
  if (like.neutral_code_size() == 0) return {};
  if (like.has_vary() || like.has_design()) {
    return Malformed(
        "neutral_code: found it with vary or a design, expected it with clip, code or learn_s");
  }
  return CheckCode(*network.space(), CodeOf(like.neutral_code()), "neutral_code");
}

Status FindVariation(const v1::Variation& vary, const RuntimeConfig& running,
                     net::StyleRequest& request) {
  const net::Styles& styles = running.network->model().styles;
  const int style = net::FindStyle(styles, vary.style());
  if (style < 0 || style >= running.own_styles) {
    std::string names;
    for (int own = 0; own < running.own_styles; ++own) {
      names += " " + styles[static_cast<std::size_t>(own)].name;
    }
    return Refused(v1::CODE_UNKNOWN_STYLE, "vary: \"" + Printable(vary.style(), 80) +
                                               "\" is not a style of the weights; these are" +
                                               names);
  }
  request.amount = vary.has_amount() ? vary.amount() : 1;
  if (!(request.amount >= 0 && request.amount <= net::kMaxStrength)) {
    return Refused(v1::CODE_OUT_OF_RANGE, "vary: amount: found " + NumberText(request.amount) +
                                              ", expected 0 to " + NumberText(net::kMaxStrength));
  }
  // The style of the same name in the network that has variations; every network has neutral.
  const int varying = style == 0 ? 0 : net::VaryingStyle(styles, style);
  if (varying < 0) {
    return Refused(v1::CODE_NO_EXAMPLES, "vary: \"" + styles[static_cast<std::size_t>(style)].name +
                                             "\": its network has no variations; those that "
                                             "have are named by model.examples");
  }
  request.sources = {{.style = varying, .seed = vary.seed()}};
  return Status::Ok();
}

Status UnknownNetwork(const std::string& name, const RuntimeConfig& running) {
  std::string names;
  for (const net::StyleInfo& style : running.network->model().styles) {
    const bool takes_examples = style.varies || style.designable;
    if (takes_examples && !style.model.empty() &&
        names.find(" " + style.model) == std::string::npos) {
      names += " " + style.model;
    }
  }
  return Malformed("network: \"" + Printable(name, kMaxSource) +
                   "\" takes no examples; those that do are" + (names.empty() ? " one" : names));
}

// Makes `style` the mean of the made style of its name and of itself, by their examples' lengths.
Status AddTo(const RuntimeConfig& running, MadeStyle& style) {
  std::shared_ptr<const MadeStyle> former;
  if (Status status = FindMade(running, style.name, former); !status.ok()) return status;
  const float seconds = former->seconds + style.seconds;
  style.code = running.network->space()->Mean(former->code, style.code,
                                              seconds > 0 ? style.seconds / seconds : 0.5F);
  if (style.code.empty()) {
    return Malformed("\"" + style.name +
                     "\": is of another kind than the example: one is the difference to a neutral "
                     "clip, or they belong to different networks");
  }
  style.name = former->name;
  style.seconds = seconds;
  if (!former->source.empty() && former->source != style.source) {
    style.source = Printable(former->source + ", " + style.source, kMaxSource);
  }
  return Status::Ok();
}

// The code of the style that a design begins with; empty: a neutral performer.
Status FindDesigned(const v1::Like& like, const RuntimeConfig& running, net::StyleCode& code) {
  const net::Styles& styles = running.network->model().styles;
  const std::string& from = like.design().from();
  const int style = net::FindStyle(styles, from.empty() ? like.name() : from);
  if (style < 0 && from.empty()) return Status::Ok();
  if (style < 0) {
    return Refused(v1::CODE_UNKNOWN_STYLE, "from: no style \"" + Printable(from, 80) + "\"");
  }
  if (style == 0) return Status::Ok();
  if (style >= running.own_styles) {
    code = running.made.at(styles[static_cast<std::size_t>(style)].name)->code;
  } else {
    code = running.network->space()->MakeCode({.sources = {{.style = style}}});
  }
  return Status::Ok();
}

Status MakeDesign(const v1::Like& like, const RuntimeConfig& running, MadeStyle& style) {
  const net::StyleSpace& space = *running.network->space();
  const v1::Design& design = like.design();
  if (Status status = FindDesigned(like, running, style.code); !status.ok()) return status;
  net::SliderValues values;
  if (!design.preset().empty()) {
    const auto preset = std::ranges::find_if(
        space.presets(), [&design](const net::Preset& one) { return design.preset() == one.name; });
    if (preset == space.presets().end() && design.preset() != "neutral") {
      std::string names = "neutral";
      for (const net::Preset& one : space.presets()) names += " " + std::string(one.name);
      return Malformed("design \"" + Printable(design.preset(), 80) + "\": expected one of " +
                       names);
    }
    for (const net::Slider& slider : space.sliders()) values.push_back({slider.name, slider.usual});
    if (preset != space.presets().end()) {
      values.insert(values.end(), preset->values.begin(), preset->values.end());
    }
  }
  for (const auto& [name, value] : design.sliders()) values.push_back({name, value});
  auto designed = space.Design(style.code, values);
  if (!designed.ok()) return Refused(v1::CODE_OUT_OF_RANGE, designed.status().message());
  style.code = std::move(designed.value());
  style.source = design.from().empty() ? "by hand" : design.from() + ", by hand";
  return Status::Ok();
}

// Finds the code and its source: writes the poses to `example`, the length to `style`, and to
// `remark` what is odd about the clip.
Status MakeCode(const v1::Like& like, const RuntimeConfig& running,
                std::span<const body::Pose> take, const WorkLimit& work, MadeStyle& style,
                std::vector<body::Pose>& example, std::string& remark) {
  const net::Model& model = running.network->model();
  const net::StyleSpace& space = *running.network->space();
  net::StyleRequest request;
  Status refusal = Status::Ok();
  example.assign(take.begin(), take.end());
  if (like.code_size() > 0) {
    style.code = CodeOf(like.code());
  } else if (like.has_design()) {
    return MakeDesign(like, running, style);
  } else if (like.has_vary()) {
    refusal = FindVariation(like.vary(), running, request);
    style.source = like.vary().style() + ", variation " + std::to_string(like.vary().seed());
  } else {
    if (take.empty()) refusal = ReadClip(like, model, space, work, example, style.seconds, remark);
    request.sources = {{.style = -1, .seed = {}, .reference = example}};
    request.network = like.network();
  }
  if (!refusal.ok()) return refusal;
  if (!take.empty()) style.seconds = like.learn_s();
  const char* const what = like.code_size() > 0 ? "code" : "the example's code";
  if (like.code_size() == 0) style.code = space.MakeCode(request);
  if (!like.network().empty() && style.code.empty()) return UnknownNetwork(like.network(), running);
  refusal = CheckCode(space, style.code, what);
  if (!refusal.ok()) return refusal;
  if (like.neutral_code_size() > 0) {
    style.code = space.Difference(style.code, CodeOf(like.neutral_code()));
    if (style.code.empty()) {
      return Malformed(
          "the example and its neutral show nothing in common; expected a walk or a "
          "run in both, or in neither");
    }
    refusal = CheckCode(space, style.code, "the difference to neutral_code");
    if (!refusal.ok()) return refusal;
  }
  return like.add() ? AddTo(running, style) : refusal;
}

// Computes the code and the distance that the style would have.
void Measure(const RuntimeConfig& running, MadeStyle& style) {
  const net::StyleSpace& space = *running.network->space();
  style.code = space.Limited(style.code);
  const net::NearestStyle nearest = space.Nearest(style.code);
  style.nearest = running.network->model().styles[static_cast<std::size_t>(nearest.style)].name;
  style.distance = nearest.distance;
}

}  // namespace

void Describe(const net::StyleSpace& space, const MadeStyle& style, v1::LikeReply& reply) {
  reply.set_name(style.name);
  reply.set_nearest(style.nearest);
  reply.set_distance(style.distance);
  reply.set_seconds(style.seconds);
  *reply.mutable_code() = {style.code.begin(), style.code.end()};
  const net::Findings findings = space.Describe(style.code);
  *reply.mutable_found() = {findings.found.begin(), findings.found.end()};
  *reply.mutable_weak() = {findings.weak.begin(), findings.weak.end()};
}

namespace {

// A style of the weights' own numbers owes what they owe; one that is measured, only the clip's
// licence.
void SetLicence(const RuntimeConfig& running, MadeStyle& style) {
  const bool measured = running.network->space()->Portable(style.code) == style.code;
  style.licence = measured ? "" : running.network->model().licence;
}

}  // namespace

Status MakeCodeAgain(const RuntimeConfig& running, const std::string& bvh, const std::string& file,
                     const WorkLimit& work, MadeStyle& style) {
  v1::Like like;
  like.set_name(style.name);
  like.set_clip(bvh);
  like.set_file(file);
  if (Status status = CheckExample(like, *running.network); !status.ok()) return status;
  std::vector<body::Pose> example;
  std::string remark;
  Status made = MakeCode(like, running, {}, work, style, example, remark);
  if (made.ok()) SetLicence(running, style);
  return made;
}

// An example of which only a network without gaits made a style.
void DescribeWithoutGait(float seconds, v1::LikeReply& reply) {
  constexpr float kUsual_s = 3;
  reply.add_found("no walk and no run");
  if (seconds < kUsual_s) {
    reply.add_weak("only " + NumberText(seconds, 1) + " s; show 3 s or more of a walk or a run");
  }
}

Status CheckLike(const RuntimeConfig& running, const v1::Like& like) {
  if (!like.measure()) {
    if (Status status = CheckNewName(like.name()); !status.ok()) return status;
    Place place;
    if (Status status = FindPlace(running, like.name(), place); !status.ok()) return status;
  }
  return CheckExample(like, *running.network);
}

Result<std::shared_ptr<RuntimeConfig>> AddStyle(const RuntimeConfig& running, v1::Like& like,
                                                std::span<const body::Pose> take,
                                                v1::LikeReply& reply,
                                                std::vector<body::Pose>* example,
                                                const WorkLimit& work) {
  MadeStyle style;
  style.name = like.name();
  style.source = Printable(like.file(), kMaxSource);
  std::vector<body::Pose> poses;
  std::string remark;
  if (Status status = CheckLike(running, like); !status.ok()) return status;
  if (Status status = MakeCode(like, running, take, work, style, poses, remark); !status.ok()) {
    return status;
  }
  SetLicence(running, style);
  std::shared_ptr<RuntimeConfig> made;
  if (like.measure()) {
    Measure(running, style);
    Describe(*running.network->space(), style, reply);
  } else {
    made = std::make_shared<RuntimeConfig>(running);
    const std::string name = style.name;
    // Sliders move: no fade from each of their places.
    const bool moves = like.has_design() || like.in_place();
    if (Status status = PutStyle(std::move(style), *made, moves); !status.ok()) return status;
    Describe(*made->network->space(), *made->made.at(name), reply);
  }
  if (!remark.empty()) reply.add_weak("the file: " + remark);
  // A network with sliders looks for gaits, unless the request names another one.
  const bool looked = like.network().empty() && !running.network->space()->sliders().empty();
  if (looked && reply.seconds() > 0 && reply.found().empty()) {
    DescribeWithoutGait(reply.seconds(), reply);
  }
  like.clear_clip();
  like.clear_learn_s();
  like.clear_vary();
  like.clear_neutral_code();
  like.clear_network();
  // A standby and a replay do the same.
  if (like.has_design()) like.set_in_place(true);
  like.clear_design();
  like.clear_add();
  *like.mutable_code() = reply.code();
  if (example != nullptr) *example = std::move(poses);
  return made;
}

}  // namespace styled::pipeline
