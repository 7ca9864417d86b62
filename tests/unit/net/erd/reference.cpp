#include "tests/unit/net/erd/reference.h"

#include <cmath>
#include <random>

namespace styled::erd {

Features FeaturesAt(int frame, unsigned seed) {
  std::mt19937 random(seed);
  Features features;
  for (float& x : features) {
    const float phase = static_cast<float>(random() % 1000) * 0.00628F;
    const float rate = 0.02F + static_cast<float>(random() % 100) * 0.002F;
    x = 0.5F * std::sin(phase + rate * static_cast<float>(frame));
  }
  for (int joint = 0; joint < 21; ++joint) features[4 * joint + 3] += 0.8F;
  return features;
}

double Difference(const net::Decoded& a, const ReferenceOutput& b) {
  double largest = std::abs(a.hips_height_m - b.height);
  for (int joint = 0; joint < 21; ++joint) {
    for (int i = 0; i < 4; ++i) {
      const double x = a.rotations[joint].coeffs()[i];
      largest = std::max(largest, std::abs(x - b.rotations[4 * joint + i]));
    }
  }
  for (int i = 0; i < 63; ++i) {
    largest = std::max(largest, std::abs(a.velocities_m_s[i] - b.velocities[i]));
  }
  return largest;
}

double Difference(const net::Decoded& a, const net::Decoded& b) {
  ReferenceOutput other;
  other.height = b.hips_height_m;
  for (const body::Quat& q : b.rotations) {
    for (int i = 0; i < 4; ++i) other.rotations.push_back(q.coeffs()[i]);
  }
  other.velocities.assign(b.velocities_m_s.begin(), b.velocities_m_s.end());
  return Difference(a, other);
}

}  // namespace styled::erd
