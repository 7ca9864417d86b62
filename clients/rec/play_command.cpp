// `stylerec play`: which outlets, and what became of it.
#include <CLI/CLI.hpp>
#include <limits>

#include "clients/rec/commands.h"
#include "clients/rec/play.h"
#include "clients/rec/publish_outlet.h"
#include "clients/rec/rig_outlet.h"
#include "clients/rec/steering.h"

namespace styled::rec {
namespace {

using std::string;

// What a recording has to send to a rig's listener.
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
    const string given = url, name = TakeName(url);
    if (!options.to.emplace(name, url).second) {
      return Status::Error("--to " + given + ": expected one address per source");
    }
  }
  const auto arrivals = FindArrivals(reader);
  if (!arrivals.ok()) return arrivals.status();
  options.from_published = !arrivals.value();
  for (const auto& [name, url] : options.to) {
    if (url == "original" && options.from_published) {
      return Status::Error("--to original: " + reader.name() +
                           " has no arrivals; expected an address");
    }
  }
  return options;
}

Result<double> SpeedOf(const string& text) {
  if (text == "max") return std::numeric_limits<double>::infinity();
  double speed = 0;
  if (!CLI::detail::lexical_cast(text, speed) || !(speed >= 0.001 && speed <= 1e6)) {
    return Status::Error("--speed " + text + ": expected 0.001 to 1000000, or max");
  }
  return speed;
}

// The outlets that were asked for.
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
  void Report(const Surroundings& to) const {
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
    for (const string& line : steering->refused()) to.err << "stylerec: refused: " << line << "\n";
  }
};

Status WaitForSubscriber(const Arguments& a, const Surroundings& to, player::Clock& clock,
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

Status RunPlay(const Arguments& a, const Surroundings& to) {
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
  SayDamage(*reader.value(), to);
  return status;
}

}  // namespace styled::rec
