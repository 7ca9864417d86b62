// Fuzzes the daemon's configuration file: it is either refused with a reason, or parsed and valid.
// The last line, if any, is an override like --set.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "daemon/config/config.h"
#include "proto/rigs/types.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

void Check(const std::string& text, const std::vector<config::Override>& overrides) {
  const auto loaded = config::Parse(text, "styled.toml", overrides);
  if (!loaded.ok()) return Require(!loaded.status().message().empty());
  Require(!loaded.value().sources.empty());
  for (const auto& source : loaded.value().sources) {
    Require(config::IsName(source.name));
    Require(rigs::FindSourceType(source.type) != nullptr);
  }
  Require(config::Validate(loaded.value()).ok());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  Check(text, {});
  const auto setting = config::ParseOverride(text.substr(text.rfind('\n') + 1));
  if (setting.ok()) Check("", {setting.value()});
  return 0;
}
