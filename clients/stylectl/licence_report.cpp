#include "clients/stylectl/licence_report.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "clients/stylectl/report.h"

namespace styled::stylectl {
namespace {

using nlohmann::json;

constexpr const char* kOfExample = "that of its example";

std::string StylesWith(const v1::ListReply& list, v1::CommercialUse use) {
  std::string names;
  for (const auto& style : list.styles()) {
    if (style.neutral() || style.commercial_use() != use) continue;
    names += (names.empty() ? "" : ", ") + style.name();
  }
  return names;
}

// Styles that share licence and credit, in the order of the list.
std::vector<std::pair<const v1::StyleInfo*, std::string>> StylesByCredit(
    const v1::ListReply& list) {
  std::vector<std::pair<const v1::StyleInfo*, std::string>> groups;
  for (const auto& style : list.styles()) {
    if (style.neutral()) continue;
    bool found = false;
    for (auto& [first, names] : groups) {
      found = first->licence() == style.licence() && first->credit() == style.credit();
      if (!found) continue;
      names += ", " + style.name();
      break;
    }
    if (!found) groups.emplace_back(&style, style.name());
  }
  return groups;
}

}  // namespace

std::string CommercialText(v1::CommercialUse use) {
  if (use == v1::COMMERCIAL_USE_UNSPECIFIED) return "-";
  return use == v1::COMMERCIAL_USE_YES ? "yes" : "no";
}

json CommercialJson(v1::CommercialUse use) {
  return use == v1::COMMERCIAL_USE_UNSPECIFIED ? json() : json(use == v1::COMMERCIAL_USE_YES);
}

std::string LicencesText(const v1::ListReply& list) {
  std::string out;
  constexpr std::array kUses{
      std::pair{v1::COMMERCIAL_USE_YES, "for commercial use, with the credits below: "},
      std::pair{v1::COMMERCIAL_USE_NO, "not for commercial use: "},
      std::pair{v1::COMMERCIAL_USE_UNSPECIFIED, "not known, read the licence: "}};
  for (const auto& [use, title] : kUses) {
    if (const std::string names = StylesWith(list, use); !names.empty()) {
      out += title + names + "\n";
    }
  }
  std::vector<std::vector<std::string>> rows{{"WEIGHTS", "LICENCE", "COMMERCIAL"}};
  for (const auto& terms : list.terms()) {
    rows.push_back({terms.file(), terms.licence().empty() ? "none is given" : terms.licence(),
                    CommercialText(terms.commercial_use())});
  }
  out += "\n" + Table(rows) + "\ncredits:\n";
  for (const auto& terms : list.terms()) {
    if (!terms.credit().empty()) out += "  " + terms.file() + ": " + terms.credit() + "\n";
  }
  for (const auto& [style, names] : StylesByCredit(list)) {
    bool of_file = false;
    for (const auto& terms : list.terms()) {
      of_file =
          of_file || (terms.credit() == style->credit() && terms.licence() == style->licence());
    }
    if (of_file) continue;
    out += "  " + names + ": " + (style->credit().empty() ? "" : style->credit() + "; ") +
           "licence " + (style->licence().empty() ? kOfExample : style->licence()) + "\n";
  }
  return out + "The programs are Apache-2.0. A licence's own text counts.\n";
}

json LicencesJson(const v1::ListReply& list) {
  json styles = json::array(), weights = json::array();
  for (const auto& style : list.styles()) {
    styles.push_back({{"name", style.name()},
                      {"licence", style.licence()},
                      {"credit", style.credit()},
                      {"commercial", CommercialJson(style.commercial_use())}});
  }
  for (const auto& terms : list.terms()) {
    weights.push_back({{"file", terms.file()},
                       {"licence", terms.licence()},
                       {"credit", terms.credit()},
                       {"commercial", CommercialJson(terms.commercial_use())}});
  }
  return {{"styles", styles}, {"weights", weights}};
}

}  // namespace styled::stylectl
