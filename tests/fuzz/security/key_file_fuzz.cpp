// Fuzzes key files: a file is either refused with a reason, or its keys are valid and can be
// written and read again.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "proto/keys/key_file.h"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace styled;
  const auto read = keys::Parse({reinterpret_cast<const char*>(data), size});
  if (!read.ok()) {
    Require(!read.status().message().empty());
    return 0;
  }
  const keys::KeyFile& file = read.value();
  Require(keys::IsKey(file.public_key));
  Require(file.secret_key.empty() || keys::IsKey(file.secret_key));
  const auto again = keys::Parse(keys::Format(file));
  Require(again.ok() && again.value().public_key == file.public_key &&
          again.value().secret_key == file.secret_key && again.value().role == file.role);
  return 0;
}
