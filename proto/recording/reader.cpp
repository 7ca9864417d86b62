#include "proto/recording/reader.h"

#include <fcntl.h>
#include <google/protobuf/io/coded_stream.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "proto/rigs/native/header.h"

namespace styled::recording {
namespace {

constexpr std::size_t kSearchStep = 4U << 10U;
// After a block with a wrong checksum the search continues within it, because bytes of it may be
// missing. After this many such bytes it continues behind it, which bounds the time for any file.
constexpr std::uint64_t kPatience = 64U << 20U;

class Memory final : public Input {
 public:
  explicit Memory(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  std::size_t Read(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset >= bytes_.size()) return 0;
    const auto from = std::span(bytes_).subspan(offset);
    const std::size_t count = std::min(from.size(), out.size());
    std::copy_n(from.begin(), count, out.begin());
    return count;
  }

 private:
  std::vector<std::byte> bytes_;
};

class File final : public Input {
 public:
  File(int fd, std::uint64_t size) : fd_(fd), size_(size) {}
  ~File() override { close(fd_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  std::uint64_t size() const override { return size_; }
  std::size_t Read(std::uint64_t offset, std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t got =
          pread(fd_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  int fd_;
  std::uint64_t size_;
};

std::string Hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    char digits[4];
    std::snprintf(digits, sizeof digits, "%02X ", std::to_integer<unsigned>(byte));
    text += digits;
  }
  if (!text.empty()) text.pop_back();
  return text.empty() ? "no bytes" : text;
}

Status CheckPreamble(Input& input, const std::string& name) {
  std::array<std::byte, kPreambleSize> found{};
  const std::size_t size = input.Read(0, found);
  const auto expected = Preamble();
  const auto magic = std::span(expected).first(kFileMagic.size());
  const auto at_magic = std::span(found).first(std::min(size, kFileMagic.size()));
  if (!std::equal(at_magic.begin(), at_magic.end(), magic.begin())) {
    return Status::Error(name + ": offset 0: found " + Hex(at_magic) +
                         ", expected a recording's first bytes, " + Hex(magic));
  }
  if (size < kPreambleSize) {
    return Status::Error(name + ": offset " + std::to_string(size) + ": found the end, expected " +
                         std::to_string(kPreambleSize) + " bytes of preamble");
  }
  const auto version = native::header::Read<std::uint32_t>(found, kFileMagic.size());
  if (version != kVersion) {
    return Status::Error(name + ": offset " + std::to_string(kFileMagic.size()) +
                         ": found version " + std::to_string(version) + ", expected " +
                         std::to_string(kVersion));
  }
  return Status::Ok();
}

}  // namespace

std::unique_ptr<Input> MemoryInput(std::vector<std::byte> bytes) {
  return std::make_unique<Memory>(std::move(bytes));
}

Result<std::unique_ptr<Input>> FileInput(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return Status::Error(file.string() + ": cannot be read: " + std::strerror(errno));
  struct stat about {};
  if (fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) {
    close(fd);
    return Status::Error(file.string() + ": not a regular file; expected a recording");
  }
  return std::unique_ptr<Input>(
      std::make_unique<File>(fd, static_cast<std::uint64_t>(about.st_size)));
}

BlockScanner::Candidate BlockScanner::Look(std::uint64_t at, BlockHeader& header,
                                           std::vector<std::byte>* payload) {
  std::array<std::byte, kBlockHeaderSize> bytes{};
  const std::size_t size = input_->Read(at, bytes);
  if (size < kBlockHeaderSize) {
    // Fewer bytes than a header: cut short if they begin like one.
    const std::size_t compared = std::min(size, kBlockMagic.size());
    const bool begins = std::memcmp(bytes.data(), kBlockMagic.data(), compared) == 0;
    return begins ? Candidate::kCutShort : Candidate::kNone;
  }
  const auto found = DecodeBlockHeader(bytes);
  if (!found) return Candidate::kNone;
  if (input_->size() - at - kBlockHeaderSize < found->stored_size) return Candidate::kCutShort;
  if (payload != nullptr) {
    payload->resize(found->stored_size);
    if (input_->Read(at + kBlockHeaderSize, *payload) != payload->size() ||
        Checksum(*payload) != found->payload_crc) {
      doubtful_bytes_ += payload->size();
      if (doubtful_bytes_ > kPatience) offset_ = at + kBlockHeaderSize + payload->size();
      return Candidate::kNone;
    }
  }
  header = *found;
  return Candidate::kBlock;
}

std::uint64_t BlockScanner::FindMagic(std::uint64_t from) {
  std::array<std::byte, kSearchStep> buffer;
  const auto* const magic = reinterpret_cast<const std::byte*>(kBlockMagic.data());
  while (from < input_->size()) {
    const std::size_t size = input_->Read(from, buffer);
    const auto end = buffer.begin() + static_cast<std::ptrdiff_t>(size);
    const auto found = std::search(buffer.begin(), end, magic, magic + kBlockMagic.size());
    if (found != end) return from + static_cast<std::uint64_t>(found - buffer.begin());
    if (size < buffer.size()) break;
    from += size - (kBlockMagic.size() - 1);  // the magic may span two steps
  }
  return input_->size();
}

bool BlockScanner::Next(BlockHeader& header, std::vector<std::byte>* payload, ReadCounts& counts) {
  const std::uint64_t begin = offset_, size = input_->size();
  const auto damaged = [&](std::uint64_t end) {
    if (end <= begin) return;
    if (counts.damage.size() < kDamageListed) counts.damage.push_back({begin, end - begin});
    ++counts.damaged_places;
    counts.skipped_bytes += end - begin;
  };
  std::uint64_t cut = size;  // the first block whose end is missing
  for (std::uint64_t at = begin; at < size;) {
    const Candidate candidate = Look(at, header, payload);
    if (candidate == Candidate::kBlock) {
      damaged(at);
      offset_ = at + kBlockHeaderSize + header.stored_size;
      if (header.number > next_number_) counts.lost_blocks += header.number - next_number_;
      next_number_ = std::uint64_t{header.number} + 1;
      ++counts.blocks;
      return true;
    }
    // A later whole block proves that this was damage; only without one it is the cut-off end.
    if (candidate == Candidate::kCutShort) cut = std::min(cut, at);
    at = FindMagic(std::max(at + 1, offset_));
  }
  offset_ = size;
  damaged(cut);
  if (cut < size) counts.tail_bytes = size - cut;
  return false;
}

struct Reader::Decompressor {
  ZSTD_DCtx* context = ZSTD_createDCtx();
  ~Decompressor() { ZSTD_freeDCtx(context); }
};

Reader::Reader(std::unique_ptr<Input> input, std::string name)
    : input_(std::move(input)),
      name_(std::move(name)),
      decompressor_(std::make_unique<Decompressor>()),
      scanner_(*input_) {}
Reader::~Reader() = default;

Result<std::unique_ptr<Reader>> Reader::Open(const std::filesystem::path& file,
                                             const ReaderOptions& options) {
  auto input = FileInput(file);
  if (!input.ok()) return input.status();
  return Open(std::move(input.value()), file.string(), options);
}

Result<std::unique_ptr<Reader>> Reader::Open(std::unique_ptr<Input> input, const std::string& name,
                                             const ReaderOptions& options) {
  Status status = CheckPreamble(*input, name);
  if (!status.ok() && !options.salvage) return status;
  std::unique_ptr<Reader> reader(new Reader(std::move(input), name));
  reader->Rewind();
  return reader;
}

void Reader::Rewind() {
  scanner_ = BlockScanner(*input_);
  counts_ = {};
  raw_.clear();
  raw_at_ = 0;
  // Reads the header, or the first records if the header is damaged.
  (void)NextBlock();
}

bool Reader::Decompress(const BlockHeader& header) {
  if (header.compression == static_cast<std::uint8_t>(Compression::kNone)) {
    raw_.swap(stored_);
    return raw_.size() == header.raw_size;
  }
  if (header.compression != static_cast<std::uint8_t>(Compression::kZstd)) return false;
  raw_.resize(header.raw_size);
  return ZSTD_decompressDCtx(decompressor_->context, raw_.data(), raw_.size(), stored_.data(),
                             stored_.size()) == raw_.size();
}

// Fills raw_ with the next block of records; returns false at the end. Also reads the header if
// that is the first block.
bool Reader::NextBlock() {
  BlockHeader header;
  raw_at_ = 0;
  raw_.clear();
  while (scanner_.Next(header, &stored_, counts_)) {
    const bool first = counts_.blocks == 1;
    const bool is_header = header.type == static_cast<std::uint8_t>(BlockType::kHeader);
    if (!(is_header && first) && header.type != static_cast<std::uint8_t>(BlockType::kRecords)) {
      ++counts_.unknown_blocks;
      continue;
    }
    if (!Decompress(header)) {
      ++counts_.malformed;
      raw_.clear();
      continue;
    }
    if (!is_header) return true;
    google::protobuf::io::CodedInputStream stream(
        reinterpret_cast<const std::uint8_t*>(raw_.data()), static_cast<int>(raw_.size()));
    std::uint32_t size = 0;
    if (!stream.ReadVarint32(&size) ||
        size != raw_.size() - static_cast<std::size_t>(stream.CurrentPosition()) ||
        !header_.ParseFromCodedStream(&stream)) {
      ++counts_.malformed;
      header_.Clear();
    }
    raw_.clear();
    return true;
  }
  return false;
}

bool Reader::Next(Record& record) {
  while (true) {
    while (raw_at_ == raw_.size()) {
      if (!NextBlock()) return false;
    }
    const auto left = std::span(raw_).subspan(raw_at_);
    const auto* const data = reinterpret_cast<const std::uint8_t*>(left.data());
    google::protobuf::io::CodedInputStream stream(data, static_cast<int>(left.size()));
    std::uint32_t size = 0;
    const bool sized = stream.ReadVarint32(&size);
    const auto prefix = static_cast<std::size_t>(stream.CurrentPosition());
    if (!sized || size > left.size() - prefix) {
      ++counts_.malformed;
      raw_at_ = raw_.size();
      continue;
    }
    raw_at_ += prefix + size;
    if (record.ParseFromArray(data + prefix, static_cast<int>(size))) {
      ++counts_.records;
      return true;
    }
    ++counts_.malformed;
  }
}

Reader::TimeRange Reader::FindTimeRange() const {
  BlockScanner scanner(*input_);
  BlockHeader header;
  ReadCounts counts;
  TimeRange range;
  while (scanner.Next(header, nullptr, counts)) {
    if (header.type != static_cast<std::uint8_t>(BlockType::kRecords)) continue;
    range.first_ns =
        range.any ? std::min(range.first_ns, header.first_time_ns) : header.first_time_ns;
    range.last_ns = range.any ? std::max(range.last_ns, header.last_time_ns) : header.last_time_ns;
    range.any = true;
  }
  return range;
}

std::string DamageText(const ReadCounts& counts) {
  std::string text;
  const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  const auto number = [](std::uint64_t count, const std::string& word) {
    return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
  };
  if (counts.damaged_places > 0) {
    say(number(counts.skipped_bytes, "byte") + " skipped in " +
        number(counts.damaged_places, "place") + " (the first at offset " +
        std::to_string(counts.damage.front().offset) + ")");
  }
  if (counts.lost_blocks > 0) say(number(counts.lost_blocks, "block") + " missing");
  if (counts.malformed > 0) say(number(counts.malformed, "record") + " malformed");
  if (counts.unknown_blocks > 0)
    say(number(counts.unknown_blocks, "block") + " of an unknown type");
  if (counts.tail_bytes > 0) {
    say("the last block is cut short (" + number(counts.tail_bytes, "byte") + " of it are here)");
  }
  return text;
}

}  // namespace styled::recording
