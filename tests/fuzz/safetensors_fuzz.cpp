// Fuzzes the weights file's reader: the container, its metadata, and the families' loaders behind
// it. Seeds: safetensors_seeds.cpp.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "model/net/load.h"
#include "model/net/safetensors.h"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> file(reinterpret_cast<const std::byte*>(data), size);
  const auto view = styled::net::ParseSafetensors(file, "fuzz");
  if (view.ok()) {
    std::size_t bytes = 0;
    for (const auto& [name, tensor] : view.value().tensors) {
      Require(tensor.bytes.data() >= file.data());
      Require(tensor.bytes.data() + tensor.bytes.size() <= file.data() + file.size());
      bytes += tensor.bytes.size();
    }
    Require(bytes <= size);
  } else {
    Require(view.status().message().starts_with("fuzz: "));
  }
  const auto network = styled::net::Parse(file, "fuzz");
  Require(view.ok() || !network.ok());
  if (network.ok()) Require(!network.value()->model().styles.empty());
  return 0;
}
