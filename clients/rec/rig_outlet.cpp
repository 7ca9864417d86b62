#include "clients/rec/rig_outlet.h"

#include <algorithm>

#include "model/base/random_id.h"

namespace styled::rec {
namespace {

constexpr std::int64_t kSilence_ns = 150'000'000;  // usually longer than a daemon's takeover_ms

std::span<const std::byte> BytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

// The performer's name in a native datagram; "" if its payload contains none.
std::string NameIn(const native::Datagram& datagram) {
  const auto name = [&](auto message) {
    const auto size = static_cast<int>(datagram.payload.size());
    return message.ParseFromArray(datagram.payload.data(), size) ? message.performer() : "";
  };
  return datagram.kind == native::Kind::kBody ? name(styled::v1::Body())
                                              : name(styled::v1::SourceFrame());
}

// A wildcard address is reached on this machine.
std::string Reachable(std::string url) {
  for (const auto& [every, here] :
       {std::pair<std::string, std::string>{"//0.0.0.0:", "//127.0.0.1:"},
        {"//[::]:", "//[::1]:"}}) {
    const std::size_t at = url.find(every);
    if (at != std::string::npos) url.replace(at, every.size(), here);
  }
  return url;
}

}  // namespace

RigOutlet::RigOutlet(RigOutletOptions options, player::Clock& clock, Steering* steering)
    : options_(std::move(options)),
      clock_(clock),
      steering_(steering),
      rig_frames_(RandomId),
      salt_(RandomId()),
      buffer_(native::kMaxDatagramSize) {}

void RigOutlet::Restart() {
  salt_ = RandomId();
  rig_frames_.Restart();
  performers_.clear();
}

std::uint64_t RigOutlet::Renewed(std::uint64_t session) const {
  if (options_.as_recorded) return session;
  return session == salt_ ? salt_ : session ^ salt_;  // never 0
}

void RigOutlet::Note(const recording::Record& record) {
  if (options_.from_published) return rig_frames_.Note(record);
  if (!record.has_arrival()) return;
  native::Datagram datagram;
  const auto bytes = BytesOf(record.arrival().datagram());
  if (native::Decode(bytes, datagram) != native::DecodeResult::kOk) return;
  if (datagram.kind != native::Kind::kBody) return;
  noted_[record.arrival().source() + "." + NameIn(datagram)] = record;
}

Status RigOutlet::Begin() {
  const auto noted = std::exchange(noted_, {});
  for (const auto& [id, record] : noted) {
    Status status = Play(record);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

Status RigOutlet::Play(const recording::Record& record) {
  if (options_.from_published) {
    if (!record.has_published()) return Status::Ok();
    Status status = Status::Ok();
    rig_frames_.Apply(record, [&](const std::string& source, std::span<const std::byte> datagram) {
      if (status.ok()) status = Deliver({source, "", ""}, record.time_ns(), datagram);
    });
    return status;
  }
  if (!record.has_arrival()) return Status::Ok();
  if (!noted_.empty()) {
    Status status = Begin();
    if (!status.ok()) return status;
  }
  const recording::Arrival& arrival = record.arrival();
  const Sender sender{arrival.source(), arrival.listen(), arrival.peer()};
  const auto bytes = BytesOf(arrival.datagram());
  // USB transfers also form a stream.
  const bool pieces = arrival.type() == "tcp" || arrival.type() == "usb";
  return pieces ? DeliverPiece(sender, record.time_ns(), bytes)
                : Deliver(sender, record.time_ns(), bytes);
}

Result<player::Link*> RigOutlet::LinkTo(const Sender& sender) {
  const auto known = links_.find(sender);
  if (known != links_.end()) return known->second.get();
  auto url = options_.to.find(sender.source);
  if (url == options_.to.end()) url = options_.to.find("");
  if (url == options_.to.end()) return links_.emplace(sender, nullptr).first->second.get();
  const bool original = url->second == "original";
  if (original && sender.listen.empty()) {
    return Status::Error("source '" + sender.source +
                         "': where it listened is not recorded; expected --to with an address");
  }
  auto link =
      player::Connect(original ? Reachable(sender.listen) : url->second, options_.start_wait_ms);
  if (!link.ok()) return link.status();
  return links_.emplace(sender, std::move(link.value())).first->second.get();
}

Status RigOutlet::DeliverPiece(const Sender& sender, std::int64_t time_ns,
                               std::span<const std::byte> piece) {
  using Result = native::StreamReader::Result;
  Stream& stream = streams_[sender];
  while (!piece.empty() && !stream.broken) {
    const auto space = stream.reader.Space();
    const std::size_t size = std::min(space.size(), piece.size());
    std::copy_n(piece.begin(), size, space.begin());
    stream.reader.Received(size);
    piece = piece.subspan(size);
    std::span<const std::byte> datagram;
    Result result = Result::kRecord;
    while ((result = stream.reader.Next(datagram)) == Result::kRecord) {
      Status status = Deliver(sender, time_ns, datagram);
      if (!status.ok()) return status;
    }
    if (result == Result::kBroken) {
      stream.broken = true;
      const std::size_t pending = stream.reader.Pending();
      const std::byte* const end = stream.reader.Space().data();
      std::vector<std::byte> rest(end - pending, end);
      rest.insert(rest.end(), piece.begin(), piece.end());
      return Deliver(sender, time_ns, rest);
    }
  }
  return Status::Ok();
}

// A daemon refuses a second sender of a performer until the first one has been silent for a while.
void RigOutlet::KeepSilence(const native::Datagram& datagram, const std::string& source,
                            std::int64_t time_ns) {
  const auto key = std::pair(source, datagram.session);
  auto performer = performers_.find(key);
  if (performer == performers_.end()) {
    const std::string name = NameIn(datagram);
    if (name.empty()) return;
    performer = performers_.emplace(key, source + "." + name).first;
  }
  Session& session = sessions_[performer->second];
  if (session.id != 0 && session.id != Renewed(datagram.session)) {
    const std::int64_t recorded_ns = time_ns - session.recorded_ns;
    const std::int64_t silence_ns =
        recorded_ns < 0 ? kSilence_ns : std::min(recorded_ns, kSilence_ns);
    // A daemon that lags behind would not notice the silence.
    if (steering_ != nullptr) {
      steering_->CatchUp();
      session.sent_ns = clock_.Now_ns();
    }
    clock_.SleepUntil(session.sent_ns + silence_ns);
  }
  session = {Renewed(datagram.session), time_ns, clock_.Now_ns()};
}

Status RigOutlet::Deliver(const Sender& sender, std::int64_t time_ns,
                          std::span<const std::byte> datagram) {
  const auto link = LinkTo(sender);
  if (!link.ok()) return link.status();
  if (link.value() == nullptr) {
    ++counts_.elsewhere;
    return Status::Ok();
  }
  native::Datagram ours;
  if (native::Decode(datagram, ours) == native::DecodeResult::kOk) {
    KeepSilence(ours, sender.source, time_ns);
    if (!options_.from_published) ours.session = Renewed(ours.session);
    datagram = std::span(buffer_).first(native::Encode(ours, buffer_));
  }
  if (steering_ != nullptr) steering_->BeforeSending();
  ++counts_.datagrams;
  counts_.bytes += datagram.size();
  return link.value()->Send(datagram);
}

}  // namespace styled::rec
