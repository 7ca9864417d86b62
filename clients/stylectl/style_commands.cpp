// set, clear, preset, cue, pin, unpin, panic, reset: the commands that change styling.
#include <array>
#include <memory>
#include <optional>

#include "clients/cpp/subscriber.h"
#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/look_options.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

struct PresetArguments {
  std::array<std::string, 2> words;  // as given: performer and name, in either order
  std::optional<double> transition_ms;
};

int Set(Session& session, const v1::Look& change) {
  const std::string what = ChangeText(change);
  if (what.empty()) {
    return session.Usage("set: nothing to set; expected " + LookOptionNames() +
                         " (to go to bypass: stylectl clear)");
  }
  for (const auto& entry : change.mix()) session.styles.push_back(entry.style());
  if (!change.input_style().empty()) session.styles.push_back(change.input_style());
  client::Applied applied;
  return session.Changed(session.control().Set(session.performer, change, &applied), applied, what);
}

void DeclareSet(Session& session) {
  const auto change = std::make_shared<v1::Look>();
  CLI::App* set =
      session.AddOnline("set", "style, strength and transition of a performer; the rest stays",
                        [&session, change] { return Set(session, *change); });
  session.AddPerformer(set, true);
  AddLookOptions(*set, *change);
}

// Accepts `preset PERFORMER NAME`, the order of the other commands, and the former `preset NAME
// PERFORMER` and `preset NAME`. The order is unambiguous: a performer's id contains a dot or is
// '*', and a preset's name does not. Returns the error, or "".
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
  CLI::App* preset = session.Add("preset", "a preset (named mix) of the daemon's configuration",
                                 [&session, arguments] { return Preset(session, *arguments); });
  // CLI11 fills optional arguments from the front; SortPresetWords assigns them.
  preset->add_option("PERFORMER", arguments->words[0], "SOURCE.NAME, or '*' (default)");
  preset->add_option("NAME", arguments->words[1], "name of the preset, as shown by list");
  preset->add_option("--transition", arguments->transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
}

void DeclareCue(Session& session) {
  session
      .AddOnline("cue", "fire the cues of that name in the daemon's configuration",
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
  DeclarePin(session, "pin", "keep the style: commands to '*' skip the performer", true);
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
