#include "model/net/sha256.h"

#include <sodium.h>

#include <array>

#include "model/net/safetensors.h"

namespace styled::net {

std::string Sha256(std::span<const std::byte> bytes) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size());
  std::array<char, 2 * hash.size() + 1> text{};
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

Result<std::string> Sha256OfFile(const std::filesystem::path& file) {
  const auto bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Sha256(bytes.value());
}

}  // namespace styled::net
