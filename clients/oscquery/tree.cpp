#include "clients/oscquery/tree.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>

#include "proto/rigs/types.h"
#include "proto/rigs/vmc/device.h"
#include "proto/rigs/vmc/vmc.h"
#include "proto/rigs/vrchat/vrchat.h"

namespace styled::oscquery {
namespace {

using nlohmann::json;

constexpr int kNoValue = 0, kWriteOnly = 2;  // ACCESS

// Adds the method to which the codec writes `message`.
template <typename Message>
void Add(const Message& message, const std::string& description, std::vector<Method>& methods) {
  std::array<std::byte, 512> buffer;
  vmc::osc::Writer writer(buffer);
  Put(message, writer);
  vmc::osc::Reader reader(std::span<const std::byte>(buffer).first(writer.size()));
  vmc::osc::Message written;
  if (reader.Next(written) != vmc::osc::Reader::Step::kMessage) return;
  methods.push_back({std::string(written.address), std::string(written.types), description});
}

std::vector<Method> MethodsOfVmc() {
  std::vector<Method> methods;
  Add(vmc::Available{}, "whether an avatar is loaded, calibrated, tracked", methods);
  Add(vmc::Time{}, "the sender's clock, seconds", methods);
  Add(vmc::Root{}, "the avatar's place: name, position in metres, quaternion x y z w", methods);
  Add(vmc::Bone{"Hips", {}}, "a bone by its name in HumanBodyBones, against its parent", methods);
  Add(vmc::Blend{"Joy", 0}, "a facial expression by its name, 0 to 1", methods);
  Add(vmc::BlendApply{}, "the expressions are complete", methods);
  using Kind = vmc::Device::Kind;
  Add(vmc::Device{Kind::kHmd, "1", {}}, "a display by its serial, in the room", methods);
  Add(vmc::Device{Kind::kController, "1", {}}, "a controller, likewise", methods);
  Add(vmc::Device{Kind::kTracker, "1", {}}, "a tracker, likewise", methods);
  methods.push_back({"/VMC/Thru", "s", "all messages below it are passed on to the avatar"});
  return methods;
}

std::vector<Method> MethodsOfVrChat() {
  std::vector<Method> methods;
  for (int index = 0; index <= vrchat::kTrackers; ++index) {
    Add(vrchat::Tracker{index, false, {}}, "position in metres, Unity's axes", methods);
    Add(vrchat::Tracker{index, true, {}}, "Euler angles in degrees, Unity's axes", methods);
  }
  using vrchat::System;
  for (const System device : {System::kHead, System::kLeftWrist, System::kRightWrist}) {
    Add(vrchat::SystemPose{device, {}, {}}, "position in metres, then Euler angles in degrees",
        methods);
  }
  return methods;
}

json Node(const std::string& path) { return {{"FULL_PATH", path}, {"ACCESS", kNoValue}}; }

}  // namespace

std::vector<Method> MethodsOf(std::string_view source_type) {
  if (source_type == rigs::kVmc.datagrams) return MethodsOfVmc();
  if (source_type == rigs::kVrChat.datagrams) return MethodsOfVrChat();
  return {};
}

json TreeOf(const std::vector<Method>& methods, const std::string& description) {
  json root = Node("/");
  root["DESCRIPTION"] = description;
  for (const Method& method : methods) {
    json* node = &root;
    for (std::size_t begin = 1; begin <= method.address.size();) {
      const std::size_t end = std::min(method.address.find('/', begin), method.address.size());
      json& children = (*node)["CONTENTS"];
      const std::string name = method.address.substr(begin, end - begin);
      if (!children.contains(name)) children[name] = Node(method.address.substr(0, end));
      node = &children[name];
      begin = end + 1;
    }
    (*node)["ACCESS"] = kWriteOnly;
    (*node)["DESCRIPTION"] = method.description;
    if (!method.types.empty()) (*node)["TYPE"] = method.types;
  }
  return root;
}

}  // namespace styled::oscquery
