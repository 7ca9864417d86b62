#include "proto/styled/look.h"

#include <algorithm>
#include <cmath>

#include "model/base/text.h"

namespace styled {
namespace {

// A visitor for std::visit, with one call operator per kind of field.
template <typename... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <typename... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

}  // namespace

const LookField* FindLookField(std::string_view name) noexcept {
  const auto* const found =
      std::find_if(kLookFields.begin(), kLookFields.end(), [name](const LookField& field) {
        return !name.empty() && (field.name == name || field.word == name || field.former == name);
      });
  return found == kLookFields.end() ? nullptr : found;
}

bool RequestsVariations(const v1::Look& look) {
  return (look.vary() > 0 || look.vary_each() || look.drift_s() > 0) && look.vary_amount() > 0;
}

bool IsIn(const LookNumber& number, double value) {
  return value >= static_cast<double>(number.low) && value <= static_cast<double>(number.high) &&
         (!number.whole || value == std::floor(value));
}

std::string Expected(const LookNumber& number) {
  return (number.whole ? "a whole number from " : "") + NumberText(number.low) + " to " +
         NumberText(number.high);
}

std::optional<int> FindChoice(const LookChoice& choice, std::string_view word) {
  const auto found = std::find(choice.words.begin(), choice.words.end(), word);
  if (found == choice.words.end()) return std::nullopt;
  return static_cast<int>(found - choice.words.begin());
}

std::string ChoiceWords(const LookChoice& choice) {
  std::string words;
  for (const std::string_view word : choice.words) {
    words.append(words.empty() ? "" : " or ").append(word);
  }
  return words;
}

std::string_view ChoiceWord(const LookChoice& choice, const v1::Look& look) {
  const auto number = static_cast<std::size_t>(choice.get(look));
  return choice.words[number < choice.words.size() ? number : 0];
}

body::Parts PartsOf(const v1::Look& look) {
  body::Parts parts = 0;
  for (const int part : look.parts()) {
    if (part == v1::BODY_PART_ALL) parts |= body::kAllParts;
    if (part > 0 && part <= body::kPartCount) parts |= body::Bit(static_cast<body::Part>(part - 1));
  }
  return parts;
}

void SetParts(body::Parts parts, v1::Look& look) {
  look.clear_parts();
  if (parts == body::kAllParts) return look.add_parts(v1::BODY_PART_ALL);
  for (int part = 0; part < body::kPartCount; ++part) {
    if ((parts >> part & 1) != 0) look.add_parts(static_cast<v1::BodyPart>(part + 1));
  }
}

v1::Look InitialLook() {
  v1::Look look;
  for (const LookField& field : kLookFields) {
    std::visit(Overloaded{[&](const LookNumber& number) { (look.*number.set)(number.initial); },
                          [&](const LookFlag& flag) { (look.*flag.set)(false); },
                          [&](const LookName& name) { name.set(look, ""); },
                          [&](const LookChoice& choice) { choice.set(look, 0); },
                          [&](const LookParts&) { SetParts(body::kAllParts, look); },
                          [](const LookMix&) {}},
               field.kind);
  }
  return look;
}

bool Equal(const v1::Look& a, const v1::Look& b) {
  return a.SerializeAsString() == b.SerializeAsString();
}

bool IsEmpty(const v1::Look& change) { return change.ByteSizeLong() == 0; }

void Apply(const v1::Look& change, v1::Look& look) {
  if (change.clear() || change.mix_size() > 0) {
    look.clear_mix();
    look.set_preset("");
  }
  if (change.parts_size() > 0) look.clear_parts();
  look.MergeFrom(change);
  look.clear_clear();
  SetParts(PartsOf(look), look);
}

Status CheckLook(const v1::Look& change) {
  for (const LookField& field : kLookFields) {
    if (const auto* const choice = std::get_if<LookChoice>(&field.kind)) {
      const int value = choice->get(change);
      if (value >= 0 && static_cast<std::size_t>(value) < choice->words.size()) continue;
      return Status::Error(std::string(field.name) + " is " + std::to_string(value) +
                           ", expected " + ChoiceWords(*choice));
    }
    const auto* const number = std::get_if<LookNumber>(&field.kind);
    if (number == nullptr || !(change.*number->has)()) continue;
    const float value = (change.*number->get)();
    if (IsIn(*number, static_cast<double>(value))) continue;
    return Status::Error(std::string(field.name) + " is " + NumberText(value) + ", expected " +
                         Expected(*number));
  }
  if (change.mix_size() > net::kMaxMix) {
    return Status::Error("mix has " + std::to_string(change.mix_size()) +
                         " styles, expected at most " + std::to_string(net::kMaxMix));
  }
  for (const int part : change.parts()) {
    if (!v1::BodyPart_IsValid(part)) {
      return Status::Error("parts has " + std::to_string(part) + ", expected a BodyPart, 0 to 6");
    }
  }
  return Status::Ok();
}

}  // namespace styled
