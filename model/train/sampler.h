#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "model/train/dataset.h"

namespace styled::train {

// Chooses the windows of a batch. A batch has `2 * per_style` slots for each style besides neutral,
// in order of style: first `per_style` neutral windows that are transferred to the style, then
// `per_style` windows of the style that are transferred to neutral. A slot keeps its role, so that
// recurrent states can be carried from one iteration to the next. Contents are drawn evenly, then
// the folders that have the content, then its windows; a neutral window mostly has a content in
// which its target style was recorded. Deterministic; Save and Restore are exact.
class Sampler {
 public:
  struct Options {
    int styles = 0, contents = 0;
    int per_style = 3;
    int length = 25;  // frames per window
    double carry = 0.5, session_start = 0.25;
    // Share of neutral windows of any content. More: the critic compares fewer windows; 0: contents
    // in which the target was not recorded are never transferred.
    double unpaired = 0.1;
    double miscalibrated = 0.0;  // share of windows with the input of a badly calibrated rig
    double idle = 0.0;           // share of neutral windows that are idle
    // Above 0: a batch is so many pairs of a styled window, drawn evenly from all, and a neutral
    // one of its content, each the other's target; per_style and the shares above do not apply.
    int pairs = 0;
    uint64_t seed = 1;
  };
  struct Window {
    int style = 0, target = 0;  // one of the two is neutral, 0
    int clip = -1;
    int start = 0;
    bool mirrored = false;
    bool session_start = false;
    bool carried = false;  // its states continue those at the end of the slot's last window
    int content = 0;
    bool paired = true;  // its target style was recorded in this content, so a critic can compare
    bool idle = false;   // its first frame, held: no data set has long idle postures
    uint64_t miscalibration = 0;  // seed of DrawMiscalibration, 0: well calibrated
  };

  // `clips` must outlive the sampler.
  Sampler(const std::vector<TrainingClip>& clips, const Options& options);

  const Options& options() const { return options_; }
  int slots() const { return static_cast<int>(last_.size()); }
  // Without pairs, a slot's windows are always of these.
  int InputStyle(int slot) const;
  int TargetStyle(int slot) const;

  // The next batch, one window per slot. A carried window continues the last one if the clip is
  // long enough; otherwise it is a random one with carried states.
  const std::vector<Window>& Next();

  // Whether any neutral clip has a frame that idle windows can be made of: both feet and the hands
  // down.
  bool HasIdleFrames() const { return !idle_.empty(); }

  // A window of `style`, of any content that it has, outside the batches.
  Window Draw(int style);

  std::string Save() const;
  void Restore(const std::string& text);

 private:
  struct Cell {
    int content = 0;
    // By source, those that have any: clip and first frame of every window.
    std::vector<std::vector<std::pair<int, int>>> places;
  };

  double Uniform();
  int64_t Below(int64_t bound);
  bool IsNeutralSlot(int slot) const;
  bool NextIdle(int slot);
  Window DrawIdle();
  bool Continues(const Window& before) const;
  Window NextFor(int slot, bool carried);
  bool Has(int style, int content) const;
  Window DrawFrom(const Cell& cell);
  void FindPlaces();
  void FindPairs();
  void NextPairs();
  void FindIdleFrames();

  const std::vector<TrainingClip>& clips_;
  Options options_;
  std::mt19937_64 random_;
  std::vector<std::vector<Cell>> cells_;  // per style, the contents that it has
  std::vector<std::vector<int>> paired_;  // per target style, indices into cells_[0]
  // With pairs: the styled windows that have a neutral one of their content; the neutral windows of
  // each content.
  std::vector<Window> styled_;
  std::vector<std::vector<Window>> neutral_;
  std::vector<std::pair<int, int>> idle_;  // neutral clips, and frames with feet and hands down
  std::vector<Window> last_;
};

}  // namespace styled::train
