#include "proto/rigs/mocopi/mocopi.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "proto/rigs/result_name.h"

namespace styled::mocopi {
namespace {

using Bytes = std::span<const std::byte>;
using R = DecodeResult;

constexpr std::size_t kChunkHeader = 8;
constexpr std::string_view kFormat = "sony motion format";
constexpr float kMaxTime_s = 1e9F;

// A chunk's four letters as the little-endian number on the wire.
constexpr std::uint32_t Tag(std::string_view letters) {
  std::uint32_t tag = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    tag |= std::uint32_t{static_cast<unsigned char>(letters[i])} << (8 * i);
  }
  return tag;
}
constexpr std::uint32_t kHead = Tag("head"), kFtyp = Tag("ftyp"), kVrsn = Tag("vrsn");
constexpr std::uint32_t kSndf = Tag("sndf"), kIpad = Tag("ipad"), kRcvp = Tag("rcvp");
constexpr std::uint32_t kSkdf = Tag("skdf"), kBons = Tag("bons"), kBndt = Tag("bndt");
constexpr std::uint32_t kBnid = Tag("bnid"), kPbid = Tag("pbid"), kTran = Tag("tran");
constexpr std::uint32_t kFram = Tag("fram"), kFnum = Tag("fnum"), kTime = Tag("time");
constexpr std::uint32_t kUttm = Tag("uttm"), kTmcd = Tag("tmcd"), kBtrs = Tag("btrs");
constexpr std::uint32_t kBtdt = Tag("btdt");

// `bytes` must hold at least sizeof(T).
template <typename T>
T Load(Bytes bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  }
  if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(value));
  } else if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<double>(value);
  } else {
    return static_cast<T>(value);
  }
}

struct Chunk {
  std::uint32_t tag = 0;
  Bytes payload;
};

// Removes the chunk at the front of `rest`; returns false if it does not fit.
bool Next(Bytes& rest, Chunk& chunk) noexcept {
  if (rest.size() < kChunkHeader) return false;
  const std::size_t length = Load<std::uint32_t>(rest);
  chunk.tag = Load<std::uint32_t>(rest.subspan(4));
  if (length > rest.size() - kChunkHeader) return false;
  chunk.payload = rest.subspan(kChunkHeader, length);
  rest = rest.subspan(kChunkHeader + length);
  return true;
}

// Collects the payloads of `container`'s chunks with the given tags; other chunks are skipped.
template <std::size_t kFields>
R Collect(Bytes container, const std::array<std::uint32_t, kFields>& tags,
          std::array<std::optional<Bytes>, kFields>& fields) noexcept {
  Chunk chunk;
  while (!container.empty()) {
    if (!Next(container, chunk)) return R::kCutChunk;
    for (std::size_t i = 0; i < kFields; ++i) {
      if (tags[i] != chunk.tag) continue;
      if (fields[i]) return R::kRepeated;
      fields[i] = chunk.payload;
    }
  }
  return R::kOk;
}

template <typename T>
R ReadField(const std::optional<Bytes>& field, T& value) noexcept {
  if (!field) return R::kMissing;
  if (field->size() != sizeof(T)) return R::kBadSize;
  value = Load<T>(*field);
  return R::kOk;
}

template <std::size_t kSize>
R ReadField(const std::optional<Bytes>& field, std::array<std::byte, kSize>& value) noexcept {
  if (!field) return R::kMissing;
  if (field->size() != kSize) return R::kBadSize;
  std::copy_n(field->begin(), kSize, value.begin());
  return R::kOk;
}

R ReadField(const std::optional<Bytes>& field, Transform& value) noexcept {
  if (!field) return R::kMissing;
  if (field->size() != 7 * sizeof(float)) return R::kBadSize;
  for (std::size_t i = 0; i < 7; ++i) {
    const auto number = Load<float>(field->subspan(sizeof(float) * i));
    (i < 4 ? value.rotation[i] : value.position_m[i - 4]) = number;
  }
  return R::kOk;
}

R First(std::initializer_list<R> results) noexcept {
  const auto* const bad =
      std::find_if(results.begin(), results.end(), [](R r) { return r != R::kOk; });
  return bad == results.end() ? R::kOk : *bad;
}

R ReadHead(Bytes& rest) noexcept {
  Chunk head;
  if (!Next(rest, head) || head.tag != kHead) return R::kNotMocopi;
  std::array<std::optional<Bytes>, 2> fields;
  if (const R r = Collect<2>(head.payload, {kFtyp, kVrsn}, fields); r != R::kOk) return r;
  if (!fields[0] || fields[0]->size() != kFormat.size() ||
      std::memcmp(fields[0]->data(), kFormat.data(), kFormat.size()) != 0) {
    return R::kNotMocopi;
  }
  std::uint8_t version = 0;
  if (const R r = ReadField(fields[1], version); r != R::kOk) return r;
  return version == 1 ? R::kOk : R::kBadVersion;
}

R ReadSender(Bytes payload, Sender& sender) noexcept {
  std::array<std::optional<Bytes>, 2> fields;
  if (const R r = Collect<2>(payload, {kIpad, kRcvp}, fields); r != R::kOk) return r;
  return First({ReadField(fields[0], sender.address), ReadField(fields[1], sender.port)});
}

// Calls `read(payload, id)` for every chunk `tag` of a list that must name each bone once.
template <typename ReadBone>
R ReadBones(const std::optional<Bytes>& list, std::uint32_t tag, const ReadBone& read) noexcept {
  if (!list) return R::kMissing;
  std::uint32_t seen = 0;
  Bytes rest = *list;
  Chunk chunk;
  while (!rest.empty()) {
    if (!Next(rest, chunk)) return R::kCutChunk;
    if (chunk.tag != tag) continue;
    std::array<std::optional<Bytes>, 3> fields;
    if (const R r = Collect<3>(chunk.payload, {kBnid, kTran, kPbid}, fields); r != R::kOk) return r;
    std::uint16_t id = 0;
    if (const R r = ReadField(fields[0], id); r != R::kOk) return r;
    if (id >= kBones || (seen >> id & 1U) != 0) return R::kBadBone;
    seen |= 1U << id;
    if (const R r = read(fields, id); r != R::kOk) return r;
  }
  return seen == (1U << kBones) - 1 ? R::kOk : R::kMissing;
}

using BoneFields = std::array<std::optional<Bytes>, 3>;

R ReadSkeleton(Bytes payload, Skeleton& skeleton) noexcept {
  std::array<std::optional<Bytes>, 1> fields;
  if (const R r = Collect<1>(payload, {kBons}, fields); r != R::kOk) return r;
  return ReadBones(fields[0], kBndt, [&skeleton](const BoneFields& bone, std::uint16_t id) {
    std::int16_t parent = 0;
    const R r = First({ReadField(bone[1], skeleton[id].rest), ReadField(bone[2], parent)});
    if (r != R::kOk) return r;
    if (id == 0 ? parent != -1 : parent < 0 || parent >= id) return R::kBadBone;
    skeleton[id].parent = parent;
    return R::kOk;
  });
}

R ReadFrame(Bytes payload, Frame& frame) noexcept {
  std::array<std::optional<Bytes>, 5> fields;
  if (const R r = Collect<5>(payload, {kFnum, kTime, kUttm, kTmcd, kBtrs}, fields); r != R::kOk) {
    return r;
  }
  const R r = First({ReadField(fields[0], frame.number), ReadField(fields[1], frame.time_s)});
  if (r != R::kOk) return r;
  if (!(frame.time_s >= 0 && frame.time_s <= kMaxTime_s)) return R::kBadTime;
  frame.unix_time_s.reset();
  frame.timecode.reset();
  if (fields[2]) {
    if (ReadField(fields[2], frame.unix_time_s.emplace()) != R::kOk) return R::kBadSize;
  }
  if (fields[3]) {
    if (ReadField(fields[3], frame.timecode.emplace()) != R::kOk) return R::kBadSize;
  }
  return ReadBones(fields[4], kBtdt, [&frame](const BoneFields& bone, std::uint16_t id) {
    return ReadField(bone[1], frame.bones[id]);
  });
}

// Writes consecutive chunks into bytes whose size was checked before.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : out_(out) {}

  std::size_t size() const noexcept { return size_; }

  // Begins a chunk, which ends with the matching End().
  std::size_t Begin(std::uint32_t tag) noexcept {
    const std::size_t at = size_;
    Put(std::uint32_t{0});
    Put(tag);
    return at;
  }
  void End(std::size_t at) noexcept {
    const std::size_t end = size_;
    size_ = at;
    Put(static_cast<std::uint32_t>(end - at - kChunkHeader));
    size_ = end;
  }
  template <typename T>
  void Field(std::uint32_t tag, const T& value) noexcept {
    const std::size_t at = Begin(tag);
    Put(value);
    End(at);
  }

 private:
  template <typename T>
  void Put(const T& value) noexcept {
    if constexpr (std::is_same_v<T, float>) {
      Put(std::bit_cast<std::uint32_t>(value));
    } else if constexpr (std::is_same_v<T, double>) {
      Put(std::bit_cast<std::uint64_t>(value));
    } else if constexpr (std::is_integral_v<T>) {
      const auto bits = static_cast<std::uint64_t>(value);
      for (std::size_t i = 0; i < sizeof(T); ++i) Put(static_cast<std::byte>(bits >> (8 * i)));
    } else if constexpr (std::is_same_v<T, Transform>) {
      for (const float number : value.rotation) Put(number);
      for (const float number : value.position_m) Put(number);
    } else if constexpr (std::is_same_v<T, std::string_view>) {
      for (const char letter : value) Put(static_cast<std::byte>(letter));
    } else if constexpr (std::is_same_v<T, std::byte>) {
      assert(size_ < out_.size());
      out_[size_++] = value;
    } else {
      for (const std::byte byte : value) Put(byte);
    }
  }

  std::span<std::byte> out_;
  std::size_t size_ = 0;
};

void WriteHeads(const Sender& sender, Writer& writer) noexcept {
  const std::size_t head = writer.Begin(kHead);
  writer.Field(kFtyp, kFormat);
  writer.Field(kVrsn, std::uint8_t{1});
  writer.End(head);
  const std::size_t sndf = writer.Begin(kSndf);
  writer.Field(kIpad, sender.address);
  writer.Field(kRcvp, sender.port);
  writer.End(sndf);
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "not_mocopi", "bad_version", "cut_chunk", "bad_size",
                                   "missing", "repeated", "bad_bone", "bad_time"});
}

DecodeResult Decode(Bytes bytes, Datagram& datagram) noexcept {
  if (const R r = ReadHead(bytes); r != R::kOk) return r;
  std::array<std::optional<Bytes>, 3> parts;
  if (const R r = Collect<3>(bytes, {kSndf, kSkdf, kFram}, parts); r != R::kOk) return r;
  datagram.sender = Sender();
  if (parts[0]) {
    if (const R r = ReadSender(*parts[0], datagram.sender); r != R::kOk) return r;
  }
  if (parts[1] && parts[2]) return R::kRepeated;
  if (parts[1]) {
    datagram.kind = Datagram::Kind::kSkeleton;
    return ReadSkeleton(*parts[1], datagram.skeleton);
  }
  if (!parts[2]) return R::kMissing;
  datagram.kind = Datagram::Kind::kFrame;
  return ReadFrame(*parts[2], datagram.frame);
}

std::size_t Encode(const Sender& sender, const Skeleton& skeleton,
                   std::span<std::byte> out) noexcept {
  if (out.size() < kSkeletonSize) return 0;
  Writer writer(out);
  WriteHeads(sender, writer);
  const std::size_t skdf = writer.Begin(kSkdf);
  const std::size_t bons = writer.Begin(kBons);
  for (std::size_t id = 0; id < kBones; ++id) {
    const std::size_t bone = writer.Begin(kBndt);
    writer.Field(kBnid, static_cast<std::uint16_t>(id));
    writer.Field(kPbid, static_cast<std::int16_t>(skeleton[id].parent));
    writer.Field(kTran, skeleton[id].rest);
    writer.End(bone);
  }
  writer.End(bons);
  writer.End(skdf);
  return writer.size();
}

std::size_t Encode(const Sender& sender, const Frame& frame, std::span<std::byte> out) noexcept {
  std::size_t size = kFrameSize;
  if (!frame.unix_time_s) size -= kChunkHeader + sizeof(double);
  if (frame.timecode) size += kChunkHeader + frame.timecode->size();
  if (out.size() < size) return 0;
  Writer writer(out);
  WriteHeads(sender, writer);
  const std::size_t fram = writer.Begin(kFram);
  writer.Field(kFnum, frame.number);
  writer.Field(kTime, frame.time_s);
  if (frame.unix_time_s) writer.Field(kUttm, *frame.unix_time_s);
  if (frame.timecode) writer.Field(kTmcd, *frame.timecode);
  const std::size_t btrs = writer.Begin(kBtrs);
  for (std::size_t id = 0; id < kBones; ++id) {
    const std::size_t bone = writer.Begin(kBtdt);
    writer.Field(kBnid, static_cast<std::uint16_t>(id));
    writer.Field(kTran, frame.bones[id]);
    writer.End(bone);
  }
  writer.End(btrs);
  writer.End(fram);
  return writer.size();
}

Skeleton UsualSkeleton() noexcept {
  Skeleton skeleton;
  for (std::size_t id = 0; id < kBones; ++id) {
    const BoneRow& row = kBoneTable[id];
    skeleton[id].parent = row.parent;
    skeleton[id].rest.position_m = {row.x_m, row.y_m, row.z_m};
  }
  return skeleton;
}

}  // namespace styled::mocopi
