// Fuzzes authentication requests (ZAP): a request is either refused, or it names one of the
// daemon's sockets and a valid key.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "daemon/security/zap.h"
#include "proto/keys/key_file.h"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace styled;
  std::vector<std::string> frames(1);
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] == '|') {
      frames.emplace_back();
    } else {
      frames.back() += static_cast<char>(data[i]);
    }
  }
  security::ZapRequest request;
  if (security::ParseZap(frames, request) != security::ZapResult::kOk) {
    Require(request.key.empty());
    return 0;
  }
  Require(frames.size() == 7 && frames[5] == "CURVE" && frames[6].size() == 32);
  Require(frames[2] == security::Domain(request.door));
  Require(keys::IsKey(request.key));
  return 0;
}
