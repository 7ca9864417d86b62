// like, learn, vary: the commands that make a style.
#include <cctype>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/like_report.h"
#include "model/base/read_file.h"
#include "model/base/text.h"
#include "model/rig/dialects.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

constexpr std::size_t kMaxClipBytes = 8 * 1024 * 1024 - 4096;  // a request with it is at most 8 MiB
constexpr std::size_t kMaxNameBytes = 32;

struct Arguments {
  std::string name;
  std::optional<double> transition_ms;
  // like
  std::string clip, rig = "auto", neutral_clip, network;
  std::vector<std::string> joints;
  bool unworn = false, add = false;
  // learn
  double seconds = 8;
  std::optional<double> neutral_s;
  int countdown_s = 3;
  // vary
  std::string style;
  std::uint64_t seed = 1;
  double amount = 1;
};

// The file's name without its extension, changed to a valid style name.
std::string NameOf(const std::string& file) {
  std::string name = std::filesystem::path(file).stem();
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 || (std::isalnum(byte) == 0 && c != '_' && c != '-')) c = '-';
  }
  name.erase(0, name.find_first_not_of('-'));  // it would look like an option
  if (name.empty()) name = "style";
  return name.substr(0, kMaxNameBytes);
}

// Sends the request, whose example is there, and reports.
int Make(Session& session, const Arguments& arguments, v1::Like request) {
  if (arguments.transition_ms) {
    request.set_transition_ms(static_cast<float>(*arguments.transition_ms));
  }
  return MakeStyle(session, arguments.unworn ? "" : session.performer, request);
}

// Requests the code of a neutral example, and writes it into the request.
int MeasureNeutral(Session& session, v1::Like neutral, v1::Like& request) {
  neutral.set_measure(true);
  v1::LikeReply reply;
  const client::CallStatus status = session.control().Like(session.performer, neutral, &reply);
  if (!status.ok()) return session.Fail(status);
  *request.mutable_neutral_code() = reply.code();
  return kExitOk;
}

// Reads the example of a request. `option` is named in errors.
int ReadExample(Session& session, const std::string& file, const char* option, v1::Like& request) {
  auto clip = ReadFile(file, kMaxClipBytes);
  if (!clip.ok()) return session.Usage("like: " + std::string(option) + clip.status().message());
  if (clip.value().empty()) {
    return session.Usage("like: " + std::string(option) + file +
                         ": is empty, expected a clip (BVH, GLB or VRMA)");
  }
  request.set_clip(std::move(clip.value()));
  request.set_file(std::filesystem::path(file).filename());
  return kExitOk;
}

int Like(Session& session, const Arguments& arguments) {
  v1::Like request, neutral;
  request.set_name(arguments.name.empty() ? NameOf(arguments.clip) : arguments.name);
  request.set_rig(arguments.rig);
  request.set_network(arguments.network);
  request.set_add(arguments.add);
  const auto joints = rig::ParseJoints("--joints", arguments.joints);
  if (!joints.ok()) return session.Usage("like: " + joints.status().message());
  for (v1::Like* const like : {&request, &neutral}) {
    like->mutable_joints()->insert(joints.value().begin(), joints.value().end());
  }
  neutral.set_network(arguments.network);
  neutral.set_rig(arguments.rig);
  int code = ReadExample(session, arguments.clip, "--clip ", request);
  if (code == kExitOk && !arguments.neutral_clip.empty()) {
    code = ReadExample(session, arguments.neutral_clip, "--neutral ", neutral);
    if (code == kExitOk) code = MeasureNeutral(session, std::move(neutral), request);
  }
  return code == kExitOk ? Make(session, arguments, std::move(request)) : code;
}

void CountDown(Session& session, int countdown_s, double seconds, const char* what) {
  session.err << what;
  for (int left_s = countdown_s; left_s > 0; --left_s) {
    session.err << left_s << "... " << std::flush;
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  session.err << "now, for " << NumberText(seconds, 1) << " s\n" << std::flush;
}

int Learn(Session& session, const Arguments& arguments) {
  v1::Like request, neutral;
  if (arguments.neutral_s) {
    CountDown(session, arguments.countdown_s, *arguments.neutral_s, "as usual: ");
    neutral.set_learn_s(static_cast<float>(*arguments.neutral_s));
    const int code = MeasureNeutral(session, std::move(neutral), request);
    if (code != kExitOk) return code;
  }
  CountDown(session, arguments.countdown_s, arguments.seconds,
            arguments.neutral_s ? "in the style: " : "");
  request.set_name(arguments.name);
  request.set_learn_s(static_cast<float>(arguments.seconds));
  return Make(session, arguments, std::move(request));
}

int Vary(Session& session, const Arguments& arguments) {
  v1::Like request;
  request.set_name(arguments.name.empty() ? arguments.style + "-" + std::to_string(arguments.seed)
                                          : arguments.name);
  v1::Variation& vary = *request.mutable_vary();
  vary.set_style(arguments.style);
  vary.set_seed(arguments.seed);
  vary.set_amount(static_cast<float>(arguments.amount));
  session.styles.push_back(arguments.style);
  return Make(session, arguments, std::move(request));
}

// `everyone`: whether '*' is allowed; a style can only be learned from a single performer.
void AddCommon(Session& session, CLI::App* command, Arguments& arguments, const char* name,
               bool everyone) {
  session.AddPerformer(command, true, everyone);
  command->add_option("--name", arguments.name, name);
  command->add_option("--transition", arguments.transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
}

void DeclareLike(Session& session) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* like =
      session.AddOnline("like", "make a style from an example clip, and set a performer to it",
                        [&session, arguments] { return Like(session, *arguments); });
  AddCommon(session, like, *arguments,
            "name of the style, for all clients; a made style of this name is replaced "
            "(default: the file's name)",
            true);
  like->add_option(
          "--clip", arguments->clip,
          "the example: BVH, glTF binary or VRMA, 0.3 s or longer; its first 60 s are used")
      ->required();
  like->add_option(
      "--neutral", arguments->neutral_clip,
      "a clip of the same performer moving as usual; only the difference from it is used");
  like->add_option("--rig", arguments->rig, "the example's rig dialect, e.g. bandai-namco, cmu")
      ->capture_default_str();
  like->add_option("--joints", arguments->joints,
                   "joints of the examples that are not recognized, CANONICAL=NAME, e.g. "
                   "leftUpperArm=Arm_01; stylize --explain prints them")
      ->take_all()
      ->allow_extra_args(false);
  like->add_option("--network", arguments->network,
                   "the network that gets the style, e.g. open or graph, or its family "
                   "(default: by what the example shows)");
  like->add_flag(
      "--add", arguments->add,
      "add the example to the made style of this name, instead of replacing it: a run to "
      "a walk, or a second walk");
  like->add_flag("--unworn", arguments->unworn,
                 "only make the style, without setting a performer to it");
}

void DeclareLearn(Session& session) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* learn = session.AddOnline(
      "learn", "make a style from a performer's motion from now on, and set the performer to it",
      [&session, arguments] { return Learn(session, *arguments); });
  AddCommon(session, learn, *arguments, "name of the style, for all clients", false);
  learn->get_option("--name")->required();
  learn->add_option("--seconds", arguments->seconds, "how long the performer shows it")
      ->check(Number(1.0, 60.0))
      ->capture_default_str();
  learn
      ->add_option("--neutral", arguments->neutral_s,
                   "seconds of the performer moving as usual first; only the difference "
                   "from them is used")
      ->check(Number(1.0, 60.0));
  learn->add_option("--countdown", arguments->countdown_s, "seconds before each")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
}

void DeclareVary(Session& session) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* vary =
      session.AddOnline("vary", "make a variation of a style, and set a performer to it",
                        [&session, arguments] { return Vary(session, *arguments); });
  AddCommon(session, vary, *arguments,
            "name of the variation, for all clients (default: STYLE-SEED)", true);
  vary->add_option("--style", arguments->style, "name of the style, as shown by list")->required();
  vary->add_option("--seed", arguments->seed, "the same number is the same variation")
      ->capture_default_str();
  vary->add_option("--amount", arguments->amount, "amount of the variation")
      ->check(Number(0.0, 1.5))
      ->capture_default_str();
}

}  // namespace

void DeclareMakingCommands(Session& session) {
  DeclareLike(session);
  DeclareLearn(session);
  DeclareVary(session);
}

}  // namespace styled::stylectl
