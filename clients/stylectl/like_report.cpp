// The answer to a request that makes a style, as text and as JSON.
#include "clients/stylectl/like_report.h"

#include <nlohmann/json.hpp>

#include "clients/stylectl/cli.h"
#include "model/base/text.h"

namespace styled::stylectl {
namespace {

constexpr float kFar = 1;  // as far as styles are from each other

void ReportJson(Session& session, const v1::LikeReply& like, const client::Applied& applied,
                const std::string& note) {
  nlohmann::json object{{"ok", true},
                        {"style", like.name()},
                        {"nearest", like.nearest()},
                        {"distance", like.distance()},
                        {"seconds", like.seconds()},
                        {"found", like.found()},
                        {"weak", like.weak()},
                        {"applied", nlohmann::json::array()}};
  for (const v1::Applied& one : applied) {
    object["applied"].push_back(
        {{"performer", one.performer()}, {"first_sequence", one.first_sequence()}});
  }
  if (!note.empty()) object["note"] = note;
  session.out << object.dump() << "\n";
}

void ReportText(Session& session, const v1::LikeReply& like, const client::Applied& applied) {
  session.out << "style " << like.name();
  if (like.seconds() > 0) session.out << ", of " << NumberText(like.seconds(), 2) << " s";
  session.out << ": nearest to " << like.nearest() << ", at " << NumberText(like.distance(), 2)
              << " of the mean distance between styles";
  // A measured style is as good far from the known styles as near them.
  if (like.distance() > kFar && like.found().empty()) {
    session.out << ": unlike all styles that the weights know, so a weak mixture of them";
  }
  session.out << "\n";
  for (const std::string& found : like.found()) session.out << "  found  " << found << "\n";
  for (const std::string& weak : like.weak()) session.out << "  weak   " << weak << "\n";
  for (const v1::Applied& one : applied) {
    session.out << one.performer() << ": " << like.name() << " from frame " << one.first_sequence()
                << "\n";
  }
}

}  // namespace

int MakeStyle(Session& session, const std::string& performer, const v1::Like& request) {
  v1::LikeReply reply;
  client::Applied applied;
  const client::CallStatus status = session.control().Like(performer, request, &reply, &applied);
  if (!status.ok()) return session.Fail(status);
  const std::string note = performer.empty() ? "" : session.NoteUnseen();
  session.json ? ReportJson(session, reply, applied, note) : ReportText(session, reply, applied);
  if (!session.json && !note.empty()) session.err << "note: " << note << "\n";
  return kExitOk;
}

}  // namespace styled::stylectl
