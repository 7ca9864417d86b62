#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// VRChat's OSC trackers ("vrchat"; bytes: proto/rigs/vrchat): what applications such as SlimeVR
// send to VRChat, and the head and wrists that VRChat sends.
//
// Transport   UDP, port 9000. Single messages or bundles; there is no clock. VRChat finds the
//             receivers of its head and wrists by OSCQuery, which styleoscquery speaks for the port
//             (clients/oscquery).
// Performer   One per port: `performer`, else the source's name.
// Devices     "1" .. "8", "head", "vrsystem/head", "vrsystem/leftwrist", "vrsystem/rightwrist".
//             Without `trackers` the numbers are worn as SlimeVR numbers them: 1 hips, 2 and 3 left
//             and right foot, 4 and 5 upper legs, 6 chest, 7 and 8 upper arms. Several senders may
//             share a port; each device belongs to one of them until it is silent for a second.
// Head        Its position is that of the head's joint. Its rotation is not a measurement: a sender
//             uses it, once per reset, to state the performer's heading.
// Body, pose  DeviceRig. Silent for 0.5 s: lost.
// Refused     source.malformed; source.ignored for all other addresses; pipeline.second_sender.
// Pinned by tests/unit/vrchat/translator_test.cpp.
std::unique_ptr<Translator> MakeVrChat(const config::Source& config);

}  // namespace styled::source
