#include "proto/recording/block.h"

#include <google/protobuf/io/coded_stream.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "model/base/crc32c.h"
#include "proto/rigs/native/header.h"

namespace styled::recording {
namespace {

using google::protobuf::io::CodedOutputStream;
using native::header::Read;
using native::header::Write;

// Offsets of the fields of a block's header (FORMAT.md).
constexpr std::size_t kType = 4, kCompression = 5, kFlags = 6, kStoredSize = 8, kRawSize = 12,
                      kRecords = 16, kPayloadCrc = 20, kFirstTime = 24, kLastTime = 32,
                      kNumber = 40, kHeaderCrc = 44;
constexpr int kCompressionLevel = 3;
constexpr std::size_t kUsualRawSize = 80U << 10U;

}  // namespace

std::array<std::byte, kPreambleSize> Preamble() {
  std::array<std::byte, kPreambleSize> bytes{};
  std::memcpy(bytes.data(), kFileMagic.data(), kFileMagic.size());
  Write<std::uint32_t>(bytes, kFileMagic.size(), kVersion);
  return bytes;
}

std::uint32_t Checksum(std::span<const std::byte> bytes) noexcept { return Crc32c(bytes); }

void EncodeBlockHeader(const BlockHeader& header,
                       std::span<std::byte, kBlockHeaderSize> out) noexcept {
  std::memcpy(out.data(), kBlockMagic.data(), kBlockMagic.size());
  Write(out, kType, header.type);
  Write(out, kCompression, header.compression);
  Write<std::uint16_t>(out, kFlags, 0);
  Write(out, kStoredSize, header.stored_size);
  Write(out, kRawSize, header.raw_size);
  Write(out, kRecords, header.records);
  Write(out, kPayloadCrc, header.payload_crc);
  Write(out, kFirstTime, header.first_time_ns);
  Write(out, kLastTime, header.last_time_ns);
  Write(out, kNumber, header.number);
  Write(out, kHeaderCrc, Checksum(out.first(kHeaderCrc)));
}

std::optional<BlockHeader> DecodeBlockHeader(
    std::span<const std::byte, kBlockHeaderSize> bytes) noexcept {
  if (std::memcmp(bytes.data(), kBlockMagic.data(), kBlockMagic.size()) != 0) return std::nullopt;
  if (Read<std::uint32_t>(bytes, kHeaderCrc) != Checksum(bytes.first(kHeaderCrc))) {
    return std::nullopt;
  }
  BlockHeader header;
  header.type = Read<std::uint8_t>(bytes, kType);
  header.compression = Read<std::uint8_t>(bytes, kCompression);
  header.stored_size = Read<std::uint32_t>(bytes, kStoredSize);
  header.raw_size = Read<std::uint32_t>(bytes, kRawSize);
  header.records = Read<std::uint32_t>(bytes, kRecords);
  header.payload_crc = Read<std::uint32_t>(bytes, kPayloadCrc);
  header.first_time_ns = Read<std::int64_t>(bytes, kFirstTime);
  header.last_time_ns = Read<std::int64_t>(bytes, kLastTime);
  header.number = Read<std::uint32_t>(bytes, kNumber);
  if (header.raw_size > kMaxRawSize || header.stored_size > kMaxRawSize) return std::nullopt;
  return header;
}

struct BlockBuilder::Compressor {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ~Compressor() { ZSTD_freeCCtx(context); }
};

BlockBuilder::BlockBuilder() : compressor_(std::make_unique<Compressor>()) {
  raw_.reserve(kUsualRawSize);
  out_.reserve(kUsualRawSize);
}
BlockBuilder::~BlockBuilder() = default;

bool BlockBuilder::AddMessage(const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  if (size > kMaxRecordSize) return false;
  const std::size_t prefix = CodedOutputStream::VarintSize32(static_cast<std::uint32_t>(size));
  const std::size_t at = raw_.size();
  if (at + prefix + size > kMaxRawSize) return false;
  raw_.resize(at + prefix + size);
  auto* const to = reinterpret_cast<std::uint8_t*>(raw_.data() + at);
  message.SerializeWithCachedSizesToArray(
      CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(size), to));
  ++records_;
  return true;
}

bool BlockBuilder::Add(const Record& record) {
  if (!AddMessage(record)) return false;
  const bool first = records_ == 1;
  first_time_ns_ = first ? record.time_ns() : std::min(first_time_ns_, record.time_ns());
  last_time_ns_ = first ? record.time_ns() : std::max(last_time_ns_, record.time_ns());
  return true;
}

std::span<const std::byte> BlockBuilder::Close() { return Encode(BlockType::kRecords); }

std::span<const std::byte> BlockBuilder::Header(FileHeader header) {
  first_time_ns_ = last_time_ns_ = header.created_time_ns();
  if (!AddMessage(header)) {
    header.clear_config();
    (void)AddMessage(header);
  }
  return Encode(BlockType::kHeader);
}

std::span<const std::byte> BlockBuilder::Encode(BlockType type) {
  const std::size_t bound = ZSTD_compressBound(raw_.size());
  out_.resize(kBlockHeaderSize + std::max(bound, raw_.size()));
  const auto payload = std::span(out_).subspan(kBlockHeaderSize);
  std::size_t stored = ZSTD_compressCCtx(compressor_->context, payload.data(), payload.size(),
                                         raw_.data(), raw_.size(), kCompressionLevel);
  Compression compression = Compression::kZstd;
  // Stored uncompressed if compression fails or does not help.
  if (ZSTD_isError(stored) != 0 || stored >= raw_.size()) {
    std::copy(raw_.begin(), raw_.end(), payload.begin());
    stored = raw_.size();
    compression = Compression::kNone;
  }
  out_.resize(kBlockHeaderSize + stored);
  BlockHeader header;
  header.type = static_cast<std::uint8_t>(type);
  header.compression = static_cast<std::uint8_t>(compression);
  header.stored_size = static_cast<std::uint32_t>(stored);
  header.raw_size = static_cast<std::uint32_t>(raw_.size());
  header.records = records_;
  header.payload_crc = Checksum(std::span(out_).subspan(kBlockHeaderSize));
  header.first_time_ns = first_time_ns_;
  header.last_time_ns = last_time_ns_;
  header.number = number_++;
  EncodeBlockHeader(header, std::span(out_).first<kBlockHeaderSize>());
  raw_.clear();
  records_ = 0;
  return out_;
}

}  // namespace styled::recording
