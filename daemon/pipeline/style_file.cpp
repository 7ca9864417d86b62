#include "daemon/pipeline/style_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "model/base/text.h"

namespace styled::pipeline {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "styled style 1";
constexpr std::size_t kShownText = 80;        // most bytes of a text that errors quote
constexpr std::size_t kMaxSourceBytes = 200;  // and of a source that lists show

std::string TextOf(const json& style, const char* key, std::size_t most) {
  const auto found = style.find(key);
  return found != style.end() && found->is_string()
             ? Printable(found->get_ref<const std::string&>(), most)
             : "";
}

float NumberOf(const json& style, const char* key) {
  const auto found = style.find(key);
  const float number = found != style.end() && found->is_number() ? found->get<float>() : 0.0F;
  return std::isfinite(number) ? number : 0.0F;
}

}  // namespace

Result<MadeStyle> ParseStyleFile(const std::string& text, const std::string& file,
                                 const RuntimeConfig& config) {
  const auto error = [&file](const std::string& what) { return Status::Error(file + ": " + what); };
  if (text.size() > kMaxStyleFileBytes) {
    return error("found " + std::to_string(text.size()) + " bytes, expected at most " +
                 std::to_string(kMaxStyleFileBytes));
  }
  const json style = json::parse(text, nullptr, false);
  if (!style.is_object() || TextOf(style, "format", kShownText) != kFormat) {
    return error("expected a JSON object with \"format\": \"" + std::string(kFormat) + "\"");
  }
  const std::string weights = TextOf(style, "weights", kShownText);
  if (weights != config.weights_hash) {
    return error("was made with other weights, " + (weights.empty() ? "unnamed" : weights) +
                 "; expected " + config.weights_hash);
  }
  const auto code = style.find("code");
  const bool numbers =
      code != style.end() && code->is_array() &&
      std::all_of(code->begin(), code->end(), [](const json& x) { return x.is_number(); });
  MadeStyle made;
  made.name = TextOf(style, "name", kShownText);
  if (made.name.empty() || !numbers) return error("expected \"name\", and \"code\" with numbers");
  made.code = code->get<std::vector<float>>();
  made.source = TextOf(style, "source", kMaxSourceBytes);
  made.seconds = NumberOf(style, "seconds");
  made.example = TextOf(style, "example", kShownText);
  made.licence = TextOf(style, "licence", kMaxSourceBytes);
  made.file = text;
  return made;
}

std::string FormatStyleFile(const MadeStyle& style, const RuntimeConfig& config) {
  json text = style.file.empty() ? json::object() : json::parse(style.file, nullptr, false);
  if (!text.is_object()) text = json::object();
  text["format"] = kFormat;
  text["name"] = style.name;
  text["weights"] = config.weights_hash;
  text["licence"] = style.licence;
  text["source"] = style.source;
  text["seconds"] = style.seconds;
  text["nearest"] = style.nearest;
  text["distance"] = style.distance;
  text.erase("example");
  if (!style.example.empty()) text["example"] = style.example;
  text["code"] = style.code;
  return text.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace styled::pipeline
