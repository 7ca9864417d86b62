#include "daemon/security/zap.h"

#include <gtest/gtest.h>
#include <zmq.h>

#include "proto/keys/key_file.h"
#include "tests/unit/security/zap_cases.h"

namespace styled::security {
namespace {

TEST(ZapTest, EachCaseOfTheTableIsReadOrRefusedForItsReason) {
  for (const ZapCase& tried : ZapCases()) {
    ZapRequest request;
    request.key = "untouched";
    EXPECT_EQ(ParseZap(tried.frames, request), tried.result) << tried.name;
    if (tried.result != ZapResult::kOk) {
      EXPECT_EQ(request.key, "untouched") << tried.name;
    }
  }
}

TEST(ZapTest, IdentityDomainAndAddressAreKept) {
  auto frames = ZapCases()[1].frames;
  const auto pair = keys::MakePair().value();
  frames[6] = std::string(32, '\0');
  zmq_z85_decode(reinterpret_cast<std::uint8_t*>(frames[6].data()), pair.public_key.c_str());
  ZapRequest request;
  ASSERT_EQ(ParseZap(frames, request), ZapResult::kOk);
  EXPECT_EQ(request.id, "1");
  EXPECT_EQ(request.door, Door::kControl);
  EXPECT_EQ(request.address, "10.0.0.7");
  EXPECT_EQ(request.key, pair.public_key);
}

}  // namespace
}  // namespace styled::security
