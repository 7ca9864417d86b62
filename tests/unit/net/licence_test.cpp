#include "model/net/licence.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace styled::net {
namespace {

TEST(Licence, TellsWhetherACompanyMayUseIt) {
  for (const char* yes : {"CC BY 4.0", "CC-BY-4.0", "cc0-1.0", "MIT", "Apache-2.0", "BSD-3-Clause",
                          "CC BY 4.0; The 100STYLE Dataset", "that of this program",
                          "free for all uses; the data itself may not be resold"}) {
    EXPECT_EQ(CommercialUse(yes), Commercial::kYes) << yes;
  }
  for (const char* no :
       {"CC BY-NC 4.0", "CC-BY-NC-4.0", "CC-BY-NC-SA-4.0", "cc by-nc", "CC BY 4.0; CC BY-NC 4.0",
        "MIT, but non-commercial", "for research only"}) {
    EXPECT_EQ(CommercialUse(no), Commercial::kNo) << no;
  }
  for (const char* unknown : {"", "mine", "none", "see LICENSE", "NCSA", "proprietary"}) {
    EXPECT_EQ(CommercialUse(unknown), Commercial::kUnknown) << unknown;
  }
}

TEST(Licence, OfTwoThingsIsBothAndAsStrictAsTheStricter) {
  const std::vector<std::string> all{"CC BY 4.0", "CC BY-NC 4.0", "mine"};
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(BothLicences(all[i], ""), all[i]);
    EXPECT_EQ(BothLicences("", all[i]), all[i]);
    EXPECT_EQ(BothLicences(all[i], all[i]), all[i]);
    for (std::size_t j = 0; j < all.size(); ++j) {
      const std::string both = BothLicences(all[i], all[j]);
      const bool forbidden = i == 1 || j == 1;
      const auto expected = forbidden
                                ? Commercial::kNo
                                : (i == 0 && j == 0 ? Commercial::kYes : Commercial::kUnknown);
      EXPECT_EQ(CommercialUse(both), expected) << both;
      EXPECT_EQ(BothLicences(both, all[j]), both) << "it is there already";
    }
  }
}

class TermsTest : public testing::Test {
 protected:
  Terms Read(const std::string& beside) {
    std::ofstream(folder_ / "w.safetensors.license") << beside;
    return ReadTerms(std::filesystem::path(folder_ / "w.safetensors"), "CC BY 4.0");
  }

  const support::TemporaryFolder folder_;
};

TEST_F(TermsTest, AreTheFilesOwnWithoutALicenceFile) {
  const Terms terms = ReadTerms(std::filesystem::path(folder_ / "w.safetensors"), "CC BY 4.0");
  EXPECT_EQ(terms.file, "w.safetensors");
  EXPECT_EQ(terms.licence, "CC BY 4.0");
  EXPECT_EQ(terms.credit, "");
  EXPECT_EQ(TermsText(terms), "w.safetensors: licence CC BY 4.0, for commercial use too");
}

TEST_F(TermsTest, AreReadFromTheLicenceFile) {
  const Terms terms = Read(
      "SPDX-FileCopyrightText: 2026 One\nSPDX-FileCopyrightText: Two, Inc.\n\n"
      "SPDX-License-Identifier: CC-BY-NC-4.0\n");
  EXPECT_EQ(terms.licence, "CC-BY-NC-4.0");
  EXPECT_EQ(terms.credit, "2026 One; Two, Inc.");
  EXPECT_EQ(TermsText(terms), "w.safetensors: licence CC-BY-NC-4.0, not for commercial use");
}

TEST_F(TermsTest, DoNotWaitForAPipe) {
  ASSERT_EQ(mkfifo((folder_ / "w.safetensors.license").c_str(), 0600), 0);
  const Terms terms = ReadTerms(std::filesystem::path(folder_ / "w.safetensors"), "CC BY 4.0");
  EXPECT_EQ(terms.licence, "CC BY 4.0");
}

TEST_F(TermsTest, IgnoreWhatIsNotText) {
  const Terms terms =
      Read("SPDX-License-Identifier: a\x1B[31m\nSPDX-FileCopyrightText: \x01\nnoise");
  EXPECT_EQ(terms.licence, "CC BY 4.0");
  EXPECT_EQ(terms.credit, "");
}

TEST_F(TermsTest, OfALargeFileAreItsBeginning) {
  const Terms terms = Read("SPDX-FileCopyrightText: A\n" + std::string(1'000'000, 'x') +
                           "\nSPDX-FileCopyrightText: B\n");
  EXPECT_EQ(terms.credit, "A");
}

}  // namespace
}  // namespace styled::net
