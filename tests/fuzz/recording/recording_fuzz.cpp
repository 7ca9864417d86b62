// Fuzzes the reader of recordings: with the input unchanged, and with corrected checksums of
// everything that looks like a block, to reach the code behind the checks. Seeds:
// tests/unit/recording/samples.h.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "proto/recording/reader.h"
#include "proto/rigs/native/header.h"

namespace {

using styled::recording::DecodeBlockHeader;
using styled::recording::kBlockHeaderSize;
using styled::recording::kPreambleSize;
using styled::recording::Reader;
using styled::recording::Record;
namespace header = styled::native::header;

void Require(bool condition) {
  if (!condition) std::abort();
}

void ReadAll(const std::vector<std::byte>& bytes) {
  const auto reader =
      Reader::Open(styled::recording::MemoryInput(bytes), "fuzz", {.salvage = true});
  Require(reader.ok());
  Record record;
  std::uint64_t records = 0;
  while (reader.value()->Next(record)) ++records;
  const auto& counts = reader.value()->counts();
  Require(counts.records == records);
  // Every byte belongs to a block, to a skipped part, or to the tail.
  const std::uint64_t behind = bytes.size() > kPreambleSize ? bytes.size() - kPreambleSize : 0;
  Require(counts.skipped_bytes + counts.tail_bytes + counts.blocks * kBlockHeaderSize <= behind);
  Require(behind == 0 || counts.blocks > 0 || counts.skipped_bytes + counts.tail_bytes == behind);
  Require((counts.damaged_places == 0) == (counts.skipped_bytes == 0));
  reader.value()->Rewind();
  while (reader.value()->Next(record)) --records;
  Require(records == 0);
  (void)reader.value()->FindTimeRange();
}

void Reseal(std::vector<std::byte>& bytes) {
  for (std::size_t at = kPreambleSize; at + kBlockHeaderSize <= bytes.size();) {
    const auto block = std::span(bytes).subspan(at);
    const std::size_t stored = std::min<std::size_t>(header::Read<std::uint32_t>(block, 8),
                                                     block.size() - kBlockHeaderSize);
    std::copy_n(reinterpret_cast<const std::byte*>(styled::recording::kBlockMagic.data()), 4,
                block.begin());
    header::Write(block, 8, static_cast<std::uint32_t>(stored));
    header::Write(block, 20, styled::recording::Checksum(block.subspan(kBlockHeaderSize, stored)));
    header::Write(block, 44, styled::recording::Checksum(block.first(44)));
    at += kBlockHeaderSize + stored;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static auto* const silence = google::protobuf::SetLogHandler(nullptr);
  (void)silence;
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  ReadAll(bytes);
  Reseal(bytes);
  ReadAll(bytes);
  return 0;
}
