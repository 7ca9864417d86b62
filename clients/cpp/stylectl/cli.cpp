#include "clients/cpp/stylectl/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"
#include "clients/cpp/stylectl/doctor_report.h"
#include "clients/cpp/stylectl/key_commands.h"
#include "clients/cpp/stylectl/report.h"
#include "clients/cpp/stylectl/suggest.h"
#include "clients/cpp/subscriber.h"
#include "model/base/text.h"
#include "model/tools/number.h"
#include "proto/styled/body_parts.h"

namespace styled::stylectl {
namespace {

using client::CallStatus;
using nlohmann::json;

constexpr float kSloppy_deg = 15;  // a calibration that is taken, but not praised

struct Arguments {
  client::ControlOptions control;
  client::KeyOptions keys;
  KeyArguments clients;
  double timeout_s = 2.0;
  bool json = false;
  bool all_counters = false;
  double watch_s = 0;  // of status; 0: once
  std::string performer{client::kEveryone};
  std::string style, preset, cue;
  std::array<std::string, 2> preset_words;  // as given: performer and name, in either order
  std::vector<std::string> mix;             // STYLE=WEIGHT
  std::optional<double> strength;
  std::optional<double> transition_ms;
  bool absolute = false, detail = false;
  std::string only;  // parts of the body
  std::string from;  // what the performer moves in already
  std::string pose = "t", sensors = "full";
  int countdown_s = 3;
  bool forget = false;  // the calibration
  doctor::Options doctor;
};

// Whether the daemon may be at another endpoint.
bool MayBeElsewhere(client::Obstacle obstacle) {
  using client::Obstacle;
  return obstacle == Obstacle::kUnknownHost || obstacle == Obstacle::kUnreachable ||
         obstacle == Obstacle::kNobody || obstacle == Obstacle::kNoFile ||
         obstacle == Obstacle::kNoSocket || obstacle == Obstacle::kLeftBehind ||
         obstacle == Obstacle::kOtherSocket || obstacle == Obstacle::kNotZeroMq;
}

// A check of --only: empty, or what is wrong.
std::string CheckParts(const std::string& list) {
  if (body::FindParts(list)) return "";
  return "'" + list + "': expected, separated by commas, some of " + std::string(body::kPartWords);
}

// What a failed command leaves behind beside the reason.
struct Failure {
  std::string suggestion;
  std::string expected;
};

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

std::string Join(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

class Program {
 public:
  Program(std::ostream& out, std::ostream& err) : out_(out), err_(err) { Declare(); }

  int Run(std::vector<std::string> arguments);

 private:
  void Declare();
  void DeclareSet();
  void DeclareCalibrate();
  void DeclareDoctor();
  void DeclareKeys();
  std::vector<std::string> Commands() const;
  CLI::App* Command(const std::string& name, const std::string& text);
  void PerformerOf(CLI::App* command, bool required, bool everyone = true);

  int Unexpected(const std::string& reason);
  std::string TakePreset();  // what is wrong; "" = nothing
  int Execute(const std::string& command);
  int List();
  int Status();
  int Watch();
  int Set();
  int Calibrate();
  int Doctor();
  int Keys(const std::string& command);
  int Changed(const CallStatus& status, const client::Applied& applied, const std::string& what);
  int Fail(const CallStatus& status);
  int Usage(const std::string& text);
  Failure Explain(const CallStatus& status);
  std::string NoteUnseen();

  std::ostream& out_;
  std::ostream& err_;
  Arguments arguments_;
  v1::Set change_;
  CLI::App app_{"stylectl: ask and steer a running styled daemon", "stylectl"};
  std::unique_ptr<client::Control> control_;
};

CLI::App* Program::Command(const std::string& name, const std::string& text) {
  CLI::App* command = app_.add_subcommand(name, text);
  command->fallthrough();  // --json and the like may stand behind the command
  return command;
}

void Program::PerformerOf(CLI::App* command, bool required, bool everyone) {
  command
      ->add_option("PERFORMER", arguments_.performer,
                   !everyone  ? "SOURCE.NAME"
                   : required ? "SOURCE.NAME, or '*' for everyone"
                              : "SOURCE.NAME; default: everyone")
      ->required(required)
      ->check([everyone](const std::string& id) {
        if ((everyone && id == client::kEveryone) || client::IsPerformerId(id))
          return std::string();
        return "'" + id + "' is not SOURCE.NAME ([A-Za-z0-9_-]{1,32} each)" +
               (everyone ? " or '*'" : "");
      });
}

void Program::Declare() {
  app_.require_subcommand(0, 1);  // none: said by Run, after what was not expected
  app_.set_version_flag("--version", "stylectl 0.1.0");
  app_.add_option("--endpoint", arguments_.control.endpoint, "the daemon's control socket")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  client::Declare(app_, arguments_.keys);
  app_.add_option("--keys", arguments_.clients.folder,
                  "of allow, revoke and keys: the daemon's folder of keys, its security.keys")
      ->envname("STYLED_SECURITY_KEYS")
      ->capture_default_str();
  app_.add_option("--timeout", arguments_.timeout_s, "seconds to wait for an answer")
      ->check(Number(0.01, 600.0))
      ->capture_default_str();
  app_.add_flag("--json", arguments_.json, "one JSON object on standard output");
  app_.footer(
      "Exit codes: 0 done, 1 the daemon refused, 2 usage, 3 no daemon answers.\n"
      "Examples:\n"
      "  stylectl set '*' --style old --strength 0.8\n"
      "  stylectl set rig.anna --mix old=0.6 --mix feminine=0.4 --transition 1000\n"
      "  stylectl clear rig.anna");
  Command("list", "styles and presets");
  CLI::App* status = Command("status", "the daemon, its performers, its counters");
  status
      ->add_option("--watch", arguments_.watch_s,
                   "again every so many seconds (1 where none are said), until Ctrl-C")
      ->expected(0, 1)
      ->default_str("1")
      ->check(Number(0.1, 3600.0));
  status->add_flag("--all", arguments_.all_counters, "counters that are 0, too");
  DeclareSet();
  PerformerOf(Command("clear", "fade to bypass, the performer as captured"), false);
  CLI::App* preset = Command("preset", "a named mix of the daemon's configuration");
  // Both are optional to CLI11, which fills them from the front; TakePreset sorts them.
  preset->add_option("PERFORMER", arguments_.preset_words[0],
                     "SOURCE.NAME, or '*'; left out: everyone");
  preset->add_option("NAME", arguments_.preset_words[1], "of the preset, as shown by list");
  preset->add_option("--transition", arguments_.transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
  Command("cue", "fire the cues of that name, of the daemon's configuration")
      ->add_option("NAME", arguments_.cue, "as shown by list")
      ->required();
  PerformerOf(Command("pin", "keep the style: commands to '*' pass the performer over"), true);
  PerformerOf(Command("unpin", "undo pin"), true);
  Command("panic", "everyone to bypass, pinned or not");
  PerformerOf(Command("reset", "clear recurrent state, keep the settings"), true);
  DeclareCalibrate();
  DeclareDoctor();
  DeclareKeys();
}

void Program::DeclareSet() {
  CLI::App* set = Command("set", "style, strength and transition of a performer; the rest stays");
  PerformerOf(set, true);
  CLI::Option* style = set->add_option("--style", arguments_.style, "one style, at full weight");
  set->add_option("--mix", arguments_.mix, "STYLE=WEIGHT, up to 4 times; weights sum to <= 1.5")
      ->excludes(style)
      ->allow_extra_args(false)  // one per --mix: what follows may be PERFORMER
      ->check([](const std::string& text) {
        return ParseWeight(text) ? std::string() : "'" + text + "' is not STYLE=WEIGHT";
      });
  set->add_option("--strength", arguments_.strength, "0 (bypass) to 1.5")->check(Number(0.0, 1.5));
  set->add_option("--transition", arguments_.transition_ms, "fade, ms; of later changes, too")
      ->check(Number(0.0, 60000.0));
  CLI::Option* absolute =
      set->add_flag("--absolute", arguments_.absolute, "the network's pose as it is");
  set->add_flag("--detail", arguments_.detail, "keep the performer's own detail (default)")
      ->excludes(absolute);
  set->add_option("--only", arguments_.only,
                  "style these parts alone, comma-separated: " + std::string(body::kPartWords))
      ->check(CheckParts);
  set->add_option("--from", arguments_.from,
                  "what the performer moves in already, to be taken away; neutral: nothing");
}

void Program::DeclareCalibrate() {
  CLI::App* calibrate =
      Command("calibrate", "take how a performer stands now as the rest pose of their rig");
  PerformerOf(calibrate, true, false);
  CLI::Option* pose =
      calibrate
          ->add_option("--pose", arguments_.pose, "t: arms sideways, palms down; n: arms hanging")
          ->check(CLI::IsMember({"t", "n"}))
          ->capture_default_str();
  calibrate
      ->add_option("--sensors", arguments_.sensors,
                   "of rigs of sensors: full (as worn, and heading), yaw (heading), mounting")
      ->check(CLI::IsMember({"full", "yaw", "mounting"}))
      ->capture_default_str();
  calibrate->add_option("--countdown", arguments_.countdown_s, "seconds to take up the pose")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  calibrate->add_flag("--clear", arguments_.forget, "forget the calibration")->excludes(pose);
}

void Program::DeclareDoctor() {
  doctor::Options& options = arguments_.doctor;
  CLI::App* doctor = Command("doctor", "connected, but nothing arrives: find out where it ends");
  doctor->add_option("--config", options.config, "the daemon's styled.toml");
  doctor->add_option("--source", options.source, "look at this source alone");
  doctor->add_option("--seconds", options.seconds, "how long to listen")
      ->check(Number(0.2, 60.0))
      ->capture_default_str();
  doctor->add_option("--listen", options.listen, "TYPE=HOST:PORT: look there, too")
      ->allow_extra_args(false);
  doctor->add_flag("!--no-capture", options.capture,
                   "listen on free ports alone, even with root's rights");
  doctor->footer("Exit codes: 0 all is well, 1 a problem was found, 2 usage.");
}

// On files of this machine: no daemon is asked.
void Program::DeclareKeys() {
  KeyArguments& clients = arguments_.clients;
  Command("keygen", "make a pair of keys in a new file, print the public one")
      ->add_option("FILE", clients.file, "where it is kept; for your eyes only")
      ->required();
  CLI::App* allow = Command("allow", "let a client with this key in, at once");
  allow->add_option("NAME", clients.name, "the client's name here: A-Z a-z 0-9 _ -")->required();
  allow->add_option("PUBLICKEY", clients.key, "as keygen printed it, or a file that holds it")
      ->required();
  allow
      ->add_option("--role", clients.role,
                   "subscriber: frames; operator: frames and the control socket")
      ->check(CLI::IsMember({"subscriber", "operator"}))
      ->capture_default_str();
  CLI::App* revoke = Command("revoke", "let a client in no more; it is cut off at once");
  revoke->add_option("NAME", clients.name, "as shown by keys")->required();
  Command("keys", "the daemon's key, and who is let in");
}

int Program::Keys(const std::string& command) {
  const KeyArguments& clients = arguments_.clients;
  auto report = command == "keygen"   ? Keygen(clients)
                : command == "allow"  ? AllowKey(clients)
                : command == "revoke" ? RevokeKey(clients)
                                      : ListKeys(clients);
  if (!report.ok()) {
    err_ << "stylectl: " << report.status().message() << "\n";
    if (arguments_.json) {
      out_ << json{{"ok", false}, {"code", "KEYS"}, {"reason", report.status().message()}}.dump()
           << "\n";
    }
    return kExitRefused;
  }
  report.value().object["ok"] = true;
  out_ << (arguments_.json ? report.value().object.dump() + "\n" : report.value().text);
  return kExitOk;
}

int Program::Doctor() {
  doctor::Options& options = arguments_.doctor;
  options.endpoint = arguments_.control.endpoint;
  options.endpoint_given = app_.get_option("--endpoint")->count() > 0;
  options.timeout = arguments_.control.timeout;
  options.curve = arguments_.control.curve;
  return RunDoctor(options, arguments_.json, out_, err_);
}

int Program::Run(std::vector<std::string> arguments) {
  const bool folder_given =  // here, not in the environment
      std::any_of(arguments.begin(), arguments.end(), [](const std::string& word) {
        return word == "--keys" || word.starts_with("--keys=");
      });
  std::reverse(arguments.begin(), arguments.end());  // what CLI11 takes
  try {
    app_.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_.exit(error, out_, err_), kExitOk;
    return Unexpected(error.what());
  }
  if (app_.get_subcommands().empty()) {
    return Usage("a command is required; expected one of " + Join(Commands()));
  }
  const std::string command = app_.get_subcommands().front()->get_name();
  const bool of_keys = command == "allow" || command == "revoke" || command == "keys";
  if (folder_given && !of_keys) {
    return Usage(
        "--keys FOLDER is of allow, revoke and keys; a client's own pair of keys is --key");
  }
  if (command == "preset") {
    if (const std::string wrong = TakePreset(); !wrong.empty()) return Usage("preset: " + wrong);
  }
  if (command == "keygen" || command == "allow" || command == "revoke" || command == "keys") {
    return Keys(command);
  }
  auto curve = client::ReadKeys(arguments_.keys);
  if (!curve.ok()) return Usage(curve.status().message());
  arguments_.control.curve = std::move(curve.value());
  arguments_.control.timeout =
      std::chrono::milliseconds(static_cast<int>(arguments_.timeout_s * 1000.0));
  auto control = client::Control::Connect(arguments_.control);
  if (!control.ok()) return Usage(control.status().message());
  control_ = std::move(control.value());
  return Execute(command);
}

std::vector<std::string> Program::Commands() const {
  std::vector<std::string> names;
  for (const CLI::App* command : app_.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

// A command line that CLI11 refuses. Where a command or an option is misspelt, what was meant.
int Program::Unexpected(const std::string& reason) {
  const auto chosen = app_.get_subcommands();
  std::vector<std::string> options;
  const auto add = [&options](const CLI::App& app) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    }
  };
  add(app_);
  if (!chosen.empty()) add(*chosen.front());
  for (const std::string& word : app_.remaining(true)) {
    const bool option = word.starts_with("--");
    if (!option && (word.starts_with("-") || !chosen.empty())) continue;
    const std::string name = word.substr(0, word.find('='));
    const std::string near = Nearest(name, option ? options : Commands());
    std::string text = "'" + name + "' is no " + (option ? "option" : "command");
    if (option && !chosen.empty()) text += " of " + chosen.front()->get_name();
    if (!near.empty()) {
      text += "; did you mean '" + near + "'?";
    } else if (!option) {
      text += "; expected one of " + Join(Commands());
    }
    return Usage(text);
  }
  return Usage(reason);
}

// `preset PERFORMER NAME`, as every other command; `preset NAME PERFORMER`, as it once was, and
// `preset NAME`. They cannot be confused: a performer's id has a dot, or is '*'; a name has none.
std::string Program::TakePreset() {
  const auto is_performer = [](const std::string& word) {
    return word == client::kEveryone || client::IsPerformerId(word);
  };
  const auto& [first, second] = arguments_.preset_words;
  const bool old = !is_performer(first);
  const std::string& performer = old ? second : first;
  arguments_.preset = old ? first : second;
  if (arguments_.preset.empty()) return "expected NAME, or PERFORMER NAME";
  if (is_performer(arguments_.preset)) return "expected one PERFORMER, and the preset's NAME";
  if (performer.empty()) return "";
  if (!is_performer(performer)) {
    return "neither '" + first + "' nor '" + second +
           "' is SOURCE.NAME ([A-Za-z0-9_-]{1,32} each) or '*'; expected PERFORMER NAME";
  }
  arguments_.performer = performer;
  return "";
}

int Program::Execute(const std::string& command) {
  const std::string& performer = arguments_.performer;
  client::Applied applied;
  if (command == "list") return List();
  if (command == "status") return arguments_.watch_s > 0 ? Watch() : Status();
  if (command == "set") return Set();
  if (command == "calibrate") return Calibrate();
  if (command == "doctor") return Doctor();
  if (command == "clear") return Changed(control_->Clear(performer, &applied), applied, "bypass");
  if (command == "cue") {
    return Changed(control_->Cue(arguments_.cue, &applied), applied, "cue " + arguments_.cue);
  }
  if (command == "panic") return Changed(control_->Panic(&applied), applied, "bypass");
  if (command == "reset") return Changed(control_->Reset(performer, &applied), applied, "reset");
  if (command == "pin" || command == "unpin") {
    return Changed(control_->Pin(performer, command == "pin", &applied), applied, command + "ned");
  }
  v1::Preset preset;
  preset.set_name(arguments_.preset);
  if (arguments_.transition_ms) {
    preset.set_transition_ms(static_cast<float>(*arguments_.transition_ms));
  }
  return Changed(control_->Preset(performer, preset, &applied), applied,
                 "preset " + arguments_.preset);
}

int Program::List() {
  v1::ListReply list;
  if (const CallStatus status = control_->List(&list); !status.ok()) return Fail(status);
  if (arguments_.json) {
    json object = ListJson(list);
    object["ok"] = true;
    out_ << object.dump() << "\n";
  } else {
    out_ << ListText(list);
  }
  return kExitOk;
}

int Program::Status() {
  v1::StatusReply reply;
  if (const CallStatus status = control_->Status(&reply); !status.ok()) return Fail(status);
  if (arguments_.json) {
    json object = StatusJson(reply);
    object["ok"] = true;
    out_ << object.dump() << "\n";
  } else {
    out_ << StatusText(reply, arguments_.all_counters);
  }
  return kExitOk;
}

// A daemon that goes away is waited for.
int Program::Watch() {
  constexpr const char* kHome = "\x1b[H\x1b[2J";
  for (;;) {
    if (!arguments_.json) out_ << kHome;
    (void)Status();
    out_ << std::flush;
    std::this_thread::sleep_for(std::chrono::duration<double>(arguments_.watch_s));
    if (!out_) return kExitOk;  // nobody reads any more
  }
}

int Program::Set() {
  if (!arguments_.style.empty()) {
    change_.add_mix()->set_style(arguments_.style);
    change_.mutable_mix(0)->set_weight(1.0F);
  }
  for (const std::string& text : arguments_.mix) *change_.add_mix() = *ParseWeight(text);
  std::string what = change_.mix().empty() ? "" : MixText(change_.mix());
  const auto add = [&what](const std::string& part) { what += (what.empty() ? "" : ", ") + part; };
  if (arguments_.strength) {
    change_.set_strength(static_cast<float>(*arguments_.strength));
    add("strength " + NumberText(*arguments_.strength));
  }
  if (arguments_.transition_ms) {
    change_.set_transition_ms(static_cast<float>(*arguments_.transition_ms));
    add("transition " + NumberText(*arguments_.transition_ms) + " ms");
  }
  if (arguments_.absolute || arguments_.detail) {
    change_.set_absolute(arguments_.absolute);
    add(arguments_.absolute ? "absolute" : "detail-preserving");
  }
  const body::Parts parts = body::FindParts(arguments_.only).value_or(0);
  if (parts != 0) {
    AddParts(parts, *change_.mutable_only());
    add(parts == body::kAllParts ? "all of the body" : "only " + body::PartsText(parts));
  }
  if (!arguments_.from.empty()) {
    change_.set_own_style(arguments_.from);
    add("from " + arguments_.from);
  }
  if (what.empty()) {
    return Usage(
        "set: nothing to set; expected --style, --mix, --strength, --transition, --only, --from, "
        "--absolute or --detail (to go to bypass: stylectl clear)");
  }
  client::Applied applied;
  return Changed(control_->Set(arguments_.performer, change_, &applied), applied, what);
}

int Program::Calibrate() {
  v1::Calibrate wanted;
  wanted.set_clear(arguments_.forget);
  wanted.set_pose(arguments_.pose == "n" ? v1::Calibrate::POSE_N : v1::Calibrate::POSE_T);
  wanted.set_sensors(arguments_.sensors == "full"  ? v1::Calibrate::SENSORS_FULL
                     : arguments_.sensors == "yaw" ? v1::Calibrate::SENSORS_YAW
                                                   : v1::Calibrate::SENSORS_MOUNTING);
  for (int left_s = arguments_.forget ? 0 : arguments_.countdown_s; left_s > 0; --left_s) {
    err_ << left_s << "... " << std::flush;
    std::this_thread::sleep_for(std::chrono::seconds(1));
    if (left_s == 1) err_ << "now\n";
  }
  v1::CalibrateReply told;
  const CallStatus status = control_->Calibrate(arguments_.performer, wanted, &told);
  if (!status.ok()) return Fail(status);
  if (arguments_.json) {
    json object{{"ok", true}, {"performer", arguments_.performer}};
    if (!told.worst_joint().empty()) {
      object["worst_joint"] = told.worst_joint();
      object["worst_degrees"] = told.worst_degrees();
      object["left_handed"] = told.left_handed();
    }
    out_ << object.dump() << "\n";
    return kExitOk;
  }
  out_ << arguments_.performer << (arguments_.forget ? ": calibration forgotten" : ": calibrated");
  if (!told.worst_joint().empty()) {
    out_ << "; " << told.worst_joint() << " stood farthest off, by "
         << std::lround(told.worst_degrees()) << " degrees";
    if (told.worst_degrees() > kSloppy_deg) {
      out_ << ": that is much, and is in every pose from now on; better stand straight "
              "and calibrate again";
    }
    if (told.left_handed()) out_ << "; the rig's axes are left-handed and are mirrored";
  }
  out_ << "\n";
  return kExitOk;
}

int Program::Changed(const CallStatus& status, const client::Applied& applied,
                     const std::string& what) {
  if (!status.ok()) return Fail(status);
  const std::string note = NoteUnseen();
  if (arguments_.json) {
    json object{{"ok", true}, {"applied", AppliedJson(applied)}};
    if (!note.empty()) object["note"] = note;
    out_ << object.dump() << "\n";
  } else {
    out_ << AppliedText(applied, what);
    if (!note.empty()) err_ << "note: " << note << "\n";
  }
  return kExitOk;
}

// A performer may be configured before it comes; a misspelt one would wait forever, silently.
std::string Program::NoteUnseen() {
  const std::string& wanted = arguments_.performer;
  v1::StatusReply status;
  if (wanted == client::kEveryone || !control_->Status(&status).ok()) return "";
  std::vector<std::string> names;
  bool listed = false;
  for (const auto& performer : status.stats().performers()) {
    if (performer.performer() == wanted && performer.sequence() > 0) return "";
    if (performer.performer() != wanted) names.push_back(performer.performer());
    listed = listed || performer.performer() == wanted;
  }
  // Bypass is what a performer comes with: the daemon keeps nothing then.
  std::string note =
      wanted + (app_.got_subcommand("clear") && !listed
                    ? " has not been seen yet; what was configured ahead is forgotten"
                    : " has not been seen yet and is configured ahead");
  if (const std::string near = Nearest(wanted, names); !near.empty()) {
    note += "; did you mean " + near + "?";
  } else if (!names.empty() && names.size() <= 8) {
    note += " (here: " + Join(names) + ")";
  }
  return note;
}

// What was misspelt, found by asking the daemon what it knows.
Failure Program::Explain(const CallStatus& status) {
  Failure failure;
  v1::ListReply list;
  if (status.code() == v1::CODE_UNKNOWN_STYLE || status.code() == v1::CODE_UNKNOWN_PRESET ||
      status.code() == v1::CODE_UNKNOWN_CUE) {
    if (!control_->List(&list).ok()) return failure;
  }
  if (status.code() == v1::CODE_UNKNOWN_STYLE) {
    std::vector<std::string> known, names;
    for (const auto& style : list.styles()) {
      if (style.neutral()) continue;
      names.push_back(style.name());
      known.push_back(style.name());
      known.insert(known.end(), style.aliases().begin(), style.aliases().end());
    }
    std::vector<std::string> asked;
    for (const auto& wanted : change_.mix()) asked.push_back(wanted.style());
    if (!change_.own_style().empty()) asked.push_back(change_.own_style());
    for (const std::string& wanted : asked) {
      const auto same = [&](const std::string& name) { return Distance(name, wanted) == 0; };
      if (std::any_of(known.begin(), known.end(), same)) continue;
      if (failure.suggestion.empty()) failure.suggestion = Nearest(wanted, known);
    }
    failure.expected = "styles: " + Join(names);
  } else if (status.code() == v1::CODE_UNKNOWN_CUE) {
    std::vector<std::string> names;
    for (const auto& cue : list.cues()) names.push_back(cue.name());
    failure.suggestion = Nearest(arguments_.cue, names);
    failure.expected = names.empty() ? "the configuration has no cues" : "cues: " + Join(names);
  } else if (status.code() == v1::CODE_UNKNOWN_PRESET) {
    std::vector<std::string> names;
    for (const auto& preset : list.presets()) names.push_back(preset.name());
    failure.suggestion = Nearest(arguments_.preset, names);
    failure.expected =
        names.empty() ? "the configuration has no presets" : "presets: " + Join(names);
  } else if (status.code() == v1::CODE_UNKNOWN_PERFORMER) {
    v1::StatusReply reply;
    if (!control_->Status(&reply).ok()) return failure;
    std::vector<std::string> names;
    for (const auto& entry : reply.stats().performers()) {
      // One that is only configured ahead is listed too, and may be the very one.
      if (entry.performer() != arguments_.performer) names.push_back(entry.performer());
    }
    failure.suggestion = Nearest(arguments_.performer, names);
    failure.expected = names.empty() ? "no performer is here" : "performers: " + Join(names);
  } else if (status.code() == v1::CODE_PINNED) {
    failure.expected = "first: stylectl unpin " + arguments_.performer;
  }
  return failure;
}

int Program::Fail(const CallStatus& status) {
  const bool refused = status.kind() == CallStatus::Kind::kRefused;
  Failure failure;
  if (refused) {
    failure = Explain(status);
  } else {
    failure.expected = status.obstacle() == client::Obstacle::kNone
                           ? "--timeout gives it longer; styled's journal says what it does"
                           : client::Advice(status.obstacle(), client::Peer::kControl);
    if (MayBeElsewhere(status.obstacle())) {
      failure.expected += " Another endpoint: --endpoint or STYLED_CONTROL";
    }
  }
  err_ << "stylectl: " << status.reason();
  if (!failure.suggestion.empty()) err_ << "; did you mean '" << failure.suggestion << "'?";
  err_ << "\n";
  // Most reasons say themselves what was expected.
  const bool said = refused && status.reason().find("expected") != std::string::npos;
  if (!failure.expected.empty() && !said) err_ << "  " << failure.expected << "\n";
  if (arguments_.json) {
    json object{{"ok", false},
                {"code", refused ? client::CodeName(status.code()) : "NO_ANSWER"},
                {"reason", status.reason()}};
    if (!failure.suggestion.empty()) object["suggestion"] = failure.suggestion;
    if (!failure.expected.empty()) object["expected"] = failure.expected;
    out_ << object.dump() << "\n";
  }
  return refused ? kExitRefused : kExitNoDaemon;
}

int Program::Usage(const std::string& text) {
  err_ << "stylectl: " << text << "\n  see stylectl --help, stylectl COMMAND --help\n";
  if (arguments_.json) {
    out_ << json{{"ok", false}, {"code", "USAGE"}, {"reason", text}}.dump() << "\n";
  }
  return kExitUsage;
}

}  // namespace

int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err) {
  return Program(out, err).Run(std::move(arguments));
}

}  // namespace styled::stylectl
