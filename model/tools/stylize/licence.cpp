#include "model/tools/stylize/licence.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "model/net/licence.h"
#include "model/net/shipped_weights.h"

namespace styled::stylize {

std::string LicenceText(const std::filesystem::path& file, const net::Model& model) {
  const net::Terms terms = net::ReadTerms(file, model.licence);
  std::string text = net::TermsText(terms) + "\n";
  if (!terms.credit.empty()) text += "  credit: " + terms.credit + "\n";
  std::vector<std::pair<std::string, std::string>> own;  // licence and credit, and their styles
  for (const net::StyleInfo& style : model.styles) {
    if (style.licence.empty() && style.credit.empty()) continue;
    std::string said = net::TermsText({"", style.licence, style.credit}).substr(2);
    if (!style.credit.empty()) said += "; credit: " + style.credit;
    const auto same = std::ranges::find(own, said, &std::pair<std::string, std::string>::first);
    if (same == own.end()) {
      own.emplace_back(std::move(said), style.name);
    } else {
      same->second += ", " + style.name;
    }
  }
  for (const auto& [said, names] : own) text += "  " + names + ": " + said + "\n";
  for (const std::filesystem::path& other : net::OtherShippedWeights(file)) {
    text +=
        "other weights: " + net::TermsText(net::ReadTerms(file.parent_path() / other, "")) + "\n";
  }
  return text + "The program is Apache-2.0. A licence's own text counts.\n";
}

}  // namespace styled::stylize
