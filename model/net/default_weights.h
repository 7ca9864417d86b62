#pragma once

#include <string>

namespace styled::net {

// For --version: the name, SHA-256 (its first 12 digits, as `sha256sum` prints them) and place of
// the weights that a program loads by default, or why there are none. Reads the file.
// Pinned by tests/unit/base/test_version.py.
std::string DescribeDefaultWeights();

}  // namespace styled::net
