#include "daemon/config/look_keys.h"

#include <string>
#include <utility>

#include "daemon/config/keys.h"
#include "model/base/text.h"

namespace styled::config {
namespace {

Status ReadNumber(const LookNumber& number, const toml::node& node, v1::Look& look) {
  const auto value = node.value<double>();
  if (!node.is_number() || !value || !IsIn(number, *value)) {
    return Expected((number.whole ? "" : "a number from ") + styled::Expected(number), node);
  }
  (look.*number.set)(static_cast<float>(*value));
  return Status::Ok();
}

Status ReadParts(const toml::node& node, v1::Look& look) {
  const auto words = node.value<std::string>();
  const auto parts = words ? body::FindParts(*words) : std::nullopt;
  if (!parts) {
    return Expected("in quotes, separated by commas, some of " + std::string(body::kPartWords),
                    node);
  }
  SetParts(*parts, look);
  return Status::Ok();
}

Status AddWeight(std::string_view style, const toml::node& weight, v1::Look& look) {
  const auto value = weight.value<double>();
  if (!weight.is_number() || !value || !(*value >= 0) ||
      !(*value <= static_cast<double>(net::kMaxStrength))) {
    return Expected("a weight from 0 to 1.5 for \"" + Printable(style, kLongestName) + "\"",
                    weight);
  }
  auto& entry = *look.add_mix();
  entry.set_style(std::string(style));
  entry.set_weight(static_cast<float>(*value));
  return Status::Ok();
}

Status ReadMix(const toml::node& node, v1::Look& look) {
  const auto refuse = [&node] {
    return Expected("styles and weights, e.g. { elderly = 0.7, tired = 0.3 }", node);
  };
  v1::Look read;
  if (const toml::table* const table = node.as_table()) {
    if (table->empty()) return refuse();
    for (const auto& [style, weight] : *table) {
      const Status status = AddWeight(style.str(), weight, read);
      if (!status.ok()) return status;
    }
  } else if (const toml::array* const array = node.as_array()) {
    for (const auto& element : *array) {
      const toml::table* const entry = element.as_table();
      const auto style = entry == nullptr ? std::nullopt : (*entry)["style"].value<std::string>();
      if (!style || entry->get("weight") == nullptr || read.mix_size() == net::kMaxMix) {
        return refuse();
      }
      const Status status = AddWeight(*style, *entry->get("weight"), read);
      if (!status.ok()) return status;
    }
  } else {
    return refuse();
  }
  *look.mutable_mix() = std::move(*read.mutable_mix());
  return Status::Ok();
}

struct Reader {
  const toml::node& node;
  v1::Look& look;

  Status operator()(const LookNumber& number) const { return ReadNumber(number, node, look); }
  Status operator()(const LookFlag& flag) const {
    if (!node.is_boolean()) return Expected("true or false", node);
    (look.*flag.set)(*node.value<bool>());
    return Status::Ok();
  }
  Status operator()(const LookName& name) const {
    if (!node.is_string()) return Expected("a string in quotes", node);
    name.set(look, *node.value<std::string>());
    return Status::Ok();
  }
  Status operator()(const LookChoice& choice) const {
    const auto word = node.value<std::string>();
    const auto number = word ? FindChoice(choice, *word) : std::nullopt;
    if (!number) return Expected(ChoiceWords(choice) + ", in quotes", node);
    choice.set(look, *number);
    return Status::Ok();
  }
  Status operator()(const LookMix&) const { return ReadMix(node, look); }
  Status operator()(const LookParts&) const { return ReadParts(node, look); }
};

struct Writer {
  std::string_view key;
  const v1::Look& look;
  toml::table& table;

  void operator()(const LookNumber& number) const {
    table.insert(key, static_cast<double>((look.*number.get)()));
  }
  void operator()(const LookFlag& flag) const { table.insert(key, (look.*flag.get)()); }
  void operator()(const LookName& name) const { table.insert(key, (look.*name.get)()); }
  void operator()(const LookChoice& choice) const {
    table.insert(key, std::string(ChoiceWord(choice, look)));
  }
  void operator()(const LookMix&) const {
    toml::array mix;
    for (const auto& entry : look.mix()) {
      mix.push_back(
          toml::table{{"style", entry.style()}, {"weight", static_cast<double>(entry.weight())}});
    }
    table.insert(key, std::move(mix));
  }
  void operator()(const LookParts&) const { table.insert(key, body::PartsText(PartsOf(look))); }
};

}  // namespace

Status ReadLookField(const LookField& field, const toml::node& node, v1::Look& look) {
  return std::visit(Reader{node, look}, field.kind);
}

toml::table LookTable(const v1::Look& look) {
  toml::table table;
  for (const LookField& field : kLookFields) {
    std::visit(Writer{field.name, look, table}, field.kind);
  }
  return table;
}

}  // namespace styled::config
