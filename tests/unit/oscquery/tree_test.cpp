#include "clients/oscquery/tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "proto/rigs/types.h"
#include "proto/rigs/vmc/device.h"
#include "proto/rigs/vmc/vmc.h"
#include "proto/rigs/vrchat/vrchat.h"

namespace styled::oscquery {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::IsSupersetOf;

std::map<std::string, std::string> TypesByAddress(std::string_view type) {
  std::map<std::string, std::string> types;
  for (const Method& method : MethodsOf(type)) types[method.address] = method.types;
  return types;
}

TEST(OscQueryTree, HasMethodsForVmcAndVrChatAlone) {
  for (const rigs::SourceType& type : rigs::kSourceTypes) {
    const bool spoken = type.name == "vmc" || type.name == "vrchat";
    EXPECT_EQ(!MethodsOf(type.name).empty(), spoken) << type.name;
  }
}

TEST(OscQueryTree, ListsTheAddressesOfVmcWithTheirTypes) {
  using Row = std::pair<const std::string, std::string>;
  EXPECT_THAT(
      TypesByAddress("vmc"),
      IsSupersetOf({Row{"/VMC/Ext/OK", "iiii"}, Row{"/VMC/Ext/T", "f"},
                    Row{"/VMC/Ext/Root/Pos", "sfffffff"}, Row{"/VMC/Ext/Bone/Pos", "sfffffff"},
                    Row{"/VMC/Ext/Blend/Val", "sf"}, Row{"/VMC/Ext/Blend/Apply", ""},
                    Row{"/VMC/Ext/Hmd/Pos", "sfffffff"}, Row{"/VMC/Ext/Con/Pos", "sfffffff"},
                    Row{"/VMC/Ext/Tra/Pos", "sfffffff"}, Row{"/VMC/Thru", "s"}}));
}

TEST(OscQueryTree, ListsTheAddressesThatVrChatSendsTo) {
  const auto types = TypesByAddress("vrchat");
  EXPECT_EQ(types.size(), 2U * 9U + 3U);
  for (const char* device : {"head", "leftwrist", "rightwrist"}) {
    const std::string address = std::string("/tracking/vrsystem/") + device + "/pose";
    EXPECT_EQ(types.at(address), "ffffff");
  }
  EXPECT_EQ(types.at("/tracking/trackers/8/rotation"), "fff");
}

// A message of each address and its types, all arguments zero, is taken by a decoder of the source.
TEST(OscQueryTree, EachMethodIsTakenByTheDecoder) {
  for (const char* type : {"vmc", "vrchat"}) {
    for (const Method& method : MethodsOf(type)) {
      std::array<std::byte, 256> buffer;
      vmc::osc::Writer writer(buffer);
      const bool thru = method.address == "/VMC/Thru";
      writer.BeginMessage(thru ? "/VMC/Thru/a/b" : method.address, method.types);
      for (const char tag : method.types) {
        if (tag == 'i') writer.Int(0);
        if (tag == 'f') writer.Float(0);
        if (tag == 's') writer.Text("Hips");
      }
      writer.EndMessage();
      ASSERT_TRUE(writer.ok());
      vmc::osc::Reader reader(std::span<const std::byte>(buffer).first(writer.size()));
      vmc::osc::Message bytes;
      ASSERT_EQ(reader.Next(bytes), vmc::osc::Reader::Step::kMessage);
      vmc::Message message;
      vmc::Device device;
      vrchat::Message tracker;
      const bool accepted = std::string_view(type) == "vrchat"
                                ? vrchat::Decode(bytes, tracker) == vrchat::DecodeResult::kOk
                                : vmc::Decode(bytes, message) == vmc::DecodeResult::kOk ||
                                      vmc::Decode(bytes, device) == vmc::DecodeResult::kOk;
      EXPECT_TRUE(accepted) << method.address;
    }
  }
}

TEST(OscQueryTree, ContainersHaveNoValueAndMethodsCanBeWritten) {
  const json tree = TreeOf({{"/a/b/c", "sf", "one"}, {"/a/d", "", "two"}}, "the source");
  EXPECT_EQ(tree, json::parse(R"({"FULL_PATH": "/", "ACCESS": 0, "DESCRIPTION": "the source",
    "CONTENTS": {"a": {"FULL_PATH": "/a", "ACCESS": 0, "CONTENTS": {
      "b": {"FULL_PATH": "/a/b", "ACCESS": 0, "CONTENTS": {
        "c": {"FULL_PATH": "/a/b/c", "ACCESS": 2, "TYPE": "sf", "DESCRIPTION": "one"}}},
      "d": {"FULL_PATH": "/a/d", "ACCESS": 2, "DESCRIPTION": "two"}}}}})"));
}

}  // namespace
}  // namespace styled::oscquery
