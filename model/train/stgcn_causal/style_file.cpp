#include "model/train/stgcn_causal/style_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "model/base/read_file.h"
#include "model/train/checkpoint.h"

namespace styled::train::st_gcn_causal {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "styled style 1";
constexpr std::size_t kMaxFileBytes = 256UL * 1024;

bool IsNumber(const json& x) { return x.is_number() && std::isfinite(x.get<float>()); }

}  // namespace

Result<StyleFile> ReadStyleFile(const std::filesystem::path& file) {
  const auto error = [&file](const std::string& what) {
    return Status::Error(file.string() + ": " + what);
  };
  const auto text = ReadFile(file.string(), kMaxFileBytes);
  if (!text.ok()) return text.status();
  StyleFile style;
  style.all = json::parse(text.value(), nullptr, false);
  const auto is_text = [&style](const char* key) {
    return style.all.contains(key) && style.all[key].is_string();
  };
  if (!style.all.is_object() || !is_text("format") || style.all["format"] != kFormat) {
    return error("expected a JSON object with \"format\": \"" + std::string(kFormat) + "\"");
  }
  if (!is_text("name") || !is_text("weights")) return error("expected \"name\" and \"weights\"");
  const auto code = style.all.find("code");
  if (code == style.all.end() || !code->is_array() || code->empty() ||
      !std::all_of(code->begin(), code->end(), IsNumber)) {
    return error("expected \"code\" with finite numbers");
  }
  style.name = style.all["name"].get<std::string>();
  style.weights = style.all["weights"].get<std::string>();
  for (const json& number : *code) style.code.push_back(number.get<float>());
  return style;
}

Status WriteStyleFile(StyleFile style, const std::filesystem::path& file) {
  style.all["name"] = file.stem().string();
  style.all["code"] = style.code;
  std::ofstream out(PartialFile(file));
  out << style.all.dump(1, ' ', false, json::error_handler_t::replace) << "\n";
  out.close();
  if (!out) return Status::Error(file.string() + ": cannot be written");
  return ReplaceByPartial(file);
}

}  // namespace styled::train::st_gcn_causal
