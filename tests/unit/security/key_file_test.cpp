#include "proto/keys/key_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/security/key_texts.h"

namespace styled::keys {
namespace {

using testing::HasSubstr;

TEST(KeyFileTest, AWrittenFileIsReadAgain) {
  const KeyFile pair = MakePair().value();
  for (const KeyFile& file :
       {pair, KeyFile{pair.public_key, "", Role::kOperator},
        KeyFile{pair.public_key, "", Role::kSubscriber}, KeyFile{pair.public_key, "", {}}}) {
    const auto read = Parse(Format(file));
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(read.value().public_key, file.public_key);
    EXPECT_EQ(read.value().secret_key, file.secret_key);
    EXPECT_EQ(read.value().role, file.role);
  }
}

TEST(KeyFileTest, TwoPairsAreNotTheSameAndNoneLooksLikeAnOption) {
  EXPECT_NE(MakePair().value().secret_key, MakePair().value().secret_key);
  for (int i = 0; i < 500; ++i) EXPECT_NE(MakePair().value().public_key[0], '-');
}

TEST(KeyFileTest, CertificatesOfOtherProgramsAreRead) {
  const auto read = Parse(kForeignCertificate);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read.value().public_key, kPublicOfRfc);
  EXPECT_EQ(read.value().secret_key, kSecretOfRfc);
  EXPECT_FALSE(read.value().role);
}

TEST(KeyFileTest, ErrorsAreNamedAndNoKeyIsRepeated) {
  const std::string key = kPublicOfRfc;
  const auto complaint = [](const std::string& text) {
    const auto read = Parse(text);
    return read.ok() ? "" : read.status().message();
  };
  EXPECT_THAT(complaint(""), HasSubstr("holds no public-key"));
  EXPECT_THAT(complaint("public-key = \"" + key + "\"\n"), HasSubstr("holds no public-key"))
      << "not below a section";
  EXPECT_THAT(complaint("curve\n    public-key = \"short\"\n"),
              HasSubstr("line 2: expected a key, 40 characters"));
  EXPECT_THAT(complaint("curve\n    public-key = \"" + std::string(40, ' ') + "\"\n"),
              HasSubstr("line 2"));
  EXPECT_THAT(complaint("curve\n    public-key = \"" + std::string(40, '~') + "\"\n"),
              HasSubstr("line 2"))
      << "no character of Z85";
  EXPECT_THAT(complaint("curve\n    public-key = \"" + std::string(40, '#') + "\"\n"),
              HasSubstr("line 2"))
      << "more than 32 bytes hold";
  EXPECT_THAT(complaint("curve\n    public-key \"" + key + "\"\n"), HasSubstr("line 2"));
  EXPECT_THAT(complaint("curve\n    publickey = \"" + key + "\"\n"),
              HasSubstr("line 2: expected public-key or secret-key"));
  const std::string twice = "    public-key = \"" + key + "\"\n";
  EXPECT_THAT(complaint("curve\n" + twice + twice), HasSubstr("line 3: a second key"));
  EXPECT_THAT(complaint("metadata\n    role = \"king\"\ncurve\n" + twice),
              HasSubstr("line 2: role: expected subscriber or operator"));
  const std::string other = MakePair().value().secret_key;
  const std::string mixed = complaint("curve\n" + twice + "    secret-key = \"" + other + "\"\n");
  EXPECT_THAT(mixed, HasSubstr("do not belong together"));
  EXPECT_EQ(mixed.find(other), std::string::npos);
}

TEST(KeyFileTest, AKeyIsFortyCharactersAndNoZeroAmongThem) {
  std::string key = kPublicOfRfc;
  EXPECT_TRUE(IsKey(key));
  EXPECT_FALSE(IsKey(key.substr(1)));
  EXPECT_FALSE(IsKey(key + "0"));
  key[35] = '\0';
  EXPECT_FALSE(IsKey(key));
  EXPECT_EQ(ToText("too short"), "");
}

}  // namespace
}  // namespace styled::keys
