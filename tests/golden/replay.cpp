#include "tests/golden/replay.h"

#include <set>

#include "daemon/replay/replay.h"
#include "daemon/styles/make_config.h"

namespace styled::golden {
Result<Played> Replay(recording::Reader& reader, const std::string& weights,
                      const Options& options) {
  const auto config =
      replay::ConfigOf(reader, {{"model.weights", "'" + weights + "'", "these weights"}});
  if (!config.ok()) return config.status();
  std::uint32_t crc = 0;
  const auto made = pipeline::MakeRuntimeConfig(config.value(), nullptr, crc);
  if (!made.ok()) return made.status();
  Played played;
  std::set<std::pair<std::uint64_t, int>> known;
  runtime::Counters counters;
  const auto collect = [&](std::int64_t, std::string_view topic,
                           std::span<const std::byte> payload) {
    const auto size = static_cast<int>(payload.size());
    if (topic.starts_with("body/")) {
      v1::Body body;
      body.ParseFromArray(payload.data(), size);
      if (known.insert({body.hash(), body.output()}).second) played.bodies.push_back(body);
    } else {
      played.frames[std::string(topic)].emplace_back().ParseFromArray(payload.data(), size);
    }
  };
  const Status status = replay::Replay(reader, config.value(), made.value(),
                                       {"styled/", options.commands, {}}, counters, collect);
  if (!status.ok()) return status;
  for (int i = 0; i < static_cast<int>(runtime::Counter::kCount); ++i) {
    const auto counter = static_cast<runtime::Counter>(i);
    if (!replay::IsOfTheMotion(counter)) continue;
    played.counters[std::string(runtime::Name(counter))] = counters.Get(counter);
  }
  return played;
}

}  // namespace styled::golden
