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

// Where a recording's bytes come from. One thread at a time.
class Input {
 public:
  virtual ~Input() = default;
  virtual std::uint64_t size() const = 0;  // what is in a file when it is opened
  // Reads up to out.size() bytes at `offset` and returns how many; fewer only at the end of the
  // input, or where it cannot be read.
  virtual std::size_t Read(std::uint64_t offset, std::span<std::byte> out) = 0;
};
std::unique_ptr<Input> MemoryInput(std::vector<std::byte> bytes);
Result<std::unique_ptr<Input>> FileInput(const std::filesystem::path& file);

// A stretch of the file that is no block of this recording.
struct Damage {
  std::uint64_t offset = 0, bytes = 0;
};

// What was met on the way so far.
struct ReadCounts {
  std::uint64_t blocks = 0, records = 0;
  std::vector<Damage> damage;  // the first kDamageListed places
  std::uint64_t damaged_places = 0, skipped_bytes = 0;
  std::uint64_t lost_blocks = 0;  // missing by their numbers
  std::uint64_t malformed = 0;    // records, or rests of blocks, that are not what they should be
  std::uint64_t unknown_blocks = 0;  // of a later program; passed over
  std::uint64_t tail_bytes = 0;      // of a block cut short at the end: normal after a kill
};
inline constexpr std::size_t kDamageListed = 32;

// Finds the blocks of a recording, whatever became of it: behind damage it goes on with the next
// whole block.
class BlockScanner {
 public:
  explicit BlockScanner(Input& input) : input_(&input) {}

  // The next whole block and its stored bytes, checksums compared; false at the end. A null
  // `payload` trusts the header's checksum alone: quick.
  bool Next(BlockHeader& header, std::vector<std::byte>* payload, ReadCounts& counts);

 private:
  enum class Candidate { kBlock, kNone, kCutShort };
  Candidate Look(std::uint64_t at, BlockHeader& header, std::vector<std::byte>* payload);
  std::uint64_t FindMagic(std::uint64_t from);  // the input's end where there is none

  Input* input_;
  std::uint64_t offset_ = kPreambleSize;  // where the next block should be
  std::uint64_t next_number_ = 0;
  std::uint64_t doubtful_bytes_ = 0;  // of payloads whose checksum was wrong
};

struct ReaderOptions {
  bool salvage = false;  // read on although the file does not begin like a recording
};

// Reads a recording from its beginning and says how much damage it met; a block cut short at the
// end is the normal end of a killed recorder. Memory is bounded by the largest block. Hostile bytes
// are no danger. One thread at a time; allocates; never throws on content. Pinned by
// tests/unit/recording/reader_test.cpp, fuzzed by tests/fuzz/recording.
class Reader {
 public:
  // Errors name the file, the offset, what was found and what was expected: no file; not a
  // recording; a version that is not kVersion. `name` is for messages.
  static Result<std::unique_ptr<Reader>> Open(const std::filesystem::path& file,
                                              const ReaderOptions& options = {});
  static Result<std::unique_ptr<Reader>> Open(std::unique_ptr<Input> input, const std::string& name,
                                              const ReaderOptions& options = {});
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  // Empty where the header's block is damaged.
  const FileHeader& header() const { return header_; }
  const std::string& name() const { return name_; }

  // The next record; false at the end. `record` keeps its memory; unspecified on false.
  bool Next(Record& record);
  // Back to the first record; counts begin anew.
  void Rewind();
  const ReadCounts& counts() const { return counts_; }

  // First and last time of the records, by the blocks' headers alone: quick. Does not move the
  // reader.
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
  std::size_t raw_at_ = 0;  // of the next record in raw_
  ReadCounts counts_;
};

// "412 bytes skipped in 2 places (the first at offset 96), 1 block missing, cut short by 17 bytes";
// "" where the recording is whole.
std::string DamageText(const ReadCounts& counts);

}  // namespace styled::recording
