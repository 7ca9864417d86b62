#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "daemon/pipeline/performer.h"

namespace styled::pipeline {

// Who is there: the profiles of all ids that were seen or configured, and the live state of those
// that send. Pipeline thread only. Bounded: `max_performers` live, four times as many profiles.
class Roster {
 public:
  Roster(std::vector<std::string> source_names, std::shared_ptr<const Live> live,
         std::uint64_t epoch, publish::Subscriptions& subscriptions, runtime::Counters& counters);

  // The live performer, or null. Neither allocates nor throws.
  STYLED_REALTIME Performer* Find(int source, std::string_view name) noexcept;
  // A new live performer; null when there are max_performers already. Allocates.
  Performer* Add(int source, std::string_view name);
  // Frees its live state; its profile stays where somebody configured it.
  void Forget(Performer& performer);

  // The profile of an id, or null; Ensure makes one, null when there are too many.
  Profile* FindProfile(const std::string& id);
  Profile* EnsureProfile(const std::string& id);
  // Takes back what Ensure made, unless it was put to use.
  void DropUnused(Profile& profile);
  // The live performer of a profile, or null.
  Performer* LiveOf(const Profile& profile);

  // Settings that were kept from the last run ("*" among them).
  void Restore(std::vector<Profile> profiles);
  // What to keep: configured profiles and, as "*", those of performers to come.
  std::unique_ptr<std::vector<Profile>> Keep() const;

  // New weights, presets or limits. Returns what of the profiles no longer fits.
  std::vector<std::string> Take(std::shared_ptr<const Live> live);

  const Live& live() const { return *live_; }
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
    return 4 * static_cast<std::size_t>(live_->performers.max_performers);
  }
  void InitializeToCome();

  std::vector<std::string> source_names_;
  std::shared_ptr<const Live> live_;
  std::uint64_t epoch_;
  publish::Subscriptions& subscriptions_;
  runtime::Counters& counters_;
  // Where sequences of new profiles begin: beyond those of any profile that was freed, so that a
  // performer's sequence never goes back.
  std::uint64_t first_sequence_ = 1;
};

}  // namespace styled::pipeline
