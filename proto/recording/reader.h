#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "proto/recording/block.h"

namespace styled::recording {

// The source of a recording's bytes. One thread at a time.
class Input {
 public:
  virtual ~Input() = default;
  virtual std::uint64_t size() const = 0;  // of a file: its size when it was opened
  // Reads up to out.size() bytes at `offset` and returns their number. It is smaller only at the
  // end of the input or after a read error.
  virtual std::size_t Read(std::uint64_t offset, std::span<std::byte> out) = 0;
};
std::unique_ptr<Input> MemoryInput(std::vector<std::byte> bytes);
Result<std::unique_ptr<Input>> FileInput(const std::filesystem::path& file);

// A part of the file that is not a block of this recording.
struct Damage {
  std::uint64_t offset = 0, bytes = 0;
};

// The damage and the counts that the reader has found so far.
struct ReadCounts {
  std::uint64_t blocks = 0, records = 0;
  std::vector<Damage> damage;  // the first kDamageListed places
  std::uint64_t damaged_places = 0, skipped_bytes = 0;
  std::uint64_t lost_blocks = 0;     // missing, by the block numbers
  std::uint64_t malformed = 0;       // records, or remainders of blocks, that are invalid
  std::uint64_t unknown_blocks = 0;  // block types of a later program; skipped
  std::uint64_t tail_bytes = 0;      // of a block that is cut short at the end: normal after a kill
};
inline constexpr std::size_t kDamageListed = 32;

// Finds the blocks of a recording in any state. After damage it continues with the next whole
// block.
class BlockScanner {
 public:
  explicit BlockScanner(Input& input) : input_(&input) {}

  // Finds the next whole block, and reads its stored bytes into `payload` if its checksum is right;
  // returns false at the end. With a null `payload` it checks the header's checksum only, which is
  // fast.
  bool Next(BlockHeader& header, std::vector<std::byte>* payload, ReadCounts& counts);

 private:
  enum class Candidate { kBlock, kNone, kCutShort };
  Candidate Look(std::uint64_t at, BlockHeader& header, std::vector<std::byte>* payload);
  std::uint64_t FindMagic(std::uint64_t from);  // the input's end if there is none

  Input* input_;
  std::uint64_t offset_ = kPreambleSize;  // where the next block is expected
  std::uint64_t next_number_ = 0;
  std::uint64_t doubtful_bytes_ = 0;  // of payloads with a wrong checksum
};

struct ReaderOptions {
  bool salvage = false;  // continue although the file does not begin like a recording
};

// Reads a recording from its beginning and reports the damage found. A block that is cut short at
// the end is the normal end after a recorder was killed. Memory is bounded by the largest block.
// Input may be hostile. One thread at a time; allocates; never throws because of content. Pinned by
// tests/unit/recording/reader_test.cpp, fuzzed by tests/fuzz/recording.
class Reader {
 public:
  // Errors name the file, the offset, what was found and what was expected: file missing, not a
  // recording, or a version other than kVersion. `name` is used in messages.
  static Result<std::unique_ptr<Reader>> Open(const std::filesystem::path& file,
                                              const ReaderOptions& options = {});
  static Result<std::unique_ptr<Reader>> Open(std::unique_ptr<Input> input, const std::string& name,
                                              const ReaderOptions& options = {});
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  // Empty if the header's block is damaged.
  const FileHeader& header() const { return header_; }
  const std::string& name() const { return name_; }

  // Reads the next record; returns false at the end. `record` keeps its memory; its content is
  // unspecified on false.
  bool Next(Record& record);
  // Goes back to the first record and resets the counts.
  void Rewind();
  const ReadCounts& counts() const { return counts_; }

  // First and last time of the records, from the blocks' headers only, which is fast. Does not move
  // the reader.
  struct TimeRange {
    bool any = false;  // false: no records
    std::int64_t first_ns = 0, last_ns = 0;
  };
  TimeRange FindTimeRange() const;

 private:
  Reader(std::unique_ptr<Input> input, std::string name);
  bool NextBlock();
  bool Decompress(const BlockHeader& header);

  struct Decompressor;
  std::unique_ptr<Input> input_;
  std::string name_;
  std::unique_ptr<Decompressor> decompressor_;
  BlockScanner scanner_;
  FileHeader header_;
  std::vector<std::byte> stored_, raw_;
  std::size_t raw_at_ = 0;  // offset of the next record in raw_
  ReadCounts counts_;
};

// Describes the damage, e.g. "412 bytes skipped in 2 places (the first at offset 96), 1 block
// missing"; "" if the recording is whole.
std::string DamageText(const ReadCounts& counts);

}  // namespace styled::recording
