#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/parity/schedule.h"

namespace styled::parity {

// Streams the first `frames` frames of a clip, on its own skeleton and in its own source time, into
// the real `styled` over TCP. The mixes of `schedule` are set through the control socket when all
// frames before their first one have been published. Returns the canonical frames published.
// Low-pass, fade, feet and the domain check are off, so the frames are the network's output. Fails
// the test if a command is refused, or if its reply names another sequence than its first frame's.
std::vector<v1::Frame> StreamThroughDaemon(const clip::Clip& clip, int frames,
                                           const std::vector<Segment>& schedule,
                                           const std::filesystem::path& weights, bool absolute);

// The source time of a frame.
std::uint64_t TimeOf_ns(const clip::Clip& clip, int frame);

}  // namespace styled::parity
