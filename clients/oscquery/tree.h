#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace styled::oscquery {

// An OSC method that a source reads.
struct Method {
  std::string address;      // "/VMC/Ext/T"
  std::string types;        // the tags of its arguments, "sfffffff"; "": none, or any
  std::string description;  // for people
};

// The methods that a source of this type reads ("vmc", "vrchat": source.type in styled.toml); none
// for other types. Addresses and tags are taken from messages that the rig's codec has written, so
// they are those that the daemon decodes. Pinned by tests/unit/oscquery/tree_test.cpp.
std::vector<Method> MethodsOf(std::string_view source_type);

// The JSON of the OSCQuery proposal (github.com/Vidvox/OSCQueryProposal) for the node "/":
// FULL_PATH, ACCESS, DESCRIPTION, and CONTENTS of a container or TYPE of a method. Methods are
// write-only.
nlohmann::json TreeOf(const std::vector<Method>& methods, const std::string& description);

}  // namespace styled::oscquery
