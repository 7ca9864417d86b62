#include "model/net/weights_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>
#include <utility>

#include "model/base/text.h"
#include "model/body/humanoid.h"
#include "model/net/strict_json.h"

namespace styled::net {
namespace {

using nlohmann::json;

constexpr float kMaxRate_hz = 1000.0F;

// The measurements of a style, each key optional.
struct Measured {
  const char* key;
  float StyleInfo::*value;
  double least, most;
  const char* range;
};
constexpr std::array<Measured, 6> kMeasured{
    {{"walk_mps", &StyleInfo::walk_mps, 0.05, 15, "a number from 0.05 to 15"},
     {"run_mps", &StyleInfo::run_mps, 0.05, 15, "a number from 0.05 to 15"},
     {"walk_spm", &StyleInfo::walk_spm, 20, 400, "a number from 20 to 400"},
     {"run_spm", &StyleInfo::run_spm, 20, 400, "a number from 20 to 400"},
     {"recognized", &StyleInfo::recognized, 0, 1, "a number from 0 to 1"},
     {"recorded_s", &StyleInfo::recorded_s, 0.1, 1e8, "a number from 0.1 to 1e8"}}};

std::string ReadString(const json& object, const std::string& key, Faults& faults) {
  const json* value = FindKey(object, key, faults);
  if (value == nullptr) return "";
  if (!value->is_string()) {
    faults.Key(key, "a string", Shown(*value));
    return "";
  }
  return value->get<std::string>();
}

std::array<std::pair<const char*, GateBounds::Range*>, 3> RangesOf(GateBounds& gate) {
  return {{{"arms", &gate.arms}, {"trunk", &gate.trunk}, {"legs", &gate.legs}}};
}

// Reads a name or alias. Lookup ignores case, so names must differ in more than case. Programs
// print names, so none may control a terminal.
void ReadName(const json& value, const std::string& place, std::set<std::string>& known,
              std::string& name, Faults& faults) {
  if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
    faults.Key(place, "a string that is not empty", Shown(value));
    return;
  }
  name = value.get<std::string>();
  if (Printable(name, name.size()) != name) {
    faults.Key(place, "a name without control characters", Shown(value));
    return;
  }
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!known.insert(lower).second) {
    faults.Key(place, "a name or alias that occurs once", Shown(value));
  }
}

void ReadMeasured(const json& entry, const std::string& place, StyleInfo& style, Faults& faults) {
  for (const Measured& measured : kMeasured) {
    if (!entry.contains(measured.key)) continue;
    const json& found = entry[measured.key];
    const double value = found.is_number() ? found.get<double>() : -1;
    if (!(value >= measured.least && value <= measured.most)) {
      faults.Key(place + "." + measured.key, measured.range, Shown(found));
    }
    style.*measured.value = static_cast<float>(value);
  }
}

// Optional: for each of kPostureJoints x, y, z of a rotation vector.
void ReadPosture(const json& entry, const std::string& place, StyleInfo& style, Faults& faults) {
  const auto found = entry.find("posture");
  if (found == entry.end()) return;
  constexpr double kMost_rad = 1.6;
  constexpr std::size_t kNumbers = 3 * kPostureJoints.size();
  const auto fits = [](const json& n) {
    return n.is_number() && std::abs(n.get<double>()) <= kMost_rad;
  };
  if (!found->is_array() || found->size() != kNumbers ||
      !std::all_of(found->begin(), found->end(), fits)) {
    faults.Key(place + ".posture",
               std::to_string(kNumbers) + " numbers from -1.6 to 1.6, a turn in rad per joint",
               Shown(*found));
    return;
  }
  Posture& posture = style.posture.emplace();
  for (std::size_t i = 0; i < kNumbers; ++i) {
    posture[i / 3][static_cast<Eigen::Index>(i % 3)] = (*found)[i].get<float>();
  }
}

// Optional texts: "licence" and "credit".
void ReadOrigin(const json& entry, const std::string& place, StyleInfo& style, Faults& faults) {
  constexpr std::size_t kMost = 300;  // bytes, of a line in lists
  for (const auto& [key, text] :
       {std::pair{"licence", &style.licence}, {"credit", &style.credit}}) {
    const auto found = entry.find(key);
    if (found == entry.end()) continue;
    if (!found->is_string() || found->get_ref<const std::string&>().size() > kMost) {
      faults.Key(place + "." + key, "a text of at most 300 bytes", Shown(*found));
      continue;
    }
    *text = Printable(found->get<std::string>(), kMost);
  }
}

void ReadStyles(const json& metadata, Styles& styles, Faults& faults) {
  const json* list = FindKey(metadata, "styles", faults);
  if (list == nullptr) return;
  if (!list->is_array() || list->empty() || list->size() > kMaxStyles) {
    faults.Key("styles", "1 to " + std::to_string(kMaxStyles) + " objects",
               list->is_array() ? std::to_string(list->size()) : Shown(*list));
    return;
  }
  std::set<std::string> known;
  for (std::size_t s = 0; s < list->size(); ++s) {
    const json& entry = (*list)[s];
    const std::string place = "styles[" + std::to_string(s) + "]";
    if (!entry.is_object() || !entry.contains("name") || !entry.contains("aliases") ||
        !entry["aliases"].is_array()) {
      faults.Key(place, "{\"name\", \"aliases\": [...]}", Shown(entry));
      return;
    }
    StyleInfo style;
    ReadName(entry["name"], place + ".name", known, style.name, faults);
    for (const json& alias : entry["aliases"]) {
      ReadName(alias, place + ".aliases", known, style.aliases.emplace_back(), faults);
    }
    ReadMeasured(entry, place, style, faults);
    ReadPosture(entry, place, style, faults);
    ReadOrigin(entry, place, style, faults);
    styles.push_back(std::move(style));
    // The first is neutral, whatever it is called.
    if (s > 0 && FindStyle({styles.back()}, "neutral") == 0) {
      faults.Key(place, "a style, since the first is neutral", Shown(entry));
      return;
    }
  }
}

// The carriage under `key` of `object`: for each joint x, y, z, w of a rotation.
neutral::Carriage ReadCarriage(const json& object, const std::string& key, Faults& faults) {
  constexpr std::size_t kNumbers = 4 * static_cast<std::size_t>(body::kJointCount);
  constexpr double kTolerance = 1e-3;  // of a unit quaternion's length
  neutral::Carriage carriage;
  const std::string place = "reference." + key;
  const std::string expected = std::to_string(kNumbers) + " numbers, a unit quaternion per joint";
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array() || found->size() != kNumbers ||
      !std::all_of(found->begin(), found->end(), [](const json& n) { return n.is_number(); })) {
    faults.Key(place, expected, found == object.end() ? "none" : Shown(*found));
    return carriage;
  }
  for (std::size_t joint = 0; joint < carriage.rotations.size(); ++joint) {
    const auto number = [&](std::size_t i) { return (*found)[4 * joint + i].get<float>(); };
    const body::Quat rotation(number(3), number(0), number(1), number(2));
    if (!(std::abs(static_cast<double>(rotation.norm()) - 1) <= kTolerance)) {
      faults.Key(place, expected,
                 std::string(body::kHumanoid[joint].name) + " of length " +
                     std::to_string(rotation.norm()));
      return carriage;
    }
    carriage.rotations[joint] = rotation.normalized();
  }
  return carriage;
}

// Of the performers that the network was trained on: optional, and their speeds are neutral's.
void ReadReference(const json& object, Model& model, Faults& faults) {
  const auto found = object.find("reference");
  if (found == object.end()) return;
  if (!found->is_object()) {
    faults.Key("reference", "an object", Shown(*found));
    return;
  }
  neutral::Reference& reference = model.reference.emplace();
  reference.standing = ReadCarriage(*found, "standing", faults);
  reference.walking = ReadCarriage(*found, "walking", faults);
  reference.running = ReadCarriage(*found, "running", faults);
  if (model.styles.empty()) return;
  if (model.styles[0].walk_mps > 0) reference.walk_mps = model.styles[0].walk_mps;
  if (model.styles[0].run_mps > 0) reference.run_mps = model.styles[0].run_mps;
}

// Optional: by class of limb, the two distances between which its style fades out.
void ReadGate(const json& object, GateBounds& gate, Faults& faults) {
  const auto found = object.find("gate");
  if (found == object.end()) return;
  constexpr double kMost_m = 10;
  for (const auto& [key, range] : RangesOf(gate)) {
    const auto two = found->is_object() ? found->find(key) : found->end();
    const bool fits = found->is_object() && two != found->end() && two->is_array() &&
                      two->size() == 2 && (*two)[0].is_number() && (*two)[1].is_number();
    const double begin_m = fits ? (*two)[0].get<double>() : 0;
    const double end_m = fits ? (*two)[1].get<double>() : 0;
    if (!fits || !(begin_m > 0 && begin_m < end_m && end_m <= kMost_m)) {
      faults.Key("gate." + std::string(key), "two distances, 0 < begin < end <= 10",
                 found->is_object() && two == found->end() ? "none"
                 : found->is_object()                      ? Shown(*two)
                                                           : Shown(*found));
      continue;
    }
    *range = {static_cast<float>(begin_m), static_cast<float>(end_m)};
  }
}

json CarriageAsJson(const neutral::Carriage& carriage) {
  json numbers = json::array();
  for (const body::Quat& rotation : carriage.rotations) {
    for (const float number : rotation.coeffs()) numbers.push_back(number);
  }
  return numbers;
}

// Reads the family. Files of version 1 are older than the families and are all Style-ERD.
void ReadFamily(const json& object, std::string& family, Faults& faults) {
  const json* const version = FindKey(object, "version", faults);
  if (version == nullptr) return;
  if (*version == json(1U) && version->is_number_integer()) {
    family = kStyleErd;
  } else if ((*version == json(2U) || *version == json(kWeightsVersion)) &&
             version->is_number_integer()) {
    family = ReadString(object, "family", faults);
  } else {
    faults.Key("version", "1 to 3", Shown(*version));
  }
}

std::string HumanoidHash() {
  char hash[17];
  std::snprintf(hash, sizeof(hash), "%016llx",
                static_cast<unsigned long long>(body::HumanoidHash()));
  return hash;
}

void ReadModel(const json& object, Model& model, Faults& faults) {
  ReadFamily(object, model.family, faults);
  ExpectEqual(object, "humanoid_hash", HumanoidHash(), faults);
  ReadStyles(object, model.styles, faults);
  ReadReference(object, model, faults);
  ReadGate(object, model.gate, faults);
  model.rate_hz = ReadNumber(object, "rate_hz", {0, kMaxRate_hz, false}, faults);
  model.licence = ReadString(object, "licence", faults);
  if (const json* training = FindKey(object, "training", faults)) {
    if (!training->is_object()) faults.Key("training", "an object", Shown(*training));
    model.training = training->dump(-1, ' ', false, json::error_handler_t::replace);
  }
}

std::string Spelled(const std::string& dtype, const std::vector<std::int64_t>& shape) {
  return dtype + " " + json(shape).dump();
}

}  // namespace

std::string Shown(const json& value) {
  constexpr std::size_t kLongest = 80;
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

const json* FindKey(const json& object, const std::string& key, Faults& faults) {
  const auto found = object.find(key);
  if (found != object.end()) return &*found;
  faults.Add("key '" + key + "': missing");
  return nullptr;
}

void ExpectEqual(const json& object, const std::string& key, const json& expected, Faults& faults) {
  const json* value = FindKey(object, key, faults);
  if (value == nullptr) return;
  // 1.0 is not accepted for 1: counts are written as integers.
  if (value->type_name() != std::string_view(expected.type_name()) || *value != expected ||
      value->is_number_float()) {
    faults.Key(key, Shown(expected), Shown(*value));
  }
}

float ReadNumber(const json& object, const std::string& key, Range range, Faults& faults) {
  const json* value = FindKey(object, key, faults);
  if (value == nullptr) return 0;
  const double number = value->is_number() ? value->get<double>() : std::nan("");
  if (!(range.least_allowed ? number >= range.least : number > range.least) ||
      !(number <= range.most)) {
    char text[64];
    std::snprintf(text, sizeof(text), "a number %s %g and <= %g", range.least_allowed ? ">=" : ">",
                  static_cast<double>(range.least), static_cast<double>(range.most));
    faults.Key(key, text, Shown(*value));
    return 0;
  }
  return static_cast<float>(number);
}

Result<WeightsFile> ParseWeights(std::span<const std::byte> bytes, const std::string& name) {
  Result<SafetensorsView> view = ParseSafetensors(bytes, name);
  if (!view.ok()) return view.status();
  WeightsFile file;
  file.name = name;
  file.view = std::move(view.value());
  Faults faults(name);
  const auto& container = file.view.metadata;
  const auto text = container.find("styled");
  if (text == container.end() || container.size() != 1) {
    faults.Add(
        "__metadata__: expected the one key 'styled', found " +
        (text == container.end() ? "no such key" : std::to_string(container.size()) + " keys"));
    return faults.status();
  }
  const std::string wrong = ParseStrictJson(text->second, file.header);
  if (!wrong.empty()) {
    faults.Add("key 'styled': " + wrong);
  } else if (!file.header.is_object()) {
    faults.Key("styled", "an object", Shown(file.header));
  } else {
    ReadModel(file.header, file.model, faults);
  }
  if (!faults.none()) return faults.status();
  return file;
}

json AsJson(const Posture& posture) {
  json numbers = json::array();
  for (const body::Vec3& turn : posture) {
    for (const float number : turn) numbers.push_back(number);
  }
  return numbers;
}

json AsJson(const GateBounds& gate) {
  GateBounds copy = gate;
  json object;
  for (const auto& [key, range] : RangesOf(copy)) object[key] = {range->begin_m, range->end_m};
  return object;
}

json AsJson(const neutral::Reference& reference) {
  return {{"standing", CarriageAsJson(reference.standing)},
          {"walking", CarriageAsJson(reference.walking)},
          {"running", CarriageAsJson(reference.running)}};
}

json HeaderOf(const Model& model) {
  json styles = json::array();
  for (const StyleInfo& style : model.styles) {
    json& entry = styles.emplace_back();
    entry = {{"name", style.name}, {"aliases", style.aliases}};
    for (const Measured& measured : kMeasured) {
      if (style.*measured.value > 0) entry[measured.key] = style.*measured.value;
    }
    if (style.posture) entry["posture"] = AsJson(*style.posture);
    if (!style.licence.empty()) entry["licence"] = style.licence;
    if (!style.credit.empty()) entry["credit"] = style.credit;
  }
  const json training = json::parse(model.training, nullptr, /*allow_exceptions=*/false);
  json header = {{"version", kWeightsVersion},
                 {"family", model.family},
                 {"humanoid_hash", HumanoidHash()},
                 {"styles", styles},
                 {"rate_hz", model.rate_hz},
                 {"licence", model.licence},
                 {"training", training.is_object() ? training : json::object()}};
  if (model.gate != GateBounds()) header["gate"] = AsJson(model.gate);
  if (model.reference) header["reference"] = AsJson(*model.reference);
  return header;
}

RowMajor TensorReader::Matrix(const std::string& name, int rows, int columns) {
  return Read(name, {rows, columns}, rows, columns);
}

RowMajor TensorReader::Vector(const std::string& name, int rows) {
  return Read(name, {rows}, rows, 1);
}

RowMajor TensorReader::Tensor(const std::string& name, const std::vector<std::int64_t>& shape) {
  std::int64_t columns = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) columns *= shape[i];
  return Read(name, shape, static_cast<int>(shape[0]), static_cast<int>(columns));
}

void TensorReader::Finish() {
  if (!view_.tensors.empty()) {
    faults_.Add("tensor '" + view_.tensors.begin()->first + "': unknown");
  }
}

RowMajor TensorReader::Read(const std::string& name, const std::vector<std::int64_t>& shape,
                            int rows, int columns) {
  RowMajor values = RowMajor::Zero(rows, columns);
  const auto found = view_.tensors.find(name);
  if (found == view_.tensors.end()) {
    faults_.Add("tensor '" + name + "': expected " + Spelled("F32", shape) + ", found none");
    return values;
  }
  const TensorView tensor = found->second;
  view_.tensors.erase(found);
  if (tensor.dtype != "F32" || tensor.shape != shape) {
    faults_.Add("tensor '" + name + "': expected " + Spelled("F32", shape) + ", found " +
                Spelled(tensor.dtype, tensor.shape));
    return values;
  }
  std::memcpy(values.data(), tensor.bytes.data(), tensor.bytes.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values.data()[i])) {
      faults_.Add("tensor '" + name + "': expected finite values, found " +
                  std::to_string(values.data()[i]) + " at " + std::to_string(i));
      break;
    }
  }
  return values;
}

}  // namespace styled::net
