#pragma once

#include <string>
#include <vector>

#include "daemon/security/zap.h"

namespace styled::security {

struct ZapCase {
  std::string name;
  std::vector<std::string> frames;
  ZapResult result;
};

// Requests as libzmq makes them, and malformed ones.
inline std::vector<ZapCase> ZapCases() {
  const std::string key("\x00\x01\xFF key of thirty-two bytes, raw.", 32);
  const auto request = [&key](std::size_t place, const std::string& text) {
    std::vector<std::string> frames{"1.0", "1", "publish", "10.0.0.7", "", "CURVE", key};
    frames[place] = text;
    return frames;
  };
  const auto good = request(1, "1");
  auto longer = good, shorter = good;
  longer.push_back("");
  shorter.pop_back();
  return {{"publisher", good, ZapResult::kOk},
          {"control", request(2, "control"), ZapResult::kOk},
          {"identity of the client's choice", request(4, std::string(255, '\0')), ZapResult::kOk},
          {"nothing", {}, ZapResult::kFrames},
          {"one empty frame", {""}, ZapResult::kFrames},
          {"a frame too many", longer, ZapResult::kFrames},
          {"no key", shorter, ZapResult::kFrames},
          {"other version", request(0, "2.0"), ZapResult::kVersion},
          {"no version", request(0, ""), ZapResult::kVersion},
          {"no domain", request(2, ""), ZapResult::kDomain},
          {"unknown domain", request(2, "contro"), ZapResult::kDomain},
          {"domain with a zero", request(2, std::string("control\0", 8)), ZapResult::kDomain},
          {"no CURVE", request(5, "NULL"), ZapResult::kMechanism},
          {"a password", request(5, "PLAIN"), ZapResult::kMechanism},
          {"empty key", request(6, ""), ZapResult::kKey},
          {"short key", request(6, key.substr(1)), ZapResult::kKey},
          {"long key", request(6, key + "x"), ZapResult::kKey}};
}

}  // namespace styled::security
