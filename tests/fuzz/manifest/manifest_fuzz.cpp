// Fuzzes the reader of manifests, over a folder of files with the usual names: a manifest is either
// refused with a reason that names it, or every clip that it lists exists with its style and
// content.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "model/clip/manifest.h"
#include "tests/support/temporary_folder.h"

namespace {

namespace fs = std::filesystem;
using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

// The files contain no motion: patterns match names only.
struct Folder {
  Folder() {
    for (const char* const name :
         {"bandai-2-train/dataset-2_walk_normal_001.bvh",
          "bandai-2-train/dataset-2_walk_active_001.bvh",
          "bandai-2-train/dataset-2_walk_active_002.bvh",
          "bandai-2-train/dataset-2_run_feminine_001.bvh",
          "bandai-2-val/dataset-2_walk_normal_001.bvh", "bandai-1/dataset-1_run_normal_001.bvh",
          "bandai-1/dataset-1_bow_happy_001.bvh", "a.bvh"}) {
      fs::create_directories((place.path() / name).parent_path());
      std::ofstream(place.path() / name) << "HIERARCHY\n";
    }
  }
  support::TemporaryFolder place;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  static const int fd = memfd_create("manifest.toml", 0);
  static const std::string file = "/proc/self/fd/" + std::to_string(fd);
  Require(ftruncate(fd, 0) == 0);
  Require(pwrite(fd, data, size, 0) == static_cast<ssize_t>(size));
  const auto loaded = clip::LoadManifest(file, folder.place.path());
  if (!loaded.ok()) {
    Require(loaded.status().message().find(file) != std::string::npos);
    return 0;
  }
  const clip::Manifest& manifest = loaded.value();
  for (const auto& entry : manifest.entries) {
    Require(fs::exists(entry.file));
    Require(std::ranges::any_of(manifest.styles,
                                [&](const auto& style) { return style.name == entry.style; }));
    Require(std::ranges::find(manifest.contents, entry.content) != manifest.contents.end());
    Require(entry.from >= 0 && entry.from < entry.to && entry.to <= 1);
  }
  return 0;
}
