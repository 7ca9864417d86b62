#include "clients/nats/report.h"

#include <algorithm>

#include "clients/cpp/key_options.h"
#include "clients/nats/subject.h"

namespace styled::stylenats {
namespace {

constexpr std::size_t kShownStreams = 3;  // of those with replaced frames, the worst

}  // namespace

std::string EventText(const LinkEvent& event, const std::string& brokers, const std::string& lost,
                      const std::string& again) {
  using Kind = LinkEvent::Kind;
  switch (event.kind) {
    case Kind::kAbsent:
      return "no broker answers at " + brokers + (event.text.empty() ? "" : " that is trusted: ") +
             event.text + "; retrying";
    case Kind::kConnected:
      return "connected to " + event.text;
    case Kind::kDisconnected:
      return "lost the broker: " + event.text + lost;
    case Kind::kReconnected:
      return "connected again, to " + event.text + again;
    case Kind::kError:
      return "the broker reports: " + event.text;
    default:
      return "the broker at " + brokers + " refuses the connection: " + event.text +
             "; expected a login that it knows (--nats-login FILE, --nats-creds FILE) and, with "
             "tls://, a certificate of its host (--nats-ca FILE)";
  }
}

Report::Report(const Options& options, std::ostream& out, std::ostream& err)
    : options_(options),
      out_(out),
      err_(err),
      lookout_(options.publisher, client::Peer::kPublisher, options.curve) {}

void Report::PrintStart() {
  err_ << "stylenats: " << options_.publisher << " -> " << BrokersText(options_.link)
       << ", frames at styled." << Escape(options_.site) << ".>, commands at "
       << ControlSubject(options_.site) << std::endl;
}

// Whether the daemon is there: printed when it changes, with the reason if there is one.
void Report::PrintDaemon(Bridge& bridge) {
  if (bridge.connected() > 0) {
    lookout_.Rest();
    why_.clear();
    if (!daemon_) err_ << "stylenats: subscribed to " << options_.publisher << std::endl;
    daemon_ = true;
    return;
  }
  if (daemon_) err_ << "stylenats: the daemon is gone; retrying" << std::endl;
  daemon_ = false;
  const client::Reach& reach = lookout_.Look();
  if (reach.text.empty() || reach.text == why_) return;
  why_ = reach.text;
  const std::string advice = client::Advice(reach.obstacle, client::Peer::kPublisher);
  err_ << "stylenats: no daemon answers at " << options_.publisher << ": " << why_
       << (advice.empty() ? "" : "; " + advice) << std::endl;
}

bool Report::PrintNews(Bridge& bridge) {
  bool closed = false;
  for (const LinkEvent& event : bridge.link().Events()) {
    err_ << "stylenats: "
         << EventText(event, BrokersText(options_.link), "; frames are dropped until it is back",
                      "; all bodies are written again")
         << std::endl;
    closed = closed || event.kind == LinkEvent::Kind::kClosed;
  }
  const std::string error = bridge.store().NextError();
  if (!error.empty()) err_ << "stylenats: KV: " << error << std::endl;
  if (bridge.NextRefusedOutput()) {
    err_ << "stylenats: the [[output]] " << kAudienceStream
         << " is not passed on: the audience tier has its name" << std::endl;
  }
  PrintDaemon(bridge);
  return closed;
}

void Report::PrintCounters(const Bridge& bridge, const FrameQueue& queue) {
  const Totals t = bridge.totals();
  if (t == shown_) return;
  shown_ = t;
  out_ << "stylenats: " << t.sent << " sent, " << t.audience << " of the audience tier, "
       << t.bodies << " bodies, " << t.replaced << " replaced, " << t.disconnected
       << " dropped without a broker, " << t.too_large << " too large, " << t.failed << " failed, "
       << t.refused << " without a slot, " << t.missed << " missed, " << t.malformed
       << " malformed; " << t.stalled << " slow calls, longest " << t.longest_call_us / 1000
       << " ms; KV " << t.written << " written, " << t.unwritten << " failed, " << t.unkept
       << " refused; " << t.requests << " commands, " << t.unanswered << " without an answer, "
       << t.unsent_replies << " answers lost";
  const auto rows = queue.replaced();
  for (std::size_t i = 0; i < std::min(rows.size(), kShownStreams); ++i) {
    out_ << (i == 0 ? "; replaced most: " : ", ") << rows[i].first << " " << rows[i].second;
  }
  out_ << std::endl;
}

}  // namespace styled::stylenats
