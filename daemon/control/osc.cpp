#include "daemon/control/osc.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "model/base/text.h"
#include "proto/styled/look.h"

namespace styled::control {
namespace {

using vmc::osc::Arguments;
using vmc::osc::Message;

// Consoles send numbers as OSC type f or i.
bool Number(Arguments& arguments, float& value) {
  std::int32_t whole = 0;
  if (arguments.Float(value)) return std::isfinite(value);
  if (!arguments.Int(whole)) return false;
  value = static_cast<float>(whole);
  return true;
}

bool Text(Arguments& arguments, std::string& value) {
  std::string_view text;
  // Protobuf strings must be UTF-8: other text would make replies and recordings unreadable.
  if (!arguments.Text(text) || !IsUtf8(text)) return false;
  value = text;
  return true;
}

// Each function below reads its arguments into the request and returns false when they do not fit.
bool Style(Arguments& arguments, v1::Request& request) {
  v1::Look& set = *request.mutable_set();
  auto& style = *set.add_mix();
  float strength = 0, transition_ms = 0;
  if (!Text(arguments, *style.mutable_style())) return false;
  style.set_weight(1);
  if (arguments.AtEnd()) return true;
  if (!Number(arguments, strength)) return false;
  set.set_strength(strength);
  if (arguments.AtEnd()) return true;
  if (!Number(arguments, transition_ms)) return false;
  set.set_transition_ms(transition_ms);
  return true;
}

// Reads one field of a look.
struct FieldReader {
  Arguments& arguments;
  v1::Look& look;

  bool operator()(const LookNumber& number) const {
    float value = 0;
    if (!Number(arguments, value)) return false;
    (look.*number.set)(value);
    return true;
  }
  bool operator()(const LookFlag& flag) const {
    float value = 0;
    if (!Number(arguments, value)) return false;
    (look.*flag.set)(value != 0);
    return true;
  }
  bool operator()(const LookName& name) const {
    std::string text;
    if (!Text(arguments, text)) return false;
    name.set(look, text);
    return true;
  }
  bool operator()(const LookChoice& choice) const {
    std::string word;
    if (!Text(arguments, word)) return false;
    const auto number = FindChoice(choice, word);
    if (number) choice.set(look, *number);
    return number.has_value();
  }
  bool operator()(const LookMix&) const {
    while (!arguments.AtEnd()) {
      auto& entry = *look.add_mix();
      float weight = 0;
      if (!Text(arguments, *entry.mutable_style()) || !Number(arguments, weight)) return false;
      entry.set_weight(weight);
    }
    return look.mix_size() > 0;
  }
  bool operator()(const LookParts&) const {
    std::string words;
    if (!Text(arguments, words)) return false;
    const auto parts = body::FindParts(words);
    if (parts) SetParts(*parts, look);
    return parts.has_value();
  }
};

std::string ExpectedOf(const LookField& field) {
  if (const auto* const number = std::get_if<LookNumber>(&field.kind)) {
    return (number->whole ? "" : "a number from ") + Expected(*number);
  }
  if (std::holds_alternative<LookFlag>(field.kind)) return "1 or 0";
  if (const auto* const choice = std::get_if<LookChoice>(&field.kind)) return ChoiceWords(*choice);
  if (std::holds_alternative<LookMix>(field.kind)) return "styles and weights in turn";
  return std::string(field.help);
}

bool Clear(Arguments&, v1::Request& request) {
  request.mutable_set()->set_clear(true);
  return true;
}

bool Preset(Arguments& arguments, v1::Request& request) {
  float transition_ms = 0;
  if (!Text(arguments, *request.mutable_preset()->mutable_name())) return false;
  if (arguments.AtEnd()) return true;
  if (!Number(arguments, transition_ms)) return false;
  request.mutable_preset()->set_transition_ms(transition_ms);
  return true;
}

bool Pin(Arguments& arguments, v1::Request& request) {
  float pinned = 0;
  if (!Number(arguments, pinned)) return false;
  request.mutable_pin()->set_pinned(pinned != 0);
  return true;
}

bool Reset(Arguments&, v1::Request& request) {
  request.mutable_reset();
  return true;
}

// No clip by path: a sender of OSC has no key, and a path would let it open files of this machine.
bool Learn(Arguments& arguments, v1::Request& request) {
  float seconds = 8;
  if (!Text(arguments, *request.mutable_like()->mutable_name())) return false;
  if (!arguments.AtEnd() && !Number(arguments, seconds)) return false;
  request.mutable_like()->set_learn_s(seconds);
  return seconds != 0;
}

// Sets all sliders.
bool Design(Arguments& arguments, v1::Request& request) {
  return Text(arguments, *request.mutable_like()->mutable_design()->mutable_preset());
}

// /styled/PERFORMER/design/SLIDER: the performer's part of `place`, or "" for another address.
std::string_view DesignedPerformer(std::string_view place) {
  constexpr std::string_view kDesign = "/design";
  return place.size() > kDesign.size() && place.ends_with(kDesign)
             ? place.substr(0, place.size() - kDesign.size())
             : std::string_view();
}

struct Row {
  std::string_view word;
  bool (*read)(Arguments&, v1::Request&);
  std::string_view expected;
};
// The commands of a performer beyond the fields of a look. A preset's own request fades, too.
constexpr std::array<Row, 7> kOfPerformers{{
    {"style", Style, "a style and, optionally, strength and transition in ms"},
    {"preset", Preset, "a preset and, optionally, transition in ms"},
    {"pin", Pin, "1 or 0"},
    {"clear", Clear, "nothing"},
    {"reset", Reset, "nothing"},
    {"learn", Learn, "a name for the style and, optionally, 1 to 60 seconds"},
    {"design", Design, "the name of a design"},
}};

// The value of a button: TouchOSC sends 1 when it is pressed and 0 when it is released. Only a
// press has an effect.
std::optional<float> Press(Arguments& arguments) {
  float value = 1;
  if (!arguments.AtEnd() && !Number(arguments, value)) return std::nullopt;
  return value;
}

}  // namespace

Result<v1::Request> ReadOsc(const Message& message) {
  const std::string address(message.address);
  const auto refuse = [&address](const std::string& expected) {
    return Status::Error(Printable(address, 120) + ": expected " + expected);
  };
  if (!IsUtf8(address)) return refuse("UTF-8");
  constexpr std::string_view kRoot = "/styled/";
  if (!address.starts_with(kRoot)) {
    return refuse("/styled/PERFORMER/style, /styled/cue, /styled/panic, ... (OSC.md)");
  }
  const std::string rest = address.substr(kRoot.size());
  Arguments arguments(message);
  v1::Request request;
  // An error from another daemon, or one of our own that came back. Answering it would start an
  // endless loop.
  if (rest == "error") return request;
  if (rest == "panic") {
    const auto pressed = Press(arguments);
    if (!pressed || !arguments.AtEnd()) return refuse("nothing, or 1");
    if (*pressed != 0) request.mutable_panic();
    return request;
  }
  if (rest == "cue") {
    if (!Text(arguments, *request.mutable_cue()->mutable_name()) || !arguments.AtEnd()) {
      return refuse("a cue's name");
    }
    return request;
  }
  if (rest.starts_with("cue/")) {
    const auto pressed = Press(arguments);
    if (!pressed || !arguments.AtEnd()) return refuse("nothing, or 1");
    if (*pressed != 0) request.mutable_cue()->set_name(rest.substr(4));
    return request;
  }
  const std::size_t slash = rest.rfind('/');
  const std::string_view word =
      slash == std::string::npos ? std::string_view() : std::string_view(rest).substr(slash + 1);
  if (const std::string_view who = DesignedPerformer(std::string_view(rest).substr(0, slash));
      slash != std::string::npos && !who.empty()) {
    float value = 0;
    request.set_performer(who == "all" ? "*" : std::string(who));
    if (!Number(arguments, value) || !arguments.AtEnd()) return refuse("a number");
    (*request.mutable_like()->mutable_design()->mutable_sliders())[std::string(word)] = value;
    return request;
  }
  for (const Row& row : kOfPerformers) {
    if (row.word != word) continue;
    const std::string performer = rest.substr(0, slash);
    request.set_performer(performer == "all" ? "*" : performer);
    if (row.read(arguments, request) && arguments.AtEnd()) return request;
    return refuse(std::string(row.expected));
  }
  if (const LookField* const field = FindLookField(word)) {
    const std::string performer = rest.substr(0, slash);
    request.set_performer(performer == "all" ? "*" : performer);
    const bool read = std::visit(FieldReader{arguments, *request.mutable_set()}, field->kind);
    if (read && arguments.AtEnd()) return request;
    return refuse(ExpectedOf(*field));
  }
  std::string words = "style";
  for (const LookField& field : kLookFields) words.append(", ").append(field.word);
  words += ", pin, clear, reset, learn, design, design/SLIDER";
  return refuse("/styled/PERFORMER/ and one of " + words + "; or /styled/cue, /styled/panic");
}

}  // namespace styled::control
