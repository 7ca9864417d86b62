#pragma once

#include <torch/torch.h>

#include <exception>
#include <filesystem>
#include <map>
#include <string>

#include "model/base/status.h"
#include "model/train/adam.h"

namespace styled::train {

// The state of a run as a file stores it: tensors and strings by name. The trainer's own names are
// the tensors "best" and "elapsed_s" and the string "family"; all others are the recipe's. Files
// contain tensors of the CPU. Pinned by tests/unit/train/run_test.cpp.
struct Checkpoint {
  std::map<std::string, torch::Tensor> tensors;
  std::map<std::string, std::string> strings;
};

// The network family of a checkpoint. One without the string "family" is older than the choice of
// families, and belongs to "style-erd".
std::string FamilyOf(const Checkpoint& checkpoint);

// The message of an exception in one line: those of libtorch hold a whole stack.
std::string Reason(const std::exception& error);

// A file is written under the name PartialFile(file), then ReplaceByPartial renames it, so that
// neither a reader nor a crash finds an incomplete one. Errors name the file.
std::filesystem::path PartialFile(std::filesystem::path file);
Status ReplaceByPartial(const std::filesystem::path& file);

// Replaces `file` atomically; errors name it. ReadCheckpoint adds to `checkpoint`, which is
// incomplete after an error.
Status WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file);
Status ReadCheckpoint(const std::filesystem::path& file, Checkpoint& checkpoint);

// The state of an optimizer, saved under `name`. RestoreAdam throws if the checkpoint has no state
// of this name, or one for another number of parameters.
void SaveAdam(const std::string& name, const Adam& adam, Checkpoint& checkpoint);
void RestoreAdam(const std::string& name, const Checkpoint& checkpoint, Adam& adam);

}  // namespace styled::train
