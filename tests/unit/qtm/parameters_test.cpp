#include "proto/rigs/qtm/parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/qtm/decode_cases.h"

namespace styled::qtm {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kFlatXml;
using testing::kNestedXml;

std::string Refusal(std::string_view xml) {
  const auto read = ReadParameters(xml);
  return read.ok() ? "" : read.status().message();
}
std::string InSkeleton(std::string_view segments) {
  return "<QTM><Skeletons><Skeleton Name=\"a\">" + std::string(segments) +
         "</Skeleton></Skeletons></QTM>";
}

TEST(QtmParameters, AreRefusedWithWhatWasExpected) {
  EXPECT_THAT(Refusal("<QTM><Skeletons></QTM>"), HasSubstr("not XML: byte "));
  EXPECT_THAT(Refusal(""), HasSubstr("not XML: byte 0"));
  EXPECT_EQ(Refusal("<QTM><General><Frequency>fast</Frequency></General></QTM>"),
            "General: Frequency \"fast\", expected a number above 0");
  EXPECT_EQ(Refusal("<QTM><General><Frequency>-1</Frequency></General></QTM>"),
            "General: Frequency \"-1\", expected a number above 0");
  EXPECT_EQ(Refusal("<QTM><The_3D><AxisUpwards>up</AxisUpwards></The_3D></QTM>"),
            "The_3D: AxisUpwards \"up\", expected one of +X, +Y, +Z, -X, -Y, -Z");
  EXPECT_EQ(Refusal(InSkeleton("<Segment Name=\"Hips\" ID=\"seven\"/>")),
            "skeleton a: segment Hips: ID=\"seven\", expected a number");
  EXPECT_EQ(Refusal(InSkeleton("<Segment Name=\"Hips\" ID=\"99999999999\"/>")),
            "skeleton a: segment Hips: ID=\"99999999999\", expected a number");
  for (const char* x : {"one", "nan", "inf", "1e300", "1,5", ""}) {
    EXPECT_EQ(Refusal(InSkeleton("<Segment Name=\"Hips\"><Position X=\"" + std::string(x) +
                                 "\"/></Segment>")),
              "skeleton a: segment Hips: Position X=\"" + std::string(x) + "\", expected a number");
  }
  // Of itself, of a later segment, of none: parents come first.
  EXPECT_EQ(Refusal(InSkeleton("<Segment Name=\"Hips\" ID=\"1\" Parent_ID=\"1\"/>")),
            "skeleton a: segment Hips: Parent_ID=\"1\", expected the ID of a segment before it");
}

TEST(QtmParameters, OversizedParametersAreRefusedBeforeTheyAreParsed) {
  std::string nested = "<QTM><Skeletons><Skeleton Name=\"a\"><Segments>";
  for (int i = 0; i < 1'000'000; ++i) nested += "<Segment>";
  EXPECT_EQ(Refusal(nested), "XML with more than 200000 elements");
  // Fewer, well-formed: of a depth that no skeleton has.
  std::string deep = "<QTM><Skeletons><Skeleton Name=\"a\"><Segments>", end;
  for (int i = 0; i < 50'000; ++i) {
    deep += "<Segment>";
    end += "</Segment>";
  }
  EXPECT_EQ(Refusal(deep + end + "</Segments></Skeleton></Skeletons></QTM>"),
            "skeleton a: segments deeper than 128");
  // Entities are not expanded.
  EXPECT_NE(Refusal("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;"), "");
}

// To look for each parent among all of them would take the square of their number.
TEST(QtmParameters, ASkeletonWithTooManySegmentsKeepsTheFirstAndTheCount) {
  std::string flat = "<Segment Name=\"s0\" ID=\"0\"/>";
  for (int i = 1; i < 70'000; ++i) {
    flat +=
        "<Segment ID=\"" + std::to_string(i) + "\" Parent_ID=\"" + std::to_string(i - 1) + "\"/>";
  }
  std::string nested = "<Segments><Segment Name=\"root\">";
  for (int i = 0; i < 200; ++i) nested += "<Segment><Segment/></Segment>";
  nested += "</Segment></Segments>";
  const auto read =
      ReadParameters("<QTM><Skeletons><Skeleton Name=\"a\">" + flat +
                     "</Skeleton><Skeleton Name=\"b\">" + nested + "</Skeleton></Skeletons></QTM>");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read.value().skeletons->size(), 2U);
  const SkeletonDescription& a = read.value().skeletons->at(0);
  EXPECT_EQ(a.segments.size(), kMaxSegments);
  EXPECT_EQ(a.segments.back().parent, static_cast<int>(kMaxSegments) - 2);
  EXPECT_EQ(a.segments_left_out, 70'000 - kMaxSegments);
  const SkeletonDescription& b = read.value().skeletons->at(1);
  EXPECT_EQ(b.segments.size(), kMaxSegments);
  EXPECT_EQ(b.segments_left_out, 401 - kMaxSegments);
}

TEST(QtmParameters, LeftOutSkeletonsAreNamed) {
  Parameters written;
  written.skeletons.emplace();
  for (int k = 0; k < 20; ++k) {
    written.skeletons->push_back({"s" + std::to_string(k), false, {{"Hips", 1}}});
  }
  const auto read = ReadParameters(WriteParameters(written, 25));
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read.value().skeletons->size(), 20U);
  EXPECT_EQ(read.value().skeletons->at(15).segments.size(), 1U);
  EXPECT_EQ(read.value().skeletons->at(16).segments.size(), 0U);
  EXPECT_EQ(read.value().skeletons->at(19).name, "s19");
}

TEST(QtmParameters, TheNestedFormHasEveryValue) {
  const auto read = ReadParameters(kNestedXml);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read.value().frequency_hz, 100);
  EXPECT_EQ(read.value().up, Axis::kZ);
  ASSERT_TRUE(read.value().skeletons);
  ASSERT_EQ(read.value().skeletons->size(), 1U);
  const SkeletonDescription& skeleton = read.value().skeletons->front();
  EXPECT_EQ(skeleton.name, "Eli & co");
  EXPECT_FALSE(skeleton.global);
  ASSERT_EQ(skeleton.segments.size(), 3U);
  EXPECT_EQ(skeleton.segments[0].name, "Hips");
  EXPECT_EQ(skeleton.segments[0].id, 8496U);
  EXPECT_EQ(skeleton.segments[0].parent, -1);
  EXPECT_THAT(skeleton.segments[0].position_mm,
              ElementsAre(DoubleEq(10), DoubleEq(-20.5), DoubleEq(950.25)))
      << "DefaultTransform's, neither Transform's nor a marker's";
  EXPECT_THAT(skeleton.segments[0].rotation, ElementsAre(0, 0, 0.707107, 0.707107));
  EXPECT_EQ(skeleton.segments[1].name, "Spine");
  EXPECT_EQ(skeleton.segments[1].parent, 0);
  EXPECT_THAT(skeleton.segments[1].rotation, ElementsAre(0.6, 0, 0, 0.8)) << "Transform's";
  EXPECT_EQ(skeleton.segments[2].parent, 0);
  EXPECT_THAT(skeleton.segments[2].rotation, ElementsAre(0, 0, 0, 1)) << "nothing said";
}

TEST(QtmParameters, TheFlatFormHasEveryValue) {
  const auto read = ReadParameters(kFlatXml);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_FALSE(read.value().frequency_hz);
  EXPECT_FALSE(read.value().up);
  ASSERT_EQ(read.value().skeletons->size(), 2U);
  const SkeletonDescription& skeleton = read.value().skeletons->front();
  EXPECT_TRUE(skeleton.global);
  ASSERT_EQ(skeleton.segments.size(), 2U);
  EXPECT_EQ(skeleton.segments[1].parent, 0);
  EXPECT_THAT(skeleton.segments[1].position_mm, ElementsAre(314.25, 329.5, 1120.5));
  EXPECT_THAT(skeleton.segments[1].rotation, ElementsAre(0, 0, 1, 0));
  EXPECT_TRUE(read.value().skeletons->back().segments.empty());
}

TEST(QtmParameters, WithoutSkeletonsSaySo) {
  const auto none = ReadParameters("<QTM_Parameters_Ver_1.25/>");
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(none.value().skeletons);
  const auto empty =
      ReadParameters("<QTM_Parameters_Ver_1.25><Skeletons/></QTM_Parameters_Ver_1.25>");
  ASSERT_TRUE(empty.ok());
  ASSERT_TRUE(empty.value().skeletons);
  EXPECT_TRUE(empty.value().skeletons->empty());
}

TEST(QtmParameters, WrittenAreReadInBothForms) {
  Parameters written;
  written.frequency_hz = 120;
  written.up = Axis::kMinusY;
  written.skeletons = {{"anna",
                        false,
                        {{"Hips", 7, -1, {1, 2, 3}, {0.6, 0, 0, 0.8}},
                         {"Spine", 8, 0, {0, 100, 0}, {0, 0, 0, 1}},
                         {"Head", 9, 1, {0, 200, 0}, {0, 0.6, 0, 0.8}},
                         {"LeftUpLeg", 10, 0, {90, 0, 0}, {0, 0, 0, 1}}}}};
  for (const int minor : {25, 21, 20, 19}) {
    const auto read = ReadParameters(WriteParameters(written, minor));
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(read.value().frequency_hz, 120);
    EXPECT_EQ(read.value().up, Axis::kMinusY);
    const SkeletonDescription& skeleton = read.value().skeletons->at(0);
    EXPECT_EQ(skeleton.global, minor < 21);
    ASSERT_EQ(skeleton.segments.size(), 4U);
    for (std::size_t s = 0; s < 4; ++s) {
      const SegmentDescription &a = skeleton.segments[s], &b = written.skeletons->at(0).segments[s];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.id, b.id);
      EXPECT_EQ(a.parent, b.parent);
      EXPECT_EQ(a.position_mm, b.position_mm);
      EXPECT_EQ(a.rotation, b.rotation);
    }
  }
}

}  // namespace
}  // namespace styled::qtm
