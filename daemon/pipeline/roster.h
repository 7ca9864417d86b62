#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "daemon/pipeline/performer/performer.h"

namespace styled::pipeline {

// Who is there: the profiles of all ids that were seen or configured, and the live state of those
// that send. Pipeline thread only. Bounded: `max_performers` live, four times as many profiles.
//
// Who sends goes before who was only named. Control requests can name any number of performers who
// never come, so:
// - A performer who comes to a full table takes the place of the profile that was only named and is
//   the longest absent; where there is none, of the longest absent of those who came and are
//   neither pinned nor calibrated. A control request takes no place.
// - A profile that was only named ends kForgetNamed_h after it was last set by its name. Hours
//   count while a daemon runs, over restarts ([state]): settings prepared on Friday are there on
//   Monday.
// - Settings of a performer who came do not end.
// Pinned by tests/unit/daemon/roster_test.cpp.
class Roster {
 public:
  // A week: longer than a show is prepared ahead of its performers, on a daemon that always runs.
  static constexpr int kForgetNamed_h = 168;
  // Rigs send their first frame within a second of the skeleton.
  static constexpr std::int64_t kFrameless_ns = 5'000'000'000;

  Roster(std::vector<std::string> source_names, std::shared_ptr<const RuntimeConfig> config,
         std::uint64_t epoch, publish::Subscriptions& subscriptions, runtime::Counters& counters);

  // The live performer, or null. Neither allocates nor throws.
  STYLED_REALTIME Performer* Find(int source, std::string_view name) noexcept;
  // A new live performer; null when there are max_performers already, or no profile gives way. Of
  // performers who sent bodies and no frame for kFrameless_ns the first one gives way.
  // Allocates.
  Performer* Add(int source, std::string_view name, std::int64_t now_ns);
  // Frees its live state; its profile stays where somebody configured it.
  void Forget(Performer& performer);

  // The profile of an id, or null; Ensure makes one, null when there are too many.
  Profile* FindProfile(const std::string& id);
  Profile* EnsureProfile(const std::string& id);
  // Somebody set a profile by its name (not by "*"): its hours count anew.
  void NoteNamed(Profile& profile);
  // Removes what Ensure made, unless it was put to use.
  void DropUnused(Profile& profile);
  // The live performer of a profile, or null.
  Performer* LiveOf(const Profile& profile) const;

  // Settings that were kept from the last run ("*" among them).
  void Restore(std::vector<Profile> profiles);
  // What to keep: configured profiles and, as "*", those of performers to come.
  std::unique_ptr<std::vector<Profile>> Snapshot() const;

  // Counts the hours, and ends what was only named. Called about once a second; does nothing but
  // once an hour. Allocates.
  void Age(std::int64_t now_ns);
  // What Add and Age did to profiles since the last call, for the log.
  std::vector<std::string> PopLog() { return std::exchange(log_, {}); }
  // Whether what Snapshot() returns changed since the last call, but for what control requests set.
  bool PopChanged();

  // New weights, presets or limits. Returns what of the profiles no longer fits.
  std::vector<std::string> Apply(std::shared_ptr<const RuntimeConfig> config);

  const RuntimeConfig& config() const { return *config_; }
  std::uint64_t epoch() const { return epoch_; }
  // "rig.a" from a source's number and a performer's name.
  std::string Id(int source, std::string_view name) const;
  bool KnowsSource(std::string_view name) const;
  const std::vector<std::string>& source_names() const { return source_names_; }

  std::vector<std::unique_ptr<Performer>> performers;
  std::unordered_map<std::string, std::unique_ptr<Profile>> profiles;
  Profile to_come;  // "*": what a performer seen for the first time is to look like

 private:
  std::size_t max_profiles() const {
    return 4 * static_cast<std::size_t>(config_->performers.max_performers);
  }
  void InitializeToCome();
  bool ForgetFrameless(std::int64_t now_ns);
  bool HasCome(const Profile& profile) const;
  void NoteCome(Profile& profile);
  // Frees the place of one profile for a performer who came; false where none gives way.
  bool MakeRoom(const std::string& comer);
  void Drop(Profile& profile);

  std::vector<std::string> source_names_;
  std::shared_ptr<const RuntimeConfig> config_;
  std::uint64_t epoch_;
  publish::Subscriptions& subscriptions_;
  runtime::Counters& counters_;
  // Where sequences of new profiles begin: beyond those of any profile that was freed, so that a
  // performer's sequence never goes back.
  std::uint64_t first_sequence_ = 1;
  std::uint64_t named_ = 0;   // as Profile::named_last
  std::int64_t aged_ns_ = 0;  // when the last full hour ended; 0: no hour has begun
  std::vector<std::string> log_;
  bool changed_ = false;
};

}  // namespace styled::pipeline
