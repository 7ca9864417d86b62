#include "model/net/stgcn/codes.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace styled::stgcn {

Code PulledIn(const CodeSpace& space, const Code& code) {
  const net::NearestStyle nearest = Nearest(space, code);
  const Code& mean = space.mean_code(nearest.style);
  if (!(nearest.distance > kFarthest) || !std::isfinite(nearest.distance)) return code;
  return mean + kFarthest / nearest.distance * (code - mean);
}

// Computed by hand, because the standard's distributions differ between libraries: splitmix64
// (Steele et al. 2014), then Box and Muller's transformation.
Noise NoiseOf(std::uint64_t seed) {
  const auto next = [&seed] {
    seed += 0x9E3779B97F4A7C15U;
    std::uint64_t z = seed;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;  // [0, 1)
  };
  Noise noise;
  for (int i = 0; i < kNoise; i += 2) {
    const double radius = std::sqrt(-2 * std::log(1 - next()));
    const double angle = 2 * std::numbers::pi * next();
    noise[i] = static_cast<float>(radius * std::cos(angle));
    noise[i + 1] = static_cast<float>(radius * std::sin(angle));
  }
  return noise;
}

Code NoiseCode(const CodeSpace& space, std::uint64_t seed, int domain) {
  return space.MapNoise(NoiseOf(seed), domain);
}

Code Varied(const CodeSpace& space, std::uint64_t seed, int domain, float amount) {
  const Code& mean = space.mean_code(domain);
  return mean + amount * (NoiseCode(space, seed, domain) - mean);
}

Code AtStrength(const CodeSpace& space, const Code& code, float alpha) {
  const Code& neutral = space.mean_code(0);
  return neutral + alpha * (code - neutral);
}

Code Mixed(const CodeSpace& space, std::span<const WeightedCode> codes) {
  const Code& neutral = space.mean_code(0);
  Code sum = neutral;
  for (const WeightedCode& one : codes) sum += one.weight * (one.code - neutral);
  return sum;
}

net::NearestStyle Nearest(const CodeSpace& space, const Code& code) {
  const int domains = space.domain_count();
  net::NearestStyle nearest{0, std::numeric_limits<float>::infinity()};
  double between = 0;
  for (int domain = 0; domain < domains; ++domain) {
    const Code& mean = space.mean_code(domain);
    const float distance = (code - mean).norm();
    if (distance < nearest.distance) nearest = {domain, distance};
    for (int other = 0; other < domain; ++other) {
      between += static_cast<double>((mean - space.mean_code(other)).norm());
    }
  }
  between /= std::max(1, domains * (domains - 1) / 2);
  nearest.distance = between > 0 ? nearest.distance / static_cast<float>(between) : 0;
  return nearest;
}

}  // namespace styled::stgcn
