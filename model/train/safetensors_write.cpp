#include "model/train/safetensors_write.h"

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/train/checkpoint.h"

namespace styled::train {
namespace {

using torch::Tensor;
using Json = nlohmann::ordered_json;

constexpr std::size_t kAlignment = 8;  // bytes; the data begin at a multiple of it

// The header before the data: each tensor's type, shape and place, padded with spaces.
std::string Header(const NamedTensors& tensors, const std::string& metadata) {
  Json header;
  header["__metadata__"] = {{"styled", metadata}};
  int64_t offset = 0;
  for (const auto& [name, tensor] : tensors) {
    const int64_t bytes = tensor.numel() * static_cast<int64_t>(sizeof(float));
    header[name] = {{"dtype", "F32"},
                    {"shape", tensor.sizes().vec()},
                    {"data_offsets", {offset, offset + bytes}}};
    offset += bytes;
  }
  std::string text = header.dump();
  text.append((kAlignment - text.size() % kAlignment) % kAlignment, ' ');
  return text;
}

void WriteLittleEndian(uint64_t value, std::ostream& out) {
  for (int byte = 0; byte < 8; ++byte) {
    out.put(static_cast<char>(value & 0xFFU));
    value >>= 8;
  }
}

}  // namespace

Status WriteSafetensors(const NamedTensors& tensors, const std::string& metadata,
                        const std::filesystem::path& file) {
  const std::string header = Header(tensors, metadata);
  std::ofstream out(PartialFile(file), std::ios::binary);
  WriteLittleEndian(header.size(), out);
  out.write(header.data(), static_cast<std::streamsize>(header.size()));
  for (const auto& [name, tensor] : tensors) {
    const Tensor plain = tensor.detach().cpu().to(torch::kFloat32).contiguous();
    out.write(static_cast<const char*>(plain.data_ptr()),
              plain.numel() * static_cast<int64_t>(sizeof(float)));
  }
  out.close();
  if (!out) return Status::Error(file.string() + ": cannot be written");
  return ReplaceByPartial(file);
}

}  // namespace styled::train
