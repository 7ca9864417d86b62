#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/parity/schedule.h"

namespace styled::parity {

// Streams the first `frames` frames of a clip, on its own skeleton and in its own source time, into
// the real `styled` over TCP; the mixes of `schedule` are set through the control socket when all
// frames before their first one have been published. Returns the canonical frames published. No
// low-pass, no fade, no feet, no pose out of domain: what comes out is the network's. A test
// failure where a command is refused or names another sequence than that of its first frame.
std::vector<v1::Frame> StreamThroughDaemon(const clip::Clip& clip, int frames,
                                           const std::vector<Segment>& schedule,
                                           const std::filesystem::path& weights, bool absolute);

// The source time of a frame.
std::uint64_t TimeOf_ns(const clip::Clip& clip, int frame);

}  // namespace styled::parity
