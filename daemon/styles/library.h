#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"
#include "model/body/pose.h"

// The folder [style] library: a file NAME.json (style_file.h) for each style that was made, so that
// it survives a restart, and NAME.bvh, its example as the canonical humanoid in metres, so that it
// can be refined later. A style of a code or of a variation has no example. Each file is replaced
// atomically; NAME.bvh belongs to NAME.json if the latter has its hash. Blocks; allocates; not the
// pipeline's thread. Errors name the file and the system's reason. Without a library nothing is
// done. Pinned by tests/e2e/style_library_test.cpp.
namespace styled::pipeline {

// Makes the styles of `config` those of its folder: adds what is new or another there, in the order
// of names, and retires what came from there and is gone. What cannot be used is left out, with a
// line in config.complaints that names the file and what was expected. Start-up and reload.
void ReadLibrary(RuntimeConfig& config);

// An example as the text of its NAME.bvh: poses at `rate_hz`, of the canonical humanoid in metres;
// "" without poses. At most `most_bytes`, of which 64 KiB are always enough: every second, third
// ... pose is kept until it fits, at 1 Hz or more. A minute of few keys, a small file, would
// otherwise be kept as two megabytes.
std::string ExampleText(const std::vector<body::Pose>& poses, double rate_hz,
                        std::size_t most_bytes);

// Keeps the style `name` of config.made. `example`: the text of its NAME.bvh; "": one that is there
// stays if it is the style's.
Status KeepStyle(const std::string& name, const std::string& example, RuntimeConfig& config);
// Keeps the style `to` of config.made, which was called `name`. After an error the folder is as it
// was.
Status KeepRenamed(const std::string& name, const std::string& to, RuntimeConfig& config);
// Removes the files of a style.
Status KeepRemoved(const std::string& name, RuntimeConfig& config);

}  // namespace styled::pipeline
