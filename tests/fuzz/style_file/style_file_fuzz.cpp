// Fuzzes the reader of styles' files: what it accepts is written as a file that is not much longer
// and is read again with the same code.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "daemon/styles/style_file.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const pipeline::RuntimeConfig config = [] {
    pipeline::RuntimeConfig made;
    made.weights_hash = "crc32c:00000001";
    return made;
  }();
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto style = pipeline::ParseStyleFile(text, "fuzz.json", config);
  if (!style.ok()) {
    Require(style.status().message().starts_with("fuzz.json: "));
    return 0;
  }
  const auto& code = style.value().code;
  if (!std::ranges::all_of(code, [](float x) { return std::isfinite(x); }))
    return 0;  // refused later
  const std::string written = pipeline::FormatStyleFile(style.value(), config);
  Require(written.size() <= 2 * size + 2048);
  const auto again = pipeline::ParseStyleFile(written, "again.json", config);
  Require(again.ok() && again.value().code == code);
  Require(pipeline::FormatStyleFile(again.value(), config).size() <= 2 * size + 2048);
  return 0;
}
