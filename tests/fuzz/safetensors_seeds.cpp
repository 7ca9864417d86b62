// Writes the seeds of safetensors_fuzz to a folder. Usage: main FOLDER
#include <cstdio>
#include <filesystem>
#include <string>

#include "tests/unit/net/erd/random_weights.h"

int main(int argc, char** argv) {
  using styled::erd::RandomWeights;
  using styled::erd::WeightsFile;
  using styled::net::NamedTensor;
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  bool ok = true;
  const auto write = [&](const char* name, const WeightsFile& file) {
    const styled::Status status = styled::net::WriteSafetensors(folder / name, file.tensors,
                                                                {{"styled", file.metadata.dump()}});
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.message().c_str());
    ok = ok && status.ok();
  };
  // Small files, in which a mutation hits the header rather than a weight; and one that loads.
  const WeightsFile whole = RandomWeights(2, 1);
  WeightsFile small = whole;
  std::erase_if(small.tensors, [](const NamedTensor& t) { return t.values.size() > 64; });
  write("small", small);
  small.tensors = {{"feature.mean", {2, 3}, std::vector<float>(6)}, {"empty", {0}, {}}};
  write("tiny", small);
  small.metadata = {{"version", 1}};
  small.tensors.clear();
  write("metadata", small);
  write("whole", whole);
  return ok ? 0 : 1;
}
