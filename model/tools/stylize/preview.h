#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"

namespace styled::stylize {

// The content of a preview: the same motion before and after, as the humanoid.
struct Shown {
  std::vector<body::Pose> input, output;  // not empty; of other lengths only with --cadence
  double rate_hz = 30;
  std::string style;  // the label
};

// Whether this kind of preview (by extension, .png or .mp4) can be made here: .mp4 needs the
// program ffmpeg in PATH.
Status CanPreview(const std::string& file);

// Writes a picture, .png: the input on top and the output below it at the same shares of their
// lengths, from the right and from the front; or a video, .mp4: both side by side, at most 30 Hz,
// made by ffmpeg. Errors name the file. Blocks.
Status WritePreview(const Shown& shown, const std::string& file);

}  // namespace styled::stylize
