#include "daemon/styles/networks.h"

#include <array>
#include <span>
#include <system_error>
#include <utility>

#include "daemon/styles/style_list.h"
#include "model/base/crc32c.h"
#include "model/net/load.h"
#include "model/net/safetensors.h"
#include "model/net/several.h"
#include "model/net/shipped_weights.h"
#include "model/trial/trial.h"
#include "proto/recording/writer.h"

namespace styled::pipeline {
namespace {

constexpr const char* kNone = "none";
// The networks beside the main one: the key of each, the shipped file that an empty value means,
// and whether it means that beside other weights than the shipped ones, too: only a file that may
// be used commercially does not change what may be done with them.
struct Beside {
  const char* key;
  const char* shipped;
  std::string config::Model::*file;
  bool with_others;
};
constexpr std::array kBeside{Beside{"examples", "graph", &config::Model::examples, false},
                             Beside{"gaits", "open", &config::Model::gaits, true}};

bool Rounds(const config::Model& model) { return model.precision != "float32"; }

// The suffix of the file name when the weights are rounded; "" when they are not.
std::string RoundedTo(const config::Model& model, std::span<const std::byte> bytes) {
  return Rounds(model) && net::CanBeRounded(bytes) ? " in " + model.precision : "";
}

// Whether an empty value of that key means its shipped file beside `main`: the shipped weights, or
// others that make no styles from examples by themselves. A file that cannot be read is not
// reported here, but where it is loaded.
bool MeansShipped(const Beside& beside, const std::filesystem::path& main) {
  if (net::IsShippedDefault(main)) return true;
  if (!beside.with_others) return false;
  const auto bytes = net::ReadFile(main);
  return bytes.ok() && !net::KnowsStyleSpace(bytes.value());
}

}  // namespace

Result<std::vector<std::filesystem::path>> FindWeightsFiles(const config::Model& model) {
  std::vector<std::filesystem::path> files;
  const auto main = net::FindWeights(model.weights);
  if (!main.ok()) return main.status();
  files.push_back(main.value());
  for (const Beside& beside : kBeside) {
    const std::string& wanted = model.*beside.file;
    if (wanted == kNone) continue;
    if (wanted.empty() && !MeansShipped(beside, main.value())) continue;
    const auto found = net::FindWeights(wanted.empty() ? beside.shipped : wanted);
    if (!found.ok() && wanted.empty()) continue;  // not installed
    if (!found.ok()) {
      return Status::Error("model." + std::string(beside.key) + ": " + found.status().message());
    }
    std::error_code error;  // the shipped default may be the file of `gaits`
    if (std::filesystem::equivalent(found.value(), main.value(), error)) continue;
    files.push_back(found.value());
  }
  return files;
}

Result<WeightsLabel> LabelOf(const config::Model& model,
                             const std::vector<std::filesystem::path>& files) {
  WeightsLabel label;
  for (const std::filesystem::path& file : files) {
    const auto hash = recording::HashOfFile(file);
    if (!hash.ok()) return hash.status();
    std::string rounded;
    if (Rounds(model)) {
      const auto bytes = net::ReadFile(file);
      if (!bytes.ok()) return bytes.status();
      rounded = RoundedTo(model, bytes.value());
    }
    label.names += (label.names.empty() ? "" : "+") + file.filename().string() + rounded;
    label.hashes += (label.hashes.empty() ? "" : "+") + hash.value() + rounded;
  }
  return label;
}

Result<Networks> ReadNetworks(const config::Model& model,
                              std::optional<std::uint32_t> running_crc) {
  const auto files = FindWeightsFiles(model);
  if (!files.ok()) return files.status();
  Networks networks;
  std::vector<std::vector<std::byte>> contents;
  std::vector<std::uint32_t> tensors, parts;
  for (const std::filesystem::path& file : files.value()) {
    auto bytes = net::ReadFile(file);
    if (!bytes.ok()) return bytes.status();
    tensors.push_back(Crc32c(net::TensorBytes(bytes.value())));
    parts.push_back(Crc32c(bytes.value()));
    const std::string rounded = RoundedTo(model, bytes.value());
    // Weights that are rounded are others: no checkpoint of one network fits the other.
    if (!rounded.empty()) parts.push_back(Crc32c(std::as_bytes(std::span(rounded))));
    contents.push_back(std::move(bytes.value()));
    networks.names += (networks.names.empty() ? "" : "+") + file.filename().string() + rounded;
  }
  networks.crc = parts.size() == 1 ? parts.front() : Crc32c(std::as_bytes(std::span(parts)));
  if (networks.crc == running_crc) return networks;
  std::vector<net::NamedNetwork> named;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    auto network =
        trial::Parse(contents[i], files.value()[i].string(), net::PrecisionNamed(model.precision));
    if (!network.ok()) return network.status();
    if (i > 0 && network.value()->space() == nullptr) {
      return Status::Error(files.value()[i].string() + ": family \"" +
                           network.value()->model().family +
                           "\" takes no examples; expected weights that have a style encoder");
    }
    networks.terms.push_back(net::ReadTerms(files.value()[i], network.value()->model().licence));
    named.push_back({files.value()[i].stem().string(), std::move(network.value())});
  }
  // As in several_space.h: the first network whose codes depend on its weights, if there is one.
  networks.examples_hash = HashText(tensors.front());
  for (std::size_t i = named.size(); i > 0; --i) {
    const net::StyleSpace* const space = named[i - 1].network->space();
    if (space == nullptr) continue;
    const bool portable = !space->Portable(space->MakeCode({.sources = {{.style = 0}}})).empty();
    if (!portable) networks.examples_hash = HashText(tensors[i - 1]);
  }
  auto network = net::Combine(std::move(named));
  if (!network.ok()) return network.status();
  networks.network = std::move(network.value());
  networks.own_styles = static_cast<int>(networks.network->model().styles.size());
  return networks;
}

}  // namespace styled::pipeline
