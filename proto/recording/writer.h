#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "model/base/status.h"
#include "proto/recording/block.h"

namespace styled::recording {

struct WriterOptions {
  // A block is written when its records reach this size in bytes.
  std::size_t block_size = 64U << 10U;
  std::int64_t block_age_ns = 25'000'000;  // ... or when its first record is this old
};

struct WriterCounts {
  std::uint64_t records = 0, blocks = 0;
  std::uint64_t bytes = 0;      // in the file
  std::uint64_t too_large = 0;  // records left out: larger than kMaxRecordSize
  std::uint64_t lost = 0;       // records of blocks that could not be written
};

// Appends to a recording. Each block is one write(), so killing the process loses only the records
// younger than block_age_ns, and the file stays readable up to there. Data is never synchronized to
// the disk: a power failure may lose what the operating system had not written yet. One thread at a
// time; blocks on the disk; allocates. Pinned by tests/unit/recording/writer_test.cpp.
class FileWriter {
 public:
  // Creates the file and writes its header. Refuses an existing file. Errors name the file.
  static Result<std::unique_ptr<FileWriter>> Create(const std::filesystem::path& file,
                                                    const FileHeader& header,
                                                    const WriterOptions& options = {});
  ~FileWriter();  // calls Flush() and ignores its errors
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  // Adds a record; `now_ns` is on the clock of the records' times. Writes when the block is full or
  // old enough. After an error the block is lost and the file ends with the last whole one; later
  // blocks are tried again.
  Status Add(const Record& record, std::int64_t now_ns);
  // Writes the block if it is old enough.
  Status Poll(std::int64_t now_ns);
  // When Poll has work; INT64_MAX: not before the next Add.
  std::int64_t NextDeadline_ns() const;
  // Writes the block at once.
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
  std::int64_t opened_ns_ = 0;  // when the current block got its first record
  WriterCounts counts_;
};

// Raises the calling thread's priority (nice -10), if the process is permitted to. On a busy
// machine a kill loses the records that wait for the writing thread.
void PreferThisThread() noexcept;

// The clock of time_ns; and the header of a recording that begins now, with both times and the
// program.
std::int64_t MonotonicNow_ns();
FileHeader BeginningNow(const std::string& program, const std::string& version);

// The hash "fnv1a64:0123456789abcdef" over a file's bytes. Errors name the file.
Result<std::string> HashOfFile(const std::filesystem::path& file);

}  // namespace styled::recording
