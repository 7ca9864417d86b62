#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/stylizer.h"

// Several networks combined into one: a performer may show styles of any of them, mixed and faded
// as if they belonged to one network.
//
// Styles. The list has the first network's styles, then those of the others without their neutral,
// then styles added by With. A name that is already in use gets its network's name as a prefix:
// "graph-elderly". net::StyleInfo has the style's network, and its name there.
//
// Styles of examples. If one network follows gaits (its reference has some), a style that an
// example with a gait makes belongs to it while the performer is in a gait, and otherwise to the
// first other network that takes examples; both are faded by the confidence of the gait
// (several_space.h).
//
// Step. A network runs while one of its styles is active, and for kStayAwake_s after that. While no
// style is active, only the first one runs, because its reconstruction shows whether the pose is
// known. Each network's change, from its reconstruction to its styled pose, counts as a rotation
// vector of each joint, and the sum is applied to the reconstruction of the network with the
// largest share. Weights fade, so that changes fade from one network to the other. A network that
// starts in the middle of a stream knows no past; its change grows over kWakeSteps. If one network
// has all active styles, the prediction is exactly that network's, bit for bit.
//
// An input style, which is to be removed, is each network's own style of that name, or neutral if
// it has none. A content is each network's own of that name; a network that lacks it gets none.
// Pinned by tests/unit/net/several_test.cpp.
namespace styled::net {

// How long a network continues without a style, seconds, so that switching back and forth finds a
// network that knows the past. Meanwhile it costs that network's step, 20 us a frame.
inline constexpr float kStayAwake_s = 10.0F;
// Steps until a network that was just started shows all of its change: the time during which the
// families' learned starts are inaccurate (8 frames: three times the later distance to the
// teacher).
inline constexpr int kWakeSteps = 8;

// The confidence of a gait between which a style of two networks fades from the one to the other. A
// performer who surely walks does not keep the other network awake.
inline constexpr float kGaitBegins = 0.1F, kGaitIsSure = 0.9F;

struct NamedNetwork {
  std::string name;  // of its file, without ".safetensors"
  std::shared_ptr<const Stylizer> network;
};

// A single network is returned as it is. Errors name the networks: different rates, two of one
// name, more than kMaxNetworks. Must not be empty. Allocates.
inline constexpr std::size_t kMaxNetworks = 4;
Result<std::shared_ptr<const Stylizer>> Combine(std::vector<NamedNetwork> networks);

}  // namespace styled::net
