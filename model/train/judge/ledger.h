#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "model/base/status.h"

namespace styled::judge {

// A use of a test split. The figures of a split that is used again and again choose weights, and
// then say too much: so each use is a line of a file (tab-separated, TESTED.tsv).
struct TestUse {
  std::string manifest;  // its name
  std::string weights;   // SHA-256 of each file, joined by "+"
  std::string files;     // their names
  std::string judges;    // SHA-256
  std::string commit;    // of the programs
  std::string day;       // 2026-11-28
};

// Today's use, of what Provenance() gives.
TestUse UseOf(const nlohmann::json& provenance, const std::string& commit);
// The judges' figures in styleeval's JSON for the main set of clips, in brackets those of the
// constant offset and of real clips.
std::string LedgerFigures(const nlohmann::json& report);

// The first line of such a file.
inline constexpr const char* kLedgerHead =
    "manifest\tweights_sha256\tfiles\tjudges_sha256\tcommit\tday\tfigures";

// Adds a use without figures, before anything of the split is judged; makes the file if it is
// missing. Refuses weights that have a line of this manifest already, unless `again`.
Status BeginTest(const TestUse& use, bool again, const std::filesystem::path& ledger);
// Writes the figures into the last line of this use.
Status EndTest(const TestUse& use, const std::string& figures, const std::filesystem::path& ledger);

}  // namespace styled::judge
