#include "proto/recording/writer.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <limits>

#include "model/base/hash.h"

namespace styled::recording {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::int64_t Read_ns(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

}  // namespace

Result<std::unique_ptr<FileWriter>> FileWriter::Create(const std::filesystem::path& file,
                                                       const FileHeader& header,
                                                       const WriterOptions& options) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
  if (fd < 0 && errno == EEXIST) {
    return Status::Error(file.string() + ": exists already; expected the name of a new file");
  }
  if (fd < 0) {
    return Status::Error(file.string() + ": cannot be written: " + std::strerror(errno));
  }
  std::unique_ptr<FileWriter> writer(new FileWriter(file, options, fd));
  // Preamble and header in one write, so that a file never ends between them.
  const auto preamble = Preamble();
  std::vector<std::byte> begin(preamble.begin(), preamble.end());
  const auto block = writer->builder_.Header(header);
  begin.insert(begin.end(), block.begin(), block.end());
  Status status = writer->Write(begin);
  if (!status.ok()) return status;
  return writer;
}

FileWriter::~FileWriter() {
  (void)Flush();
  close(fd_);
}

Status FileWriter::Add(const Record& record, std::int64_t now_ns) {
  if (!builder_.Add(record)) {
    // The record does not fit into the waiting block, or is larger than any block allows.
    Status status = Flush();
    if (!status.ok()) return status;
    if (!builder_.Add(record)) {
      ++counts_.too_large;
      return Status::Ok();
    }
  }
  ++counts_.records;
  if (builder_.records() == 1) opened_ns_ = now_ns;
  return builder_.raw_size() >= options_.block_size ? Flush() : Poll(now_ns);
}

Status FileWriter::Poll(std::int64_t now_ns) {
  return now_ns >= NextDeadline_ns() ? Flush() : Status::Ok();
}

std::int64_t FileWriter::NextDeadline_ns() const {
  if (builder_.records() == 0) return std::numeric_limits<std::int64_t>::max();
  return opened_ns_ + options_.block_age_ns;
}

Status FileWriter::Flush() {
  const std::uint32_t records = builder_.records();
  if (records == 0) return Status::Ok();
  Status status = Write(builder_.Close());
  if (!status.ok()) {
    counts_.lost += records;
    counts_.records -= records;
  }
  return status;
}

Status FileWriter::Write(std::span<const std::byte> bytes) {
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t size = write(fd_, bytes.data() + written, bytes.size() - written);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      const std::string reason = size < 0 ? std::strerror(errno) : "no bytes accepted";
      // Removes a partial block: a reader would have to search for the next one.
      const auto end = static_cast<off_t>(counts_.bytes);
      if (written > 0 && (ftruncate(fd_, end) != 0 || lseek(fd_, end, SEEK_SET) != end)) {
        counts_.bytes += written;
      }
      return Status::Error(file_.string() + ": offset " + std::to_string(counts_.bytes) +
                           ": cannot be written: " + reason);
    }
    written += static_cast<std::size_t>(size);
  }
  counts_.bytes += bytes.size();
  ++counts_.blocks;
  return Status::Ok();
}

void PreferThisThread() noexcept {
  constexpr int kNice = -10;
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

std::int64_t MonotonicNow_ns() { return Read_ns(CLOCK_MONOTONIC); }

FileHeader BeginningNow(const std::string& program, const std::string& version) {
  FileHeader header;
  header.set_created_time_ns(Read_ns(CLOCK_MONOTONIC));
  header.set_created_unix_ns(Read_ns(CLOCK_REALTIME));
  header.set_program(program);
  header.set_version(version);
  return header;
}

Result<std::string> HashOfFile(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               &std::fclose);
  if (!stream) return Status::Error(file.string() + ": cannot be read: " + std::strerror(errno));
  Fnv1a hash;
  std::vector<unsigned char> buffer(1U << 16U);
  for (std::size_t size = buffer.size(); size == buffer.size();) {
    size = std::fread(buffer.data(), 1, buffer.size(), stream.get());
    hash.Bytes(buffer.data(), size);
  }
  if (std::ferror(stream.get()) != 0) return Status::Error(file.string() + ": cannot be read");
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "fnv1a64:%016llx",
                static_cast<unsigned long long>(hash.value()));
  return std::string(text.data());
}

}  // namespace styled::recording
