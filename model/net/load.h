#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/net/clip_stylizer.h"
#include "model/net/kernels/kernel.h"
#include "model/net/stylizer.h"

namespace styled::net {

// Loads the network of a weights file of any family (FORMAT.md). An error names the file, the key
// or tensor, what was expected and what was found. For an unknown family, and for a family whose
// network needs whole clips, it lists the known ones. Allocates: start-up and reload only. Pinned
// by tests/unit/net/load_test.cpp.
//
// `precision`: to which a network of a family that CanBeRounded rounds its weights; the others have
// float32 always.
Result<std::shared_ptr<const Stylizer>> Load(const std::filesystem::path& file,
                                             Precision precision = Precision::kFloat32);
Result<std::shared_ptr<const Stylizer>> Parse(std::span<const std::byte> bytes,
                                              const std::string& name,
                                              Precision precision = Precision::kFloat32);

// The precisions by the names that configurations and options give them.
inline constexpr std::array<std::string_view, 2> kPrecisions{"float32", "int8"};
Precision PrecisionNamed(std::string_view name);  // one of kPrecisions

// Whether the file's family is one whose weights can be rounded; false if it is not a weights file.
bool CanBeRounded(std::span<const std::byte> bytes);
// Whether the file's family knows a space of styles, from which examples and variations come; false
// if it is not a weights file.
bool KnowsStyleSpace(std::span<const std::byte> bytes);

// A network of either kind; exactly one is set.
struct AnyStylizer {
  std::shared_ptr<const Stylizer> frames;     // styles frame by frame
  std::shared_ptr<const ClipStylizer> clips;  // needs whole clips

  const Model& model() const { return clips ? clips->model() : frames->model(); }
};

// The same for programs that run both kinds.
Result<AnyStylizer> LoadAny(const std::filesystem::path& file,
                            Precision precision = Precision::kFloat32);
Result<AnyStylizer> ParseAny(std::span<const std::byte> bytes, const std::string& name,
                             Precision precision = Precision::kFloat32);

// The families whose networks need whole clips, or know a space of styles, for messages:
// "\"a\" or \"b\"".
std::string ClipFamilyNames();
std::string SpaceFamilyNames();

}  // namespace styled::net
