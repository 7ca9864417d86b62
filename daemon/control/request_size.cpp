#include "daemon/control/request_size.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <array>
#include <cstdint>

#include "proto/styled/v1/checkpoint.pb.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::control {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

// The paths of field numbers from a Request to the bytes of a file.
using Path = std::span<const int>;
constexpr std::array kClip{int{v1::Request::kLikeFieldNumber}, int{v1::Like::kClipFieldNumber}};
constexpr std::array kStyleFile{int{v1::Request::kImportStyleFieldNumber},
                                int{v1::ImportStyle::kFileFieldNumber}};
constexpr std::array kState{int{v1::Request::kRestoreCheckpointFieldNumber},
                            int{v1::RestoreCheckpoint::kCheckpointFieldNumber},
                            int{v1::Checkpoint::kStateFieldNumber}};

// Counts the bytes at the end of the path in the message, up to the stream's limit. Leaves the
// stream at the point where it no longer parses as a message.
std::size_t FileBytes(CodedInputStream& in, Path path) {
  std::size_t bytes = 0;
  while (const std::uint32_t tag = in.ReadTag()) {
    if (WireFormatLite::GetTagWireType(tag) != WireFormatLite::WIRETYPE_LENGTH_DELIMITED ||
        WireFormatLite::GetTagFieldNumber(tag) != path.front()) {
      if (!WireFormatLite::SkipField(&in, tag)) break;
      continue;
    }
    std::uint32_t size = 0;
    if (!in.ReadVarint32(&size) || in.BytesUntilLimit() < 0 ||
        size > static_cast<std::uint32_t>(in.BytesUntilLimit())) {
      break;
    }
    if (path.size() == 1) {
      if (!in.Skip(static_cast<int>(size))) break;
      bytes += size;
      continue;
    }
    const auto limit = in.PushLimit(static_cast<int>(size));
    bytes += FileBytes(in, path.subspan(1));
    const bool whole = in.BytesUntilLimit() == 0;
    in.PopLimit(limit);
    if (!whole) break;
  }
  return bytes;
}

std::size_t FileBytes(std::span<const std::byte> request, Path path) {
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(request.data()),
                      static_cast<int>(request.size()));
  in.PushLimit(static_cast<int>(request.size()));
  return FileBytes(in, path);
}

}  // namespace

RequestSize SizeOfRequest(std::span<const std::byte> request) {
  const std::size_t state = FileBytes(request, kState);
  const std::size_t files = FileBytes(request, kClip) + FileBytes(request, kStyleFile) + state;
  return {request.size() - files, state > 0};
}

}  // namespace styled::control
