#include "daemon/perform/load_balance.h"

#include <cmath>
#include <cstdlib>
#include <string>

namespace styled::pipeline {
namespace {

constexpr int kNamed = 8;  // performers in one line of the log

// How much of a style the performer's settings ask for.
float ShareOf(const Performer& performer) {
  float sum = 0;
  for (const auto& entry : performer.profile.look.mix()) sum += entry.weight();
  return sum * performer.profile.look.strength();
}

bool LosesBefore(const Performer& a, const Performer& b) {
  if (a.profile.pinned != b.profile.pinned) return b.profile.pinned;
  if (ShareOf(a) != ShareOf(b)) return ShareOf(a) < ShareOf(b);
  return a.added_ns > b.added_ns;
}

// Who is relieved next, or, without `relieve`, gets the style back; null: nobody.
Performer* NextOf(const Roster& roster, bool relieve) {
  Performer* next = nullptr;
  for (const auto& performer : roster.performers) {
    if (!performer->admission.live() || performer->relieved() == relieve) continue;
    const bool better = next == nullptr ||
                        (relieve ? LosesBefore(*performer, *next) : LosesBefore(*next, *performer));
    if (better) next = performer.get();
  }
  return next;
}

}  // namespace

void BalanceLoad(Performance& performance, std::int64_t now_ns) {
  decide::Overload& overload = performance.overload;
  if (!overload.due(now_ns)) return;
  int styled = 0, relieved = 0;
  for (const auto& performer : performance.roster.performers) {
    if (performer->admission.live()) ++(performer->relieved() ? relieved : styled);
  }
  const int change = overload.Decide(now_ns, styled, relieved);
  const bool relieve = change > 0;
  std::string names;
  for (int i = 0; i < std::abs(change); ++i) {
    Performer* const next = NextOf(performance.roster, relieve);
    if (next == nullptr) break;
    next->Relieve(relieve);
    if (i < kNamed) names += (names.empty() ? "" : ", ") + next->profile.id;
    if (i == kNamed) names += " and of others";
  }
  if (names.empty()) return;
  const long percent = std::lround(100 * overload.load());
  performance.events.LogOf(
      LogLimit::Kind::kOverload, {}, "overload",
      relieve ? Event::Level::kWarning : Event::Level::kInfo,
      (relieve ? "frames leave too late at a load of " : "there is room at a load of ") +
          std::to_string(percent) + " %: the style of " + names +
          (relieve ? " fades out" : " comes back"));
}

}  // namespace styled::pipeline
