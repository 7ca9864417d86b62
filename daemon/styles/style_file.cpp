#include "daemon/styles/style_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "model/base/hash.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "styled style 1";
constexpr std::size_t kShownText = 80;        // the most bytes of a text that errors quote
constexpr std::size_t kMaxSourceBytes = 200;  // the most bytes of a source that lists show
constexpr std::size_t kMaxDepth = 16;         // the depth of brackets; the file's own fields need 2

// Reads the known fields while parsing, so that unknown ones take no memory, however many there
// are. A field of an unexpected type counts as missing. If a key occurs twice, the last one counts.
class Fields final : public json::json_sax_t {
 public:
  std::string format, weights, name, source, example, licence;
  float seconds = 0;
  std::vector<float> code;
  bool has_code = false;  // a list of numbers

  bool null() override { return Other(); }
  bool boolean(bool) override { return Other(); }
  bool number_integer(number_integer_t value) override { return Number(static_cast<float>(value)); }
  bool number_unsigned(number_unsigned_t value) override {
    return Number(static_cast<float>(value));
  }
  bool number_float(number_float_t value, const string_t&) override {
    return Number(static_cast<float>(value));
  }
  bool string(string_t& value) override {
    if (depth_ != 1) return Other();
    const auto put = [&](const char* key, std::string& text, std::size_t most) {
      if (key_ == key) text = Printable(value, most);
    };
    put("format", format, kShownText);
    put("weights", weights, kShownText);
    put("name", name, kShownText);
    put("source", source, kMaxSourceBytes);
    put("example", example, kShownText);
    put("licence", licence, kMaxSourceBytes);
    return Other();
  }
  bool binary(binary_t&) override { return false; }  // does not occur in JSON text
  bool start_object(std::size_t) override { return Other() && Open(); }
  bool start_array(std::size_t) override {
    if (InCode()) has_code = false;  // a list within the list
    if (depth_ == 1 && key_ == "code") {
      code.clear();
      has_code = true;
    }
    return Open();
  }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool key(string_t& name) override {
    if (depth_ != 1) return true;
    key_ = name.size() < kShownText ? std::move(name) : "";
    Forget();
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

 private:
  bool InCode() const { return depth_ == 2 && key_ == "code"; }
  // A repeated key replaces the former value.
  void Forget() {
    for (const auto& [key, text] :
         {std::pair{"format", &format}, std::pair{"weights", &weights}, std::pair{"name", &name},
          std::pair{"source", &source}, std::pair{"example", &example},
          std::pair{"licence", &licence}}) {
      if (key_ == key) text->clear();
    }
    if (key_ == "seconds") seconds = 0;
    if (key_ == "code") has_code = false;
  }
  bool Number(float value) {
    if (depth_ == 1 && key_ == "seconds") seconds = std::isfinite(value) ? value : 0;
    if (InCode() && has_code) code.push_back(value);
    return depth_ > 0;
  }
  // A value that is not a number.
  bool Other() {
    if (InCode()) has_code = false;
    return true;
  }
  bool Open() { return ++depth_ <= kMaxDepth; }
  bool Close() {
    --depth_;
    return true;
  }

  std::string key_;  // the depth of the file's object
  std::size_t depth_ = 0;
};

// The shortest text that is read as the same float.
std::string TextOf(float number) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return std::isfinite(number) ? std::string(text.data(), end) : "0";
}

}  // namespace

Result<MadeStyle> ParseStyleFile(const std::string& text, const std::string& file,
                                 const RuntimeConfig& config, std::string* other_weights) {
  const auto error = [&file](const std::string& what) { return Status::Error(file + ": " + what); };
  if (text.size() > kMaxStyleFileBytes) {
    return error("found " + std::to_string(text.size()) + " bytes, expected at most " +
                 std::to_string(kMaxStyleFileBytes));
  }
  Fields fields;
  if (!json::sax_parse(text, &fields) || fields.format != kFormat) {
    return error("expected a JSON object with \"format\": \"" + std::string(kFormat) + "\"");
  }
  const bool has_code = fields.has_code && !fields.name.empty();
  if (fields.weights != config.weights_hash && has_code && config.network != nullptr &&
      config.network->space() != nullptr) {
    // Of a style that was made with other weights, the part that does not depend on them.
    fields.code = config.network->space()->Portable(fields.code);
    if (!fields.code.empty()) fields.weights = config.weights_hash;
  }
  const bool foreign = fields.weights != config.weights_hash;
  if (foreign && other_weights != nullptr && !fields.name.empty()) {
    *other_weights = fields.weights.empty() ? "unnamed" : fields.weights;
  } else if (foreign) {
    return error("was made with other weights, " +
                 (fields.weights.empty() ? "unnamed" : fields.weights) + "; expected " +
                 config.weights_hash);
  }
  if (fields.name.empty() || (!foreign && !fields.has_code)) {
    return error("expected \"name\", and \"code\" with numbers");
  }
  MadeStyle made;
  made.name = std::move(fields.name);
  if (!foreign) made.code = std::move(fields.code);
  made.source = std::move(fields.source);
  made.seconds = fields.seconds;
  made.example = std::move(fields.example);
  made.licence = std::move(fields.licence);
  made.file_hash = HashOf(text);
  return made;
}

std::string FormatStyleFile(const MadeStyle& style, const RuntimeConfig& config) {
  std::string text = "{\n";
  const auto add = [&text](const char* key, const std::string& value) {
    text += (text.size() > 2 ? ",\n \"" : " \"") + std::string(key) + "\": " + value;
  };
  const auto quoted = [](const std::string& value) {
    return json(value).dump(-1, ' ', false, json::error_handler_t::replace);
  };
  add("format", quoted(kFormat));
  add("name", quoted(style.name));
  add("weights", quoted(config.weights_hash));
  add("licence", quoted(style.licence));
  add("source", quoted(style.source));
  add("seconds", TextOf(style.seconds));
  add("nearest", quoted(style.nearest));
  add("distance", TextOf(style.distance));
  if (!style.example.empty()) add("example", quoted(style.example));
  add("code", "[");
  for (std::size_t i = 0; i < style.code.size(); ++i) {
    text += (i == 0 ? "" : ",") + TextOf(style.code[i]);
  }
  return text + "]\n}\n";
}

}  // namespace styled::pipeline
