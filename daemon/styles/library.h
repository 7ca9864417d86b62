#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"
#include "model/body/pose.h"

// The folder [style] library. It has a file NAME.json (style_file.h) for each style that was made,
// so that the style survives a restart, and NAME.bvh, its example as the canonical humanoid in
// metres, so that the style can be refined later. A style made from a code or a variation has no
// example. Each file is replaced atomically; NAME.bvh belongs to NAME.json if the latter has its
// hash. Blocks; allocates; not the pipeline's thread. Errors name the file and the system's reason.
// Without a library the functions do nothing. Pinned by tests/e2e/style_library_test.cpp.
namespace styled::pipeline {

// An example of a minute takes about 0.6 s (like.h), a thousand of them ten minutes; systemd waits
// 90 s for a daemon to start.
inline constexpr std::chrono::seconds kLongestAgain(20);

// Synchronizes the styles of `config` with the folder: adds new and changed ones in the order of
// names, and retires those whose file is gone. A file that cannot be used is left out, with a line
// in config.complaints that names it and what was expected. A style of other weights is made again
// from its example, with such a line; its files stay as they are, for those weights. Start-up and
// reload.
// `longest` is for all that are made again: those beyond it are left out with a line, and the next
// call makes the others.
void ReadLibrary(RuntimeConfig& config, std::chrono::milliseconds longest = kLongestAgain);

// An example as the text of its NAME.bvh: poses at `rate_hz`, of the canonical humanoid in metres;
// "" without poses. At most `most_bytes`, of which 64 KiB are always enough: only every second,
// third, ... pose is kept until the text fits, at 1 Hz or more. Without this limit a small file, a
// minute with few keys, would be kept as two megabytes.
std::string ExampleText(const std::vector<body::Pose>& poses, double rate_hz,
                        std::size_t most_bytes);

// Stores the style `name` of config.made. `example`: the text of its NAME.bvh; "": an existing file
// stays if it belongs to the style.
Status KeepStyle(const std::string& name, const std::string& example, RuntimeConfig& config);
// Renames the stored style `name` to `to`, a style of config.made. After an error the folder is as
// it was.
Status KeepRenamed(const std::string& name, const std::string& to, RuntimeConfig& config);
// Removes the files of a style.
Status KeepRemoved(const std::string& name, RuntimeConfig& config);

}  // namespace styled::pipeline
