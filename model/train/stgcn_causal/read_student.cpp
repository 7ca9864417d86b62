#include "model/train/stgcn_causal/read_student.h"

#include <nlohmann/json.hpp>

#include "model/net/stgcn_causal/space.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/stgcn/read_generator.h"
#include "model/train/stgcn_causal/weights.h"

namespace styled::train::st_gcn_causal {
namespace {

// A network with another memory than the student here would not be the one that is refined.
Status CheckMemory(const nlohmann::json& header, const std::string& name) {
  const nlohmann::json expected{{"spacing", kSpacing},
                                {"memory", static_cast<int>(kMemory)},
                                {"start_frames", static_cast<int>(kStartFrames)}};
  for (const auto& [key, value] : expected.items()) {
    if (header.at(key) == value) continue;
    return Status::Error(name + ": key '" + key + "': expected " + value.dump() + ", found " +
                         header.at(key).dump());
  }
  return Status::Ok();
}

}  // namespace

Result<LoadedStudent> ReadStudent(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  const auto opened = net::ParseWeights(bytes.value(), file.string());
  if (!opened.ok()) return opened.status();
  const std::string& family = opened.value().model.family;
  if (family != kFamily) {
    return Status::Error(file.string() + ": key 'family': expected \"" + kFamily + "\", found \"" +
                         family + "\"");
  }
  const auto network = stgcn_causal::Network::Parse(bytes.value(), file.string());
  if (!network.ok()) return network.status();
  const Status memory = CheckMemory(opened.value().header, file.string());
  if (!memory.ok()) return memory;
  try {
    const torch::NoGradGuard no_grad;
    const net::SafetensorsView& view = opened.value().view;
    st_gcn::Shape shape;
    shape.domains = network.value()->space().domain_count();
    shape.width = network.value()->width();
    LoadedStudent loaded;
    loaded.student = std::make_unique<Student>(shape, torch::kCPU);
    loaded.student->parameters.RequireGradient(false);
    for (const auto& [name, tensor] : loaded.student->parameters.named()) {
      st_gcn::CopyFloats(view, name, tensor);
    }
    loaded.network = network.value();
    st_gcn::CopyStatistics(view, loaded.statistics);
    loaded.codes = torch::empty({shape.domains, shape.code});
    st_gcn::CopyFloats(view, "codes.mean", loaded.codes);
    return loaded;
  } catch (const std::exception& failure) {
    return Status::Error(file.string() + ": " + Reason(failure));
  }
}

std::vector<float> ExampleStyle(const LoadedStudent& network, std::span<const body::Pose> example) {
  net::StyleRequest request;
  request.sources = {{.style = -1, .seed = {}, .reference = example}};
  return stgcn_causal::ExampleSpace(network.network).MakeCode(request);
}

}  // namespace styled::train::st_gcn_causal
