#include "clients/rec/play.h"

#include <algorithm>
#include <cmath>

#include "model/base/text.h"

namespace styled::rec {
namespace {

constexpr std::int64_t kIdle_ns = 20'000'000;

class Pass {
 public:
  Pass(const PlayOptions& options, player::Clock& clock, const std::vector<Outlet*>& outlets,
       const std::atomic<bool>& stop, PlayCounts& counts)
      : options_(options), clock_(clock), outlets_(outlets), stop_(stop), counts_(counts) {}

  Status Run(recording::Reader& reader, std::int64_t first_ns) {
    const auto at_ns = [&](double seconds) {
      return seconds * 1e9 < 9e18 - std::abs(static_cast<double>(first_ns))
                 ? first_ns + static_cast<std::int64_t>(seconds * 1e9)
                 : std::numeric_limits<std::int64_t>::max();
    };
    const std::int64_t from_ns = at_ns(options_.from_s), until_ns = at_ns(options_.until_s);
    start_ns_ = clock_.Now_ns();
    from_ns_ = from_ns;
    std::int64_t last_ns = from_ns;
    recording::Record record;
    while (!stop_ && reader.Next(record)) {
      if (record.time_ns() > until_ns) break;
      if (record.time_ns() < from_ns) {
        for (Outlet* const outlet : outlets_) outlet->Note(record);
        start_ns_ = clock_.Now_ns();  // the time for reading up to here is not part of the playback
        continue;
      }
      WaitFor(record.time_ns());
      if (stop_) break;
      for (Outlet* const outlet : outlets_) {
        Status status = outlet->Play(record);
        if (!status.ok()) return status;
      }
      ++counts_.records;
      last_ns = std::max(last_ns, record.time_ns());
    }
    counts_.seconds += static_cast<double>(last_ns - from_ns) * 1e-9;
    return Status::Ok();
  }

 private:
  void WaitFor(std::int64_t time_ns) {
    if (std::isinf(options_.speed)) return;
    const double wait_ns = static_cast<double>(time_ns - from_ns_) / options_.speed;
    const std::int64_t due_ns = start_ns_ + static_cast<std::int64_t>(wait_ns);
    std::int64_t now_ns = clock_.Now_ns();
    while (now_ns < due_ns && !stop_) {
      clock_.SleepUntil(std::min(due_ns, now_ns + kIdle_ns));
      for (Outlet* const outlet : outlets_) outlet->Idle();
      now_ns = clock_.Now_ns();
    }
    counts_.most_late_ns = std::max(counts_.most_late_ns, now_ns - due_ns);
  }

  const PlayOptions& options_;
  player::Clock& clock_;
  const std::vector<Outlet*>& outlets_;
  const std::atomic<bool>& stop_;
  PlayCounts& counts_;
  std::int64_t start_ns_ = 0, from_ns_ = 0;
};

}  // namespace

Status Play(recording::Reader& reader, const PlayOptions& options, player::Clock& clock,
            const std::vector<Outlet*>& outlets, const std::atomic<bool>& stop,
            PlayCounts& counts) {
  const auto range = reader.FindTimeRange();
  if (!range.any) return Status::Error(reader.name() + ": found no records, expected some to play");
  const double length_s = static_cast<double>(range.last_ns - range.first_ns) * 1e-9;
  if (options.from_s > length_s) {
    return Status::Error(reader.name() + ": found " + NumberText(length_s, 3) +
                         " s, expected --from within them");
  }
  const std::int64_t begin_ns = clock.Now_ns();
  Status status = Status::Ok();
  do {
    if (counts.passes > 0) {
      for (Outlet* const outlet : outlets) outlet->Restart();
    }
    reader.Rewind();
    ++counts.passes;
    status = Pass(options, clock, outlets, stop, counts).Run(reader, range.first_ns);
  } while (options.loop && !stop && status.ok());
  if (stop) status = Status::Ok();  // a signal also ends the call in progress
  for (Outlet* const outlet : outlets) outlet->Finish();
  counts.wall_ns = clock.Now_ns() - begin_ns;
  return status;
}

}  // namespace styled::rec
