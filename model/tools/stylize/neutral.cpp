// The argument --neutral of stylize: the source of the performer's own carriage.
#include "model/clip/any_clip.h"
#include "model/offline/learn_neutral.h"
#include "model/tools/stylize/report.h"
#include "model/tools/stylize/stylize.h"

namespace styled::stylize {

Result<std::optional<neutral::Known>> ReadNeutral(const Arguments& arguments,
                                                  const rig::JointNames& joints,
                                                  const net::Model& model) {
  using Learned = std::optional<neutral::Known>;
  const std::string& file = arguments.neutral;
  if (file == kNeutralOfClip || file == kNeutralLive || file == kNoNeutral) return Learned();
  if (!model.reference) {
    return Status::Error(
        "--neutral " + file +
        ": these weights have no reference of how their performers stand and walk; "
        "expected weights of version 3 (styletrain --write-reference)");
  }
  const auto clip = clip::ReadAnyClip(file, {}, joints);
  if (!clip.ok()) return Status::Error("--neutral: " + clip.status().message());
  Warn("--neutral " + file, clip.value().clip.remark);
  const auto bound =
      clip::BindAnyClip(clip.value(), {arguments.rig, clip::ParseRestPose(arguments.rest).value(),
                                       joints, clip::ParseUp(arguments.up).value()});
  if (!bound.ok()) return Status::Error("--neutral: " + file + ": " + bound.status().message());
  Learned learned =
      offline::LearnNeutral(clip.value().clip, bound.value().binding, *model.reference);
  if (learned->body_s > 0) return learned;
  return Status::Error("--neutral " + file +
                       ": found no standing or walking; expected some seconds of it, in the "
                       "performer's own way");
}

}  // namespace styled::stylize
