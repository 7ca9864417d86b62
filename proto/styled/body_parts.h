#pragma once

#include "model/body/parts.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled {

// v1::BodyPart and model/body/parts.h: the same parts in the same order, from 1, and 0 for all.
inline body::Parts PartsOf(const google::protobuf::RepeatedField<int>& message) {
  body::Parts parts = 0;
  for (const int part : message) {
    if (part == v1::BODY_PART_ALL) parts |= body::kAllParts;
    if (part > 0 && part <= body::kPartCount) parts |= body::Bit(static_cast<body::Part>(part - 1));
  }
  return parts;
}

inline void AddParts(body::Parts parts, google::protobuf::RepeatedField<int>& message) {
  if (parts == body::kAllParts) return message.Add(v1::BODY_PART_ALL);
  for (int part = 0; part < body::kPartCount; ++part) {
    if ((parts >> part & 1) != 0) message.Add(part + 1);
  }
}

}  // namespace styled
