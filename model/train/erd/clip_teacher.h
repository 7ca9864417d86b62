#pragma once

#include <torch/torch.h>

#include <array>
#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/net/clip_stylizer.h"
#include "model/train/dataset.h"
#include "model/train/sampler.h"

namespace styled::train::style_erd {

// The output of a network that sees whole clips (net::ClipStylizer) for every training clip:
// neutral clips in each style that it teaches, by the style's mean code, and clips of those styles
// in neutral. If it reconstructs a clip well, its own output is taught, not its change of style: a
// student that learns from the change inherits the teacher's errors of reconstruction. Otherwise,
// as with another rig, its change is taught, because its output would be another body. Immutable;
// any thread.
class ClipTeacher {
 public:
  // The change of a frame's pose: rotations [T, B, 21, 4], input⁻¹ ∘ taught, the hips' relative to
  // the heading, and the rise of the hips [T, B], m. The identity and 0 if nothing is taught.
  struct Changes {
    torch::Tensor rotations, rise_m;
  };
  // The source and target style of a slot's window, indices into Manifest::styles.
  struct Roles {
    std::vector<int> input, target;
  };

  // `taught`: per style of the manifest but neutral, its name if it is taught, else "". Takes some
  // 0.02 ms per frame and style, and 340 bytes. Errors: another rate than the clips'.
  static Result<ClipTeacher> Make(const net::ClipStylizer& network, const clip::Manifest& manifest,
                                  const std::vector<TrainingClip>& clips, double rate_hz,
                                  const std::vector<std::string>& taught);

  // The share of clips of which its change is taught, not its output.
  double share_by_change() const { return share_by_change_; }

  // For `frames` frames of each window, on the CPU: the teacher's change `lead` frames later, with
  // a clip's last frame held. An idle window has its first frame's.
  Changes Of(const std::vector<Sampler::Window>& windows, const Roles& roles, int frames,
             double lead = 0) const;

 private:
  // One frame's: 21 rotations x,y,z,w and the rise.
  static constexpr int kNumbers = 4 * body::kJointCount + 1;
  using Frames = std::vector<std::array<float, kNumbers>>;

  ClipTeacher() = default;
  static void Read(const Frames& clip, double at, body::Pose& change, float& rise_m);
  // The change of one clip, and how well the clip is reconstructed.
  struct OfClip {
    Frames by_output, by_change;
    double error_rad = 0;
  };
  static OfClip Changed(const net::ClipStylizer& network, const TrainingClip& clip, int input_style,
                        int style);

  // By style and clip; empty if it is not taught. Clips of a style are under that style.
  std::vector<std::vector<Frames>> changes_;
  double share_by_change_ = 0;
};

}  // namespace styled::train::style_erd
