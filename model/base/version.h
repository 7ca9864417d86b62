#pragma once

#include <string>
#include <string_view>

namespace styled {

// The first line of --version: "stylesim 0.2.0, commit 0123456789ab, changed". The commit is that
// of the tree that was built; ", changed": with changes to it. A tree without git has no commit to
// name. Any thread. Pinned by tests/unit/base/test_version.py.
std::string VersionText(std::string_view program);

}  // namespace styled
