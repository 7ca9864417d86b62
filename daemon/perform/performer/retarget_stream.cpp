#include "daemon/perform/performer/retarget_stream.h"

#include <algorithm>
#include <utility>

namespace styled::pipeline {

RetargetStream::RetargetStream(std::shared_ptr<const RetargetOutput> output, const BoundBody& body,
                               const std::string& id, std::uint64_t epoch,
                               const RuntimeConfig& config, publish::Subscriptions& subscriptions)
    : output_(std::move(output)),
      avatar_(body.binding, output_->skeleton.binding, output_->skeleton.rest, config.stylist,
              output_->skeleton.tail),
      rotations_(output_->skeleton.rest.rotations),
      wrists_(*output_->skeleton.binding),
      message_(id, epoch, output_->body, body.binding->skeleton().joint_count(),
               config.network->model().styles),
      subscriptions_(subscriptions) {
  v1::Body message = output_->body;
  message.set_performer(id);
  body_bytes_ = message.SerializeAsString();
  topic.name = "styled/" + id + "/" + output_->name + "/";
  subscriptions_.Register(topic);
}

RetargetStream::~RetargetStream() { subscriptions_.Unregister(topic); }

void RetargetStream::Process(std::int64_t elapsed_ns, const stylist::Output& out,
                             const CarriedProps& props) noexcept {
  if (topic.wanted == 0) {
    has_frame_ = failed_ = false;
    return;
  }
  if (!has_frame_) avatar_.Reset();
  has_frame_ = true;
  failed_ = !avatar_.Process(elapsed_ns, out);
  const auto& skeleton = output_->skeleton;
  const rig::Vec3 root = skeleton.binding->RootPosition(avatar_.pose());
  PlaceProps(root, props);
  root_ = skeleton.RootInFile(root);
  std::copy(avatar_.pose().rotations.begin(), avatar_.pose().rotations.end(), rotations_.begin());
  rotations_.front() = skeleton.RootInFile(rotations_.front());
}

void RetargetStream::PlaceProps(const rig::Vec3& root, const CarriedProps& props) noexcept {
  props_.Clear();
  if (props.empty()) return;
  const auto& skeleton = output_->skeleton;
  props.OnWrists(wrists_.Read(root, avatar_.pose().rotations), props_,
                 [&skeleton](const rig::Placed& placed, source::Prop& prop) {
                   rig::FromCanonical(*skeleton.binding, placed, prop.position, prop.rotation);
                   prop.position = skeleton.RootInFile(prop.position);
                   prop.rotation = skeleton.RootInFile(prop.rotation) * skeleton.above_rotation;
                 });
}

}  // namespace styled::pipeline
