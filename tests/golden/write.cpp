// styled_golden_write TAKE NAME: makes golden recording NAME from the daemon's recording TAKE,
// packed as small as the format allows, and its expected output. record.sh calls it.
#include <filesystem>
#include <iostream>
#include <limits>

#include "proto/recording/writer.h"
#include "tests/golden/golden.h"

namespace {

using styled::Status;

const std::string kFolder = STYLED_SOURCE_DIR "/tests/golden/";
const std::string kWeights = STYLED_SOURCE_DIR "/model/weights/v2.safetensors";

// Writes blocks of the largest allowed size, which zstd compresses better.
Status Repack(styled::recording::Reader& take, const std::string& file) {
  std::filesystem::remove(file);
  // The weights that the expected output is made with: other ones, or ones whose metadata changed.
  auto hash = styled::recording::HashOfFile(kWeights);
  if (!hash.ok()) return hash.status();
  auto header = take.header();
  header.set_weights(std::filesystem::path(kWeights).filename().string());
  header.set_weights_hash(hash.value());
  auto writer = styled::recording::FileWriter::Create(
      file, header,
      {.block_size = 2U << 20U, .block_age_ns = std::numeric_limits<std::int64_t>::max()});
  if (!writer.ok()) return writer.status();
  styled::recording::Record record;
  while (take.Next(record)) {
    Status status = writer.value()->Add(record, 0);
    if (!status.ok()) return status;
  }
  return writer.value()->Flush();
}

Status Write(const std::string& take, const std::string& name) {
  auto reader = styled::recording::Reader::Open(take);
  if (!reader.ok()) return reader.status();
  const std::string file = kFolder + "recordings/" + name + ".styrec";
  Status status = Repack(*reader.value(), file);
  if (!status.ok()) return status;
  reader = styled::recording::Reader::Open(file);
  if (!reader.ok()) return reader.status();
  const auto played = styled::golden::Replay(*reader.value(), kWeights);
  if (!played.ok()) return played.status();
  std::cout << name << ": " << std::filesystem::file_size(file) << " bytes";
  for (const auto& [topic, frames] : played.value().frames) {
    std::cout << ", " << topic << " " << frames.size();
  }
  std::cout << "\n";
  return styled::golden::WriteExpected(played.value(), kFolder + "expected/" + name + ".styrec");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: styled_golden_write TAKE NAME\n";
    return 2;
  }
  const Status status = Write(argv[1], argv[2]);
  if (!status.ok()) std::cerr << "styled_golden_write: " << status.message() << "\n";
  return status.ok() ? 0 : 1;
}
