#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"
#include "model/net/stylizer.h"

namespace styled::net {

// Loads the network of a weights file of any family (FORMAT.md). An error names the file, the key
// or tensor, what was expected and what was found; for an unknown family it lists the known ones.
// Allocates: start-up and reload only. Pinned by tests/unit/net/load_test.cpp.
Result<std::shared_ptr<const Stylizer>> Load(const std::filesystem::path& file);
Result<std::shared_ptr<const Stylizer>> Parse(std::span<const std::byte> bytes,
                                              const std::string& name);

}  // namespace styled::net
