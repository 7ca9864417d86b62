// Reads model/net/erd/FORMAT.md's file into a Network, or says in one sentence why not.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>

#include "model/net/erd/network.h"
#include "model/net/erd/weights.h"
#include "model/net/safetensors.h"
#include "model/net/strict_json.h"

namespace styled::erd {
namespace {

using net::SafetensorsView;
using net::TensorView;
using nlohmann::json;

constexpr float kMaxRate_hz = 1000.0F;
constexpr float kMaxHeadingTau_s = 60.0F;

// The first thing found wrong, and the file's name in front of it. Later faults are dropped, so
// that a reader can go on and check once at the end.
class Faults {
 public:
  explicit Faults(const std::string& file) : file_(file) {}
  void Add(const std::string& what) {
    if (first_.empty()) first_ = file_ + ": " + what;
  }
  void Key(const std::string& key, const std::string& expected, const std::string& found) {
    Add("key '" + key + "': expected " + expected + ", found " + found);
  }
  bool none() const { return first_.empty(); }
  Status status() const { return none() ? Status::Ok() : Status::Error(first_); }

 private:
  std::string file_, first_;
};

// A value as it is shown in an error.
std::string Shown(const json& value) {
  constexpr std::size_t kLongest = 80;
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

// The value of a required key; nullptr and a fault if there is none.
const json* Find(const json& object, const std::string& key, Faults& faults) {
  const auto found = object.find(key);
  if (found != object.end()) return &*found;
  faults.Add("key '" + key + "': missing");
  return nullptr;
}

void ExpectEqual(const json& object, const std::string& key, const json& expected, Faults& faults) {
  const json* value = Find(object, key, faults);
  if (value == nullptr) return;
  // 1.0 is not 1: a count is written as an integer.
  if (value->type_name() != std::string_view(expected.type_name()) || *value != expected ||
      value->is_number_float()) {
    faults.Key(key, Shown(expected), Shown(*value));
  }
}

std::string ReadString(const json& object, const std::string& key, Faults& faults) {
  const json* value = Find(object, key, faults);
  if (value == nullptr) return "";
  if (!value->is_string()) {
    faults.Key(key, "a string", Shown(*value));
    return "";
  }
  return value->get<std::string>();
}

float ReadNumber(const json& object, const std::string& key, float least, bool least_allowed,
                 float most, Faults& faults) {
  const json* value = Find(object, key, faults);
  if (value == nullptr) return 0;
  const double number = value->is_number() ? value->get<double>() : std::nan("");
  if (!(least_allowed ? number >= least : number > least) || !(number <= most)) {
    char range[64];
    std::snprintf(range, sizeof(range), "a number %s %g and <= %g", least_allowed ? ">=" : ">",
                  static_cast<double>(least), static_cast<double>(most));
    faults.Key(key, range, Shown(*value));
    return 0;
  }
  return static_cast<float>(number);
}

// Adds a name or alias; names are looked up without case, so they must differ without it.
void ReadName(const json& value, const std::string& place, std::set<std::string>& known,
              std::string& name, Faults& faults) {
  if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
    faults.Key(place, "a string that is not empty", Shown(value));
    return;
  }
  name = value.get<std::string>();
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!known.insert(lower).second) {
    faults.Key(place, "a name or alias that occurs once", Shown(value));
  }
}

void ReadStyles(const json& metadata, std::vector<StyleInfo>& styles, Faults& faults) {
  const json* list = Find(metadata, "styles", faults);
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
    styles.push_back(std::move(style));
  }
}

void ReadMetadata(const std::map<std::string, std::string>& container, Metadata& metadata,
                  Faults& faults) {
  const auto text = container.find("styled");
  if (text == container.end() || container.size() != 1) {
    faults.Add("__metadata__: expected the one key 'styled', found " +
               (text == container.end() ? "none of that name"
                                        : std::to_string(container.size()) + " keys"));
    return;
  }
  json object;
  const std::string wrong = net::ParseStrictJson(text->second, object);
  if (!wrong.empty()) return faults.Add("key 'styled': " + wrong);
  if (!object.is_object()) return faults.Key("styled", "an object", Shown(object));

  ExpectEqual(object, "version", 1U, faults);
  char hash[17];
  std::snprintf(hash, sizeof(hash), "%016llx",
                static_cast<unsigned long long>(body::HumanoidHash()));
  ExpectEqual(object, "humanoid_hash", hash, faults);
  ReadStyles(object, metadata.styles, faults);
  if (const json* contents = Find(object, "contents", faults)) {
    if (!contents->is_array()) {
      faults.Key("contents", "an array", Shown(*contents));
    } else if (!contents->empty()) {
      faults.Key("contents", "[]",
                 Shown(*contents) +
                     ": the network takes a content input, which this build does "
                     "not feed");
    }
  }
  metadata.features.rate_hz = ReadNumber(object, "rate_hz", 0, false, kMaxRate_hz, faults);
  metadata.features.heading_tau_s =
      ReadNumber(object, "heading_tau_s", 0, true, kMaxHeadingTau_s, faults);
  ExpectEqual(object, "latent", static_cast<unsigned>(kLatent), faults);
  ExpectEqual(object, "encoder", json::array({static_cast<unsigned>(kEncoderWidth)}), faults);
  ExpectEqual(object, "decoder", kDecoderWidths, faults);
  ExpectEqual(object, "neutral_layers", static_cast<unsigned>(kNeutralLayers), faults);
  ExpectEqual(object, "style_layers", static_cast<unsigned>(kStyleLayers), faults);
  ExpectEqual(object, "gates", "ifgo", faults);
  metadata.licence = ReadString(object, "licence", faults);
  if (const json* training = Find(object, "training", faults)) {
    if (!training->is_object()) faults.Key("training", "an object", Shown(*training));
    metadata.training = training->dump(-1, ' ', false, json::error_handler_t::replace);
  }
}

template <typename Derived, std::size_t Size>
void Pack(const Eigen::MatrixBase<Derived>& vector, std::array<float, Size>& out) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) out[i] = vector[i];
}
template <typename Derived, int Rows, int Columns>
void Pack(const Eigen::MatrixBase<Derived>& matrix, PackedMatrix<Rows, Columns>& out) {
  for (int column = 0; column < Columns; ++column) {
    for (int row = 0; row < Rows; ++row) out[out.Index(row, column)] = matrix(row, column);
  }
}

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Takes tensors out of the file one by one; what is left at the end is unknown.
class TensorReader {
 public:
  TensorReader(SafetensorsView& view, Faults& faults) : view_(view), faults_(faults) {}

  // A matrix [rows, columns] into `out`; zeros and a fault if it is not as expected.
  RowMajor Take(const std::string& name, int rows, int columns) {
    return TakeShape(name, {rows, columns}, rows, columns);
  }
  template <int Rows>
  Vector<Rows> Take(const std::string& name) {
    return TakeShape(name, {Rows}, Rows, 1);
  }
  template <int Rows, int Columns>
  void Take(const std::string& name, Affine<Rows, Columns>& out) {
    Pack(Take(name + ".weight", Rows, Columns), out.weight);
    Pack(Take<Rows>(name + ".bias"), out.bias);
  }
  // As above, with one column per style behind, which joins the bias of its style.
  template <int Rows, int Columns>
  void Take(const std::string& name, int style_count, PackedMatrix<Rows, Columns>& out,
            std::array<PackedVector<Rows>, kMaxStyles>& style_bias) {
    const RowMajor all = Take(name + ".weight", Rows, Columns + style_count);
    const Vector<Rows> bias = Take<Rows>(name + ".bias");
    Pack(all.leftCols<Columns>(), out);
    for (int s = 0; s < style_count; ++s) Pack(bias + all.col(Columns + s), style_bias[s]);
  }
  void Take(const std::string& name, LstmLayer& out) {
    const RowMajor input = Take(name + ".input", kGates, kLatent);
    const RowMajor hidden = Take(name + ".hidden", kGates, kLatent);
    const Vector<kGates> bias = Take<kGates>(name + ".bias");
    RowMajor weight(kGates, 2 * kLatent);
    Vector<kGates> ordered_bias;
    for (int row = 0; row < kGates; ++row) {
      const int gate = row / kLatent;  // of ifgo
      const int to = net::LstmRow(gate, row % kLatent);
      const float scale = gate == 2 ? 1.0F : 0.5F;
      weight.row(to) << scale * hidden.row(row), scale * input.row(row);
      ordered_bias[to] = scale * bias[row];
    }
    Pack(weight, out.weight);
    Pack(ordered_bias, out.bias);
    Pack(Take<kLatent>(name + ".h0"), out.h0);
    Pack(Take<kLatent>(name + ".c0"), out.c0);
  }
  void Finish() {
    if (!view_.tensors.empty()) {
      faults_.Add("tensor '" + view_.tensors.begin()->first + "': unknown");
    }
  }

 private:
  static std::string Spelled(const std::string& dtype, const std::vector<std::int64_t>& shape) {
    return dtype + " " + json(shape).dump();
  }

  RowMajor TakeShape(const std::string& name, const std::vector<std::int64_t>& shape, int rows,
                     int columns) {
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

  SafetensorsView& view_;
  Faults& faults_;
};

std::string LayerName(int style, int layer) {
  return "recurrent." + std::to_string(style) + "." + std::to_string(layer);
}

// The mean rotations give the hemispheres; a deviation divides.
void CheckFeatures(const Vector<kFeatureCount>& mean, const Vector<kFeatureCount>& deviation,
                   FeatureParameters& features, Faults& faults) {
  constexpr float kLeastNorm = 1e-3F;
  for (int i = 0; i < kFeatureCount; ++i) {
    if (!(deviation[i] > 0)) {
      faults.Add("tensor 'feature.deviation': expected values > 0, found " +
                 std::to_string(deviation[i]) + " at " + std::to_string(i));
    }
  }
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const Eigen::Vector4f q = mean.segment<4>(4 * joint);
    if (!(q.norm() >= kLeastNorm)) {
      faults.Add("tensor 'feature.mean': expected a rotation for " +
                 std::string(body::kHumanoid[joint].name) + ", found one of length " +
                 std::to_string(q.norm()));
    }
    features.hemisphere[joint].coeffs() = q.normalized();
  }
}

// The heads under each other. They give standardized features; deviation and mean are put into
// their weights, so that a step need not bring them back.
void TakeHeads(TensorReader& tensors, const Vector<kFeatureCount>& mean,
               const Vector<kFeatureCount>& deviation, Affine<kHeads, kDecoderWidths[2]>& out) {
  RowMajor weight(kHeads, kDecoderWidths[2]);
  Vector<kHeads> bias;
  int row = 0;
  const auto take = [&](const std::string& name, auto rows, int feature) {
    const auto scale = deviation.segment<rows>(feature);
    weight.middleRows<rows>(row) =
        scale.asDiagonal() * tensors.Take(name + ".weight", rows, kDecoderWidths[2]);
    bias.segment<rows>(row) =
        scale.cwiseProduct(tensors.Take<rows>(name + ".bias")) + mean.segment<rows>(feature);
    row += rows;
  };
  take("head.rotation", std::integral_constant<int, kRotationFeatures>(), 0);
  take("head.velocity", std::integral_constant<int, kVelocityFeatures>(), kVelocityBegin);
  take("head.height", std::integral_constant<int, 1>(), kHipsHeightIndex);
  Pack(weight, out.weight);
  Pack(bias, out.bias);
}

}  // namespace

Network::Network() : weights_(std::make_unique<Weights>()) {}

Result<std::shared_ptr<const Network>> Network::Load(const std::filesystem::path& file) {
  Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string());
}

Result<std::shared_ptr<const Network>> Network::Parse(std::span<const std::byte> bytes,
                                                      const std::string& name) {
  Result<SafetensorsView> view = net::ParseSafetensors(bytes, name);
  if (!view.ok()) return view.status();

  const std::shared_ptr<Network> network(new Network);
  Metadata& metadata = network->metadata_;
  Weights& w = *network->weights_;
  Faults faults(name);
  ReadMetadata(view.value().metadata, metadata, faults);
  if (!faults.none()) return faults.status();

  TensorReader tensors(view.value(), faults);
  const int style_count = network->style_count();
  const auto mean = tensors.Take<kFeatureCount>("feature.mean");
  const auto deviation = tensors.Take<kFeatureCount>("feature.deviation");
  if (faults.none()) CheckFeatures(mean, deviation, metadata.features, faults);
  Pack(mean, w.mean);
  Pack(deviation.cwiseInverse(), w.inverse_deviation);
  tensors.Take("encoder.0", style_count, w.encoder0, w.encoder0_bias);
  tensors.Take("encoder.1", w.encoder1);
  for (int l = 0; l < kNeutralLayers; ++l) tensors.Take(LayerName(0, l), w.neutral[l]);
  w.styles.resize(style_count - 1);
  for (int s = 1; s < style_count; ++s) {
    for (int l = 0; l < kStyleLayers; ++l) tensors.Take(LayerName(s, l), w.styles[s - 1][l]);
  }
  tensors.Take("decoder.0", style_count, w.decoder0, w.decoder0_bias);
  tensors.Take("decoder.1", w.decoder1);
  tensors.Take("decoder.2", w.decoder2);
  TakeHeads(tensors, mean, deviation, w.heads);
  tensors.Finish();
  if (!faults.none()) return faults.status();
  return std::shared_ptr<const Network>(network);
}

}  // namespace styled::erd
