#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "model/net/clip_stylizer.h"
#include "model/rig/binding.h"
#include "model/stylist/settings.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {

// A recorded clip as a ClipStylist reads it: frame i at i / rate_hz, each as Stylist::Process takes
// it. `frame` is called twice for each index, in rising order.
struct ClipFrames {
  std::size_t count = 0;
  double rate_hz = 30;
  std::function<const rig::RigPose&(std::size_t)> frame;
};

// How a clip is styled; the styles in Settings are not used.
struct ClipStyle {
  net::StyleCode code;  // of the network
  // The weight that later stages see, 0 .. net::kMaxStrength: feet are held in full from 0.25 on,
  // and 0 is bypass.
  float weight = 1;
  int input_style = 0;  // of the network: the style that the performer moves in; 0: neutral
  bool absolute = false;
  body::Parts parts = body::kAllParts;
  net::Extent extent = net::Extent::kByLength;
};

// Styles a clip with a network that needs the frames after the one that it styles, by the very code
// that styles a live stream. Two Stylists process the same frames. The first is ahead and only
// records the poses with which each of its recurrent states is stepped. The network turns these
// streams of poses into predictions, and the second Stylist's states return them, step for step.
// Source time alone decides which poses are due, so both do the same steps. Binding, interleaving,
// filters, out-of-domain weight, feet and guards are therefore the Stylist's own, and a clip of 120
// Hz is styled by four interleaved streams of 30 Hz as it would be live. The first is ahead by as
// much as the network needs: memory is bounded unless the extent is kWhole. Allocates; one thread
// at a time. Pinned by tests/unit/stylist/clip_stylist_test.cpp.
class ClipStylist {
 public:
  ClipStylist(std::shared_ptr<const net::ClipStylizer> network, ClipStyle style,
              const std::shared_ptr<const rig::Binding>& binding, const Options& options,
              ClipFrames frames);
  ~ClipStylist();

  // Before the first frame: the performer's neutral (Stylist::Know).
  void Know(const neutral::Known& known);
  // Styles the next frame; call it frames.count times.
  void Next(Output& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylist
