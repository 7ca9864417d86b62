#include "daemon/pipeline/library.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "daemon/pipeline/like.h"
#include "model/base/read_file.h"

namespace styled::pipeline {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "styled style 1";
constexpr std::size_t kMaxFileBytes = 64UL * 1024;

// What a style file asks for, as a Like has it.
Result<v1::Like> ReadStyle(const std::filesystem::path& file, const RuntimeConfig& config) {
  const auto error = [&file](const std::string& what) {
    return Status::Error(file.string() + ": " + what);
  };
  const auto text = ReadFile(file, kMaxFileBytes);
  if (!text.ok()) return text.status();
  const json style = json::parse(text.value(), nullptr, false);
  const auto is_text = [&style](const char* key) {
    return style.contains(key) && style[key].is_string();
  };
  if (!style.is_object() || !is_text("format") || style["format"] != kFormat) {
    return error("expected a JSON object with \"format\": \"" + std::string(kFormat) + "\"");
  }
  if (!is_text("weights") || style["weights"] != config.weights_hash) {
    return error("was made with other weights, " +
                 (is_text("weights") ? style["weights"].get<std::string>() : "unnamed") +
                 "; expected " + config.weights_hash);
  }
  const auto code = style.find("code");
  const bool numbers =
      code != style.end() && code->is_array() &&
      std::all_of(code->begin(), code->end(), [](const json& x) { return x.is_number(); });
  if (!is_text("name") || !numbers) return error("expected \"name\", and \"code\" with numbers");
  if (style["name"] != file.stem().string()) {
    return error("holds the style \"" + style["name"].get<std::string>() +
                 "\"; expected the file's name");
  }
  v1::Like like;
  like.set_name(style["name"].get<std::string>());
  for (const json& number : *code) like.add_code(number.get<float>());
  return like;
}

// The style files of a folder, by name.
std::vector<std::filesystem::path> FilesOf(RuntimeConfig& config) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  const std::filesystem::path folder = config.style.library;
  if (!std::filesystem::exists(folder, error)) return files;  // made by the first style
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  if (error)
    config.complaints.push_back("style.library: " + folder.string() + ": " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

Status KeepStyle(const RuntimeConfig& config, const v1::LikeReply& like,
                 const std::string& source) {
  const std::filesystem::path folder = config.style.library;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const std::filesystem::path file = folder / (like.name() + ".json");
  std::filesystem::path fresh = file;
  fresh += ".new";
  json style{{"format", kFormat},
             {"name", like.name()},
             {"weights", config.weights_hash},
             {"licence", config.network->model().licence},
             {"source", source},
             {"seconds", like.seconds()},
             {"nearest", like.nearest()},
             {"distance", like.distance()},
             {"code", std::vector<float>(like.code().begin(), like.code().end())}};
  std::ofstream out(fresh);
  out << style.dump(1, ' ', false, json::error_handler_t::replace) << "\n";
  out.close();
  if (out && std::rename(fresh.c_str(), file.c_str()) == 0) return Status::Ok();
  std::filesystem::remove(fresh, error);
  return Status::Error(file.string() + " cannot be written");
}

void ReadLibrary(RuntimeConfig& config) {
  if (config.style.library.empty()) return;
  const std::vector<std::filesystem::path> files = FilesOf(config);
  const auto in_folder = [&files](const std::string& name) {
    return std::any_of(files.begin(), files.end(),
                       [&name](const auto& file) { return file.stem() == name; });
  };
  for (const std::string& name : config.kept) {
    const int number = net::FindStyle(config.network->model().styles, name);
    if (in_folder(name) || number < config.own_styles) continue;
    config.network = config.network->Retired(number);
  }
  config.kept.clear();
  for (const std::filesystem::path& file : files) {
    auto like = ReadStyle(file, config);
    if (!like.ok()) {
      config.complaints.push_back("style.library: " + like.status().message());
      continue;
    }
    const std::string name = like.value().name();
    config.kept.insert(name);
    if (net::FindStyle(config.network->model().styles, name) >= config.own_styles) continue;
    v1::Reply reply;
    const auto with = AddStyle(config, like.value(), {}, reply);
    if (with != nullptr) {
      config.network = with->network;
    } else {
      config.complaints.push_back("style.library: " + file.string() + ": " + reply.reason());
    }
  }
}

}  // namespace styled::pipeline
