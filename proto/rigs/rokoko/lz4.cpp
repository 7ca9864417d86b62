#include "proto/rigs/rokoko/lz4.h"

#include <lz4frame.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <vector>

namespace styled::rokoko {
namespace {

constexpr std::array<unsigned char, 4> kMagic{0x04, 0x22, 0x4D, 0x18};
constexpr std::size_t kMaxText = std::size_t{1} << 20;

LZ4F_preferences_t Preferences(LZ4F_blockSizeID_t block_size) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = block_size;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.autoFlush = 1;
  return preferences;
}

}  // namespace

bool IsLz4Frame(std::span<const std::byte> bytes) noexcept {
  return bytes.size() >= kMagic.size() &&
         std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

struct Lz4Unpacker::Context {
  Context() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&lz4, LZ4F_VERSION)) != 0) {
      throw std::bad_alloc();
    }
  }
  ~Context() { LZ4F_freeDecompressionContext(lz4); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  LZ4F_dctx* lz4 = nullptr;
};

// liblz4 allocates whenever a frame's header requires more memory than any before. The constructor
// decodes the header with the largest requirement: largest blocks, linked.
Lz4Unpacker::Lz4Unpacker() : context_(std::make_unique<Context>()) {
  LZ4F_cctx* writer = nullptr;
  if (LZ4F_isError(LZ4F_createCompressionContext(&writer, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  std::array<std::byte, LZ4F_HEADER_SIZE_MAX> header{};
  const LZ4F_preferences_t preferences = Preferences(LZ4F_max4MB);
  std::size_t size = LZ4F_compressBegin(writer, header.data(), header.size(), &preferences);
  LZ4F_freeCompressionContext(writer);
  std::size_t written = 0;
  if (LZ4F_isError(size) != 0 ||
      LZ4F_isError(LZ4F_decompress(context_->lz4, header.data(), &written, header.data(), &size,
                                   nullptr)) != 0) {
    throw std::bad_alloc();
  }
}

Lz4Unpacker::~Lz4Unpacker() = default;

Lz4Unpacker::Result Lz4Unpacker::Unpack(std::span<const std::byte> packed, std::span<std::byte> out,
                                        std::size_t& size) noexcept {
  if (!IsLz4Frame(packed)) return Result::kBad;  // LZ4's skippable frames are refused, too
  LZ4F_resetDecompressionContext(context_->lz4);
  LZ4F_decompressOptions_t options{};
  options.stableDst = 1;
  std::size_t unpacked = 0;
  while (true) {
    std::size_t taken = packed.size();
    std::size_t given = out.size() - unpacked;
    const std::size_t wanted = LZ4F_decompress(context_->lz4, out.data() + unpacked, &given,
                                               packed.data(), &taken, &options);
    if (LZ4F_isError(wanted) != 0) return Result::kBad;
    packed = packed.subspan(taken);
    unpacked += given;
    if (wanted == 0) break;
    if (taken == 0 && given == 0) {
      return unpacked == out.size() && !packed.empty() ? Result::kTooLong : Result::kBad;
    }
  }
  if (!packed.empty()) return Result::kBad;
  size = unpacked;
  return Result::kOk;
}

struct Lz4Packer::Context {
  Context()
      : preferences(Preferences(LZ4F_max64KB)),
        buffer(LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(kMaxText, &preferences)) {
    if (LZ4F_isError(LZ4F_createCompressionContext(&lz4, LZ4F_VERSION)) != 0) {
      throw std::bad_alloc();
    }
  }
  ~Context() { LZ4F_freeCompressionContext(lz4); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  LZ4F_preferences_t preferences;
  std::vector<std::byte> buffer;  // liblz4 requires room for the worst case
  LZ4F_cctx* lz4 = nullptr;
};

Lz4Packer::Lz4Packer() : context_(std::make_unique<Context>()) {}
Lz4Packer::~Lz4Packer() = default;

std::size_t Lz4Packer::Pack(std::span<const std::byte> text, std::span<std::byte> out) noexcept {
  if (text.size() > kMaxText) return 0;
  auto& [preferences, buffer, lz4] = *context_;
  std::size_t size = 0;
  const auto add = [&size](std::size_t result) {
    const bool good = LZ4F_isError(result) == 0;
    if (good) size += result;
    return good;
  };
  const auto rest = [&] { return std::span(buffer).subspan(size); };
  if (!add(LZ4F_compressBegin(lz4, buffer.data(), buffer.size(), &preferences)) ||
      !add(LZ4F_compressUpdate(lz4, rest().data(), rest().size(), text.data(), text.size(),
                               nullptr)) ||
      !add(LZ4F_compressEnd(lz4, rest().data(), rest().size(), nullptr)) || size > out.size()) {
    return 0;
  }
  std::copy_n(buffer.begin(), size, out.begin());
  return size;
}

}  // namespace styled::rokoko
