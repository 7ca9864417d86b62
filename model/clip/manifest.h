#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"

namespace styled::clip {

// One clip of a dataset, with its labels.
struct ManifestEntry {
  std::filesystem::path file;
  std::string style;    // one of Manifest::styles
  std::string content;  // one of Manifest::contents
  std::string rig;      // a dialect of rig::BindDialect, "auto" by default, or "standing"
  std::string split;    // "train", "judge", "validation" or "test"
  int take = 0;
  double from = 0, to = 1;     // the part of the clip to use, as shares of its duration
  double repeat_s = 0;         // a loop: repeated, its path continued, for at least this long
  double skip_s = 0;           // skips the beginning: a T-pose, or a walk to the starting place
  bool floor_at_feet = false;  // the floor is under the lowest foot, whatever the file states
  bool still = true;           // [still] holds for this clip
  std::string person;          // a person other than the set's performers; empty: one of these
};

// A dataset, described by a TOML manifest:
//   name = "bandai-2"
//   licence = "CC BY-NC 4.0"
//   neutral = "neutral"                                   # the style that means "no style"
//   styles = [ { name = "neutral", labels = ["normal"], aliases = [] }, ... ]  # neutral first
//   contents = [ { name = "turn", labels = ["walk-turn-left", "walk-turn-right"] }, ... ]
//   [[clips]]
//   pattern = "bandai-2-train/dataset-2_{content}_{style}_{take}.bvh"   # or fixed style=/content=
//   rig = "bandai-namco" # or "standing": the first frame that stands upright gives the rest pose
//   split = "train"
//   judge_share = 0.2    # of each (style, content) cell, the last takes go to "judge"
//   time = [0.0, 0.75]   # only this part of each clip: one clip may serve several splits in turn
//   skip_s = 0.5         # left out at the beginning of each file; `time` is of the rest
//   floor = "feet"       # the file has no floor, or not at 0: it is under the lowest foot
//   still = false        # [still] below does not hold for these
//   person = "accad-female1" # another person: shown to a network like its own performers,
//                        # using the carriage from all of this person's clips;
//                        # {take} in it: another person for each take
//   repeat_s = 8.0       # loops (the last frame shows the first again), repeated so long
//   except = ["*/dataset-2_run_*"]   # files that the pattern does not mean
//   [still]              # stretches in which nothing moves faster are another content
//   content = "stand"
//   speed_mps = 0.15
// Paths are relative to the data folder given at load time. {content} and {style} match any of
// their labels, the longest first; {take} digits; * anything but "/". Files without a label are
// left out. validation_share, beside judge_share: the takes that go to "validation", the very last;
// with split "validation", test_share: the takes that go to "test", which no training or choice may
// see. Shares are rounded per cell, and one clip of it stays. Errors: an unknown key, patterns that
// select overlapping parts of a file. Pinned by tests/unit/clip/manifest_test.cpp.
struct ManifestStyle {
  std::string name;
  std::vector<std::string> labels, aliases;
  std::string licence, credit;  // of its clips, if others than the set's; optional keys
};
struct Manifest {
  std::string name, licence;
  std::vector<ManifestStyle> styles;
  std::vector<std::string> contents;
  // By content: how many labels belong to it, as left and right do. Clips of one label are one act.
  std::vector<std::size_t> content_labels;
  std::vector<ManifestEntry> entries;  // sorted by path, then by `from`
  std::string still_content;           // one of contents; empty: standing has no label of its own
  double still_speed_mps = 0;
};

// Loads a manifest and finds its files. Errors, a line each, name file, line, key, what was found
// and what was expected: the first error of each part and of each [[clips]]. A pattern without
// files is an error, too. Blocks; allocates; any thread.
Result<Manifest> LoadManifest(const std::filesystem::path& file,
                              const std::filesystem::path& data_folder);

}  // namespace styled::clip
