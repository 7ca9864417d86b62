#include "model/net/safetensors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>

#include "model/net/strict_json.h"

namespace styled::net {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "tensor bytes are copied as they are");

constexpr std::size_t kLengthBytes = sizeof(std::uint64_t);

// Bytes per element; 0 for an unknown dtype.
std::uint64_t ElementBytes(std::string_view dtype) {
  if (dtype == "F64" || dtype == "I64" || dtype == "U64") return 8;
  if (dtype == "F32" || dtype == "I32" || dtype == "U32") return 4;
  if (dtype == "F16" || dtype == "BF16" || dtype == "I16" || dtype == "U16") return 2;
  if (dtype == "I8" || dtype == "U8" || dtype == "BOOL") return 1;
  return 0;
}

// Reads a JSON number that is a non-negative integer.
bool ReadUnsigned(const json& value, std::uint64_t& number) {
  if (!value.is_number_unsigned()) return false;
  number = value.get<std::uint64_t>();
  return number <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
}

// The beginning of a file with this header: length and text, aligned to 8 bytes.
std::vector<std::byte> WithHeader(std::string header) {
  header.resize((header.size() + 7) / 8 * 8, ' ');
  std::vector<std::byte> file(kLengthBytes + header.size());
  const std::uint64_t length = header.size();
  std::memcpy(file.data(), &length, kLengthBytes);
  std::memcpy(file.data() + kLengthBytes, header.data(), header.size());
  return file;
}

struct Extent {
  std::uint64_t begin, end;
  std::string name;
};

// Fills `tensor` and `extent` from one entry of the header. Returns an empty string, or the fault.
std::string ReadEntry(const json& entry, std::span<const std::byte> data, TensorView& tensor,
                      Extent& extent) {
  if (!entry.is_object()) return "expected an object";
  if (entry.size() != 3 || !entry.contains("dtype") || !entry.contains("shape") ||
      !entry.contains("data_offsets")) {
    return "expected the keys dtype, shape, data_offsets";
  }
  const json& dtype = entry["dtype"];
  if (!dtype.is_string()) return "dtype: expected a string";
  tensor.dtype = dtype.get<std::string>();
  std::uint64_t bytes = ElementBytes(tensor.dtype);
  if (bytes == 0) return "dtype: unknown '" + tensor.dtype + "'";

  const json& shape = entry["shape"];
  if (!shape.is_array()) return "shape: expected an array";
  for (const json& dimension : shape) {
    std::uint64_t size = 0;
    if (!ReadUnsigned(dimension, size)) return "shape: expected non-negative integers";
    // Bounding every partial product by the file's size prevents an overflow.
    if (size != 0 && bytes > data.size() / size) {
      return "shape " + shape.dump() + " is larger than the file";
    }
    bytes *= size;
    tensor.shape.push_back(static_cast<std::int64_t>(size));
  }

  const json& offsets = entry["data_offsets"];
  if (!offsets.is_array() || offsets.size() != 2 || !ReadUnsigned(offsets[0], extent.begin) ||
      !ReadUnsigned(offsets[1], extent.end)) {
    return "data_offsets: expected two non-negative integers";
  }
  if (extent.begin > extent.end || extent.end > data.size()) {
    return "data_offsets " + offsets.dump() + " are outside the file's " +
           std::to_string(data.size()) + " data bytes";
  }
  if (extent.end - extent.begin != bytes) {
    return "data_offsets: expected " + std::to_string(bytes) + " bytes for " + tensor.dtype + " " +
           shape.dump() + ", found " + std::to_string(extent.end - extent.begin);
  }
  tensor.bytes = data.subspan(extent.begin, bytes);
  return "";
}

// The tensors must cover the data exactly once. Returns an empty string, or the fault.
std::string CheckCover(std::vector<Extent>& extents, std::uint64_t data_bytes) {
  std::sort(extents.begin(), extents.end(), [](const Extent& a, const Extent& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.end < b.end;
  });
  std::uint64_t end = 0;
  for (const Extent& extent : extents) {
    const std::string place = "tensor '" + extent.name + "': data_offsets: expected to begin at " +
                              std::to_string(end) + ", found " + std::to_string(extent.begin);
    if (extent.begin < end) return place + " (overlaps another tensor)";
    if (extent.begin > end) return place + " (leaves a hole)";
    end = extent.end;
  }
  if (end != data_bytes) {
    return "expected " + std::to_string(end) + " data bytes, found " + std::to_string(data_bytes);
  }
  return "";
}

}  // namespace

Result<SafetensorsView> ParseSafetensors(std::span<const std::byte> file, const std::string& name) {
  const auto error = [&name](const std::string& what) { return Status::Error(name + ": " + what); };
  if (file.size() < kLengthBytes) {
    return error("truncated: expected an 8-byte header length, found " +
                 std::to_string(file.size()) + " bytes");
  }
  std::uint64_t header_bytes = 0;
  std::memcpy(&header_bytes, file.data(), kLengthBytes);
  const std::uint64_t rest = file.size() - kLengthBytes;
  if (header_bytes > std::min<std::uint64_t>(rest, kMaxHeaderBytes)) {
    return error("header length: expected at most " +
                 std::to_string(std::min<std::uint64_t>(rest, kMaxHeaderBytes)) +
                 " (file and limit), found " + std::to_string(header_bytes));
  }
  json header;
  const std::string wrong = ParseStrictJson(
      {reinterpret_cast<const char*>(file.data() + kLengthBytes), header_bytes}, header);
  if (!wrong.empty()) return error("header: " + wrong);
  if (!header.is_object()) return error("header: expected an object");

  const auto data = file.subspan(kLengthBytes + header_bytes);
  SafetensorsView view;
  std::vector<Extent> extents;
  for (const auto& [key, entry] : header.items()) {
    if (key == "__metadata__") {
      if (!entry.is_object()) return error("__metadata__: expected an object");
      for (const auto& [metadata_key, value] : entry.items()) {
        if (!value.is_string()) {
          return error("__metadata__: key '" + metadata_key + "': expected a string");
        }
        view.metadata[metadata_key] = value.get<std::string>();
      }
      continue;
    }
    Extent extent{0, 0, key};
    const std::string fault = ReadEntry(entry, data, view.tensors[key], extent);
    if (!fault.empty()) return error(std::string("tensor '").append(key).append("': ") + fault);
    extents.push_back(std::move(extent));
  }
  const std::string fault = CheckCover(extents, data.size());
  if (!fault.empty()) return error(fault);
  return view;
}

std::span<const std::byte> TensorBytes(std::span<const std::byte> file) {
  std::uint64_t header = 0;
  if (file.size() < kLengthBytes) return {};
  std::memcpy(&header, file.data(), kLengthBytes);
  return header > file.size() - kLengthBytes ? std::span<const std::byte>()
                                             : file.subspan(kLengthBytes + header);
}

Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& file) {
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status)) return Status::Error(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(status)) {
    return Status::Error(file.string() + ": expected a regular file");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return Status::Error(file.string() + ": cannot be opened");
  stream.seekg(0, std::ios::end);
  const std::streamoff size = stream.tellg();
  if (size < 0 || static_cast<std::uint64_t>(size) > kMaxFileBytes) {
    return Status::Error(file.string() + ": expected at most " + std::to_string(kMaxFileBytes) +
                         " bytes, found " + std::to_string(size));
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(bytes.data()), size);
  if (stream.gcount() != size) return Status::Error(file.string() + ": cannot be read");
  return bytes;
}

std::vector<std::byte> SerializeSafetensors(std::span<const NamedTensor> tensors,
                                            const std::map<std::string, std::string>& metadata) {
  json header = json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  std::uint64_t offset = 0;
  for (const NamedTensor& tensor : tensors) {
    [[maybe_unused]] std::int64_t count = 1;
    for (const std::int64_t dimension : tensor.shape) count *= dimension;
    assert(count == static_cast<std::int64_t>(tensor.values.size()));
    assert(!header.contains(tensor.name));
    const std::uint64_t end = offset + tensor.values.size() * sizeof(float);
    header[tensor.name] = {
        {"dtype", "F32"}, {"shape", tensor.shape}, {"data_offsets", {offset, end}}};
    offset = end;
  }
  std::vector<std::byte> file = WithHeader(header.dump());
  const std::size_t head = file.size();
  file.resize(head + offset);
  std::byte* out = file.data() + head;
  for (const NamedTensor& tensor : tensors) {
    const std::size_t bytes = tensor.values.size() * sizeof(float);
    if (bytes != 0) std::memcpy(out, tensor.values.data(), bytes);
    out += bytes;
  }
  return file;
}

Result<std::vector<std::byte>> WithMetadata(std::span<const std::byte> file,
                                            const std::map<std::string, std::string>& metadata,
                                            const std::string& name) {
  const auto view = ParseSafetensors(file, name);
  if (!view.ok()) return view.status();
  std::uint64_t length = 0;
  std::memcpy(&length, file.data(), kLengthBytes);
  const auto* const text = reinterpret_cast<const char*>(file.data()) + kLengthBytes;
  auto header = nlohmann::ordered_json::parse(text, text + length);  // parsed once, so it is sound
  header["__metadata__"] = metadata;
  std::vector<std::byte> out = WithHeader(header.dump());
  const auto tensors = file.subspan(kLengthBytes + length);
  out.insert(out.end(), tensors.begin(), tensors.end());
  return out;
}

Status WriteFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::filesystem::path beside = file;
  beside += ".part";
  {
    std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    stream.flush();
    if (!stream) return Status::Error(beside.string() + ": cannot be written");
  }
  std::error_code code;
  std::filesystem::rename(beside, file, code);
  if (code) return Status::Error(file.string() + ": " + code.message());
  return Status::Ok();
}

Status WriteSafetensors(const std::filesystem::path& file, std::span<const NamedTensor> tensors,
                        const std::map<std::string, std::string>& metadata) {
  return WriteFile(file, SerializeSafetensors(tensors, metadata));
}

}  // namespace styled::net
