// The options of stylize for steps: --root stride and --cadence.
//
// Time is warped after a clip is styled, not before. The network, the filters and the contacts of
// the feet then see the performer's motion at its own pace, for which they are made. The rate of
// time comes from the styled frames themselves (Output::cadence), so that it fits the length of the
// steps. A planted foot stays planted, since a warp only changes when a pose is shown.
#include <cstdio>

#include "model/tools/stylize/stylize.h"

namespace styled::stylize {
namespace {

// The figures that an option needs of each style.
struct Needed {
  const char* option;
  const char* figure;
  const char* figures;
  float net::StyleInfo::*walk;
  float net::StyleInfo::*run;
};
constexpr Needed kStrideNeeds{"--root stride", "speed", "speeds", &net::StyleInfo::walk_mps,
                              &net::StyleInfo::run_mps};
constexpr Needed kCadenceNeeds{"--cadence", "cadence", "cadences", &net::StyleInfo::walk_spm,
                               &net::StyleInfo::run_spm};
// Speeds separate walking from running.
constexpr Needed kCadenceNeedsOfNeutral{"--cadence", "speed", "speeds", &net::StyleInfo::walk_mps,
                                        &net::StyleInfo::run_mps};

Status Lacks(const Needed& needed, const net::StyleInfo& style) {
  return Status::Error(std::string(needed.option) + ": the weights have no " + needed.figure +
                       " of '" + style.name + "', expected weights with " + needed.figures +
                       " (styletrain --write-speeds)");
}

// Neutral in both gaits, with which all others are compared.
Status CheckNeutral(const Needed& needed, const net::StyleInfo& neutral) {
  const bool known = neutral.*needed.walk > 0 && neutral.*needed.run > 0;
  return known ? Status::Ok() : Lacks(needed, neutral);
}

// Another style in at least one gait: in the other it changes nothing.
Status CheckStyle(const Needed& needed, const net::StyleInfo& style) {
  const bool known = style.*needed.walk > 0 || style.*needed.run > 0;
  return known ? Status::Ok() : Lacks(needed, style);
}

Status CheckMix(const Needed& needed, const net::Styles& styles,
                const stylist::Settings& settings) {
  Status known = CheckNeutral(needed, styles[0]);
  for (const net::StyleWeight& entry : settings.mix) {
    if (!known.ok()) break;
    if (entry.style >= 0) known = CheckStyle(needed, styles[static_cast<std::size_t>(entry.style)]);
  }
  return known;
}

}  // namespace

Status CheckGait(const Arguments& arguments, const net::Styles& styles,
                 const stylist::Settings& settings) {
  if (settings.root == stylist::Root::kStride) {
    const Status known = CheckMix(kStrideNeeds, styles, settings);
    if (!known.ok()) return known;
  }
  if (!arguments.cadence) return Status::Ok();
  const Status mix = CheckMix(kCadenceNeeds, styles, settings);
  if (!mix.ok()) return mix;
  const Status gaits = CheckNeutral(kCadenceNeedsOfNeutral, styles[0]);
  if (!gaits.ok()) return gaits;
  return CheckStyle(kCadenceNeeds, styles[static_cast<std::size_t>(settings.input_style)]);
}

void Retime(const std::string& file, std::span<const double> times_s, bool say, clip::Clip& clip) {
  const auto length_s = [&clip] {
    return static_cast<double>(clip.frames.size() - 1) / clip.rate_hz;
  };
  const double before_s = length_s();
  clip = clip::Retime(clip, times_s);
  if (!say) return;
  std::fprintf(stderr, "stylize: %s: %.2f s of motion, %.2f s at the style's cadence\n",
               file.c_str(), before_s, length_s());
}

}  // namespace styled::stylize
