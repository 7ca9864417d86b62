#include "daemon/perform/terms.h"

#include <gtest/gtest.h>

#include <array>

namespace styled::pipeline {
namespace {

const std::array<net::Terms, 2> kFiles{net::Terms{"v2.safetensors", "CC-BY-NC-4.0", "A"},
                                       net::Terms{"open.safetensors", "CC-BY-4.0", "B"}};

v1::StyleInfo InfoOf(const net::StyleInfo& style, std::span<const net::Terms> files) {
  v1::StyleInfo info;
  FillTerms(style, files, info);
  FillCommercialUse(nullptr, info);
  return info;
}

TEST(DaemonTerms, AStyleWithoutALicenceHasThatOfItsNetworksFile) {
  net::StyleInfo style;
  style.model = "open";
  const v1::StyleInfo info = InfoOf(style, kFiles);
  EXPECT_EQ(info.licence(), "CC-BY-4.0");
  EXPECT_EQ(info.credit(), "B");
  EXPECT_EQ(info.commercial_use(), v1::COMMERCIAL_USE_YES);
}

TEST(DaemonTerms, AStyleOfTheOnlyNetworkHasThatOfTheOnlyFile) {
  EXPECT_EQ(InfoOf({}, std::span(kFiles).first(1)).licence(), "CC-BY-NC-4.0");
}

TEST(DaemonTerms, AStylesOwnLicenceComesFirst) {
  net::StyleInfo style;
  style.model = "v2";
  style.licence = "MIT";
  style.credit = "C";
  const v1::StyleInfo info = InfoOf(style, kFiles);
  EXPECT_EQ(info.licence(), "MIT");
  EXPECT_EQ(info.credit(), "C");
}

TEST(DaemonTerms, AnUnknownLicenceIsNotAPermission) {
  net::StyleInfo style;
  style.licence = "mine";
  EXPECT_EQ(InfoOf(style, kFiles).commercial_use(), v1::COMMERCIAL_USE_UNSPECIFIED);
}

TEST(DaemonTerms, AStyleListedAfterOneOfItsLicenceIsJudgedAsThat) {
  v1::StyleInfo first, same, other;
  first.set_licence("MIT");
  same.set_licence("MIT");
  other.set_licence("CC BY-NC 4.0");
  FillCommercialUse(nullptr, first);
  FillCommercialUse(&first, same);
  FillCommercialUse(&same, other);
  EXPECT_EQ(same.commercial_use(), v1::COMMERCIAL_USE_YES);
  EXPECT_EQ(other.commercial_use(), v1::COMMERCIAL_USE_NO);
}

TEST(DaemonTerms, OfAFileAreComplete) {
  v1::WeightsTerms out;
  FillTerms(kFiles[0], out);
  EXPECT_EQ(out.file(), "v2.safetensors");
  EXPECT_EQ(out.commercial_use(), v1::COMMERCIAL_USE_NO);
  EXPECT_EQ(out.credit(), "A");
}

}  // namespace
}  // namespace styled::pipeline
