#include "daemon/perform/roster.h"

#include <algorithm>
#include <tuple>

#include "daemon/runtime/clock.h"

namespace styled::pipeline {
namespace {

constexpr int kMaxAbsent_h = 1'000'000;  // about a century; larger values carry no information

}  // namespace

Roster::Roster(std::vector<std::string> source_names, std::shared_ptr<const RuntimeConfig> config,
               std::uint64_t epoch, publish::Subscriptions& subscriptions,
               runtime::Counters& counters)
    : source_names_(std::move(source_names)),
      config_(std::move(config)),
      epoch_(epoch),
      subscriptions_(subscriptions),
      counters_(counters) {
  InitializeToCome();
}

// Uses the configuration's [style], unless "*" was set explicitly.
void Roster::InitializeToCome() {
  if (to_come.configured) return;
  to_come = Profile();
  to_come.id = "*";
  // Both were checked when the configuration was read.
  v1::Look change = config_->style.look;
  if (ProperNames(config_->network->model().styles, change).ok()) {
    styled::Apply(change, to_come.look);
  }
  if (!config_->style.initial.empty()) {
    (void)LookUp(config_->style.initial, config_->presets, config_->network->model().styles,
                 to_come.look);
  }
}

// Frames arrive in about the same order in every period, so the search starts behind the performer
// found last and widens to both sides.
Performer* Roster::Find(int source, std::string_view name) noexcept {
  const std::string& source_name = source_names_[static_cast<std::size_t>(source)];
  const std::size_t count = performers.size();
  if (expected_ >= count) expected_ = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t away = (k + 1) / 2;
    std::size_t place = k % 2 == 0 ? expected_ + away : expected_ + count - away;
    if (place >= count) place -= count;
    Performer& performer = *performers[place];
    if (performer.name == name &&
        source_names_[static_cast<std::size_t>(performer.source)] == source_name) {
      expected_ = place + 1;
      return &performer;
    }
  }
  return nullptr;
}

Performer* Roster::Add(int source, std::string_view name, std::int64_t now_ns) {
  const auto most = static_cast<std::size_t>(config_->performers.max_performers);
  if (performers.size() >= most && !ForgetFrameless(now_ns)) return nullptr;
  const std::string id = Id(source, name);
  Profile* profile = EnsureProfile(id);
  if (profile == nullptr && MakeRoom(id)) profile = EnsureProfile(id);
  if (profile == nullptr) return nullptr;
  const auto place = static_cast<std::size_t>(source);
  if (!profile->has_come && place < config_->idle.size() && profile->look.idle() == 0) {
    profile->look.set_idle(config_->idle[place]);
  }
  profile->seen = true;
  performers.push_back(std::make_unique<Performer>(*profile, source, std::string(name), epoch_,
                                                   now_ns, subscriptions_, counters_));
  counters_.Set(runtime::Counter::kPipelinePerformers, performers.size());
  return performers.back().get();
}

bool Roster::ForgetFrameless(std::int64_t now_ns) {
  for (const auto& performer : performers) {  // in the order of their arrival
    if (performer->admission.sends_frames || now_ns - performer->added_ns < kFrameless_ns) continue;
    log_.push_back(performer->profile.id +
                   ": sent a skeleton and no frame, and was replaced by another performer");
    counters_.Add(runtime::Counter::kPipelineForgotten);
    Forget(*performer);
    return true;
  }
  return false;
}

void Roster::Forget(Performer& performer) {
  Profile& profile = performer.profile;
  performer.KeepNeutral();
  NoteCome(profile);
  if (performer.admission.received() > 0) profile.absent_hours = 0;
  std::erase_if(performers, [&](const auto& owned) { return owned.get() == &performer; });
  counters_.Set(runtime::Counter::kPipelinePerformers, performers.size());
  DropUnused(profile);
}

void Roster::DropUnused(Profile& profile) {
  if (!profile.configured && LiveOf(profile) == nullptr) Drop(profile);
}

void Roster::Drop(Profile& profile) {
  first_sequence_ = std::max(first_sequence_, profile.next_sequence);
  profiles.erase(std::string(profile.id));
}

// A calibration also proves that the performer was present.
bool Roster::HasCome(const Profile& profile) const {
  if (profile.has_come || profile.rest) return true;
  const Performer* live = LiveOf(profile);
  return live != nullptr && live->admission.received() > 0;
}

void Roster::NoteCome(Profile& profile) {
  if (profile.has_come || !HasCome(profile)) return;
  profile.has_come = true;
  changed_ = changed_ || profile.configured;
}

bool Roster::PopChanged() {
  for (const auto& [id, profile] : profiles) NoteCome(*profile);
  return std::exchange(changed_, false);
}

void Roster::NoteNamed(Profile& profile) {
  profile.absent_hours = 0;
  profile.named_last = ++named_;
}

bool Roster::MakeRoom(const std::string& comer) {
  Profile* gives_way = nullptr;
  // Replacement order: profiles that were only named come first, then those absent for longest.
  const auto rank = [this](const Profile& p) {
    return std::tuple(HasCome(p), -p.absent_hours, p.named_last, std::string_view(p.id));
  };
  for (const auto& [id, profile] : profiles) {
    const bool kept = HasCome(*profile) && (profile->pinned || profile->rest);
    if (kept || LiveOf(*profile) != nullptr) continue;
    if (gives_way == nullptr || rank(*profile) < rank(*gives_way)) gives_way = profile.get();
  }
  if (gives_way == nullptr) return false;
  counters_.Add(runtime::Counter::kPipelineNamesReplaced);
  log_.push_back(gives_way->id + (HasCome(*gives_way) ? ": absent for long" : ": only named") +
                 ", its settings were dropped for " + comer + " in a full table of " +
                 std::to_string(max_profiles()));
  changed_ = true;
  Drop(*gives_way);
  return true;
}

void Roster::Age(std::int64_t now_ns) {
  constexpr std::int64_t kHour_ns = 3600 * runtime::kSecond_ns;
  if (aged_ns_ == 0) aged_ns_ = now_ns;
  const std::int64_t hours = (now_ns - aged_ns_) / kHour_ns;
  if (hours <= 0) return;
  aged_ns_ += hours * kHour_ns;
  std::vector<Profile*> ended;
  for (const auto& [id, profile] : profiles) {
    NoteCome(*profile);
    if (LiveOf(*profile) != nullptr) continue;
    profile->absent_hours =
        static_cast<int>(std::min<std::int64_t>(profile->absent_hours + hours, kMaxAbsent_h));
    changed_ = true;
    if (!profile->has_come && profile->absent_hours >= kForgetNamed_h) {
      ended.push_back(profile.get());
    }
  }
  if (ended.empty()) return;
  std::string names;
  constexpr std::size_t kListed = 8;  // most names in one log line
  for (std::size_t i = 0; i < ended.size(); ++i) {
    if (i < kListed) names += (i == 0 ? "" : ", ") + ended[i]->id;
    Drop(*ended[i]);
  }
  if (ended.size() > kListed) names += " and " + std::to_string(ended.size() - kListed) + " more";
  counters_.Add(runtime::Counter::kPipelineNamesExpired, ended.size());
  log_.push_back(names + ": named " + std::to_string(kForgetNamed_h) +
                 " hours ago or more and never seen, the settings are forgotten");
}

Profile* Roster::FindProfile(const std::string& id) {
  const auto found = profiles.find(id);
  return found == profiles.end() ? nullptr : found->second.get();
}

const Profile* Roster::FindProfile(const std::string& id) const {
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
  profile->has_come = false;
  profile->absent_hours = 0;
  profile->named_last = ++named_;
  profile->next_sequence = first_sequence_;
  return profiles.emplace(id, std::move(profile)).first->second.get();
}

Performer* Roster::LiveOf(const Profile& profile) const {
  for (const auto& performer : performers) {
    if (&performer->profile == &profile) return performer.get();
  }
  return nullptr;
}

void Roster::Clear(std::uint64_t epoch) {
  performers.clear();
  counters_.Set(runtime::Counter::kPipelinePerformers, 0);
  profiles.clear();
  to_come = Profile();
  InitializeToCome();
  epoch_ = epoch;
}

std::uint64_t Roster::FirstSequence() const {
  std::uint64_t first = first_sequence_;
  for (const auto& [id, profile] : profiles) first = std::max(first, profile->next_sequence);
  return first;
}

void Roster::BeginSequencesAt(std::uint64_t sequence) {
  first_sequence_ = std::max(first_sequence_, sequence);
  for (const auto& [id, profile] : profiles) {
    if (LiveOf(*profile) == nullptr) {
      profile->next_sequence = std::max(profile->next_sequence, first_sequence_);
    }
  }
}

void Roster::Restore(std::vector<Profile> kept) {
  // If there are more than max_profiles(), the first ones in this order are kept.
  std::stable_sort(kept.begin(), kept.end(), [](const Profile& a, const Profile& b) {
    return std::pair(!a.has_come, a.absent_hours) < std::pair(!b.has_come, b.absent_hours);
  });
  for (auto& profile : kept) {
    profile.configured = true;
    profile.next_sequence = first_sequence_;
    std::vector<std::string> unknown;
    (void)Resolve(profile.look, config_->network->model().styles, unknown);
    for (const std::string& style : unknown) {
      log_.push_back(profile.id + ": its style \"" + style +
                     "\" of the last run is not here any more, and has no effect");
    }
    Profile* const known = FindProfile(profile.id);
    Performer* const live = known == nullptr ? nullptr : LiveOf(*known);
    if (profile.id == "*") {
      to_come = std::move(profile);
    } else if (live != nullptr) {
      RestoreLive(*live, profile);
    } else if (profiles.size() < max_profiles()) {
      const std::string id = profile.id;
      profiles[id] = std::make_unique<Profile>(std::move(profile));
    }
  }
}

void Roster::RestoreLive(Performer& performer, Profile& saved) {
  Profile& profile = performer.profile;
  profile.look = std::move(saved.look);
  profile.rest = std::move(saved.rest);
  profile.neutral = std::move(saved.neutral);
  profile.pinned = saved.pinned;
  profile.has_come = saved.has_come;
  profile.configured = true;
  (void)performer.ApplyLook(*config_);  // Restore() reports styles that are lost
}

std::unique_ptr<std::vector<Profile>> Roster::Snapshot() const {
  auto kept = std::make_unique<std::vector<Profile>>();
  if (to_come.configured) kept->push_back(to_come);
  for (const auto& [id, profile] : profiles) {
    if (profile->configured) kept->push_back(Saved(*profile));
  }
  return kept;
}

Profile Roster::Saved(const Profile& profile) const {
  Profile saved = profile;
  saved.has_come = HasCome(profile);
  const Performer* const live = LiveOf(profile);
  if (live == nullptr) return saved;
  saved.absent_hours = 0;
  saved.neutral = live->TellNeutral();
  return saved;
}

std::optional<Profile> Roster::SavedOf(const std::string& id) const {
  const Profile* const profile = id == "*" ? &to_come : FindProfile(id);
  if (profile == nullptr || !profile->configured) return std::nullopt;
  return id == "*" ? *profile : Saved(*profile);
}

std::vector<std::string> Roster::Apply(std::shared_ptr<const RuntimeConfig> config) {
  const bool rebuild = !config->network->SharesStreams(*config_->network) ||
                       config->stylist != config_->stylist || config->outputs != config_->outputs;
  const auto before = std::exchange(config_, std::move(config));
  InitializeToCome();
  std::vector<std::string> complaints;
  for (const auto& performer : performers) {
    rebuild ? performer->Rebuild(*config_) : performer->Adopt(*config_);
    for (const auto& style : performer->ApplyLook(*config_)) {
      complaints.push_back(performer->profile.id + ": the new weights have no style \"" + style +
                           "\"");
    }
  }
  return complaints;
}

std::string Roster::Id(int source, std::string_view name) const {
  return source_names_[static_cast<std::size_t>(source)] + "." + std::string(name);
}

std::vector<std::string_view> Roster::Here() const {
  std::vector<std::string_view> here;
  for (const auto& performer : performers) here.emplace_back(performer->profile.id);
  return here;
}

bool Roster::KnowsSource(std::string_view name) const {
  return std::find(source_names_.begin(), source_names_.end(), name) != source_names_.end();
}

}  // namespace styled::pipeline
