#include "tests/parity/reference_file.h"

#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "model/base/crc32c.h"
#include "model/net/safetensors.h"

namespace styled::parity {
namespace {

// Rows of floats with their frame numbers; these are small enough to be exact as floats.
std::vector<float> Load(const net::SafetensorsView& view, const std::string& name,
                        std::int64_t columns) {
  const auto found = view.tensors.find(name);
  if (found == view.tensors.end() || found->second.dtype != "F32" ||
      found->second.shape.size() != 2 || found->second.shape[1] != columns) {
    throw std::runtime_error("expected tensor " + name + ", F32, [T, " + std::to_string(columns) +
                             "]");
  }
  std::vector<float> values(found->second.bytes.size() / sizeof(float));
  std::memcpy(values.data(), found->second.bytes.data(), found->second.bytes.size());
  return values;
}

template <std::size_t N>
void Append(const std::array<float, N>& row, net::NamedTensor& tensor) {
  tensor.values.insert(tensor.values.end(), row.begin(), row.end());
  ++tensor.shape[0];
}

}  // namespace

Result<std::string> FileCrc(const std::filesystem::path& file) {
  const auto bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  char text[9];
  std::snprintf(text, sizeof text, "%08x", Crc32c(bytes.value()));
  return std::string(text);
}

Status WriteReference(const Reference& reference, const std::filesystem::path& file) {
  net::NamedTensor output_frame{"outputs.frame", {0, 1}, {}};
  net::NamedTensor heading{"outputs.heading_rad", {0, 1}, {}};
  net::NamedTensor reconstruction{"outputs.reconstruction", {0, erd::kRotationFeatures}, {}};
  net::NamedTensor styled{"outputs.styled", {0, erd::kRotationFeatures}, {}};
  for (const auto& [frame, outputs] : reference.outputs) {
    Append(std::array{static_cast<float>(frame)}, output_frame);
    Append(std::array{outputs.heading_rad}, heading);
    Append(outputs.reconstruction, reconstruction);
    Append(outputs.styled, styled);
  }
  net::NamedTensor feature_frame{"features.frame", {0, 1}, {}};
  net::NamedTensor features{"features", {0, erd::kFeatureCount}, {}};
  for (const auto& [frame, values] : reference.features) {
    Append(std::array{static_cast<float>(frame)}, feature_frame);
    Append(values, features);
  }
  std::vector<net::NamedTensor> tensors{output_frame, heading, reconstruction, styled};
  if (!reference.features.empty()) tensors.insert(tensors.end(), {feature_frame, features});
  return net::WriteSafetensors(file, tensors,
                               {{"schedule", reference.schedule},
                                {"clip", reference.clip_crc},
                                {"weights", reference.weights_crc},
                                {"frames", std::to_string(reference.frames)}});
}

Result<Reference> ReadReference(const std::filesystem::path& file) {
  const auto bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  const auto parsed = net::ParseSafetensors(bytes.value(), file.string());
  if (!parsed.ok()) return parsed.status();
  const net::SafetensorsView& view = parsed.value();
  try {
    Reference reference;
    reference.schedule = view.metadata.at("schedule");
    reference.clip_crc = view.metadata.at("clip");
    reference.weights_crc = view.metadata.at("weights");
    reference.frames = std::stoi(view.metadata.at("frames"));
    const auto frames = Load(view, "outputs.frame", 1);
    const auto headings = Load(view, "outputs.heading_rad", 1);
    const auto reconstructions = Load(view, "outputs.reconstruction", erd::kRotationFeatures);
    const auto styled = Load(view, "outputs.styled", erd::kRotationFeatures);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      Outputs& outputs = reference.outputs[static_cast<int>(frames[i])];
      outputs.heading_rad = headings.at(i);
      for (std::size_t k = 0; k < outputs.styled.size(); ++k) {
        outputs.reconstruction[k] = reconstructions.at(i * outputs.styled.size() + k);
        outputs.styled[k] = styled.at(i * outputs.styled.size() + k);
      }
    }
    if (view.tensors.contains("features")) {
      const auto feature_frames = Load(view, "features.frame", 1);
      const auto features = Load(view, "features", erd::kFeatureCount);
      for (std::size_t i = 0; i < feature_frames.size(); ++i) {
        erd::Features& row = reference.features[static_cast<int>(feature_frames[i])];
        for (std::size_t k = 0; k < row.size(); ++k) row[k] = features.at(i * row.size() + k);
      }
    }
    return reference;
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": not a parity reference: " + error.what());
  }
}

}  // namespace styled::parity
