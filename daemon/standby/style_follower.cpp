#include "daemon/standby/style_follower.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"

namespace styled::standby {
namespace {

using pipeline::Exchange;
using pipeline::MadeStyle;
using pipeline::Places;

// A leader has at most this many styles.
constexpr std::size_t kMostRequests = 2048;
constexpr const char* kTitle = "a style of the leader's";  // in errors

}  // namespace

void StyleFollower::Restart() {
  requests_.clear();
  imports_.clear();
  fetches_afterwards_ = under_way_ > 0;
}

// Motions refer to styles by place. Once this daemon has all styles, it adopts the leader's places,
// and the whole state is fetched again.
void StyleFollower::OnBeginning(const v1::Beginning& beginning) {
  arrange_.reset();
  theirs_.reset();
  // A message can name millions of places; a leader has at most kMostPlaces.
  if (static_cast<std::size_t>(beginning.places_size()) > pipeline::kMostPlaces) return;
  Places theirs;
  for (const std::string& name : beginning.places()) theirs.entries.push_back({name, false});
  for (const std::uint32_t at : beginning.retired()) {
    if (at < theirs.entries.size()) theirs.entries[at].retired = true;
  }
  theirs.last = static_cast<int>(beginning.last_place());
  const bool all_here = std::ranges::all_of(theirs.entries, [this](const auto& entry) {
    return entry.retired || performance_.roster.config().made.contains(entry.name);
  });
  if (!all_here) return;
  theirs_ = std::move(theirs);
  fading_to_come_ = static_cast<std::size_t>(beginning.fading_size());
  if (fading_to_come_ == 0) ArrangeIfOther();
}

void StyleFollower::ArrangeIfOther() {
  if (HasPlaces(performance_.roster.config(), *theirs_)) return;
  arrange_ = theirs_;
  fetches_afterwards_ = true;
  PassOn();
}

bool StyleFollower::OnStyle(const v1::StylePart& part) {
  if (part.has_fading()) {
    OnFading(part);
    return false;
  }
  return part.file().empty() || !ImportsMissing(part.file());
}

// While styles are still missing, the whole state is fetched again anyway.
void StyleFollower::OnFading(const v1::StylePart& part) {
  if (!theirs_ || fading_to_come_ == 0 || part.fading() >= theirs_->entries.size()) return;
  --fading_to_come_;
  if (!part.file().empty()) {
    auto parsed = pipeline::ParseStyleFile(part.file(), kTitle, performance_.roster.config());
    if (!parsed.ok()) return standby_.Failed(parsed.status().message());
    theirs_->fading[part.fading()] = std::make_shared<const MadeStyle>(std::move(parsed.value()));
  }
  standby_.StyleRestored(part);
  if (fading_to_come_ == 0) ArrangeIfOther();
}

// Imports a style of the leader if this daemon lacks it. Returns true in that case.
bool StyleFollower::ImportsMissing(const std::string& file) {
  const pipeline::RuntimeConfig& config = performance_.roster.config();
  const auto parsed = pipeline::ParseStyleFile(file, kTitle, config);
  if (!parsed.ok()) {
    standby_.Failed(parsed.status().message());
    return true;
  }
  const auto here = config.made.find(parsed.value().name);
  if (here != config.made.end() && FormatStyleFile(*here->second, config) == file) return false;
  fetches_afterwards_ = true;
  Import(file);
  return true;
}

void StyleFollower::Import(const std::string& file, bool in_place) {
  // A second import would give it a second place among the styles.
  if (std::ranges::count(imports_, file) != 0) return;
  imports_.push_back(file);
  v1::Request request;
  request.mutable_import_style()->set_file(file);
  request.mutable_import_style()->set_replace(true);
  request.mutable_import_style()->set_in_place(in_place);
  Enqueue(std::move(request));
}

void StyleFollower::Follow(const v1::Request& request) {
  if (!request.has_import_style()) return Enqueue(request);
  Import(request.import_style().file(), request.import_style().in_place());
}

void StyleFollower::Enqueue(v1::Request request) {
  if (requests_.size() >= kMostRequests) {
    return standby_.Failed("more than " + std::to_string(kMostRequests) +
                           " changes of styles wait");
  }
  requests_.push_back(std::move(request));
  PassOn();
}

// If the mailbox is full, the exchange stays unchanged.
bool StyleFollower::Push(std::unique_ptr<Exchange>& exchange) {
  exchange->followed = true;
  if (!mailboxes_.takes.Push(std::move(exchange))) return false;
  ++under_way_;
  mailboxes_.wake_files.Signal();
  return true;
}

void StyleFollower::PassOn() {
  while (!requests_.empty()) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request.Swap(&requests_.front());
    if (!Push(exchange)) return requests_.front().Swap(&exchange->request);
    requests_.pop_front();
  }
  if (!arrange_) return;
  auto exchange = std::make_unique<Exchange>();
  exchange->places = std::exchange(arrange_, std::nullopt);
  if (!Push(exchange)) arrange_ = std::move(exchange->places);
}

bool StyleFollower::OnFollowed(const Exchange& exchange) {
  --under_way_;
  std::erase(imports_, exchange.request.import_style().file());
  if (exchange.reply.code() != v1::CODE_OK) {
    failed_ = true;
    standby_.Failed(exchange.reply.reason());
  }
  PassOn();
  if (under_way_ > 0) return false;
  // Fetch again, if that can succeed.
  const bool failed = std::exchange(failed_, false);
  if (std::exchange(fetches_afterwards_, false) && !failed && !standby_.leads()) {
    standby_.Refetch();
  }
  return true;
}

}  // namespace styled::standby
