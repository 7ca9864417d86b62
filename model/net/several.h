#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/stylizer.h"

// Several networks that work as one: a performer may show styles of any of them, mixed and faded
// as if they were of one network.
//
// Styles. The list has the first network's styles, then those of the others without their neutral,
// then styles of With, which belong to the first network that has a space. A name that is taken
// already gets the network's own in front: "graph-elderly"; net::StyleInfo says which network a
// style belongs to, and its name there.
//
// Step. A network works where one of its styles is in force, and for kStayAwake_s beyond that.
// While no style is, the first one works alone, as its reconstruction says whether the pose is
// known. Each network's change, from its reconstruction to its styled pose, counts as a rotation
// vector of each joint, and the sum is applied to the reconstruction of the network with the
// largest share. Weights fade, so that changes fade from one network to the other. A network that
// begins to work in the middle of a stream knows no past; its change grows over kWakeSteps. Where
// one network has all styles in force, the prediction is that network's alone, bit for bit.
//
// An input style, which is to be removed, is each network's own style of that name; neutral where
// it has none. Pinned by tests/unit/net/several_test.cpp.
namespace styled::net {

// How long a network goes on without a style, seconds: who switches back and forth meets a network
// that knows the past. It costs that network's step, 20 us a frame, meanwhile.
inline constexpr float kStayAwake_s = 10.0F;
// Steps until a network that was just started shows all of its change: as long as the learned
// starts of the families are off (8 frames: three times the later distance to the teacher).
inline constexpr int kWakeSteps = 8;

struct NamedNetwork {
  std::string name;  // of its file, without ".safetensors"
  std::shared_ptr<const Stylizer> network;
};

// One network is returned as it is. Errors name the networks: other rates, two of one name, more
// than kMaxNetworks. Not empty. Allocates.
inline constexpr std::size_t kMaxNetworks = 4;
Result<std::shared_ptr<const Stylizer>> Combine(std::vector<NamedNetwork> networks);

}  // namespace styled::net
