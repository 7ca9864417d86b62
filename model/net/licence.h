#pragma once

#include <filesystem>
#include <string>
#include <string_view>

// The terms under which weights and styles may be used. Texts for people: the licence itself
// counts.
namespace styled::net {

// Whether a licence allows commercial use. kUnknown: read it.
enum class Commercial { kUnknown, kNo, kYes };

// Knows the usual licences by their SPDX identifiers and common names ("CC-BY-NC-4.0", "CC BY 4.0",
// "MIT"); several are separated by ";". Only the first may be followed by other text after a ";".
Commercial CommercialUse(std::string_view licence);

// The licence of weights that come from two things with a licence each: both, so ordered that
// CommercialUse is that of the stricter one. What is in `one` already, or "", adds nothing.
std::string BothLicences(const std::string& one, const std::string& other);

// The terms of one file of weights.
struct Terms {
  std::string file;     // its name, "v2.safetensors"
  std::string licence;  // "CC-BY-NC-4.0"; "": none is given
  std::string credit;   // the names to credit, separated by "; "; "": none is given
};

// A sentence for logs: "v2.safetensors: licence CC-BY-NC-4.0, not for commercial use".
std::string TermsText(const Terms& terms);

// Of FILE.license beside the file, in the form of the REUSE specification 3 (lines
// "SPDX-License-Identifier: …" and "SPDX-FileCopyrightText: …"), at most kMaxTerms_bytes of it.
// Without such a file, or without a licence in it: `licence`, which is the weights' own key.
// Start-up only. Pinned by tests/unit/net/licence_test.cpp.
inline constexpr std::size_t kMaxTerms_bytes = 16384;
Terms ReadTerms(const std::filesystem::path& file, const std::string& licence);

}  // namespace styled::net
