#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/motion.h"

namespace styled::clip {

// An export format. To add one, add its writer's files and a row to the table in write.cpp.
struct Format {
  std::string_view extension;  // lower case, with its dot
  std::string_view summary;    // for an option's help
  // The format has one rate and no times per frame: it is written at Motion::rate_hz, and a motion
  // with times_s must be resampled first. stylerec then also leaves out the root joint's offset,
  // which such a format would add to the root's position.
  bool constant_rate;
  // Writes the whole file. Errors name the file.
  Status (*write)(const Motion& motion, const std::filesystem::path& file);
};

// Every format, in the order in which help lists them.
std::span<const Format> Formats();
// ".bvh, .glb", ...
std::string FormatNames();
// Finds the format by the file's extension, in upper or lower case. An unknown extension is an
// error that lists the known ones.
Result<const Format*> FindFormat(const std::filesystem::path& file);

// Writes `motion` in the format that the file's extension names; an existing file is replaced.
// Errors name the file: an unknown extension, a motion that the format refuses, a file that cannot
// be written. Blocks on the disk; allocates; any thread. Pinned by tests/unit/clip/write_test.cpp.
Status Write(const std::filesystem::path& file, const Motion& motion);

}  // namespace styled::clip
