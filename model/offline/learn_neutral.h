#pragma once

#include "model/clip/clip.h"
#include "model/neutral/neutral.h"
#include "model/rig/binding.h"

namespace styled::offline {

// The performer's neutral, learned from a whole clip, so that a stylist knows it from the first
// frame on (stylist::Stylist::Know). Known::body_s is 0 where nobody stands or walks in it.
// `binding` must be of the clip's skeleton. Any thread. Pinned by tests/e2e/tools_test.cpp.
neutral::Known LearnNeutral(const clip::Clip& clip, const rig::Binding& binding,
                            const neutral::Reference& reference);

}  // namespace styled::offline
