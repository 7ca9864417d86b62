#include "daemon/standby/replication.h"

#include <array>
#include <span>
#include <utility>

#include "daemon/log/recorder.h"

namespace styled::standby {
namespace {

using Change = Standby::Change;
using pipeline::Event;

// Bounds a turn: 64 entries of one performer's frame take about 2 ms.
constexpr int kEntriesPerTurn = 64;

}  // namespace

Replication::Replication(Standby& standby, pipeline::Performance& performance,
                         pipeline::FrameProcessor& frames, const Follower::Transports& transports,
                         pipeline::Mailboxes& mailboxes, source::Receiver& to)
    : standby_(standby),
      performance_(performance),
      frames_(frames),
      mailboxes_(mailboxes),
      to_(to),
      sender_(standby, performance),
      styles_(standby, performance, mailboxes),
      follower_(standby, performance, frames, transports, styles_) {
  performance_.log.Add(&sender_);
}

void Replication::BufferingReceiver::OnFrames(int source,
                                              std::span<const source::SourceFrame> frames,
                                              bool /*more*/) {
  in_.standby_.input().Add(source, frames, in_.performance_.clock.Now_ns());
}

source::Receiver& Replication::receiver() {
  if (standby_.leads()) return to_;
  return buffering_;
}

int Replication::DoWork() {
  int work = 0;
  Standby::Step step;
  while (work < kEntriesPerTurn && standby_.Next(step)) {
    ++work;
    OnChange(step.change);
    if (step.entry != nullptr) follower_.OnEntry(*step.entry, step.own_ns);
  }
  work += follower_.DoWaiting(kEntriesPerTurn);
  // Whatever else comes in any number: what counts as a sign of the leader's life was seen first.
  OnChange(standby_.OnTime());
  styles_.PassOn();
  work += sender_.DoWork();
  if (std::string line = standby_.PopLine(); !line.empty()) {
    performance_.events.Log(Event::Level::kWarning, "standby: " + line);
  }
  if (std::string complaint = standby_.PopComplaint(); !complaint.empty()) {
    performance_.events.LogOf(pipeline::LogLimit::Kind::kStandby, {}, "standby",
                              Event::Level::kWarning, complaint);
  }
  return work;
}

void Replication::OnChange(Change change) {
  if (change == Change::kNone) return;
  if (change == Change::kFollow) {
    follower_.Clear();
    styles_.Restart();
  } else {
    follower_.EndWait();  // styles that the leader answered for come here later
  }
  mailboxes_.stands_by.store(!standby_.leads(), std::memory_order_relaxed);
  sender_.Clear();
  styles_.ForgetPlaces();
  frames_.DropPostponed();
  if (change == Change::kFollow) return standby_.publisher().Hold();
  standby_.input().Expire(performance_.roster.source_names(), performance_.clock.Now_ns());
  // With a part of the leader's state, those performers go on, in the same epoch.
  const bool goes_on = change == Change::kTakeOver || standby_.has_part();
  const std::size_t resent = standby_.publisher().Release(goes_on);
  goes_on ? ContinueFrames(resent) : ProcessBodies(true);
  standby_.input().Clear();
  for (const auto& performer : performance_.roster.performers) {
    performer->outputs.SendBodies(performance_.publisher);
    performer->next_body_ns = performance_.clock.Now_ns() + runtime::kSecond_ns;
  }
}

// The performers' own frames continue behind the last one that the leader handled, and behind
// `resent` messages that were sent in this turn already.
void Replication::ContinueFrames(std::size_t resent) {
  const auto& names = performance_.roster.source_names();
  std::unordered_map<std::string, std::size_t> from;
  for (const auto& performer : performance_.roster.performers) {
    const std::string& id = performer->profile.id;
    const auto last = standby_.last.find(id);
    if (last == standby_.last.end()) continue;  // by its numbers alone
    const auto place = standby_.input().Find(names, id, last->second);
    from[id] = place.after;
    if (place.same == nullptr) continue;
    const source::SourceFrame& same = place.same->frame;
    if (same.session == last->second.session && same.machine == last->second.machine) continue;
    performer->admission.session.GoOnAs(same.machine, same.session, same.sequence,
                                        same.source_time_ns);
  }
  ProcessBodies(false);
  ProcessBuffered(from, resent);
}

// A rig that sends its body once, at the beginning, would be unknown for ever.
void Replication::ProcessBodies(bool of_all) {
  for (const auto& [key, held] : standby_.input().bodies()) {
    if (!of_all && performance_.roster.Find(key.first, key.second) != nullptr) continue;
    (void)frames_.Process({.source = key.first, .frames = {&held->frame, 1}});
  }
}

void Replication::ProcessBuffered(const std::unordered_map<std::string, std::size_t>& from,
                                  std::size_t resent) {
  const auto& frames = standby_.input().frames();
  const auto& names = performance_.roster.source_names();
  const auto handled = [&](std::size_t i) {
    const auto found = from.find(names[static_cast<std::size_t>(frames[i]->source)] + "." +
                                 std::string(frames[i]->frame.performer));
    return found != from.end() && i < found->second;
  };
  std::size_t messages = performance_.roster.performers.size();  // their bodies
  for (std::size_t i = 0; i < frames.size(); ++i) messages += handled(i) ? 0 : 1;
  // Each on the rig's topic, the canonical one, the source's and those of the outputs.
  const std::size_t topics = 3 + performance_.roster.config().outputs.size();
  standby_.publisher().MakeRoom(resent + topics * messages);
  std::array<source::SourceFrame, source::kBatch> batch;
  std::size_t count = 0;
  int source = 0;
  const auto process = [&] {
    if (count == 0) return;
    (void)frames_.Process(
        {.source = source, .frames = std::span(batch).first(count), .keep_all = true});
    count = 0;
  };
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& held = *frames[i];
    if (handled(i)) continue;
    if (held.source != source || count == batch.size()) process();
    source = held.source;
    batch[count++] = held.frame;
  }
  process();
}

bool Replication::Answers(pipeline::Exchange& exchange) {
  const v1::Request& request = exchange.request;
  v1::Reply& reply = exchange.reply;
  if (!standby_.leads() && log::Changes(request)) {
    RefuseOrder(standby_.peer_address(), request, reply);
    if (standby_.looks()) {
      reply.set_code(v1::CODE_NOT_READY);
      reply.set_reason("this daemon looks whether " + standby_.peer_address() +
                       " leads: try again in a second");
    }
    return true;
  }
  if (!request.has_lead()) return false;
  reply.set_id(request.id());
  pipeline::FillReply(standby_.RequestLead(), reply);
  return true;
}

// The leader has not got that style. The state, which is fetched again, takes it out of the list.
void Replication::OnReload(pipeline::Reload& reload) {
  if (standby_.leads() || reload.config == nullptr || reload.exchange == nullptr) return;
  pipeline::Exchange& exchange = *reload.exchange;
  if (exchange.followed) return;
  exchange.reply.Clear();
  RefuseOrder(standby_.peer_address(), exchange.request, exchange.reply);
  standby_.Refetch();
}

void Replication::OnStyleFollowed(const pipeline::Exchange& exchange) {
  if (styles_.OnFollowed(exchange)) follower_.OnStylesFollowed();
}

void Replication::OnConfigRead() {
  sender_.Resend();  // the standby may have to complain
  if (!standby_.leads()) standby_.Refetch();
}

}  // namespace styled::standby
