#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/decide/frame_in_transit.h"
#include "model/base/realtime.h"
#include "model/net/styles.h"
#include "model/rig/skeleton.h"
#include "proto/styled/face.h"
#include "proto/styled/props.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::publish {

// One topic's `Frame` of one performer, made once and refilled for each pose. Only construction
// allocates. Pipeline thread only.
class FrameMessage {
 public:
  // `body` must have its hash; `rig_joints`: the most joints that can be held. `styles` are the
  // network's, by index, and must outlive the message, or be replaced by UseStyles.
  FrameMessage(const std::string& performer, std::uint64_t epoch, const v1::Body& body,
               int rig_joints, const net::Styles& styles);

  // Replaces the styles: the former ones, and added ones with names of at most net::kMaxStyleName
  // bytes.
  void UseStyles(const net::Styles& styles) noexcept { styles_ = &styles; }

  // What is the same on all topics of a pose, and the topic's flags.
  STYLED_REALTIME void SetHeader(const decide::FrameInTransit& frame, std::uint32_t flags) noexcept;
  STYLED_REALTIME void SetStyles(std::span<const net::StyleWeight> in_force) noexcept;
  STYLED_REALTIME void AddHeld(int joint) noexcept;
  STYLED_REALTIME void SetPose(const rig::Vec3& root_position,
                               std::span<const rig::Quat> rotations) noexcept;
  // Serializes the frame, followed by `face`: fields 18 and 19 as received (source::SourceFrame),
  // at most kMaxFace bytes; and `props`: field 20, at most kMaxPropBytes. Valid until the next
  // call.
  STYLED_REALTIME std::span<const std::byte> Serialize(std::span<const std::byte> face,
                                                       std::span<const std::byte> props) noexcept;

 private:
  v1::Frame frame_;
  std::unique_ptr<v1::Timecode> spare_timecode_;  // set while the rig sends one
  const net::Styles* styles_;
  std::vector<std::byte> buffer_;
};

}  // namespace styled::publish
