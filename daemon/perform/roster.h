#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "daemon/perform/performer/performer.h"

namespace styled::pipeline {

// The performers: the profiles of all ids that were seen or configured, and the live state of those
// that send. Pipeline thread only. Bounded: `max_performers` live, four times as many profiles.
//
// A performer that sends has precedence over one that was only named, because control requests can
// name any number of performers that never arrive:
// - A performer that arrives at a full table replaces the profile that was only named and is absent
//   for longest; if there is none, the one absent for longest of those that were present and are
//   neither pinned nor calibrated. A control request replaces no profile.
// - A profile that was only named expires kForgetNamed_h after it was last set by its name. Hours
//   count while a daemon runs, over restarts ([state]): settings prepared on Friday are there on
//   Monday.
// - Settings of a performer that was present do not expire.
// Pinned by tests/unit/daemon/perform/roster_test.cpp.
class Roster {
 public:
  // A week: longer than a show is prepared before its performers arrive, on a daemon that always
  // runs.
  static constexpr int kForgetNamed_h = 168;
  // Rigs send their first frame within a second of the skeleton.
  static constexpr std::int64_t kFrameless_ns = 5'000'000'000;

  Roster(std::vector<std::string> source_names, std::shared_ptr<const RuntimeConfig> config,
         std::uint64_t epoch, publish::Subscriptions& subscriptions, runtime::Counters& counters);

  // The live performer, or null. Neither allocates nor throws.
  STYLED_REALTIME Performer* Find(int source, std::string_view name) noexcept;
  // Makes a live performer. If max_performers are live, it replaces the first performer that sent
  // bodies and no frame for kFrameless_ns. Returns null if no place is free, for it or for its
  // profile. Allocates.
  Performer* Add(int source, std::string_view name, std::int64_t now_ns);
  // Frees its live state; its profile stays if it was configured.
  void Forget(Performer& performer);

  // FindProfile returns the profile of an id, or null. EnsureProfile makes one if needed; null when
  // there are too many.
  Profile* FindProfile(const std::string& id);
  const Profile* FindProfile(const std::string& id) const;
  Profile* EnsureProfile(const std::string& id);
  // Call when a profile was set by its name (not by "*"): its hours start again.
  void NoteNamed(Profile& profile);
  // Removes a profile that EnsureProfile made, if it is unused.
  void DropUnused(Profile& profile);
  // The live performer of a profile, or null.
  Performer* LiveOf(const Profile& profile) const;

  // Forgets all performers and settings; frames have this epoch from now on.
  void Clear(std::uint64_t epoch);
  // The first sequence number for future performers: beyond all that were used.
  std::uint64_t FirstSequence() const;
  void BeginSequencesAt(std::uint64_t sequence);
  // The saved settings of the last run ("*" among them). Live performers continue with them.
  void Restore(std::vector<Profile> profiles);
  // The settings to save: configured profiles and, as "*", those for future performers.
  std::unique_ptr<std::vector<Profile>> Snapshot() const;
  // The saved settings of one performer; null: it has none.
  std::optional<Profile> SavedOf(const std::string& id) const;

  // Counts the hours, and removes expired profiles. Call about once a second; it acts once an hour.
  // Allocates.
  void Age(std::int64_t now_ns);
  // Log lines of Add, Restore and Age since the last call.
  std::vector<std::string> PopLog() { return std::exchange(log_, {}); }
  // Whether Snapshot() changed since the last call, apart from changes by control requests.
  bool PopChanged();

  // Applies new weights, presets or limits. Returns a message for each profile that no longer fits.
  std::vector<std::string> Apply(std::shared_ptr<const RuntimeConfig> config);

  const RuntimeConfig& config() const { return *config_; }
  std::uint64_t epoch() const { return epoch_; }
  // "rig.a": the id from a source's number and a performer's name.
  std::string Id(int source, std::string_view name) const;
  // The ids of the live performers, valid until one comes or goes.
  std::vector<std::string_view> Here() const;
  bool KnowsSource(std::string_view name) const;
  const std::vector<std::string>& source_names() const { return source_names_; }

  std::vector<std::unique_ptr<Performer>> performers;
  std::unordered_map<std::string, std::unique_ptr<Profile>> profiles;
  Profile to_come;  // "*": the settings of a performer seen for the first time

 private:
  std::size_t max_profiles() const {
    return 4 * static_cast<std::size_t>(config_->performers.max_performers);
  }
  void InitializeToCome();
  bool ForgetFrameless(std::int64_t now_ns);
  bool HasCome(const Profile& profile) const;
  Profile Saved(const Profile& profile) const;
  void RestoreLive(Performer& performer, Profile& saved);
  void NoteCome(Profile& profile);
  // Frees one profile's place for an arriving performer; false if none can be replaced.
  bool MakeRoom(const std::string& comer);
  void Drop(Profile& profile);

  std::vector<std::string> source_names_;
  std::shared_ptr<const RuntimeConfig> config_;
  std::uint64_t epoch_;
  publish::Subscriptions& subscriptions_;
  runtime::Counters& counters_;
  // Where sequences of new profiles begin: beyond those of every freed profile, so that a
  // performer's sequence never goes back.
  std::size_t expected_ = 0;  // where Find looks first
  std::uint64_t first_sequence_ = 1;
  std::uint64_t named_ = 0;   // as Profile::named_last
  std::int64_t aged_ns_ = 0;  // end of the last full hour; 0: no hour has begun
  std::vector<std::string> log_;
  bool changed_ = false;
};

}  // namespace styled::pipeline
