#include "daemon/styles/library.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "daemon/styles/like.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
#include "model/base/hash.h"
#include "model/base/read_file.h"
#include "model/base/write_file.h"
#include "model/clip/clip.h"
#include "model/synthetic/performer.h"

namespace styled::pipeline {
namespace {

constexpr const char* kStyle = ".json";
constexpr const char* kExample = ".bvh";
constexpr std::size_t kMaxExampleBytes = std::size_t{64} << 20U;

std::string FileOf(const RuntimeConfig& config, const std::string& name, const char* extension) {
  return std::filesystem::path(config.style.library) / (name + extension);
}

// The style files of a folder, by name.
std::vector<std::filesystem::path> FilesOf(RuntimeConfig& config) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  const std::filesystem::path folder = config.style.library;
  if (!std::filesystem::exists(folder, error)) return files;  // made by the first style
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == kStyle) files.push_back(entry.path());
  }
  if (error)
    config.complaints.push_back("style.library: " + folder.string() + ": " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

// Makes the code of a style of other weights again, from the example beside its file.
Status MakeAgain(const std::filesystem::path& file, const std::string& other_weights,
                 const WorkLimit& work, RuntimeConfig& config, MadeStyle& style) {
  const std::string made_with = file.string() + ": was made with other weights, " + other_weights;
  const std::filesystem::path example = std::filesystem::path(file).replace_extension(kExample);
  const auto bvh = ReadFile(example, kMaxExampleBytes);
  if (!bvh.ok() || style.example.empty() || HashOfExample(bvh.value()) != style.example) {
    return Status::Error(made_with + "; expected " + config.weights_hash + ", or its example " +
                         example.filename().string() + " beside it");
  }
  if (work.exceeded()) return Status::Error(made_with + "; " + work.Refusal().message());
  const float all_s = style.seconds;
  Status made = MakeCodeAgain(config, bvh.value(), example.string(), work, style);
  if (!made.ok()) return Status::Error(made_with + "; " + made.message());
  std::string line = made_with + ", and is made again from its example";
  constexpr float kSame_s = 0.5F;  // the rate of the kept example may be lower
  if (all_s > style.seconds + kSame_s) line += ", the last that was added to it";
  config.complaints.push_back(
      "style.library: " + line +
      ". It looks a little different, more so if it was compared with a neutral clip");
  return made;
}

// Adds the style of a file, unless the configuration already has it as it is in the file.
Status AddFromFile(const std::filesystem::path& file, const WorkLimit& again,
                   RuntimeConfig& config) {
  const auto text = ReadFile(file, kMaxStyleFileBytes);
  if (!text.ok()) return text.status();
  std::string other_weights;
  auto style = ParseStyleFile(text.value(), file, config, &other_weights);
  if (!style.ok()) return style.status();
  const std::string name = style.value().name;
  if (name != file.stem().string()) {
    return Status::Error(file.string() + ": holds the style \"" + name +
                         "\"; expected the file's name");
  }
  const auto known = config.made.find(name);
  const bool same = known != config.made.end() && known->second->file_hash == HashOf(text.value());
  if (!same && !other_weights.empty()) {
    const Status made = MakeAgain(file, other_weights, again, config, style.value());
    if (!made.ok()) return made;
  }
  const Status refusal = same ? Status::Ok() : PutStyle(std::move(style.value()), config);
  if (!refusal.ok()) return Status::Error(file.string() + ": " + refusal.message());
  config.kept.insert(name);
  return Status::Ok();
}

Status Removed(const std::string& file) {
  if (std::remove(file.c_str()) == 0 || errno == ENOENT) return Status::Ok();
  return Status::Error(file + ": cannot be removed: " + std::strerror(errno));
}

// Whether the kept example of a name belongs to the style.
bool HasExample(const RuntimeConfig& config, const std::string& name, const MadeStyle& style) {
  const auto text = ReadFile(FileOf(config, name, kExample), kMaxExampleBytes);
  return text.ok() && !style.example.empty() && HashOfExample(text.value()) == style.example;
}

// Writes NAME.json, and records its content in config.made.
Status WriteStyle(const std::string& name, RuntimeConfig& config) {
  std::error_code error;  // the write reports the error
  std::filesystem::create_directories(config.style.library, error);
  MadeStyle style = *config.made.at(name);
  const std::string text = FormatStyleFile(style, config);
  style.file_hash = HashOf(text);
  const Status written = WriteFileAtomically(FileOf(config, name, kStyle), text);
  if (!written.ok()) return written;
  config.made[name] = std::make_shared<const MadeStyle>(std::move(style));
  config.kept.insert(name);
  return Status::Ok();
}

}  // namespace

void ReadLibrary(RuntimeConfig& config, std::chrono::milliseconds longest) {
  if (config.style.library.empty()) return;
  const std::vector<std::filesystem::path> files = FilesOf(config);
  const auto gone = [&files](const std::string& name) {
    return std::none_of(files.begin(), files.end(),
                        [&name](const auto& file) { return file.stem() == name; });
  };
  for (const std::string& name : std::exchange(config.kept, {})) {
    const int number = net::FindStyle(config.network->model().styles, name);
    if (!gone(name)) {
      config.kept.insert(name);
    } else if (number >= config.own_styles) {
      RetireStyle(number, config);
    }
  }
  const auto again =
      WorkLimit::Within(longest, "fewer styles to make again; a reload makes the others");
  for (const std::filesystem::path& file : files) {
    const Status added = AddFromFile(file, again, config);
    if (!added.ok()) config.complaints.push_back("style.library: " + added.message());
  }
}

std::string ExampleText(const std::vector<body::Pose>& poses, double rate_hz,
                        std::size_t most_bytes) {
  if (poses.empty()) return "";
  clip::Clip clip;
  clip.skeleton = synthetic::MakeSkeleton({});
  for (std::size_t every = 1;; ++every) {
    clip.rate_hz = rate_hz / static_cast<double>(every);
    clip.frames.clear();
    for (std::size_t i = 0; i < poses.size(); i += every) {
      rig::RigPose& frame = clip.frames.emplace_back(clip.skeleton);
      frame.translations[body::kHips] = poses[i].hips_position_m;
      frame.rotations.assign(poses[i].rotations.begin(), poses[i].rotations.end());
    }
    std::string text = clip::FormatBvh(clip);
    if (text.size() <= most_bytes || rate_hz < static_cast<double>(every + 1)) return text;
    every = std::max(every, every * text.size() / most_bytes);  // the rate is nearly the one that
                                                                // fits
    every = std::min(every, static_cast<std::size_t>(rate_hz) - 1);
  }
}

Status KeepStyle(const std::string& name, const std::string& example, RuntimeConfig& config) {
  if (config.style.library.empty()) return Status::Ok();
  if (const Status written = WriteStyle(name, config); !written.ok()) return written;
  // The replaced style's name may have differed in case.
  for (const std::string& other : std::vector(config.kept.begin(), config.kept.end())) {
    if (config.made.contains(other)) continue;
    (void)KeepRemoved(other, config);
  }
  if (!example.empty()) return WriteFileAtomically(FileOf(config, name, kExample), example);
  if (HasExample(config, name, *config.made.at(name))) return Status::Ok();
  return Removed(FileOf(config, name, kExample));
}

Status KeepRenamed(const std::string& name, const std::string& to, RuntimeConfig& config) {
  if (config.style.library.empty()) return Status::Ok();
  if (const Status written = WriteStyle(to, config); !written.ok()) return written;
  const std::string before = FileOf(config, name, kExample), after = FileOf(config, to, kExample);
  const bool moved = std::rename(before.c_str(), after.c_str()) == 0;
  if (!moved) (void)Removed(after);  // belonged to a removed style
  const Status removed = Removed(FileOf(config, name, kStyle));
  if (!removed.ok()) {
    (void)Removed(FileOf(config, to, kStyle));
    if (moved) (void)std::rename(after.c_str(), before.c_str());
    return removed;
  }
  config.kept.erase(name);
  return Status::Ok();
}

Status KeepRemoved(const std::string& name, RuntimeConfig& config) {
  if (!config.kept.contains(name)) return Status::Ok();
  if (const Status removed = Removed(FileOf(config, name, kStyle)); !removed.ok()) return removed;
  config.kept.erase(name);
  return Removed(FileOf(config, name, kExample));
}

}  // namespace styled::pipeline
