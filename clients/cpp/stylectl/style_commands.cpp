// set, clear, preset, cue, pin, unpin, panic, reset: the commands that change styling.
#include <array>
#include <charconv>
#include <optional>

#include "clients/cpp/stylectl/cli.h"
#include "clients/cpp/stylectl/commands.h"
#include "clients/cpp/stylectl/report.h"
#include "clients/cpp/subscriber.h"
#include "model/base/text.h"
#include "model/tools/number.h"
#include "proto/styled/body_parts.h"

namespace styled::stylectl {
namespace {

struct SetArguments {
  std::string style;
  std::vector<std::string> mix;  // STYLE=WEIGHT
  std::optional<double> strength;
  std::optional<double> transition_ms;
  bool absolute = false, detail = false;
  std::string parts;        // of the body, comma-separated
  std::string input_style;  // the style that the performer already moves in
};

struct PresetArguments {
  std::array<std::string, 2> words;  // as given: performer and name, in either order
  std::optional<double> transition_ms;
};

// Checks --parts: "" or what is wrong.
std::string CheckParts(const std::string& list) {
  if (body::FindParts(list)) return "";
  return "'" + list + "': expected, separated by commas, some of " + std::string(body::kPartWords);
}

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

// Converts the options to a change. Returns a description of the change; "" if there is none.
std::string ToChange(const SetArguments& arguments, v1::Set& change) {
  if (!arguments.style.empty()) {
    change.add_mix()->set_style(arguments.style);
    change.mutable_mix(0)->set_weight(1.0F);
  }
  for (const std::string& text : arguments.mix) *change.add_mix() = *ParseWeight(text);
  std::string what = change.mix().empty() ? "" : MixText(change.mix());
  const auto add = [&what](const std::string& part) { what += (what.empty() ? "" : ", ") + part; };
  if (arguments.strength) {
    change.set_strength(static_cast<float>(*arguments.strength));
    add("strength " + NumberText(*arguments.strength));
  }
  if (arguments.transition_ms) {
    change.set_transition_ms(static_cast<float>(*arguments.transition_ms));
    add("transition " + NumberText(*arguments.transition_ms) + " ms");
  }
  if (arguments.absolute || arguments.detail) {
    change.set_absolute(arguments.absolute);
    add(arguments.absolute ? "absolute" : "detail-preserving");
  }
  const body::Parts parts = body::FindParts(arguments.parts).value_or(0);
  if (parts != 0) {
    AddParts(parts, *change.mutable_only());
    add(parts == body::kAllParts ? "all of the body" : "only " + body::PartsText(parts));
  }
  if (!arguments.input_style.empty()) {
    change.set_own_style(arguments.input_style);
    add("input style " + arguments.input_style);
  }
  return what;
}

int Set(Session& session, const SetArguments& arguments) {
  v1::Set change;
  const std::string what = ToChange(arguments, change);
  if (what.empty()) {
    return session.Usage(
        "set: nothing to set; expected --style, --mix, --strength, --transition, --parts, "
        "--input-style, --absolute or --detail (to go to bypass: stylectl clear)");
  }
  for (const auto& entry : change.mix()) session.styles.push_back(entry.style());
  if (!arguments.input_style.empty()) session.styles.push_back(arguments.input_style);
  client::Applied applied;
  return session.Changed(session.control().Set(session.performer, change, &applied), applied, what);
}

void DeclareSet(Session& session) {
  const auto arguments = std::make_shared<SetArguments>();
  CLI::App* set =
      session.AddOnline("set", "style, strength and transition of a performer; the rest stays",
                        [&session, arguments] { return Set(session, *arguments); });
  session.AddPerformer(set, true);
  CLI::Option* style = set->add_option("--style", arguments->style, "one style, at full weight");
  set->add_option("--mix", arguments->mix, "STYLE=WEIGHT, up to 4 times; weights sum to <= 1.5")
      ->excludes(style)
      ->allow_extra_args(false)  // one value per --mix: the next argument may be PERFORMER
      ->check([](const std::string& text) {
        return ParseWeight(text) ? std::string() : "'" + text + "' is not STYLE=WEIGHT";
      });
  set->add_option("--strength", arguments->strength, "0 (bypass) to 1.5")->check(Number(0.0, 1.5));
  set->add_option("--transition", arguments->transition_ms, "fade, ms; of later changes, too")
      ->check(Number(0.0, 60000.0));
  CLI::Option* absolute =
      set->add_flag("--absolute", arguments->absolute, "the network's pose as it is");
  set->add_flag("--detail", arguments->detail, "keep the performer's own detail (default)")
      ->excludes(absolute);
  set->add_option("--parts,--only", arguments->parts,
                  "style these parts alone, comma-separated: " + std::string(body::kPartWords))
      ->check(CheckParts);
  set->add_option("--input-style,--from", arguments->input_style,
                  "the style that the performer moves in, which is removed; neutral: none");
}

// Accepts `preset PERFORMER NAME`, the order of the other commands, and the former `preset NAME
// PERFORMER` and `preset NAME`. The order is unambiguous: a performer's id contains a dot or is
// '*', and a preset's name does not. Returns what is wrong, or "".
std::string SortPresetWords(const std::array<std::string, 2>& words, std::string& performer,
                            std::string& name) {
  const auto is_performer = [](const std::string& word) {
    return word == client::kEveryone || client::IsPerformerId(word);
  };
  const auto& [first, second] = words;
  const bool old = !is_performer(first);
  const std::string& given = old ? second : first;
  name = old ? first : second;
  if (name.empty()) return "expected NAME, or PERFORMER NAME";
  if (is_performer(name)) return "expected one PERFORMER, and the preset's NAME";
  if (given.empty()) return "";
  if (!is_performer(given)) {
    return "neither '" + first + "' nor '" + second +
           "' is SOURCE.NAME ([A-Za-z0-9_-]{1,32} each) or '*'; expected PERFORMER NAME";
  }
  performer = given;
  return "";
}

int Preset(Session& session, const PresetArguments& arguments) {
  const std::string wrong = SortPresetWords(arguments.words, session.performer, session.preset);
  if (!wrong.empty()) return session.Usage("preset: " + wrong);
  if (const int code = session.Connect(); code != kExitOk) return code;
  v1::Preset preset;
  preset.set_name(session.preset);
  if (arguments.transition_ms) {
    preset.set_transition_ms(static_cast<float>(*arguments.transition_ms));
  }
  client::Applied applied;
  return session.Changed(session.control().Preset(session.performer, preset, &applied), applied,
                         "preset " + session.preset);
}

void DeclarePreset(Session& session) {
  const auto arguments = std::make_shared<PresetArguments>();
  CLI::App* preset = session.Add("preset", "a named mix of the daemon's configuration",
                                 [&session, arguments] { return Preset(session, *arguments); });
  // CLI11 fills optional arguments from the front; SortPresetWords assigns them.
  preset->add_option("PERFORMER", arguments->words[0], "SOURCE.NAME, or '*'; left out: everyone");
  preset->add_option("NAME", arguments->words[1], "of the preset, as shown by list");
  preset->add_option("--transition", arguments->transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
}

void DeclareCue(Session& session) {
  session
      .AddOnline("cue", "fire the cues of that name, of the daemon's configuration",
                 [&session] {
                   client::Applied applied;
                   return session.Changed(session.control().Cue(session.cue, &applied), applied,
                                          "cue " + session.cue);
                 })
      ->add_option("NAME", session.cue, "as shown by list")
      ->required();
}

void DeclarePin(Session& session, const std::string& name, const std::string& text, bool pinned) {
  CLI::App* command = session.AddOnline(name, text, [&session, name, pinned] {
    client::Applied applied;
    return session.Changed(session.control().Pin(session.performer, pinned, &applied), applied,
                           name + "ned");
  });
  session.AddPerformer(command, true);
}

}  // namespace

void DeclareStyleCommands(Session& session) {
  DeclareSet(session);
  CLI::App* clear =
      session.AddOnline("clear", "fade to bypass, the performer as captured", [&session] {
        session.clears = true;
        client::Applied applied;
        return session.Changed(session.control().Clear(session.performer, &applied), applied,
                               "bypass");
      });
  session.AddPerformer(clear, false);
  DeclarePreset(session);
  DeclareCue(session);
  DeclarePin(session, "pin", "keep the style: commands to '*' pass the performer over", true);
  DeclarePin(session, "unpin", "undo pin", false);
  session.AddOnline("panic", "everyone to bypass, pinned or not", [&session] {
    client::Applied applied;
    return session.Changed(session.control().Panic(&applied), applied, "bypass");
  });
  CLI::App* reset =
      session.AddOnline("reset", "clear recurrent state, keep the settings", [&session] {
        client::Applied applied;
        return session.Changed(session.control().Reset(session.performer, &applied), applied,
                               "reset");
      });
  session.AddPerformer(reset, true);
}

}  // namespace styled::stylectl
