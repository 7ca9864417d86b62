#include "clients/doctor/traffic.h"

#include <algorithm>
#include <array>

namespace styled::doctor {
namespace {

template <typename Takes>
std::string ListKinds(const Tally& tally, const Takes& takes) {
  std::string out;
  for (const auto& kind : tally.kinds) {
    if (!takes(kind.what)) continue;
    out.append(out.empty() ? "" : ", ").append(kind.what.kind).append(" ");
    out.append(std::to_string(kind.count));
  }
  return out;
}

template <typename Takes>
std::uint64_t CountKinds(const Tally& tally, const Takes& takes) {
  std::uint64_t count = 0;
  for (const auto& kind : tally.kinds) count += takes(kind.what) ? kind.count : 0;
  return count;
}

}  // namespace

void Tally::Add(const Sniffed& what, std::uint64_t count) {
  const auto same = std::ranges::find_if(kinds, [&](const Kind& kind) {
    return kind.what.format == what.format && kind.what.verdict == what.verdict &&
           kind.what.kind == what.kind;
  });
  if (same != kinds.end()) {
    same->count += count;
  } else if (kinds.size() < kMaxKinds) {
    kinds.push_back({what, count});
  } else {
    // At most one "others" row per format and verdict.
    const auto others = std::ranges::find_if(kinds, [&](const Kind& kind) {
      return kind.what.format == what.format && kind.what.verdict == what.verdict &&
             kind.what.kind == "others";
    });
    if (others != kinds.end()) {
      others->count += count;
    } else {
      kinds.push_back({{what.format, what.verdict, "others"}, count});
    }
  }
}

void Tally::Add(const Tally& other) {
  for (const auto& kind : other.kinds) Add(kind.what, kind.count);
}

std::uint64_t Tally::Count() const {
  return CountKinds(*this, [](const Sniffed&) { return true; });
}

std::uint64_t Tally::Count(Format format) const {
  return CountKinds(*this, [format](const Sniffed& what) { return what.format == format; });
}

std::uint64_t Tally::Count(Format format, Verdict verdict) const {
  return CountKinds(
      *this, [=](const Sniffed& what) { return what.format == format && what.verdict == verdict; });
}

Format Tally::MainFormat() const {
  std::array<std::uint64_t, static_cast<std::size_t>(Format::kCount)> counts{};
  for (const auto& kind : kinds) counts[static_cast<std::size_t>(kind.what.format)] += kind.count;
  const auto most = std::ranges::max_element(counts);
  return static_cast<Format>(most - counts.begin());
}

std::string Tally::Kinds(Format format) const {
  return ListKinds(*this, [format](const Sniffed& what) { return what.format == format; });
}

std::string Tally::Kinds(Format format, Verdict verdict) const {
  return ListKinds(
      *this, [=](const Sniffed& what) { return what.format == format && what.verdict == verdict; });
}

double Flow::rate_hz() const {
  const double seconds = last_s - first_s;
  return datagrams < 3 || seconds < 0.1 ? 0 : static_cast<double>(datagrams - 1) / seconds;
}

void Traffic::Add(const Arrival& arrival, const Sniffed& what) {
  auto flow = std::ranges::find_if(flows_, [&](const Flow& f) {
    return f.stream == arrival.stream && f.to == arrival.to && f.from.host == arrival.from.host &&
           f.interface == arrival.interface;
  });
  if (flow == flows_.end()) {
    if (flows_.size() >= kMaxFlows) {
      ++left_out_;
      return;
    }
    Flow fresh;
    fresh.stream = arrival.stream;
    fresh.to = arrival.to;
    fresh.interface = arrival.interface;
    fresh.first_s = arrival.time_s;
    fresh.smallest = arrival.size;
    flows_.push_back(fresh);
    flow = flows_.end() - 1;
  }
  flow->from = arrival.from;
  ++flow->datagrams;
  flow->bytes += arrival.size;
  flow->smallest = std::min(flow->smallest, arrival.size);
  flow->largest = std::max(flow->largest, arrival.size);
  flow->last_s = arrival.time_s;
  flow->tally.Add(what);
}

}  // namespace styled::doctor
