// What the pipeline does with [standby] (daemon/standby/README.md): as standby it repeats what the
// leader tells it (journaling.cpp), and goes on where that ends.
#include <algorithm>

#include "daemon/looks/state_file.h"
#include "daemon/perform/checkpoints.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
#include "daemon/styles/style_requests.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

using Change = standby::Standby::Change;

// Bounds a turn: 64 entries of one performer's frame take about 2 ms.
constexpr int kEntriesPerTurn = 64;
// A leader's styles are as many at most.
constexpr std::size_t kMostStyleRequests = 2048;
constexpr std::size_t kShownReason = 200;  // bytes of what the leader says
// A style takes 2 to 20 ms on the files thread, on a slow disk 400. Entries that wait for so long
// are repeated without it, and the state is fetched: a standby further behind would lead with old
// poses, and 0.35 s later (46 performers who waited for a second).
constexpr std::int64_t kLongestStyle_ns = 500'000'000;

}  // namespace

void Pipeline::Holder::OnFrames(int source, std::span<const source::SourceFrame> frames,
                                bool /*more*/) {
  to_.to_.standby->held().Add(source, frames, to_.to_.clock.Now_ns());
}

int Pipeline::DoStandby() {
  standby::Standby& standby = *to_.standby;
  int work = 0;
  standby::Standby::Step step;
  while (work < kEntriesPerTurn && standby.Next(step)) {
    ++work;
    OnChange(step.change);
    if (step.entry == nullptr) continue;
    if (!awaits_style_ && waiting_.empty()) {
      Repeat(*step.entry, step.own_ns);
    } else {
      waiting_.push_back({{}, step.own_ns, to_.clock.Now_ns()});
      waiting_.back().entry.Swap(step.entry);
    }
  }
  work += RepeatWaiting(kEntriesPerTurn);
  // Whatever else comes in any number: what counts as a sign of the leader's life was seen first.
  OnChange(standby.OnTime());
  PassOnStyles();
  work += SendState();
  if (std::string line = standby.PopLine(); !line.empty()) {
    log_.Log(Event::Level::kWarning, "standby: " + line);
  }
  if (std::string complaint = standby.PopComplaint(); !complaint.empty()) {
    log_.LogOf(LogLimit::Kind::kStandby, {}, "standby", Event::Level::kWarning, complaint);
  }
  return work;
}

void Pipeline::OnChange(Change change) {
  if (change == Change::kNone) return;
  standby::Standby& standby = *to_.standby;
  if (change == Change::kFollow) {
    style_requests_.clear();
    imports_.clear();
    waiting_.clear();
    awaits_style_ = false;
    fetches_after_styles_ = followed_ > 0;
  } else {
    EndWait();  // styles that the leader answered for come here later
  }
  to_.mailboxes.stands_by.store(!standby.leads(), std::memory_order_relaxed);
  unsent_.clear();
  unsent_settings_.clear();
  arrange_.reset();
  silence_.Clear();
  put_off_.clear();
  if (change == Change::kFollow) return standby.publisher().Hold();
  standby.held().Expire(roster_.source_names(), to_.clock.Now_ns());
  // With a part of the leader's state, those performers go on, in the same epoch.
  const bool goes_on = change == Change::kTakeOver || standby.has_part();
  const std::size_t again = standby.publisher().Release(goes_on);
  goes_on ? GoOn(again) : FeedBodies(true);
  standby.held().Clear();
  for (const auto& performer : roster_.performers) {
    performer->outputs.SendBodies(to_.publisher);
    performer->next_body_ns = to_.clock.Now_ns() + runtime::kSecond_ns;
  }
}

// The performers' own frames continue behind the last one that the leader handled, and behind
// `again` messages that were sent in this turn already.
void Pipeline::GoOn(std::size_t again) {
  standby::Standby& standby = *to_.standby;
  const auto& names = roster_.source_names();
  std::unordered_map<std::string, std::size_t> from;
  for (const auto& performer : roster_.performers) {
    const std::string& id = performer->profile.id;
    const auto last = standby.last.find(id);
    if (last == standby.last.end()) continue;  // by its numbers alone
    const auto place = standby.held().Find(names, id, last->second);
    from[id] = place.after;
    if (place.same == nullptr) continue;
    const source::SourceFrame& same = place.same->frame;
    if (same.session == last->second.session && same.machine == last->second.machine) continue;
    performer->admission.session.GoOnAs(same.machine, same.session, same.sequence,
                                        same.source_time_ns);
  }
  FeedBodies(false);
  Feed(from, again);
}

// A rig that sends its body once, at the beginning, would be unknown for ever.
void Pipeline::FeedBodies(bool of_all) {
  for (const auto& [key, held] : to_.standby->held().bodies()) {
    if (!of_all && roster_.Find(key.first, key.second) != nullptr) continue;
    OnFrames(key.first, {&held->frame, 1}, false);
  }
}

void Pipeline::Feed(const std::unordered_map<std::string, std::size_t>& from, std::size_t again) {
  const auto& frames = to_.standby->held().frames();
  const auto& names = roster_.source_names();
  const auto handled = [&](std::size_t i) {
    const auto found = from.find(names[static_cast<std::size_t>(frames[i]->source)] + "." +
                                 std::string(frames[i]->frame.performer));
    return found != from.end() && i < found->second;
  };
  std::size_t messages = roster_.performers.size();  // their bodies
  for (std::size_t i = 0; i < frames.size(); ++i) messages += handled(i) ? 0 : 1;
  // Each on the rig's topic, the canonical one, the source's and those of the outputs.
  const std::size_t topics = 3 + roster_.config().outputs.size();
  to_.standby->publisher().MakeRoom(again + topics * messages);
  std::array<source::SourceFrame, source::kBatch> batch;
  std::size_t count = 0;
  int source = 0;
  const auto hand_on = [&] {
    if (count > 0) OnFrames(source, std::span(batch).first(count), false);
    count = 0;
  };
  feeds_ = true;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& held = *frames[i];
    if (handled(i)) continue;
    if (held.source != source || count == batch.size()) hand_on();
    source = held.source;
    batch[count++] = held.frame;
  }
  hand_on();
  feeds_ = false;
}

// Those behind a change of styles that is done now, at most so many.
int Pipeline::RepeatWaiting(int most) {
  const std::int64_t now_ns = to_.clock.Now_ns();
  const std::int64_t since_ns = waiting_.empty() ? awaits_since_ns_ : waiting_.front().read_ns;
  const bool waits = awaits_style_ || (!waiting_.empty() && to_.standby->whole());
  if (waits && now_ns - since_ns >= kLongestStyle_ns) {
    to_.standby->Failed("styles change at the leader faster than here");
    fetches_after_styles_ = true;
    awaits_style_ = false;
  }
  int done = 0;
  for (; done < most && !awaits_style_ && !waiting_.empty(); ++done) RepeatFirstWaiting();
  return done;
}

void Pipeline::RepeatFirstWaiting() {
  const Waiting first = std::move(waiting_.front());
  waiting_.pop_front();
  Repeat(first.entry, first.own_ns);
}

// Repeats what waits without the styles that are not here yet.
void Pipeline::EndWait() {
  while (!waiting_.empty()) RepeatFirstWaiting();
  awaits_style_ = false;
}

void Pipeline::Repeat(const v1::Journal& entry, std::int64_t own_ns) {
  to_.standby->clock().Stand(own_ns, entry.wall_ns());
  switch (entry.what_case()) {
    case v1::Journal::kBeginning:
      RepeatBeginning(entry);
      break;
    case v1::Journal::kSettings:
      RepeatSettings(entry.settings());
      break;
    case v1::Journal::kStyle:
      RepeatStyle(entry.style());
      break;
    case v1::Journal::kCheckpoint:
      RepeatCheckpoint(entry.checkpoint());
      break;
    case v1::Journal::kBatch:
      RepeatBatch(entry.batch(), own_ns);
      break;
    case v1::Journal::kSilence:
      RepeatSilence(entry.silence(), own_ns);
      break;
    case v1::Journal::kRequest:
      RepeatRequest(entry.request());
      break;
    case v1::Journal::kTooLarge:
      to_.standby->Failed("the leader cannot send " + Printable(entry.too_large(), kShownReason));
      break;
    case v1::Journal::WHAT_NOT_SET:
      break;
  }
  to_.standby->clock().Run();
}

void Pipeline::RepeatBeginning(const v1::Journal& entry) {
  if (!to_.standby->Begin(entry)) return;
  Arrange(entry.beginning());
  roster_.Clear(entry.epoch());
  to_.standby->configured.clear();
}

// Motions name styles by their place. Once every style is here they get the leader's places, and
// everything is fetched again.
void Pipeline::Arrange(const v1::Beginning& beginning) {
  arrange_.reset();
  theirs_.reset();
  // A message may name millions of places; no leader has so many.
  if (static_cast<std::size_t>(beginning.places_size()) > kMostPlaces) return;
  Places theirs;
  for (const std::string& name : beginning.places()) theirs.entries.push_back({name, false});
  for (const std::uint32_t at : beginning.retired()) {
    if (at < theirs.entries.size()) theirs.entries[at].retired = true;
  }
  theirs.last = static_cast<int>(beginning.last_place());
  const bool all_here = std::ranges::all_of(theirs.entries, [this](const auto& entry) {
    return entry.retired || roster_.config().made.contains(entry.name);
  });
  if (!all_here) return;
  theirs_ = std::move(theirs);
  fading_to_come_ = static_cast<std::size_t>(beginning.fading_size());
  if (fading_to_come_ == 0) ArrangeIfOther();
}

void Pipeline::ArrangeIfOther() {
  if (HasPlaces(roster_.config(), *theirs_)) return;
  arrange_ = theirs_;
  fetches_after_styles_ = true;
  PassOnStyles();
}

// While the styles themselves are not all here, everything is fetched again anyway.
void Pipeline::RepeatFading(const v1::StylePart& part) {
  if (!theirs_ || fading_to_come_ == 0 || part.fading() >= theirs_->entries.size()) return;
  --fading_to_come_;
  if (!part.file().empty()) {
    auto parsed = ParseStyleFile(part.file(), "a style of the leader's", roster_.config());
    if (!parsed.ok()) return to_.standby->Failed(parsed.status().message());
    theirs_->fading[part.fading()] = std::make_shared<const MadeStyle>(std::move(parsed.value()));
  }
  to_.standby->StyleRestored(part);
  if (fading_to_come_ == 0) ArrangeIfOther();
}

void Pipeline::RepeatSettings(const v1::SettingsPart& part) {
  if (!to_.standby->fetches()) return;
  auto kept = ParseProfiles(part.text(), "the leader's settings");
  if (!kept.ok()) return to_.standby->Failed(kept.status().message());
  for (const Profile& profile : kept.value()) to_.standby->configured.insert(profile.id);
  roster_.Restore(std::move(kept.value()));
  if (!part.last()) return;
  to_.standby->SettingsRestored(part);
  commands_.MarkChanged();
}

void Pipeline::RepeatStyle(const v1::StylePart& part) {
  if (!to_.standby->fetches()) return;
  if (part.has_fading()) return RepeatFading(part);
  // Where it is imported first, everything is fetched again afterwards.
  if (part.file().empty() || !ImportsMissing(part.file())) to_.standby->StyleRestored(part);
}

// A style that the leader has made and this daemon perhaps has not: true, then.
bool Pipeline::ImportsMissing(const std::string& style) {
  const auto parsed = ParseStyleFile(style, "a style of the leader's", roster_.config());
  if (!parsed.ok()) {
    to_.standby->Failed(parsed.status().message());
    return true;
  }
  const auto here = roster_.config().made.find(parsed.value().name);
  if (here != roster_.config().made.end() &&
      FormatStyleFile(*here->second, roster_.config()) == style) {
    return false;
  }
  fetches_after_styles_ = true;
  Import(style);
  return true;
}

void Pipeline::Import(const std::string& style) {
  // Asked for twice, it would get a second place among the styles.
  if (std::ranges::count(imports_, style) != 0) return;
  imports_.push_back(style);
  v1::Request request;
  request.mutable_import_style()->set_file(style);
  request.mutable_import_style()->set_replace(true);
  FollowStyles(std::move(request));
}

void Pipeline::AwaitStyle(const v1::Request& request) {
  awaits_style_ = to_.standby->whole();
  awaits_since_ns_ = to_.standby->clock().base().Now_ns();
  if (!awaits_style_) fetches_after_styles_ = true;
  request.has_import_style() ? Import(request.import_style().file()) : FollowStyles(request);
}

// What the leader did to styles, for the files thread.
void Pipeline::FollowStyles(v1::Request request) {
  if (style_requests_.size() >= kMostStyleRequests) {
    return to_.standby->Failed("more than " + std::to_string(kMostStyleRequests) +
                               " changes of styles wait");
  }
  style_requests_.push_back(std::move(request));
  PassOnStyles();
}

void Pipeline::PassOnStyles() {
  while (!style_requests_.empty()) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request.Swap(&style_requests_.front());
    exchange->followed = true;
    if (!to_.mailboxes.takes.Push(std::move(exchange))) {       // a full ring leaves it as it is
      return style_requests_.front().Swap(&exchange->request);  // NOLINT(bugprone-use-after-move)
    }
    style_requests_.pop_front();
    ++followed_;
    to_.mailboxes.wake_files.Signal();
  }
  if (!arrange_) return;
  auto exchange = std::make_unique<Exchange>();
  exchange->places = std::exchange(arrange_, std::nullopt);
  exchange->followed = true;
  if (!to_.mailboxes.takes.Push(std::move(exchange))) {
    arrange_ = std::move(exchange->places);  // NOLINT(bugprone-use-after-move)
    return;
  }
  ++followed_;
  to_.mailboxes.wake_files.Signal();
}

// The files thread did one of them, or could not. Once all are done, everything is fetched again if
// some were not done at the leader's frame; at once only if it can succeed.
void Pipeline::StylesFollowed(const Exchange& exchange) {
  --followed_;
  std::erase(imports_, exchange.request.import_style().file());
  if (exchange.reply.code() != v1::CODE_OK) {
    follow_failed_ = true;
    to_.standby->Failed(exchange.reply.reason());
  }
  PassOnStyles();
  if (followed_ > 0) return;
  awaits_style_ = false;
  const bool failed = std::exchange(follow_failed_, false);
  if (std::exchange(fetches_after_styles_, false) && !failed && !leads()) to_.standby->Refetch();
}

void Pipeline::RepeatCheckpoint(const v1::Checkpoint& checkpoint) {
  if (!to_.standby->fetches()) return;
  const std::string& id = checkpoint.performer();
  if (id == kJournalSequences) roster_.BeginSequencesAt(checkpoint.sequence());
  if (checkpoint.version() == 0) return to_.standby->Restored(id);
  v1::Request request;
  *request.mutable_restore_checkpoint()->mutable_checkpoint() = checkpoint;
  v1::Reply reply;
  Performer* const performer =
      RestoreCheckpoint(request, roster_, layers_, to_.clock.Now_ns(), reply);
  if (performer == nullptr) return to_.standby->Failed(reply.reason());
  performer->profile.configured = to_.standby->configured.contains(id);
  to_.standby->Restored(id);
}

void Pipeline::RepeatBatch(const v1::Batch& batch, std::int64_t own_ns) {
  const auto& names = roster_.source_names();
  const auto count = static_cast<std::size_t>(batch.frames_size());
  if (batch.source() >= names.size() || names[batch.source()] != batch.name() ||
      count > source::kBatch) {
    return to_.standby->Failed("frames of source \"" + batch.name() + "\", number " +
                               std::to_string(batch.source()) +
                               "; expected the same [[source]] tables as the leader has");
  }
  std::array<source::SourceFrame, source::kBatch> frames;
  std::array<decide::FrameInTransit, source::kBatch> decided;
  for (std::size_t i = 0; i < count; ++i) {
    const v1::Handled& entry = batch.frames(static_cast<int>(i));
    if (!log::Read(entry, frames[i], decided[i])) return;
    if (entry.is_body() || decided[i].decision.fate == v1::FATE_REFUSED) continue;
    to_.standby->last[batch.name() + "." + entry.performer()] = {
        frames[i].machine,        frames[i].session,           frames[i].sequence,
        frames[i].source_time_ns, standby::PoseCrc(frames[i]), own_ns};
  }
  decided_ = std::span(decided).first(count);
  OnFrames(static_cast<int>(batch.source()), std::span(frames).first(count), false);
  decided_ = {};
  for (std::size_t i = 0; i < count; ++i) {
    if (decided[i].decision.fate != v1::FATE_STYLED &&
        transit_[i].decision.fate != v1::FATE_STYLED) {
      continue;
    }
    if (roster_.Find(static_cast<int>(batch.source()), frames[i].performer) == nullptr) continue;
    to_.standby->Compared(log::Compare(transit_[i], decided[i]));
  }
}

void Pipeline::RepeatSilence(const v1::Silence& silence, std::int64_t own_ns) {
  for (const v1::Applied& stale : silence.stale()) {
    Profile* const profile = roster_.FindProfile(stale.performer());
    Performer* const performer = profile == nullptr ? nullptr : roster_.LiveOf(*profile);
    if (performer == nullptr) continue;
    profile->next_sequence = stale.first_sequence();
    Stale(*performer, own_ns);
  }
  for (const std::string& id : silence.forgotten()) {
    Profile* const profile = roster_.FindProfile(id);
    Performer* const performer = profile == nullptr ? nullptr : roster_.LiveOf(*profile);
    if (performer != nullptr) roster_.Forget(*performer);
    to_.standby->last.erase(id);
  }
}

void Pipeline::RepeatRequest(const v1::Request& request) {
  if (IsStyleRequest(request)) return AwaitStyle(request);
  v1::Reply reply;
  Answer(request, reply);
  if (reply.code() != v1::CODE_OK) {
    // While the state comes, of somebody whose part of it comes later.
    return to_.standby->fetches() ? void() : to_.standby->Failed(reply.reason());
  }
  if (to_.recorder != nullptr) to_.recorder->OnRequest(to_.clock.Now_ns(), request, reply);
}

bool Pipeline::RefusesOrders(Exchange& exchange) {
  if (leads() || !log::Changes(exchange.request)) return false;
  standby::RefuseOrder(to_.standby->peer_address(), exchange.request, exchange.reply);
  if (to_.standby->looks()) {
    exchange.reply.set_code(v1::CODE_NOT_READY);
    exchange.reply.set_reason("this daemon looks whether " + to_.standby->peer_address() +
                              " leads: try again in a second");
  }
  return true;
}

// A style that this daemon made for somebody while it lost the lead: the leader has not got it. The
// state, which is fetched again, takes it out of the list.
void Pipeline::DisownStyle(Reload& reload) {
  if (leads() || reload.config == nullptr || reload.exchange == nullptr) return;
  Exchange& exchange = *reload.exchange;
  if (exchange.followed) return;
  exchange.reply.Clear();
  standby::RefuseOrder(to_.standby->peer_address(), exchange.request, exchange.reply);
  to_.standby->Refetch();
}

bool Pipeline::DoesLead(Exchange& exchange) {
  if (!exchange.request.has_lead()) return false;
  exchange.reply.set_id(exchange.request.id());
  const std::string why = to_.standby == nullptr ? "" : to_.standby->Wish();
  if (!why.empty()) {
    exchange.reply.set_code(v1::CODE_NOT_READY);
    exchange.reply.set_reason("lead: " + why);
  }
  return true;
}

}  // namespace styled::pipeline
