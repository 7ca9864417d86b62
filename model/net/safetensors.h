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

// The container of the weights file: https://github.com/huggingface/safetensors. Start-up code: it
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

// The largest header and file that are read; weights of 32 styles need 0.1 MB and 4.5 MB.
inline constexpr std::size_t kMaxHeaderBytes = std::size_t{4} << 20;
inline constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;

// Refuses a header that is too long, not JSON or has a key twice, a dtype it does not know, offsets
// outside the file, tensors that overlap or leave a hole, and sizes that do not fit the shape.
// `name` begins every error. `file` must outlive the view.
Result<SafetensorsView> ParseSafetensors(std::span<const std::byte> file, const std::string& name);

// The whole file, at most kMaxFileBytes; anything but a regular file is refused.
Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& file);

// A tensor to be written, F32; values.size() is the product of the shape.
struct NamedTensor {
  std::string name;
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

// The bytes of a file with these tensors, in this order. Programmer errors are asserted.
std::vector<std::byte> SerializeSafetensors(std::span<const NamedTensor> tensors,
                                            const std::map<std::string, std::string>& metadata);

// Writes them beside `file` and renames, so that a reader sees the old file or the new one.
Status WriteSafetensors(const std::filesystem::path& file, std::span<const NamedTensor> tensors,
                        const std::map<std::string, std::string>& metadata);

}  // namespace styled::net
