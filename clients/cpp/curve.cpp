#include "clients/cpp/curve.h"

#include <zmq.h>

#include <array>
#include <cstdint>

namespace styled::client {
namespace {

constexpr std::size_t kKeyCharacters = 40, kKeyBytes = 32;

bool IsKey(const std::string& text) {
  std::array<std::uint8_t, kKeyBytes> bytes{};
  return text.size() == kKeyCharacters && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

}  // namespace

Result<Curve> Complete(const Curve& curve) {
  Curve complete = curve;
  if (curve.public_key.empty() && curve.secret_key.empty()) {
    std::array<char, kKeyCharacters + 1> public_key{}, secret_key{};
    if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
      return Status::Error(std::string("curve: ") + zmq_strerror(zmq_errno()));
    }
    complete.public_key = public_key.data();
    complete.secret_key = secret_key.data();
  }
  for (const auto& [name, key] : {std::pair{"server_key", &complete.server_key},
                                  std::pair{"public_key", &complete.public_key},
                                  std::pair{"secret_key", &complete.secret_key}}) {
    if (IsKey(*key)) continue;
    return Status::Error(std::string("curve: ") + name + " has " + std::to_string(key->size()) +
                         " characters; expected 40 of Z85");
  }
  return complete;
}

}  // namespace styled::client
