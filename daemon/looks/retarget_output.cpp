#include "daemon/looks/retarget_output.h"

#include <algorithm>
#include <utility>

#include "daemon/publish/body_message.h"

namespace styled::pipeline {
namespace {

v1::Body MakeBody(const clip::AvatarSkeleton& avatar, const std::string& name) {
  rig::Skeleton skeleton = avatar.binding->skeleton();
  std::vector<rig::Quat> rest = avatar.binding->spec().rest_rotations;
  for (std::size_t joint = 0; joint < rest.size(); ++joint) {
    rig::Vec3& offset = skeleton.offsets[joint];
    offset = joint == 0 ? avatar.RootInFile(offset) : rig::Vec3(offset / avatar.above_scale);
    rest[joint] = avatar.RootInFile(rest[joint]);
  }
  v1::Body body = publish::SkeletonBody(skeleton, rest, avatar.metres_per_unit, avatar.dialect,
                                        v1::OUTPUT_AVATAR);
  body.set_output_name(name);
  return body;
}

}  // namespace

bool RetargetOutput::IsFor(std::string_view performer) const {
  return performers.empty() ||
         std::find(performers.begin(), performers.end(), performer) != performers.end();
}

Result<std::shared_ptr<const RetargetOutput>> ReadRetargetOutput(const config::Output& output) {
  auto skeleton = clip::ReadAvatar(output.avatar, output.dialect, output.joints);
  if (!skeleton.ok()) {
    return Status::Error(output.place + ": output.avatar: " + skeleton.status().message());
  }
  auto avatar = std::make_shared<RetargetOutput>();
  avatar->name = output.name;
  avatar->performers = output.performers;
  avatar->skeleton = std::move(skeleton.value());
  avatar->body = MakeBody(avatar->skeleton, avatar->name);
  return std::shared_ptr<const RetargetOutput>(std::move(avatar));
}

}  // namespace styled::pipeline
