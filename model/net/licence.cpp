#include "model/net/licence.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

namespace styled::net {
namespace {

// Lower case, with "-" for every space, so that "CC BY 4.0" is "cc-by-4.0".
std::string Simplified(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  std::string simple(text);
  std::ranges::transform(simple, simple.begin(), [](unsigned char c) {
    return c == ' ' ? '-' : static_cast<char>(std::tolower(c));
  });
  return simple;
}

constexpr std::array<std::string_view, 5> kForbidding{"-nc-", "noncommercial", "non-commercial",
                                                      "not-for-commercial", "research-only"};
// The beginnings of licences that allow it. "that-of-this-program" is how the shipped weights mark
// the styles that were made by hand.
constexpr std::array<std::string_view, 16> kAllowing{"cc-by-4",
                                                     "cc-by-3",
                                                     "cc-by-sa-",
                                                     "cc0",
                                                     "apache-2",
                                                     "apache-license",
                                                     "mit",
                                                     "expat",
                                                     "bsd-",
                                                     "isc",
                                                     "unlicense",
                                                     "odc-by",
                                                     "cdla-permissive",
                                                     "public-domain",
                                                     "free-for-all-uses",
                                                     "that-of-this-program"};

bool IsOneLine(std::string_view text) {
  return std::ranges::none_of(text, [](unsigned char c) { return c < ' ' || c == 0x7F; });
}

}  // namespace

Commercial CommercialUse(std::string_view licence) {
  const std::string simple = Simplified(licence) + "-";
  const auto within = [&simple](std::string_view word) {
    return simple.find(word) != std::string::npos;
  };
  if (std::ranges::any_of(kForbidding, within)) return Commercial::kNo;
  const auto begins = [&simple](std::string_view word) { return simple.starts_with(word); };
  return std::ranges::any_of(kAllowing, begins) ? Commercial::kYes : Commercial::kUnknown;
}

std::string BothLicences(const std::string& one, const std::string& other) {
  if (other.empty() || ("; " + one + "; ").find("; " + other + "; ") != std::string::npos)
    return one;
  if (one.empty()) return other;
  // The first decides unless a later one forbids it.
  return CommercialUse(one) == Commercial::kYes ? other + "; " + one : one + "; " + other;
}

std::string TermsText(const Terms& terms) {
  if (terms.licence.empty()) return terms.file + ": gives no licence";
  std::string text = terms.file + ": licence " + terms.licence;
  switch (CommercialUse(terms.licence)) {
    case Commercial::kYes:
      return text + ", for commercial use too" + (terms.credit.empty() ? "" : " if credited");
    case Commercial::kNo:
      return text + ", not for commercial use";
    case Commercial::kUnknown:
      break;
  }
  return text;
}

Terms ReadTerms(const std::filesystem::path& file, const std::string& licence) {
  Terms terms{file.filename().string(), licence, ""};
  const std::string beside = file.string() + ".license";
  std::error_code error;
  if (!std::filesystem::is_regular_file(beside, error)) return terms;  // a pipe would be waited for
  std::ifstream in(beside);
  std::string text(kMaxTerms_bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    for (const auto& [key, value] : {std::pair{"SPDX-License-Identifier: ", &terms.licence},
                                     {"SPDX-FileCopyrightText: ", &terms.credit}}) {
      if (!line.starts_with(key) || !IsOneLine(line)) continue;
      const std::string_view found = line.substr(std::string_view(key).size());
      if (value == &terms.credit && !value->empty()) {
        *value += "; ";
        value->append(found);
      } else {
        *value = found;
      }
    }
  }
  return terms;
}

}  // namespace styled::net
