#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "model/base/status.h"

namespace styled::net {

// SHA-256 (FIPS 180-4), 64 hexadecimal digits: names weights and judges in tables, as `sha256sum`
// does. Pinned by tests/unit/net/sha256_test.cpp.
std::string Sha256(std::span<const std::byte> bytes);
// Of a regular file. The error names it.
Result<std::string> Sha256OfFile(const std::filesystem::path& file);

}  // namespace styled::net
