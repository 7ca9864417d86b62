#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace styled::oscquery {

// A source as an OSCQuery server describes it.
struct Description {
  std::string name;            // in the network, "styled-stage"
  nlohmann::json tree;         // of TreeOf()
  std::uint16_t osc_port = 0;  // UDP
};

// The answer to a request: an HTTP status, and for 200 a JSON text, else a sentence.
struct Answer {
  unsigned status = 200;
  std::string text;
};

// Answers a GET of `target` ("/VMC/Ext?CONTENTS") by the OSCQuery proposal: a node, one of its
// attributes, or HOST_INFO of any node. `own_address` is the one at which the client has reached
// us; it becomes OSC_IP. 204: the node does not have that attribute. 400: no such attribute, or the
// target is not a path. 404: no such node. Pure; pinned by tests/unit/oscquery/answers_test.cpp.
Answer AnswerTo(std::string_view target, const Description& description,
                const std::string& own_address);

}  // namespace styled::oscquery
