#include "sim/faults/faults.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <string>

#include "model/base/text.h"
#include "proto/rigs/native/datagram.h"
#include "proto/rigs/native/header.h"

namespace styled::faults {
namespace {

constexpr std::string_view kWords =
    "loss, duplicate, reorder, corrupt, truncate, nan, oversized, restart, late, burst, step, "
    "occlude (each = a probability), seed, late-ms, restart-pause-ms, burst-frames, step-s, "
    "occlude-frames, jitter-ms or drift-ppm";

// A setting that is a number, but not a probability.
struct Setting {
  std::string_view word;
  double Spec::*member;
  double least, most;
  bool whole;
  std::string_view expected;
};
constexpr Setting kSettings[] = {
    {"late-ms", &Spec::late_ms, 0, 60000, false, "milliseconds from 0 to 60000"},
    {"restart-pause-ms", &Spec::restart_pause_ms, 0, 60000, false, "milliseconds from 0 to 60000"},
    {"burst-frames", &Spec::burst_frames, 2, 1000, true, "a whole number from 2 to 1000"},
    {"step-s", &Spec::step_s, -86400, 86400, false, "seconds from -86400 to 86400"},
    {"occlude-frames", &Spec::occlude_frames, 1, 100000, true, "a whole number from 1 to 100000"},
    {"jitter-ms", &Spec::jitter_ms, 0, 1000, false, "milliseconds from 0 to 1000"},
    {"drift-ppm", &Spec::drift_ppm, -100000, 100000, false, "a number from -100000 to 100000"},
};

bool ParseNumber(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

Fault FaultByName(std::string_view name) {
  for (std::size_t i = 1; i < static_cast<std::size_t>(Fault::kCount); ++i) {
    if (Name(static_cast<Fault>(i)) == name) return static_cast<Fault>(i);
  }
  return Fault::kNone;
}

// Parses one "word=value" of the list.
Status ParseItem(std::string_view item, Spec& spec) {
  const auto wrong = [item](std::string_view expected) {
    return Status::Error("faults: '" + std::string(item) + "': expected " + std::string(expected));
  };
  const std::size_t equals = item.find('=');
  if (equals == std::string_view::npos) return wrong("word=value");
  const std::string_view word = item.substr(0, equals), text = item.substr(equals + 1);
  if (word == "seed") {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), spec.seed);
    if (error != std::errc() || end != text.data() + text.size()) {
      return wrong("a whole number from 0");
    }
    return Status::Ok();
  }
  double value = 0;
  const bool is_number = ParseNumber(text, value);
  for (const Setting& setting : kSettings) {
    if (word != setting.word) continue;
    const bool good = is_number && value >= setting.least && value <= setting.most &&
                      (!setting.whole || value == std::floor(value));
    if (!good) return wrong(setting.expected);
    spec.*setting.member = value;
    return Status::Ok();
  }
  const Fault fault = FaultByName(word);
  if (fault == Fault::kNone) return wrong(kWords);
  if (!is_number || value < 0 || value > 1) return wrong("a probability from 0 to 1");
  spec.probability[static_cast<std::size_t>(fault)] = value;
  return Status::Ok();
}

double Uniform(std::mt19937_64& random) noexcept {
  return static_cast<double>(random() >> 11) * 0x1p-53;  // [0, 1), the same on every platform
}

}  // namespace

std::string_view Name(Fault fault) noexcept {
  constexpr std::array<std::string_view, static_cast<std::size_t>(Fault::kCount)> kNames{
      "none",      "loss",    "duplicate", "reorder", "corrupt", "truncate", "nan",
      "oversized", "restart", "late",      "burst",   "step",    "occlude"};
  return kNames[static_cast<std::size_t>(fault)];
}

bool Spec::any() const noexcept {
  for (const double p : probability) {
    if (p > 0) return true;
  }
  return jitter_ms > 0 || drift_ppm != 0;
}

Result<Spec> Parse(std::string_view text) {
  Spec spec;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    if (const Status status = ParseItem(text.substr(0, comma), spec); !status.ok()) return status;
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  }
  double sum = 0;
  for (const double p : spec.probability) sum += p;
  if (sum > 1 + 1e-9) {
    return Status::Error("faults: the probabilities sum to " + NumberText(sum) +
                         ", expected at most 1 (a frame suffers one fault at a time)");
  }
  return spec;
}

Faults::Faults(const Spec& spec, std::uint64_t stream)
    : spec_(spec),
      random_(spec.seed * 0x9E3779B97F4A7C15ULL + stream),
      jitter_random_(~(spec.seed * 0x9E3779B97F4A7C15ULL + stream)) {}

std::uint32_t Faults::Choose(std::uint32_t below) noexcept {
  assert(below > 0);
  return static_cast<std::uint32_t>(Uniform(random_) * below);
}

Fault Faults::Draw() noexcept {
  // Inverts the cumulative distribution: `at` falls into the interval of one fault, or of none. A
  // frame that must have no fault draws as well, so that each Draw() uses one random number.
  double at = Uniform(random_);
  Fault fault = Fault::kNone;
  for (std::size_t i = 1; i < spec_.probability.size() && fault == Fault::kNone; ++i) {
    if (at < spec_.probability[i]) fault = static_cast<Fault>(i);
    at -= spec_.probability[i];
  }
  if (spare_ > 0) {
    fault = Fault::kNone;
    --spare_;
  }
  if (fault == Fault::kReorder) spare_ = 1;
  if (fault == Fault::kBurst) spare_ = static_cast<std::uint32_t>(spec_.burst_frames) - 1;
  ++counts_[static_cast<std::size_t>(fault)];
  return fault;
}

double Faults::DrawJitter_s() noexcept {
  return spec_.jitter_ms > 0 ? Uniform(jitter_random_) * spec_.jitter_ms * 1e-3 : 0;
}

double Faults::ClockError_s(double true_s, Fault fault) noexcept {
  if (fault == Fault::kStep) stepped_s_ += spec_.step_s;
  // The steps are limited, and not only the result: a clock that was set back to 0 runs on from
  // there.
  const double drift_s = true_s * spec_.drift_ppm * 1e-6;
  stepped_s_ = std::max(stepped_s_, -true_s - drift_s);
  return std::max(drift_s + stepped_s_, -true_s);
}

std::size_t Faults::Damage(Fault fault, std::byte* datagram, std::size_t size) noexcept {
  assert(size > native::kHeaderSize);
  if (fault == Fault::kTruncate) {
    const auto payload = static_cast<std::uint32_t>(size - native::kHeaderSize);
    return native::kHeaderSize + Choose(payload);
  }
  if (fault == Fault::kCorrupt) {
    const auto begin = static_cast<std::uint32_t>(native::header::kCrc);
    const std::uint32_t bit = Choose((static_cast<std::uint32_t>(size) - begin) * 8);
    datagram[begin + bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  }
  return size;
}

}  // namespace styled::faults
