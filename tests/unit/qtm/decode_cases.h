#pragma once

#include <string>
#include <vector>

#include "proto/rigs/qtm/frame.h"
#include "tests/unit/qtm/bytes.h"

// Data packets, right ones and every way to get them wrong; XML of both forms. Shared by the unit
// tests and, as seeds, by the fuzzer.
namespace styled::qtm::testing {

struct DecodeCase {
  std::string name;
  Bytes packet;
  DecodeResult expected;
};

// Two skeletons: of two segments, and one that is not seen.
inline Part TwoSkeletons() {
  return ComponentOf(18, U32{2}, U32{2}, SegmentOf(752, 100, -200, 950.5F, 0, 0, 0.6F, 0.8F),
                     SegmentOf(753, 0, 0, 125, 0.5F, -0.5F, 0.5F, -0.5F), U32{0});
}
// 13:45:07 and 21 frames.
inline Part SmpteTimecode() {
  return ComponentOf(17, U32{1}, U32{0}, U32{0}, U32{13 | 45 << 5 | 7 << 11 | 21 << 17});
}
// Residuals of three markers, which are not read.
inline Part OtherComponent() { return ComponentOf(9, U32{3}, U32{0}, Any{48}); }

inline std::vector<DecodeCase> DecodeCases() {
  using enum DecodeResult;
  const auto skeleton = [](std::uint64_t count, const Bytes& rest) {
    return Data(1000, 7, ComponentOf(18, U32{count}, Part{rest}));
  };
  const Bytes one_segment = Join(U32{1}, SegmentOf(1, 0, 0, 0, 0, 0, 0, 1));
  return {
      {"all that is read", Data(1'234'567, 42, TwoSkeletons(), SmpteTimecode()), kOk},
      {"skips what it does not know", Data(1, 1, OtherComponent(), TwoSkeletons()), kOk},
      {"no components", Data(0, 1), kOk},
      {"no skeletons", skeleton(0, {}), kOk},
      {"seventeen skeletons",
       skeleton(17,
                [&] {
                  Bytes all;
                  for (int i = 0; i < 17; ++i) {
                    Part{one_segment}.AppendTo(all);
                  }
                  return all;
                }()),
       kOk},
      {"no timecode in its component", Data(1, 1, ComponentOf(17, U32{0})), kOk},
      {"bytes after the last component", Pack(3, I64{5}, U32{1}, U32{1}, TwoSkeletons(), Any{12}),
       kOk},
      {"more components than bytes", Pack(3, I64{5}, U32{1}, U32{1'000'000'000}), kBadCount},
      {"a component without an end",
       Pack(3, I64{5}, U32{1}, U32{1}, U32{4'000'000'000}, U32{18}, Any{100}), kTruncated},
      {"a component smaller than its header",
       Pack(3, I64{5}, U32{1}, U32{1}, U32{7}, U32{18}, Any{100}), kTruncated},
      {"a billion skeletons", skeleton(1'000'000'000, one_segment), kBadCount},
      {"a billion segments", skeleton(1, Join(U32{1'000'000'000}, Any{64})), kBadCount},
      {"a skeleton without its end", skeleton(2, one_segment), kTruncated},
      {"a timecode without its end", Data(1, 1, ComponentOf(17, U32{1}, U32{0}, U32{0})),
       kBadCount},
      {"a negative time", Data(-1, 1, TwoSkeletons()), kBadTime},
      {"a time of 300 years", Data(9'000'000'000'000'000, 1, TwoSkeletons()), kBadTime},
  };
}

// As a QTM of 1.21 and later lists one skeleton, with all that is not read; figures are ours.
inline constexpr std::string_view kNestedXml = R"(<?xml version="1.0" encoding="utf-8"?>
<QTM_Parameters_Ver_1.25>
  <General><Frequency>100</Frequency><Camera><ID>1</ID><Model>Arqus</Model></Camera></General>
  <The_3D><AxisUpwards>+Z</AxisUpwards><Labels>1</Labels><Label><Name>WaistL</Name></Label></The_3D>
  <Skeletons>
    <Skeleton Name="Eli &amp; co">
      <Scale>1.020000</Scale>
      <Segments>
        <Segment Name="Hips" ID="8496">
          <Solver>Global Optimization</Solver>
          <Transform>
            <Position X="1.5" Y="2.5" Z="3.5"/><Rotation X="1.0" Y="0.0" Z="0.0" W="0.0"/>
          </Transform>
          <DefaultTransform>
            <Position X="10.000000" Y="-20.500000" Z="950.250000"/>
            <Rotation X="0.000000" Y="0.000000" Z="0.707107" W="0.707107"/>
          </DefaultTransform>
          <DegreesOfFreedom>
            <RotationX><Constraint LowerBound="-1.5" UpperBound="1.5"/></RotationX>
          </DegreesOfFreedom>
          <Endpoint X="0" Y="0" Z="100"/>
          <Markers><Marker Name="WaistL">
            <Position X="120" Y="202" Z="-7"/><Weight>1.0</Weight>
          </Marker></Markers>
          <RigidBodies><RigidBody Name="Sword"><Transform>
            <Position X="7" Y="7" Z="7"/><Rotation X="0" Y="0" Z="0" W="1"/>
          </Transform></RigidBody></RigidBodies>
          <Segment Name="Spine" ID="8507">
            <Transform>
              <Position X="0" Y="0" Z="120"/><Rotation X="0.6" Y="0" Z="0" W="0.8"/>
            </Transform>
          </Segment>
          <Segment Name="LeftUpLeg" ID="8597"/>
        </Segment>
      </Segments>
    </Skeleton>
  </Skeletons>
</QTM_Parameters_Ver_1.25>)";

// As a QTM before 1.21 does: a list in the capture volume, attributes in the order of its manual.
inline constexpr std::string_view kFlatXml = R"(<QTM_Settings>
  <Skeletons>
    <Skeleton Name="VF">
      <Segment Name="Hips" ID="752">
        <Position Z="995.5" Y="329.5" X="320.25"/><Rotation Z="1.0" Y="0.0" X="0.0" W="0.0"/>
      </Segment>
      <Segment Name="Waist" ID="753" Parent_ID="752">
        <Position Z="1120.5" Y="329.5" X="314.25"/><Rotation Z="1.0" Y="0.0" X="0.0" W="0.0"/>
      </Segment>
    </Skeleton>
    <Skeleton Name="two"/>
  </Skeletons>
</QTM_Settings>)";

}  // namespace styled::qtm::testing
