#include "daemon/security/zap.h"

#include <optional>

#include "proto/keys/key_file.h"

namespace styled::security {
namespace {

enum Frame : std::uint8_t { kVersion, kId, kDomain, kAddress, kIdentity, kMechanism, kKey, kCount };

std::optional<Door> FindDoor(std::string_view domain) {
  for (const Door door : {Door::kPublish, Door::kControl}) {
    if (domain == Domain(door)) return door;
  }
  return std::nullopt;
}

}  // namespace

std::string_view Domain(Door door) noexcept {
  return door == Door::kControl ? "control" : "publish";
}

ZapResult ParseZap(std::span<const std::string> frames, ZapRequest& out) {
  if (frames.size() != kCount) return ZapResult::kFrames;
  if (frames[kVersion] != "1.0") return ZapResult::kVersion;
  const auto door = FindDoor(frames[kDomain]);
  if (!door) return ZapResult::kDomain;
  if (frames[kMechanism] != "CURVE") return ZapResult::kMechanism;
  std::string key = keys::ToText(frames[kKey]);
  if (key.empty()) return ZapResult::kKey;
  out = {frames[kId], *door, frames[kAddress], std::move(key)};
  return ZapResult::kOk;
}

}  // namespace styled::security
