#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "model/base/status.h"
#include "proto/recording/block.h"

namespace styled::recording {

struct WriterOptions {
  std::size_t block_size = 64U << 10U;     // bytes of records after which a block is written
  std::int64_t block_age_ns = 25'000'000;  // ... and the longest that a record waits for that
};

struct WriterCounts {
  std::uint64_t records = 0, blocks = 0;
  std::uint64_t bytes = 0;      // in the file
  std::uint64_t too_large = 0;  // records left out: beyond kMaxRecordSize
  std::uint64_t lost = 0;       // records of blocks that could not be written
};

// Appends to a recording. Each block is one write(): who kills the process loses what is younger
// than block_age_ns, and leaves a file that reads up to there. Nothing is ever synchronized to the
// disk: a power failure may take what the operating system had not written yet.
// One thread at a time; blocks on the disk; allocates. Pinned by
// tests/unit/recording/writer_test.cpp.
class FileWriter {
 public:
  // Makes the file and writes its header. Refuses a file that exists. Errors name the file.
  static Result<std::unique_ptr<FileWriter>> Create(const std::filesystem::path& file,
                                                    const FileHeader& header,
                                                    const WriterOptions& options = {});
  ~FileWriter();  // Flush(), whatever comes of it
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  // `now_ns`: the clock of the records' times. Writes when the block is full or old. On an error
  // the block is lost and the file ends with the last whole one; later blocks are tried again.
  Status Add(const Record& record, std::int64_t now_ns);
  // Writes when there is something old enough.
  Status Poll(std::int64_t now_ns);
  // When Poll has something to do; INT64_MAX: not before the next Add.
  std::int64_t NextDeadline_ns() const;
  Status Flush();

  const WriterCounts& counts() const { return counts_; }
  const std::filesystem::path& file() const { return file_; }

 private:
  FileWriter(std::filesystem::path file, const WriterOptions& options, int fd)
      : file_(std::move(file)), options_(options), fd_(fd) {}
  Status Write(std::span<const std::byte> bytes);

  std::filesystem::path file_;
  WriterOptions options_;
  int fd_;
  BlockBuilder builder_;
  std::int64_t opened_ns_ = 0;  // when the block at hand got its first record
  WriterCounts counts_;
};

// On a busy machine what waits for its writer's turn is what a kill loses: the calling thread gets
// its turns before others' (nice -10), where the process may ask for that.
void PreferThisThread() noexcept;

// The clock of time_ns, and the header of a recording that begins now: both times and who writes.
std::int64_t MonotonicNow_ns();
FileHeader BeginningNow(const std::string& program, const std::string& version);

// "fnv1a64:0123456789abcdef" over a file's bytes; an error names the file.
Result<std::string> HashOfFile(const std::filesystem::path& file);

}  // namespace styled::recording
