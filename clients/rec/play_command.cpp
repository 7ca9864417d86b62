// `stylerec play`: chooses the outlets and reports the outcome.
#include <CLI/CLI.hpp>
#include <limits>
#include <set>

#include "clients/rec/commands.h"
#include "clients/rec/play.h"
#include "clients/rec/publish_outlet.h"
#include "clients/rec/rig_outlet.h"
#include "clients/rec/steering.h"
#include "model/base/terminal_text.h"

namespace styled::rec {
namespace {

using std::string;

// Whether the recording contains arrivals that can be sent to a rig's listener.
Result<bool> FindArrivals(recording::Reader& reader) {
  bool source = false;
  recording::Record record;
  while (reader.Next(record)) {
    if (record.has_arrival()) return true;
    source = source || record.published().topic().starts_with("source/");
  }
  if (source) return false;
  return Status::Error(reader.name() +
                       ": found neither arrivals nor anything published on source/, expected one "
                       "of them to send with --to");
}

Result<RigOutletOptions> WhereTo(const Arguments& a, recording::Reader& reader) {
  RigOutletOptions options;
  options.as_recorded = a.as_recorded;
  for (string url : a.to) {
    const string name = CutName(url);
    options.to.emplace(name, url);
  }
  const auto arrivals = FindArrivals(reader);
  if (!arrivals.ok()) return arrivals.status();
  options.from_published = !arrivals.value();
  return options;
}

// The sources whose arrivals, or otherwise whose published frames, `play` would send.
std::set<string> SourcesOf(recording::Reader& reader, bool from_published) {
  std::set<string> sources;
  recording::Record record;
  reader.Rewind();
  while (reader.Next(record)) {
    if (!from_published) {
      if (record.has_arrival()) sources.insert(record.arrival().source());
      continue;
    }
    const string id = IdOfTopic(record.published().topic(), "source/");
    if (!id.empty()) sources.insert(id.substr(0, id.find('.')));
  }
  return sources;
}

Status CheckTo(const Arguments& a) {
  std::set<string> names;
  bool named = false, original = false;
  for (string url : a.to) {
    const string given = url, name = CutName(url);
    if (!names.insert(name).second) {
      return Status::Error("--to " + given + ": expected one address per source");
    }
    named = named || !name.empty();
    original = original || url == "original";
    if (url == "original") continue;
    Status readable = player::CheckAddress(url);
    if (!readable.ok()) return Status::Error("--to " + given + ": " + readable.message());
  }
  if (!named && !original) return Status::Ok();
  const auto reader = OpenRecording(a);
  if (!reader.ok()) return Status::Ok();
  const auto arrivals = FindArrivals(*reader.value());
  if (!arrivals.ok()) return Status::Ok();
  if (original && !arrivals.value()) {
    return Status::Error("--to original: " + reader.value()->name() +
                         " has no arrivals; expected an address");
  }
  if (!named) return Status::Ok();
  const auto held = SourcesOf(*reader.value(), !arrivals.value());
  string list;
  for (const string& source : held) list.append(list.empty() ? "" : ", ").append(source);
  for (const string& name : names) {
    if (name.empty() || held.contains(name)) continue;
    return Status::Error("--to " + name + "=...: " + reader.value()->name() +
                         " has no source of that name; it has: " + list);
  }
  return Status::Ok();
}

// Checks the form of the address; binding it later tells whether it is free.
Status CheckPublish(const string& url) {
  const auto wrong = [&url] {
    return Status::Error("--publish " + url + ": expected e.g. tcp://127.0.0.1:7001 or ipc://PATH");
  };
  if (url.starts_with("ipc://")) return url.size() > 6 ? Status::Ok() : wrong();
  const std::size_t colon = url.rfind(':');
  if (!url.starts_with("tcp://") || colon <= 6) return wrong();
  const string port = url.substr(colon + 1);
  int number = 0;
  const bool digits = port.find_first_not_of("0123456789") == string::npos && port.size() <= 5;
  if (port == "*") return Status::Ok();
  const bool valid = digits && CLI::detail::lexical_cast(port, number) && number <= 65535;
  return valid ? Status::Ok() : wrong();
}

Result<double> SpeedOf(const string& text) {
  if (text == "max") return std::numeric_limits<double>::infinity();
  double speed = 0;
  if (!CLI::detail::lexical_cast(text, speed) || !(speed >= 0.001 && speed <= 1e6)) {
    return Status::Error("--speed " + text + ": expected 0.001 to 1000000, or max");
  }
  return speed;
}

// The requested outlets.
struct Outlets {
  std::unique_ptr<Steering> steering;
  std::unique_ptr<RigOutlet> rig;
  std::unique_ptr<PublishOutlet> publisher;

  Status Make(const Arguments& a, recording::Reader& reader, player::Clock& clock) {
    if (!a.control.empty()) {
      const auto curve = client::ReadKeys(a.keys);
      if (!curve.ok()) return curve.status();
      auto made = Steering::Connect(a.control, clock, curve.value());
      if (!made.ok()) return made.status();
      steering = std::move(made.value());
    }
    if (!a.to.empty()) {
      auto where = WhereTo(a, reader);
      if (!where.ok()) return where.status();
      rig = std::make_unique<RigOutlet>(std::move(where.value()), clock, steering.get());
    }
    if (!a.publish.empty()) {
      auto made = PublishOutlet::Bind(a.publish, a.as_recorded);
      if (!made.ok()) return made.status();
      publisher = std::move(made.value());
    }
    return Status::Ok();
  }
  std::vector<Outlet*> all() const {
    std::vector<Outlet*> outlets;
    for (Outlet* const outlet :
         std::initializer_list<Outlet*>{rig.get(), steering.get(), publisher.get()}) {
      if (outlet != nullptr) outlets.push_back(outlet);
    }
    return outlets;
  }
  void Report(const Dependencies& to) const {
    if (rig) {
      to.out << " datagrams=" << rig->counts().datagrams << " elsewhere=" << rig->counts().elsewhere
             << " without_body=" << rig->rig_frames().without_body();
    }
    if (steering) {
      to.out << " commands=" << steering->commands() << " refused=" << steering->refused().size();
    }
    if (publisher) {
      to.out << " messages=" << publisher->counts().messages
             << " dropped=" << publisher->counts().dropped;
    }
    to.out << "\n";
    if (!steering) return;
    for (const string& line : steering->refused())
      to.err << "stylerec: refused: " << ForTerminal(line) << "\n";
  }
};

Status WaitForSubscriber(const Arguments& a, const Dependencies& to, player::Clock& clock,
                         PublishOutlet& outlet) {
  to.err << "stylerec: publishing on " << outlet.endpoint() << "\n" << std::flush;
  if (a.wait_s == 0) return Status::Ok();
  const std::int64_t end_ns = clock.Now_ns() + static_cast<std::int64_t>(a.wait_s * 1e9);
  while (!to.stop && outlet.subscriptions() == 0) {
    const std::int64_t now_ns = clock.Now_ns();
    if (now_ns >= end_ns) {
      return Status::Error(outlet.endpoint() + ": found no subscriber, expected one within --wait");
    }
    clock.SleepUntil(now_ns + 2'000'000);
    outlet.Idle();
  }
  return Status::Ok();
}

}  // namespace

Status CheckPlay(const Arguments& a) {
  const auto speed = SpeedOf(a.speed);
  if (!speed.ok()) return speed.status();
  if (!a.publish.empty()) {
    Status status = CheckPublish(a.publish);
    if (!status.ok()) return status;
  }
  return CheckTo(a);
}

Status RunPlay(const Arguments& a, const Dependencies& to) {
  const auto speed = SpeedOf(a.speed);
  if (!speed.ok()) return speed.status();
  const auto reader = OpenRecording(a);
  if (!reader.ok()) return reader.status();
  player::SteadyClock clock;
  Outlets outlets;
  Status status = outlets.Make(a, *reader.value(), clock);
  if (status.ok() && outlets.publisher) {
    status = WaitForSubscriber(a, to, clock, *outlets.publisher);
  }
  if (!status.ok()) return status;
  PlayCounts counts;
  status = Play(*reader.value(), {speed.value(), a.loop, a.from_s, a.until_s}, clock, outlets.all(),
                to.stop, counts);
  to.out << "stylerec: " << a.file << ": records=" << counts.records << " passes=" << counts.passes
         << " seconds=" << counts.seconds
         << " wall_s=" << static_cast<double>(counts.wall_ns) * 1e-9
         << " most_late_ms=" << static_cast<double>(counts.most_late_ns) * 1e-6;
  outlets.Report(to);
  ReportDamage(*reader.value(), to);
  return status;
}

}  // namespace styled::rec
