// Runs a fuzz target without libFuzzer: every seed unchanged, then seeded mutations of each (the
// same seeds give the same run). Usage: main [--runs=N] [--seed=N] [--seconds=S] FILE-OR-FOLDER...
// Ends after S seconds, or after N mutations per seed if N is given. With neither, it ends after
// 20,000 mutations per seed or 4 s.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Blob = std::vector<std::uint8_t>;

struct Options {
  std::optional<long> runs;  // mutations of each seed
  std::optional<double> seconds;
  unsigned seed = 1;
  std::vector<Blob> seeds;
};

Blob Read(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    std::fprintf(stderr, "%s: cannot be opened\n", file.c_str());
    std::exit(2);
  }
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void AddSeeds(const std::string& place, std::vector<Blob>& seeds) {
  if (!std::filesystem::is_directory(place)) return seeds.push_back(Read(place));
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(place)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());  // directory order differs between machines
  for (const auto& file : files) seeds.push_back(Read(file));
}

Options Parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--runs=")) {
      options.runs = std::atol(argument.c_str() + 7);
    } else if (argument.starts_with("--seed=")) {
      options.seed = static_cast<unsigned>(std::atol(argument.c_str() + 7));
    } else if (argument.starts_with("--seconds=")) {
      options.seconds = std::atof(argument.c_str() + 10);
    } else {
      AddSeeds(argument, options.seeds);
    }
  }
  return options;
}

// One small change, of the kinds that most often break length fields, counts and signs.
void Mutate(Blob& bytes, std::mt19937& random) {
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  constexpr std::uint8_t kTelling[] = {0x00, 0x01, 0x7f, 0x80, 0xff, '0', '9', '-', '"', '{'};
  if (bytes.empty()) bytes.push_back(static_cast<std::uint8_t>(random()));
  // Half of all changes are in the first 64 bytes, where headers are.
  const std::size_t reach = below(2) == 0 ? std::min<std::size_t>(bytes.size(), 64) : bytes.size();
  const std::size_t at = below(reach);
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  switch (below(7)) {
    case 0:
      *place ^= static_cast<std::uint8_t>(1U << below(8));
      break;
    case 1:
      *place = static_cast<std::uint8_t>(random());
      break;
    case 2:
      *place = kTelling[below(std::size(kTelling))];
      break;
    case 3:
      bytes.insert(place, kTelling[below(std::size(kTelling))]);
      break;
    case 4: {  // cut a piece out
      const std::size_t length = std::min(bytes.size() - at, 1 + below(16));
      bytes.erase(place, place + static_cast<std::ptrdiff_t>(length));
      break;
    }
    case 5:  // truncate
      bytes.resize(at);
      break;
    default: {  // repeat a piece
      const std::size_t length = std::min(bytes.size() - at, 1 + below(32));
      const Blob piece(place, place + static_cast<std::ptrdiff_t>(length));
      bytes.insert(place, piece.begin(), piece.end());
      break;
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = Parse(argc, argv);
  if (options.seeds.empty()) {
    std::fprintf(stderr, "usage: %s [--runs=N] [--seed=N] [--seconds=S] FILE-OR-FOLDER...\n",
                 argv[0]);
    return 2;
  }
  for (const Blob& seed : options.seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());

  // In rounds over all seeds, so that a run that is cut short has used each seed.
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto end = begin + std::chrono::duration<double>(options.seconds.value_or(4));
  // If only a time is given, the number of mutations is unlimited.
  const long runs =
      options.runs.value_or(options.seconds ? std::numeric_limits<long>::max() : 20000);
  std::mt19937 random(options.seed);
  long inputs = static_cast<long>(options.seeds.size());
  for (long run = 0; run < runs && Clock::now() < end; ++run) {
    for (const Blob& seed : options.seeds) {
      Blob bytes = seed;
      for (unsigned changes = 1 + random() % 4; changes > 0; --changes) Mutate(bytes, random);
      LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
      ++inputs;
    }
  }
  std::printf("%ld inputs in %.1f s\n", inputs,
              std::chrono::duration<double>(Clock::now() - begin).count());
  return 0;
}
