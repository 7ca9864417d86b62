#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"

namespace styled::net {

// The container of weights files: https://github.com/huggingface/safetensors. Start-up code: it
// allocates, and no input makes it throw or read outside the file.

// One tensor of a parsed file. `bytes` points into the file's bytes, little-endian, row-major.
struct TensorView {
  std::string dtype;  // "F32", "F16", ...
  std::vector<std::int64_t> shape;
  std::span<const std::byte> bytes;
};

struct SafetensorsView {
  std::map<std::string, TensorView> tensors;
  std::map<std::string, std::string> metadata;  // the header's __metadata__
};

// The largest header and file to be read. Weights of 32 styles need 0.1 MB and 4.5 MB.
inline constexpr std::size_t kMaxHeaderBytes = std::size_t{4} << 20;
inline constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;

// Parses a file; `file` must outlive the view. Refuses a header that is too long, is not JSON or
// has a key twice; an unknown dtype; offsets outside the file; tensors that overlap or leave a
// hole; and sizes that do not match the shape. Every error begins with `name`.
Result<SafetensorsView> ParseSafetensors(std::span<const std::byte> file, const std::string& name);

// The bytes of all tensors, after the header. They do not change when only metadata is rewritten.
// Empty if the file is too short.
std::span<const std::byte> TensorBytes(std::span<const std::byte> file);

// Reads a whole file of at most kMaxFileBytes; anything but a regular file is refused.
Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& file);

// A tensor to be written as F32; values.size() is the product of the shape.
struct NamedTensor {
  std::string name;
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

// The bytes of a file with these tensors, in this order. Invalid arguments are asserted.
std::vector<std::byte> SerializeSafetensors(std::span<const NamedTensor> tensors,
                                            const std::map<std::string, std::string>& metadata);

// A file with the same tensors, byte for byte and in the same order, and other metadata; or the
// error of ParseSafetensors.
Result<std::vector<std::byte>> WithMetadata(std::span<const std::byte> file,
                                            const std::map<std::string, std::string>& metadata,
                                            const std::string& name);

// Writes a file to a temporary one beside it and renames that, so a reader sees the old file or the
// new one, never a part.
Status WriteFile(const std::filesystem::path& file, std::span<const std::byte> bytes);
// The same for these tensors.
Status WriteSafetensors(const std::filesystem::path& file, std::span<const NamedTensor> tensors,
                        const std::map<std::string, std::string>& metadata);

}  // namespace styled::net
