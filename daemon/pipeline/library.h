#pragma once

#include <filesystem>
#include <string>

#include "daemon/pipeline/runtime_config.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

// The folder [style] library: a file NAME.json for each style that was made of an example, so that
// it survives a restart. A code means something to the weights that it was made with alone; their
// hash is in the file. Start-up, reload and after a Like; blocks; allocates; not the pipeline's
// thread. Pinned by tests/e2e/like_test.cpp.
namespace styled::pipeline {

// Keeps the style `like` of `config`, atomically. Errors name the file.
Status KeepStyle(const RuntimeConfig& config, const v1::LikeReply& like, const std::string& source);

// Makes the styles of `config` those of its folder: adds what is new there, in the order of names,
// and retires what came from there and is gone. What cannot be used is left out, with a line in
// config.complaints that names the file and what was expected.
void ReadLibrary(RuntimeConfig& config);

}  // namespace styled::pipeline
