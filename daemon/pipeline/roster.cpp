#include "daemon/pipeline/roster.h"

#include <algorithm>

namespace styled::pipeline {
Roster::Roster(std::vector<std::string> source_names, std::shared_ptr<const Live> live,
               std::uint64_t epoch, publish::Subscriptions& subscriptions,
               runtime::Counters& counters)
    : source_names_(std::move(source_names)),
      live_(std::move(live)),
      epoch_(epoch),
      subscriptions_(subscriptions),
      counters_(counters) {
  InitializeToCome();
}

// As the configuration's [style] says, unless somebody set "*".
void Roster::InitializeToCome() {
  if (to_come.configured) return;
  to_come = Profile();
  to_come.id = "*";
  to_come.look.strength = live_->style.strength;
  to_come.look.transition_s = live_->style.transition_s;
  std::string why;  // checked by the supervisor
  if (!live_->style.initial.empty()) {
    (void)LookUp(live_->style.initial, live_->presets, *live_->network, to_come.look, why);
  }
}

Performer* Roster::Find(int source, std::string_view name) noexcept {
  const std::string& source_name = source_names_[static_cast<std::size_t>(source)];
  for (const auto& performer : performers) {
    if (performer->name == name &&
        source_names_[static_cast<std::size_t>(performer->source)] == source_name) {
      return performer.get();
    }
  }
  return nullptr;
}

Performer* Roster::Add(int source, std::string_view name) {
  if (performers.size() >= static_cast<std::size_t>(live_->performers.max_performers)) {
    return nullptr;
  }
  Profile* profile = EnsureProfile(Id(source, name));
  if (profile == nullptr) return nullptr;
  profile->seen = true;
  performers.push_back(std::make_unique<Performer>(*profile, source, std::string(name), epoch_,
                                                   subscriptions_, counters_));
  counters_.Set(runtime::Counter::kPipelinePerformers, performers.size());
  return performers.back().get();
}

void Roster::Forget(Performer& performer) {
  Profile& profile = performer.profile;
  std::erase_if(performers, [&](const auto& owned) { return owned.get() == &performer; });
  counters_.Set(runtime::Counter::kPipelinePerformers, performers.size());
  DropUnused(profile);
}

void Roster::DropUnused(Profile& profile) {
  if (profile.configured || LiveOf(profile) != nullptr) return;
  first_sequence_ = std::max(first_sequence_, profile.next_sequence);
  profiles.erase(std::string(profile.id));
}

Profile* Roster::FindProfile(const std::string& id) {
  const auto found = profiles.find(id);
  return found == profiles.end() ? nullptr : found->second.get();
}

Profile* Roster::EnsureProfile(const std::string& id) {
  if (Profile* known = FindProfile(id)) return known;
  if (profiles.size() >= max_profiles()) return nullptr;
  auto profile = std::make_unique<Profile>(to_come);
  profile->id = id;
  profile->pinned = false;
  profile->configured = false;
  profile->seen = false;
  profile->next_sequence = first_sequence_;
  return profiles.emplace(id, std::move(profile)).first->second.get();
}

Performer* Roster::LiveOf(const Profile& profile) {
  for (const auto& performer : performers) {
    if (&performer->profile == &profile) return performer.get();
  }
  return nullptr;
}

void Roster::Restore(std::vector<Profile> kept) {
  for (auto& profile : kept) {
    profile.configured = true;
    profile.next_sequence = first_sequence_;
    if (profile.id == "*") {
      to_come = std::move(profile);
    } else if (profiles.size() < max_profiles()) {
      const std::string id = profile.id;
      profiles[id] = std::make_unique<Profile>(std::move(profile));
    }
  }
}

std::unique_ptr<std::vector<Profile>> Roster::Keep() const {
  auto kept = std::make_unique<std::vector<Profile>>();
  if (to_come.configured) kept->push_back(to_come);
  for (const auto& [id, profile] : profiles) {
    if (profile->configured) kept->push_back(*profile);
  }
  return kept;
}

std::vector<std::string> Roster::Take(std::shared_ptr<const Live> live) {
  const bool rebuild = live->network != live_->network || live->stylist != live_->stylist ||
                       live->avatars != live_->avatars;
  const auto before = std::exchange(live_, std::move(live));
  InitializeToCome();
  std::vector<std::string> complaints;
  for (const auto& performer : performers) {
    if (rebuild) performer->Rebuild(*live_);
    for (const auto& style : performer->ApplyLook(*live_)) {
      complaints.push_back(performer->profile.id + ": the new weights have no style \"" + style +
                           "\"");
    }
  }
  return complaints;
}

std::string Roster::Id(int source, std::string_view name) const {
  return source_names_[static_cast<std::size_t>(source)] + "." + std::string(name);
}

bool Roster::KnowsSource(std::string_view name) const {
  return std::find(source_names_.begin(), source_names_.end(), name) != source_names_.end();
}

}  // namespace styled::pipeline
