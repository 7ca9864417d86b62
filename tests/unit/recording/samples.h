#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/recording/block.h"

// Recordings made in memory, for the unit tests and, as seeds, for the fuzzer.
namespace styled::recording::testing {

using Bytes = std::vector<std::byte>;

inline void Append(Bytes& bytes, std::span<const std::byte> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

// Record number `i`: of every kind in turn, each different.
inline Record MakeRecord(int i) {
  Record record;
  record.set_time_ns(1'000'000'000 + i * 1'000'000LL);
  const std::string number = std::to_string(i);
  switch (i % 4) {
    case 0: {
      Arrival& arrival = *record.mutable_arrival();
      arrival.set_source("rig");
      arrival.set_type("udp");
      arrival.set_listen("udp://127.0.0.1:7000");
      arrival.set_peer("10.0.0.1:5000");
      arrival.set_datagram("datagram " + number + std::string(20, '\xF5'));
      break;
    }
    case 1:
      record.mutable_published()->set_topic("styled/rig.a/rig/");
      record.mutable_published()->set_payload("payload " + number);
      break;
    case 2: {
      Command& command = *record.mutable_command();
      command.mutable_request()->set_performer("rig.a");
      command.mutable_request()->mutable_preset()->set_name("scene " + number);
      command.add_applied()->set_first_sequence(static_cast<std::uint64_t>(i));
      break;
    }
    default:
      record.mutable_note()->set_text("note " + number);
  }
  return record;
}

struct Sample {
  Bytes bytes;
  // Where each block begins; [0] is the header's. One more entry: the end.
  std::vector<std::size_t> blocks;
  int records = 0;
};

inline FileHeader MakeHeader() {
  FileHeader header;
  header.set_created_time_ns(999'000'000);
  header.set_created_unix_ns(1'700'000'000'000'000'000);
  header.set_program("sample");
  header.set_description("a small recording");
  return header;
}

// `blocks` blocks of `per_block` records each, number i MakeRecord(i).
inline Sample MakeSample(int blocks = 3, int per_block = 4) {
  Sample sample;
  const auto preamble = Preamble();
  Append(sample.bytes, preamble);
  BlockBuilder builder;
  sample.blocks.push_back(sample.bytes.size());
  Append(sample.bytes, builder.Header(MakeHeader()));
  for (int block = 0; block < blocks; ++block) {
    for (int i = 0; i < per_block; ++i) (void)builder.Add(MakeRecord(sample.records++));
    sample.blocks.push_back(sample.bytes.size());
    Append(sample.bytes, builder.Close());
  }
  sample.blocks.push_back(sample.bytes.size());
  return sample;
}

}  // namespace styled::recording::testing
