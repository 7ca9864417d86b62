#include "clients/stylectl/look_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <vector>

#include "model/base/text.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

using nlohmann::json;

std::optional<v1::StyleWeight> ParseWeight(const std::string& text) {
  const std::size_t sign = text.rfind('=');
  if (sign == std::string::npos || sign == 0) return std::nullopt;
  float weight = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + sign + 1, end, weight);
  if (error != std::errc() || stop != end) return std::nullopt;
  v1::StyleWeight out;
  out.set_style(text.substr(0, sign));
  out.set_weight(weight);
  return out;
}

// "--input-style,--from" of input_style.
std::string Names(const LookField& field) {
  std::string names = "--" + std::string(field.word);
  if (!field.former.empty()) names.append(",--").append(field.former);
  std::replace(names.begin(), names.end(), '_', '-');
  return names;
}

// A preset is a command of its own, and vary_each a word of --vary.
bool IsOption(const LookField& field) {
  return field.name != "preset" && field.name != "vary_each";
}

// "ms" of transition_ms; "" of a field without a unit.
std::string_view UnitOf(const LookField& field) {
  for (const std::string_view suffix : {"_ms", "_s"}) {
    if (field.name.ends_with(suffix)) return suffix.substr(1);
  }
  return {};
}

// Removes the unit that follows a number: 5s.
CLI::Validator WithoutUnit(std::string_view unit) {
  return CLI::Validator(
      [unit](std::string& text) {
        const bool has = text.size() > unit.size() && text.ends_with(unit);
        if (has) text.resize(text.size() - unit.size());
        return std::string();
      },
      "");
}

struct OptionAdder {
  CLI::App& command;
  v1::Look& change;
  std::string names, help;
  std::string_view unit;

  void operator()(const LookNumber& number) const {
    if (number.whole) return AddVary(number);
    CLI::Option* const option =
        command
            .add_option_function<double>(
                names,
                [this_change = &change, set = number.set](double value) {
                  (this_change->*set)(static_cast<float>(value));
                },
                help)
            ->check(Number(static_cast<double>(number.low), static_cast<double>(number.high)));
    if (!unit.empty()) option->transform(WithoutUnit(unit));
  }
  // A number selects the same variation for everyone; `each` selects a different one per performer.
  void AddVary(const LookNumber& number) const {
    command
        .add_option_function<std::string>(
            names,
            [this_change = &change](const std::string& text) {
              const bool each = text == "each";
              this_change->set_vary(each ? 0 : std::stof(text));
              this_change->set_vary_each(each);
            },
            help + "; each: a different one per performer")
        ->check([most = static_cast<std::uint64_t>(number.high)](const std::string& text) {
          if (text == "each" || Whole(0, most)(text).empty()) return std::string();
          return "'" + text + "': expected a whole number from 0 to " + std::to_string(most) +
                 ", or each";
        });
  }
  void operator()(const LookFlag& flag) const {
    command.add_flag_callback(
        names, [this_change = &change, set = flag.set] { (this_change->*set)(true); }, help);
  }
  void operator()(const LookName& name) const {
    command.add_option_function<std::string>(
        names,
        [this_change = &change, set = name.set](const std::string& text) {
          set(*this_change, text);
        },
        help);
  }
  void operator()(const LookChoice& choice) const {
    command
        .add_option_function<std::string>(
            names,
            [this_change = &change, choice](const std::string& word) {
              choice.set(*this_change, FindChoice(choice, word).value_or(0));
            },
            help)
        ->check([choice](const std::string& word) {
          return FindChoice(choice, word) ? std::string()
                                          : "'" + word + "': expected " + ChoiceWords(choice);
        });
  }
  void operator()(const LookMix&) const {
    CLI::Option* const style = command.add_option_function<std::string>(
        "--style",
        [this_change = &change](const std::string& text) {
          auto& entry = *this_change->add_mix();
          entry.set_style(text);
          entry.set_weight(1);
        },
        "one style, at full weight");
    command
        .add_option_function<std::vector<std::string>>(
            names,
            [this_change = &change](const std::vector<std::string>& texts) {
              for (const std::string& text : texts) *this_change->add_mix() = *ParseWeight(text);
            },
            "STYLE=WEIGHT, up to 4 times; weights sum to <= 1.5")
        ->excludes(style)
        ->allow_extra_args(false)  // one value per --mix: the next argument may be PERFORMER
        ->check([](const std::string& text) {
          return ParseWeight(text) ? std::string() : "'" + text + "' is not STYLE=WEIGHT";
        });
  }
  void operator()(const LookParts&) const {
    command
        .add_option_function<std::string>(
            names,
            [this_change = &change](const std::string& words) {
              SetParts(body::FindParts(words).value_or(body::kAllParts), *this_change);
            },
            "style only these parts, comma-separated: " + std::string(body::kPartWords))
        ->check([](const std::string& words) {
          return body::FindParts(words)
                     ? std::string()
                     : "'" + words + "': expected, separated by commas, some of " +
                           std::string(body::kPartWords);
        });
  }
};

struct JsonWriter {
  const v1::Look& look;

  json operator()(const LookNumber& number) const { return (look.*number.get)(); }
  json operator()(const LookFlag& flag) const { return (look.*flag.get)(); }
  json operator()(const LookName& name) const { return (look.*name.get)(); }
  json operator()(const LookChoice& choice) const { return ChoiceWord(choice, look); }
  json operator()(const LookMix&) const { return MixJson(look.mix()); }
  json operator()(const LookParts&) const { return body::PartsText(PartsOf(look)); }
};

// The value in words; empty if the change does not contain the field.
struct TextWriter {
  const v1::Look& look;

  std::optional<std::string> operator()(const LookNumber& number) const {
    if (!(look.*number.has)()) return std::nullopt;
    return NumberText((look.*number.get)());
  }
  std::optional<std::string> operator()(const LookFlag& flag) const {
    if (!(look.*flag.has)()) return std::nullopt;
    return (look.*flag.get)() ? "on" : "off";
  }
  std::optional<std::string> operator()(const LookName& name) const {
    if (!(look.*name.has)()) return std::nullopt;
    const std::string& text = (look.*name.get)();
    return text.empty() ? "none" : text;
  }
  std::optional<std::string> operator()(const LookChoice& choice) const {
    if (!(look.*choice.has)()) return std::nullopt;
    return std::string(ChoiceWord(choice, look));
  }
  std::optional<std::string> operator()(const LookMix&) const {
    if (look.mix().empty()) return std::nullopt;
    return MixText(look.mix());
  }
  std::optional<std::string> operator()(const LookParts&) const {
    if (look.parts().empty()) return std::nullopt;
    return body::PartsText(PartsOf(look));
  }
};

void Append(const LookField& field, const std::string& value, std::string& text) {
  if (!text.empty()) text += ", ";
  std::string word(field.word);
  std::replace(word.begin(), word.end(), '_', ' ');
  if (field.name != "mix") text += word + " ";
  text += value;
  if (!UnitOf(field).empty()) text.append(" ").append(UnitOf(field));
}

}  // namespace

void AddLookOptions(CLI::App& command, v1::Look& change) {
  for (const LookField& field : kLookFields) {
    if (!IsOption(field)) continue;
    std::visit(OptionAdder{command, change, Names(field), std::string(field.help), UnitOf(field)},
               field.kind);
  }
  command
      .add_flag_callback(
          "--detail", [&change] { change.set_absolute(false); },
          "keep the performer's own detail (default)")
      ->excludes(command.get_option("--absolute"));
  command
      .add_flag_callback(
          "--no-mirror", [&change] { change.set_mirror(false); },
          "left and right as captured (default)")
      ->excludes(command.get_option("--mirror"));
}

std::string LookOptionNames() {
  std::string names = "--style";
  for (const LookField& field : kLookFields) {
    if (!IsOption(field)) continue;
    const std::string all = Names(field);
    names.append(", ").append(all, 0, all.find(','));
  }
  return names + ", --detail, --no-mirror";
}

json MixJson(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix) {
  json out = json::array();
  for (const auto& entry : mix) {
    out.push_back({{"style", entry.style()}, {"weight", entry.weight()}});
  }
  return out;
}

std::string MixText(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix,
                    const google::protobuf::RepeatedPtrField<std::string>& networks) {
  std::string out;
  for (int i = 0; i < mix.size(); ++i) {
    if (!out.empty()) out += " + ";
    std::array<char, 64> weight{};
    std::snprintf(weight.data(), weight.size(), " %.2f", static_cast<double>(mix[i].weight()));
    out += mix[i].style() + weight.data();
    if (i < networks.size() && !networks[i].empty()) out += " (" + networks[i] + ")";
  }
  return out.empty() ? "bypass" : out;
}

json LookJson(const v1::Look& look) {
  json out = json::object();
  for (const LookField& field : kLookFields) {
    out[std::string(field.name)] = std::visit(JsonWriter{look}, field.kind);
  }
  return out;
}

std::string ChangeText(const v1::Look& change) {
  std::string text;
  for (const LookField& field : kLookFields) {
    if (const auto value = std::visit(TextWriter{change}, field.kind)) Append(field, *value, text);
  }
  return text;
}

std::string NotesText(const v1::Look& look) {
  const v1::Look initial = InitialLook();
  std::string text;
  for (const LookField& field : kLookFields) {
    if (field.name == "mix" || field.name == "strength" || field.name == "transition_ms") continue;
    const auto value = std::visit(TextWriter{look}, field.kind);
    if (value && value != std::visit(TextWriter{initial}, field.kind)) Append(field, *value, text);
  }
  return text;
}

}  // namespace styled::stylectl
