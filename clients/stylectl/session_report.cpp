// Session: reporting of results and failures.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/report.h"
#include "clients/stylectl/session.h"
#include "clients/stylectl/suggest.h"

namespace styled::stylectl {
namespace {

using client::CallStatus;

// Whether the daemon might listen at another endpoint.
bool MayBeElsewhere(client::Obstacle obstacle) {
  using client::Obstacle;
  return obstacle == Obstacle::kUnknownHost || obstacle == Obstacle::kUnreachable ||
         obstacle == Obstacle::kNobody || obstacle == Obstacle::kNoFile ||
         obstacle == Obstacle::kNoSocket || obstacle == Obstacle::kLeftBehind ||
         obstacle == Obstacle::kOtherSocket || obstacle == Obstacle::kNotZeroMq;
}

template <typename Entries>
std::vector<std::string> NamesOf(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name());
  return names;
}

}  // namespace

int Session::Changed(const CallStatus& status, const client::Applied& applied,
                     const std::string& what) {
  if (!status.ok()) return Fail(status);
  const std::string note = NoteUnseen();
  if (json) {
    nlohmann::json object{{"ok", true}, {"applied", AppliedJson(applied)}};
    if (!note.empty()) object["note"] = note;
    out << object.dump() << "\n";
  } else {
    out << AppliedText(applied, what);
    if (!note.empty()) err << "note: " << note << "\n";
  }
  return kExitOk;
}

// A performer may be configured before it appears. Without this note, a misspelt name would be
// stored silently and never used.
std::string Session::NoteUnseen() {
  v1::StatusReply status;
  if (performer == client::kEveryone || !control_->Status(&status).ok()) return "";
  std::vector<std::string> names;
  bool listed = false;
  for (const auto& entry : status.stats().performers()) {
    if (entry.performer() == performer && entry.sequence() > 0) return "";
    if (entry.performer() != performer) names.push_back(entry.performer());
    listed = listed || entry.performer() == performer;
  }
  // Bypass is the default of every performer: the daemon stores no settings for it.
  std::string note =
      performer + (clears && !listed ? " has not been seen yet; its advance settings are "
                                       "forgotten"
                                     : " has not been seen yet and is configured in advance");
  if (const std::string near = Nearest(performer, names); !near.empty()) {
    note += "; did you mean " + near + "?";
  } else if (!names.empty() && names.size() <= 8) {
    note += " (here: " + Join(names) + ")";
  }
  return note;
}

// For a misspelt name: the names that the daemon knows, and the nearest one.
Session::Hint Session::Explain(const CallStatus& status) {
  Hint hint;
  v1::ListReply list;
  switch (status.code()) {
    case v1::CODE_UNKNOWN_STYLE:
      ExplainStyle(hint);
      break;
    case v1::CODE_UNKNOWN_CUE: {
      if (!control_->List(&list).ok()) break;
      const auto names = NamesOf(list.cues());
      hint.suggestion = Nearest(cue, names);
      hint.expected = names.empty() ? "the configuration has no cues" : "cues: " + Join(names);
      break;
    }
    case v1::CODE_UNKNOWN_PRESET: {
      if (!control_->List(&list).ok()) break;
      const auto names = NamesOf(list.presets());
      hint.suggestion = Nearest(preset, names);
      hint.expected =
          names.empty() ? "the configuration has no presets" : "presets: " + Join(names);
      break;
    }
    case v1::CODE_UNKNOWN_PERFORMER:
      ExplainPerformer(hint);
      break;
    case v1::CODE_PINNED:
      // `*` would unpin everybody: the error names the performers.
      hint.expected = performer == client::kEveryone
                          ? "first: stylectl unpin SOURCE.NAME of each of these"
                          : "first: stylectl unpin " + performer;
      break;
    default:
      break;
  }
  return hint;
}

void Session::ExplainStyle(Hint& hint) {
  v1::ListReply list;
  if (!control_->List(&list).ok()) return;
  std::vector<std::string> known, names;
  for (const auto& style : list.styles()) {
    if (style.neutral()) continue;
    names.push_back(style.name());
    known.push_back(style.name());
    known.insert(known.end(), style.aliases().begin(), style.aliases().end());
  }
  for (const std::string& wanted : styles) {
    const auto same = [&](const std::string& name) { return Distance(name, wanted) == 0; };
    if (std::any_of(known.begin(), known.end(), same)) continue;
    if (hint.suggestion.empty()) hint.suggestion = Nearest(wanted, known);
  }
  constexpr std::size_t kListed = 40;
  const std::size_t more = names.size() - std::min(names.size(), kListed);
  names.resize(names.size() - more);
  hint.expected = "styles: " + Join(names);
  if (more > 0) hint.expected += " and " + std::to_string(more) + " more: stylectl list";
}

void Session::ExplainPerformer(Hint& hint) {
  v1::StatusReply reply;
  if (!control_->Status(&reply).ok()) return;
  std::vector<std::string> names;
  for (const auto& entry : reply.stats().performers()) {
    // A performer that is only configured is listed, too: it may be the misspelt name itself.
    if (entry.performer() != performer) names.push_back(entry.performer());
  }
  hint.suggestion = Nearest(performer, names);
  hint.expected = names.empty() ? "no performer is present" : "performers: " + Join(names);
}

int Session::Fail(const CallStatus& status) {
  const bool refused = status.kind() == CallStatus::Kind::kRefused;
  Hint hint;
  if (refused) {
    hint = Explain(status);
  } else {
    hint.expected = status.obstacle() == client::Obstacle::kNone
                        ? "--timeout waits longer; styled's journal shows what it does"
                        : client::Advice(status.obstacle(), client::Peer::kControl);
    if (MayBeElsewhere(status.obstacle())) {
      hint.expected += " Another endpoint: --endpoint or STYLED_CONTROL";
    }
  }
  err << "stylectl: " << status.reason();
  if (!hint.suggestion.empty()) err << "; did you mean '" << hint.suggestion << "'?";
  err << "\n";
  // Most reasons already state what was expected.
  const bool complete = refused && status.reason().find("expected") != std::string::npos;
  if (!hint.expected.empty() && !complete) err << "  " << hint.expected << "\n";
  if (json) {
    nlohmann::json object{{"ok", false},
                          {"code", refused ? client::CodeName(status.code()) : "NO_ANSWER"},
                          {"reason", status.reason()}};
    if (!hint.suggestion.empty()) object["suggestion"] = hint.suggestion;
    if (!hint.expected.empty()) object["expected"] = hint.expected;
    out << object.dump() << "\n";
  }
  return refused ? kExitRefused : kExitNoDaemon;
}

int Session::Usage(const std::string& text) {
  err << "stylectl: " << text << "\n  see stylectl --help, stylectl COMMAND --help\n";
  if (json) {
    out << nlohmann::json{{"ok", false}, {"code", "USAGE"}, {"reason", text}}.dump() << "\n";
  }
  return kExitUsage;
}

}  // namespace styled::stylectl
