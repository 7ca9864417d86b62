#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/motion.h"

namespace styled::clip {

// An export format. A new one is a row of the table in write.cpp and the files of its writer.
struct Format {
  std::string_view extension;  // lower case, with its dot
  std::string_view summary;    // for an option's help
  // The file has one rate and no times of its own: it is written at Motion::rate_hz, and a motion
  // that has times_s must be resampled first.
  bool constant_rate;
  // Writes the whole file. Errors name it.
  Status (*write)(const Motion& motion, const std::filesystem::path& file);
};

// Every format, in the order in which help lists them.
std::span<const Format> Formats();
// ".bvh, .glb", ...
std::string FormatNames();
// By the file's extension, upper or lower case. An unknown extension is an error that lists the
// known ones.
Result<const Format*> FindFormat(const std::filesystem::path& file);

// Writes `motion` in the format that the file's extension names; an existing file is replaced.
// Errors name the file: an unknown extension, a motion that the format refuses, a file that cannot
// be written. Blocks on the disk; allocates; any thread. Pinned by tests/unit/clip/write_test.cpp.
Status Write(const std::filesystem::path& file, const Motion& motion);

}  // namespace styled::clip
