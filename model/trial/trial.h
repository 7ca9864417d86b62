#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"
#include "model/net/load.h"
#include "model/net/stylizer.h"

namespace styled::trial {

// Weights may be well-formed and finite and still compute something that is not a pose: one tensor
// too large, and every frame is NaN. Therefore a network is tested before it is used. The synthetic
// performer walks, runs, turns and raises both hands for kTrial_s at the network's own rate, with
// every style at kMaxStrength (the largest allowed) and with every style as the input style; a
// network with a space of styles also with an example, a network of whole clips with variations of
// every style, too. Allocates; takes milliseconds, for a network of whole clips a second: for
// start-up and reload only. Pinned by tests/unit/trial/trial_test.cpp.
inline constexpr double kTrial_s = 3.5;

// The measurements of a trial: the largest value of all styles and frames.
struct Figures {
  float reconstruction_rad = 0;  // rms over joints between the pose and its reconstruction
  float change_rad = 0;          // rms over joints between reconstruction and styled pose
  float velocity_m_s = 0;        // of one joint along one axis
  float height_m = 0;            // of the hips, either sign
};

// The bounds that a network must keep to be usable at all, whatever its quality. Their source:
// model/weights/RESULTS.md, "The trial run".
inline constexpr Figures kMost{1.8F, 1.8F, 1000.0F, 100.0F};

// Tests `network`. The error names `name` (its file), style, frame, joint, what was expected and
// what was found. `figures`, if given, is written on success only.
Status Try(const net::Stylizer& network, const std::string& name, Figures* figures = nullptr);
Status Try(const net::ClipStylizer& network, const std::string& name, Figures* figures = nullptr);

// net::Load, net::Parse and net::LoadAny followed by the trial. Every program that runs a user's
// network uses these.
Result<std::shared_ptr<const net::Stylizer>> Load(
    const std::filesystem::path& file, net::Precision precision = net::Precision::kFloat32);
Result<std::shared_ptr<const net::Stylizer>> Parse(
    std::span<const std::byte> bytes, const std::string& name,
    net::Precision precision = net::Precision::kFloat32);
Result<net::AnyStylizer> LoadAny(const std::filesystem::path& file,
                                 net::Precision precision = net::Precision::kFloat32);

}  // namespace styled::trial
