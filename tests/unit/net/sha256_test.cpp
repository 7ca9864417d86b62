#include "model/net/sha256.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace styled::net {
namespace {

std::string Of(const std::string& text) { return Sha256(std::as_bytes(std::span(text))); }

// The examples of FIPS 180-4 and of NIST's list of vectors.
TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(Of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileNamesOneThatCannotBeRead) {
  const support::TemporaryFolder folder;
  std::ofstream(folder / "abc") << "abc";
  EXPECT_EQ(Sha256OfFile(folder / "abc").value(), Of("abc"));
  EXPECT_THAT(Sha256OfFile(folder / "lost").status().message(), testing::HasSubstr("lost"));
}

}  // namespace
}  // namespace styled::net
