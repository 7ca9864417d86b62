#include "daemon/standby/replication.h"

#include <array>
#include <span>
#include <utility>

#include "daemon/log/recorder.h"
#include "daemon/looks/refusal.h"

namespace styled::standby {
namespace {

using Change = Standby::Change;
using pipeline::Event;

// Limits the work of one turn: 64 entries with one frame each take about 2 ms.
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
  // After reading, because the leader's messages end its silence.
  OnChange(standby_.OnTime());
  styles_.PassOn();
  work += sender_.DoWork();
  if (const Standby::Line line = standby_.PopLine(); !line.text.empty()) {
    performance_.events.Log(line.warning ? Event::Level::kWarning : Event::Level::kInfo,
                            "standby: " + line.text);
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
    follower_.EndWait();  // the styles still missing follow later
  }
  mailboxes_.stands_by.store(!standby_.leads(), std::memory_order_relaxed);
  sender_.Clear();
  styles_.ForgetPlaces();
  frames_.DropPostponed();
  if (change == Change::kFollow) return standby_.publisher().Hold();
  standby_.input().Expire(performance_.roster.source_names(), performance_.clock.Now_ns());
  // With a part of the leader's state, its performers continue in the same epoch.
  const bool goes_on = change == Change::kTakeOver || standby_.has_part();
  const std::size_t resent = standby_.publisher().Release(goes_on);
  goes_on ? ContinueFrames(resent) : ProcessBodies(true);
  standby_.input().Clear();
  for (const auto& performer : performance_.roster.performers) {
    performer->outputs.SendBodies(performance_.publisher);
    performer->next_body_ns = performance_.clock.Now_ns() + runtime::kSecond_ns;
  }
}

// Processes the buffered frames that follow the leader's last ones. `resent`: number of messages
// that this turn has sent already.
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

// Without this, a rig that sends its body only once would stay unknown.
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
  std::size_t messages = performance_.roster.performers.size();  // for their bodies
  for (std::size_t i = 0; i < frames.size(); ++i) messages += handled(i) ? 0 : 1;
  // Each frame is sent on the topics of the rig, the canonical body, the source and the outputs.
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
  const std::string& peer = standby_.peer_address();
  reply.set_id(request.id());
  if (!standby_.leads() && log::Changes(request)) {
    pipeline::FillReply(standby_.looks() ? pipeline::Refused(v1::CODE_NOT_READY,
                                                             "this daemon checks whether " + peer +
                                                                 " leads: try again in a second")
                                         : OrderRefused(peer),
                        reply);
    return true;
  }
  if (!request.has_lead()) return false;
  pipeline::FillReply(standby_.RequestLead(), reply);
  return true;
}

// The leader does not have that style. The state, which is fetched again, removes it from the list.
void Replication::OnReload(pipeline::Reload& reload) {
  if (standby_.leads() || reload.config == nullptr || reload.exchange == nullptr) return;
  pipeline::Exchange& exchange = *reload.exchange;
  if (exchange.followed) return;
  exchange.reply.Clear();
  exchange.reply.set_id(exchange.request.id());
  pipeline::FillReply(OrderRefused(standby_.peer_address()), exchange.reply);
  standby_.Refetch();
}

void Replication::OnStyleFollowed(const pipeline::Exchange& exchange) {
  if (styles_.OnFollowed(exchange)) follower_.OnStylesFollowed();
}

void Replication::OnConfigRead() {
  sender_.Resend();  // the standby compares the new configuration with its own
  if (!standby_.leads()) standby_.Refetch();
}

}  // namespace styled::standby
