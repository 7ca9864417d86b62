#include "model/net/default_weights.h"

#include "model/net/sha256.h"
#include "model/net/shipped_weights.h"

namespace styled::net {
namespace {

constexpr std::size_t kShownDigits = 12;

}  // namespace

std::string DescribeDefaultWeights() {
  const auto file = FindWeights("");
  if (!file.ok()) return file.status().message();
  const auto hash = Sha256OfFile(file.value());
  if (!hash.ok()) return hash.status().message();
  return "weights " + file.value().stem().string() + " " + hash.value().substr(0, kShownDigits) +
         " (" + file.value().string() + ")";
}

}  // namespace styled::net
