// like.
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "clients/cpp/stylectl/cli.h"
#include "clients/cpp/stylectl/commands.h"
#include "model/base/read_file.h"
#include "model/base/text.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

constexpr std::size_t kMaxClipBytes = 8 * 1024 * 1024 - 4096;  // a request with it is at most 8 MiB
constexpr std::size_t kMaxNameBytes = 32;
constexpr float kFar = 1;  // as far as styles are from each other

struct LikeArguments {
  std::string clip, name, rig = "auto";
  bool unworn = false;
  std::optional<double> transition_ms;
};

// The file's name without its extension, as a style may be called.
std::string NameOf(const std::string& file) {
  std::string name = std::filesystem::path(file).stem();
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 || (std::isalnum(byte) == 0 && c != '_' && c != '-')) c = '-';
  }
  return name.substr(0, kMaxNameBytes);
}

void ReportJson(Session& session, const v1::LikeReply& like, const client::Applied& applied) {
  nlohmann::json object{{"ok", true},
                        {"style", like.name()},
                        {"nearest", like.nearest()},
                        {"distance", like.distance()},
                        {"seconds", like.seconds()},
                        {"applied", nlohmann::json::array()}};
  for (const v1::Applied& one : applied) {
    object["applied"].push_back(
        {{"performer", one.performer()}, {"first_sequence", one.first_sequence()}});
  }
  session.out << object.dump() << "\n";
}

void ReportText(Session& session, const v1::LikeReply& like, const client::Applied& applied) {
  session.out << "style " << like.name() << ", of " << NumberText(like.seconds(), 2)
              << " s: nearest to " << like.nearest() << ", at " << NumberText(like.distance(), 2)
              << " of the mean distance between styles";
  if (like.distance() > kFar) {
    session.out << ": unlike all styles that the weights know, so a weak mixture of them";
  }
  session.out << "\n";
  for (const v1::Applied& one : applied) {
    session.out << one.performer() << ": " << like.name() << " from frame " << one.first_sequence()
                << "\n";
  }
}

int Like(Session& session, const LikeArguments& arguments) {
  auto clip = ReadFile(arguments.clip, kMaxClipBytes);
  if (!clip.ok()) return session.Usage("like: --clip " + clip.status().message());
  v1::Like request;
  request.set_name(arguments.name.empty() ? NameOf(arguments.clip) : arguments.name);
  request.set_clip(std::move(clip.value()));
  request.set_file(std::filesystem::path(arguments.clip).filename());
  request.set_rig(arguments.rig);
  if (arguments.transition_ms) {
    request.set_transition_ms(static_cast<float>(*arguments.transition_ms));
  }
  v1::LikeReply reply;
  client::Applied applied;
  const client::CallStatus status =
      session.control().Like(arguments.unworn ? "" : session.performer, request, &reply, &applied);
  if (!status.ok()) return session.Fail(status);
  session.json ? ReportJson(session, reply, applied) : ReportText(session, reply, applied);
  return kExitOk;
}

}  // namespace

void DeclareLike(Session& session) {
  const auto arguments = std::make_shared<LikeArguments>();
  CLI::App* like =
      session.AddOnline("like", "make a style of an example clip; a performer moves in it at once",
                        [&session, arguments] { return Like(session, *arguments); });
  session.AddPerformer(like, true);
  like->add_option("--clip", arguments->clip, "the example: a BVH file of 0.3 to 60 s")->required();
  like->add_option("--name", arguments->name,
                   "of the style, for all clients; an earlier example of this name is replaced "
                   "(default: the file's name)");
  like->add_option("--rig", arguments->rig, "the example's rig dialect, e.g. bandai-namco, cmu")
      ->capture_default_str();
  like->add_option("--transition", arguments->transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
  like->add_flag("--unworn", arguments->unworn,
                 "only make the style; nobody moves in it until set");
}

}  // namespace styled::stylectl
