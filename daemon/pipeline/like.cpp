#include "daemon/pipeline/like.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/text.h"
#include "model/clip/clip.h"
#include "model/rig/dialects.h"

namespace styled::pipeline {
namespace {

// An error with its code.
struct Refusal {
  v1::Code code = v1::CODE_OK;
  std::string reason;
};

Refusal Malformed(std::string reason) { return {v1::CODE_MALFORMED, std::move(reason)}; }

// Where the style goes among those of the network.
struct Place {
  int number = -1;
  int replaced = -1;  // the style that had the name, or -1
};

Refusal FindPlace(const RuntimeConfig& running, const std::string& name, Place& place) {
  if (!config::IsName(name) || name.size() > net::kMaxStyleName) {
    return Malformed("name \"" + Printable(name, 80) + "\": expected 1 to " +
                     std::to_string(net::kMaxStyleName) + " of A-Z a-z 0-9 _ -");
  }
  for (const auto& preset : running.presets) {
    if (preset.name == name) return Malformed("name \"" + name + "\": a preset has it");
  }
  const net::Styles& styles = running.network->model().styles;
  const int own = running.own_styles;
  place.replaced = net::FindStyle(styles, name);
  if (place.replaced >= 0 && place.replaced < own) {
    return Malformed("name \"" + name + "\": a style of the weights has it, \"" +
                     styles[static_cast<std::size_t>(place.replaced)].name + "\"");
  }
  place.number = static_cast<int>(styles.size());
  if (place.number < net::kMaxStyles) return {};
  for (int number = own; number < place.number; ++number) {
    if (!styles[static_cast<std::size_t>(number)].retired) continue;
    place.number = number;
    return {};
  }
  return {v1::CODE_BUSY, "there are " + std::to_string(net::kMaxStyles) +
                             " styles already, the most that there can be"};
}

// The clip's poses at the network's rate.
Refusal ReadClip(const v1::Like& like, const net::Model& model, const net::StyleSpace& space,
                 std::vector<body::Pose>& poses, float& seconds) {
  const std::string name = like.file().empty() ? "the clip" : Printable(like.file(), 200);
  const auto clip = clip::ParseBvh(like.clip(), name);
  if (!clip.ok()) return Malformed(clip.status().message());
  const auto bound =
      rig::BindDialect(clip.value().skeleton, like.rig().empty() ? "auto" : like.rig());
  if (!bound.ok()) return Malformed(name + ": " + bound.status().message());
  const double rate_hz = static_cast<double>(model.rate_hz);
  const double length_s =
      static_cast<double>(clip.value().frames.size() - 1) / clip.value().rate_hz;
  if (length_s > kLongestExample_s) {
    return Malformed(name + ": found " + NumberText(static_cast<float>(length_s), 2) +
                     " s, expected at most " + NumberText(static_cast<float>(kLongestExample_s)));
  }
  poses = clip::ResamplePoses(clip::ToCanonical(clip.value(), bound.value()), clip.value().rate_hz,
                              rate_hz);
  if (static_cast<int>(poses.size()) < space.least_frames()) {
    return Malformed(name + ": found " + std::to_string(poses.size()) + " frames at " +
                     NumberText(model.rate_hz) + " Hz, expected at least " +
                     std::to_string(space.least_frames()));
  }
  seconds = static_cast<float>(length_s);
  return {};
}

// The distance of a code of huge numbers overflows, and it could not be limited.
bool Usable(const net::StyleCode& code, const net::StyleSpace& space) {
  return std::all_of(code.begin(), code.end(), [](float x) { return std::isfinite(x); }) &&
         std::isfinite(space.Nearest(code).distance);
}

Refusal ReadCode(const v1::Like& like, const net::StyleSpace& space, net::StyleCode& code) {
  code.assign(like.code().begin(), like.code().end());
  if (!space.IsCode(code)) {
    return Malformed("code: found " + std::to_string(code.size()) +
                     " numbers, expected as many as these weights' codes have, " +
                     std::to_string(space.MakeCode({.sources = {{.style = 0}}}).size()) +
                     " or, of an example, more");
  }
  if (!Usable(code, space)) return Malformed("code: expected finite numbers, not huge ones");
  code = space.Limited(code);
  return {};
}

Refusal CheckExample(const v1::Like& like, const net::Stylizer& network) {
  if (network.space() == nullptr) {
    return {v1::CODE_NO_EXAMPLES, "the weights of family \"" + network.model().family +
                                      "\" have no style encoder; expected weights that have one"};
  }
  const int examples = static_cast<int>(!like.clip().empty()) +
                       static_cast<int>(like.code_size() > 0) +
                       static_cast<int>(like.learn_s() != 0) + static_cast<int>(like.has_vary());
  if (examples != 1) {
    return Malformed("expected one of clip, code, learn_s and vary, found " +
                     std::to_string(examples) + " of them");
  }
  const float learn_s = like.learn_s();
  if (learn_s != 0 && !(learn_s >= kShortestTake_s && learn_s <= kLongestExample_s)) {
    return Malformed("learn_s: found " + NumberText(learn_s) + ", expected " +
                     NumberText(kShortestTake_s) + " to " + NumberText(kLongestExample_s) + " s");
  }
  return {};
}

Refusal FindVariation(const v1::Variation& vary, const RuntimeConfig& running,
                      net::StyleRequest& request) {
  const net::Styles& styles = running.network->model().styles;
  const int style = net::FindStyle(styles, vary.style());
  if (style < 0 || style >= running.own_styles) {
    std::string names;
    for (int own = 0; own < running.own_styles; ++own) {
      names += " " + styles[static_cast<std::size_t>(own)].name;
    }
    return {v1::CODE_UNKNOWN_STYLE, "vary: \"" + Printable(vary.style(), 80) +
                                        "\" is no style of the weights; these are" + names};
  }
  request.amount = vary.has_amount() ? vary.amount() : 1;
  if (!(request.amount >= 0 && request.amount <= net::kMaxStrength)) {
    return {v1::CODE_OUT_OF_RANGE, "vary: amount: found " + NumberText(request.amount) +
                                       ", expected 0 to " + NumberText(net::kMaxStrength)};
  }
  request.sources = {{.style = style, .seed = vary.seed()}};
  return {};
}

Refusal MakeCode(const v1::Like& like, const RuntimeConfig& running,
                 std::span<const body::Pose> take, net::StyleCode& code, float& seconds) {
  const net::Model& model = running.network->model();
  const net::StyleSpace& space = *running.network->space();
  if (like.code_size() > 0) return ReadCode(like, space, code);
  net::StyleRequest request;
  std::vector<body::Pose> poses(take.begin(), take.end());
  Refusal refusal;
  if (like.has_vary()) {
    refusal = FindVariation(like.vary(), running, request);
  } else {
    if (take.empty()) refusal = ReadClip(like, model, space, poses, seconds);
    request.sources = {{.style = -1, .seed = {}, .reference = poses}};
  }
  if (refusal.code != v1::CODE_OK) return refusal;
  if (!take.empty()) seconds = like.learn_s();
  code = space.MakeCode(request);
  if (Usable(code, space)) return {};
  return Malformed("the network finds no style in the example: its code is not finite");
}

bool Accept(const Refusal& refusal, v1::Reply& reply) {
  if (refusal.code == v1::CODE_OK) return true;
  reply.set_code(refusal.code);
  reply.set_reason("like: " + refusal.reason);
  return false;
}

}  // namespace

bool CheckLike(const RuntimeConfig& running, const v1::Like& like, v1::Reply& reply) {
  Place place;
  return Accept(FindPlace(running, like.name(), place), reply) &&
         Accept(CheckExample(like, *running.network), reply);
}

std::shared_ptr<const RuntimeConfig> AddStyle(const RuntimeConfig& running, v1::Like& like,
                                              std::span<const body::Pose> take, v1::Reply& reply) {
  Place place;
  net::StyleCode code;
  float seconds = 0;
  const bool made_code = CheckLike(running, like, reply) &&
                         Accept(FindPlace(running, like.name(), place), reply) &&
                         Accept(MakeCode(like, running, take, code, seconds), reply);
  if (!made_code) return nullptr;
  const net::StyleSpace& space = *running.network->space();
  auto made = std::make_shared<RuntimeConfig>(running);
  if (place.replaced >= 0) made->network = made->network->Retired(place.replaced);
  made->network = made->network->With(place.number, {.name = like.name()}, code);
  const net::NearestStyle nearest = space.Nearest(code);
  v1::LikeReply& said = *reply.mutable_like();
  said.set_name(like.name());
  said.set_nearest(running.network->model().styles[static_cast<std::size_t>(nearest.style)].name);
  said.set_distance(nearest.distance);
  said.set_seconds(seconds);
  said.mutable_code()->Add(code.begin(), code.end());
  like.clear_clip();
  like.clear_learn_s();
  like.clear_vary();
  *like.mutable_code() = said.code();
  return made;
}

}  // namespace styled::pipeline
