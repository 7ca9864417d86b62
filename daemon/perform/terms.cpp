#include "daemon/perform/terms.h"

#include <string>
#include <string_view>

namespace styled::pipeline {
namespace {

v1::CommercialUse CommercialUseOf(const std::string& licence) {
  switch (net::CommercialUse(licence)) {
    case net::Commercial::kYes:
      return v1::COMMERCIAL_USE_YES;
    case net::Commercial::kNo:
      return v1::COMMERCIAL_USE_NO;
    case net::Commercial::kUnknown:
      break;
  }
  return v1::COMMERCIAL_USE_UNSPECIFIED;
}

}  // namespace

void FillTerms(const net::Terms& terms, v1::WeightsTerms& out) {
  out.set_file(terms.file);
  out.set_licence(terms.licence);
  out.set_credit(terms.credit);
  out.set_commercial_use(CommercialUseOf(terms.licence));
}

void FillTerms(const net::StyleInfo& style, std::span<const net::Terms> files, v1::StyleInfo& out) {
  out.set_licence(style.licence);
  out.set_credit(style.credit);
  if (!style.licence.empty()) return;
  for (const net::Terms& terms : files) {
    // With one network its styles name none.
    const auto stem = std::string_view(terms.file).substr(0, terms.file.rfind('.'));
    if (!style.model.empty() && stem != style.model) continue;
    out.set_licence(terms.licence);
    out.set_credit(terms.credit);
    return;
  }
}

void FillCommercialUse(const v1::StyleInfo* before, v1::StyleInfo& out) {
  const bool same = before != nullptr && before->licence() == out.licence();
  out.set_commercial_use(same ? before->commercial_use() : CommercialUseOf(out.licence()));
}

}  // namespace styled::pipeline
