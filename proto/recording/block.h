#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "proto/recording/recording.pb.h"

// The byte format of a recording (FORMAT.md): a preamble, then blocks. Nothing here depends on
// files. Pinned by tests/unit/recording/block_test.cpp and, independently, by
// tests/unit/recording/read_recording.py.
namespace styled::recording {

inline constexpr std::array<std::uint8_t, 8> kFileMagic{0x89, 'S', 'T', 'Y', 'R', 0x0D, 0x0A, 0x1A};
inline constexpr std::uint32_t kVersion = 1;
inline constexpr std::size_t kPreambleSize = 16;

inline constexpr std::array<std::uint8_t, 4> kBlockMagic{0xF5, 'S', 'B', 'K'};
inline constexpr std::size_t kBlockHeaderSize = 48;
inline constexpr std::size_t kMaxRecordSize = 2U << 20U;  // serialized
inline constexpr std::size_t kMaxRawSize = 4U << 20U;     // of a block, decompressed

enum class BlockType : std::uint8_t {
  kHeader = 1,   // one FileHeader; the file's first block
  kRecords = 2,  // Records
};
enum class Compression : std::uint8_t { kNone = 0, kZstd = 1 };

struct BlockHeader {
  std::uint8_t type = 0;           // a BlockType; later programs may add types
  std::uint8_t compression = 0;    // Compression
  std::uint32_t stored_size = 0;   // bytes after the header
  std::uint32_t raw_size = 0;      // size of these bytes when decompressed
  std::uint32_t records = 0;       // messages in the block
  std::uint32_t payload_crc = 0;   // CRC-32C of the stored bytes
  std::int64_t first_time_ns = 0;  // smallest and largest time_ns of the block's records
  std::int64_t last_time_ns = 0;
  std::uint32_t number = 0;  // +1 per block, from 0
};

std::array<std::byte, kPreambleSize> Preamble();

void EncodeBlockHeader(const BlockHeader& header,
                       std::span<std::byte, kBlockHeaderSize> out) noexcept;
// Empty if the bytes are not a valid block header: wrong magic or checksum, or sizes over
// kMaxRawSize.
std::optional<BlockHeader> DecodeBlockHeader(
    std::span<const std::byte, kBlockHeaderSize> bytes) noexcept;
// CRC-32C (model/base/crc32c.h).
std::uint32_t Checksum(std::span<const std::byte> bytes) noexcept;

// Collects messages and encodes them as blocks. One thread at a time; allocates.
class BlockBuilder {
 public:
  BlockBuilder();
  ~BlockBuilder();
  BlockBuilder(const BlockBuilder&) = delete;
  BlockBuilder& operator=(const BlockBuilder&) = delete;

  // Returns false and adds nothing if the record is larger than kMaxRecordSize or would make the
  // block larger than kMaxRawSize.
  [[nodiscard]] bool Add(const Record& record);

  std::uint32_t records() const { return records_; }
  std::size_t raw_size() const { return raw_.size(); }

  // Encodes the added messages as one block, valid until the next call of any function here.
  // Afterwards the builder is empty, and its next block has the next number.
  std::span<const std::byte> Close();
  // Encodes the file's first block, number 0. Call it before anything else. A header larger than
  // kMaxRecordSize loses its configuration text.
  std::span<const std::byte> Header(FileHeader header);

 private:
  struct Compressor;
  bool AddMessage(const google::protobuf::MessageLite& message);
  std::span<const std::byte> Encode(BlockType type);

  std::unique_ptr<Compressor> compressor_;
  std::vector<std::byte> raw_, out_;
  std::uint32_t records_ = 0, number_ = 0;
  std::int64_t first_time_ns_ = 0, last_time_ns_ = 0;
};

}  // namespace styled::recording
