#include "model/train/erd/clip_teacher.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/base/text.h"
#include "model/body/heading.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Two rates count as equal if clips need no resampling between them.
constexpr double kSameRate = 1e-3;
// Mean error of reconstruction over joints and frames above which a clip is foreign to the teacher.
// Of its own training clips, 95 in 100 are below 0.09; walks of other performers and rigs have 0.2
// to 0.5.
constexpr double kForeign_rad = 0.12;

}  // namespace

ClipTeacher::OfClip ClipTeacher::Changed(const net::ClipStylizer& network, const TrainingClip& clip,
                                         int input_style, int style) {
  net::StyleRequest request;
  request.sources.emplace_back().style = style;
  const auto stream =
      network.MakeStream(network.MakeCode(request), input_style, net::Extent::kByLength);
  for (const body::Pose& pose : clip.poses) stream->Add(pose);
  stream->End();
  OfClip out;
  net::Prediction prediction;
  for (const body::Pose& pose : clip.poses) {
    if (!stream->Pop(prediction)) break;
    auto& output = out.by_output.emplace_back();
    auto& change = out.by_change.emplace_back();
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      body::Quat own = pose.rotations[joint];
      if (joint == body::kHips) own = body::Yaw(-prediction.heading_rad) * own;
      const body::Quat& again = prediction.reconstruction.rotations[joint];
      const body::Quat& styled = prediction.styled.rotations[joint];
      std::copy_n((own.conjugate() * styled).coeffs().data(), 4, output.data() + 4 * joint);
      std::copy_n((again.conjugate() * styled).coeffs().data(), 4, change.data() + 4 * joint);
      out.error_rad += own.angularDistance(again);
    }
    output.back() = prediction.styled.hips_height_m - pose.hips_position_m.y();
    change.back() = prediction.styled.hips_height_m - prediction.reconstruction.hips_height_m;
  }
  out.error_rad /= static_cast<double>(clip.poses.size() * body::kJointCount);
  return out;
}

Result<ClipTeacher> ClipTeacher::Make(const net::ClipStylizer& network,
                                      const clip::Manifest& manifest,
                                      const std::vector<TrainingClip>& clips, double rate_hz,
                                      const std::vector<std::string>& taught) {
  const net::Model& model = network.model();
  if (std::abs(model.rate_hz / rate_hz - 1.0) > kSameRate) {
    return Status::Error("works at " + NumberText(model.rate_hz) + " Hz, the run at " +
                         NumberText(rate_hz));
  }
  const auto place = [&model](const std::string& name) {
    return net::FindStyle(model.styles, name);
  };
  constexpr int neutral = 0;  // the first, whatever it is called
  ClipTeacher teacher;
  teacher.changes_.resize(manifest.styles.size(), std::vector<Frames>(clips.size()));
  double by_output = 0;
  double by_change = 0;
  for (std::size_t style = 1; style < manifest.styles.size(); ++style) {
    if (taught[style - 1].empty()) continue;
    const int of_teacher = place(taught[style - 1]);
    for (std::size_t i = 0; i < clips.size(); ++i) {
      const bool is_neutral = clips[i].style == 0;
      if (!is_neutral && clips[i].style != static_cast<int>(style)) continue;
      OfClip made = Changed(network, clips[i], is_neutral ? neutral : of_teacher,
                            is_neutral ? of_teacher : neutral);
      const bool foreign = made.error_rad > kForeign_rad;
      teacher.changes_[style][i] = std::move(foreign ? made.by_change : made.by_output);
      (foreign ? by_change : by_output) += 1;
    }
  }
  teacher.share_by_change_ = by_change / std::max(1.0, by_change + by_output);
  return teacher;
}

// Between two frames, by linear interpolation, because they are similar.
void ClipTeacher::Read(const Frames& clip, double at, body::Pose& change, float& rise_m) {
  const auto last = static_cast<double>(clip.size() - 1);
  const double place = std::clamp(at, 0.0, last);
  const auto& before = clip[static_cast<std::size_t>(place)];
  const auto& after = clip[static_cast<std::size_t>(std::ceil(place))];
  const auto share = static_cast<float>(place - std::floor(place));
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::Quat from(before.data() + 4 * joint);
    const body::Quat to(after.data() + 4 * joint);
    const float side = from.dot(to) < 0 ? -1.0F : 1.0F;
    change.rotations[joint].coeffs() =
        ((1 - share) * from.coeffs() + share * side * to.coeffs()).normalized();
  }
  rise_m = (1 - share) * before.back() + share * after.back();
}

ClipTeacher::Changes ClipTeacher::Of(const std::vector<Sampler::Window>& windows,
                                     const Roles& roles, int frames, double lead) const {
  const auto count = static_cast<int64_t>(windows.size());
  Changes out{torch::zeros({frames, count, body::kJointCount, 4}), torch::zeros({frames, count})};
  auto rotations = out.rotations.accessor<float, 4>();
  auto rise = out.rise_m.accessor<float, 2>();
  body::Pose change;
  for (int64_t i = 0; i < count; ++i) {
    const Sampler::Window& window = windows[i];
    const Frames& of_clip = changes_[std::max(roles.input[i], roles.target[i])][window.clip];
    for (int t = 0; t < frames; ++t) {
      for (body::Quat& rotation : change.rotations) rotation.setIdentity();
      if (!of_clip.empty()) {
        const double at = window.start + (window.idle ? 0.0 : t + lead);
        Read(of_clip, at, change, rise[t][i]);
      }
      // A reflection of a product is the product of the reflections.
      if (window.mirrored) body::Mirror(change, change);
      for (int joint = 0; joint < body::kJointCount; ++joint) {
        for (int k = 0; k < 4; ++k) rotations[t][i][joint][k] = change.rotations[joint].coeffs()[k];
      }
    }
  }
  return out;
}

}  // namespace styled::train::style_erd
