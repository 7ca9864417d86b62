#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "model/net/styles.h"
#include "model/neutral/neutral.h"
#include "model/rig/binding.h"
#include "model/rig/skeleton.h"
#include "model/stylist/stylist.h"
#include "proto/styled/look.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A rest pose found by a calibration (rig::Calibrate), for skeletons with these joints.
struct KeptRest {
  std::uint64_t skeleton = 0;  // SkeletonHash
  bool left_handed = false;    // the pose is that of the mirrored skeleton
  rig::Quat canonical_from_source = rig::Quat::Identity();
  std::vector<rig::Quat> rotations;
};
// FNV-1a over names and parents. Other bone lengths mean the same rig on another performer.
std::uint64_t SkeletonHash(const rig::Skeleton& skeleton);

// The learned neutral of a performer, valid for bodies that are bound in the same way.
struct KeptNeutral {
  std::uint64_t binding = 0;  // BindingHash
  neutral::Known known;
};
// FNV-1a over everything that decides how a pose is bound: the joints, which of them are canonical,
// the rest pose (to the thousandth) and the axes. Bone lengths are not included.
std::uint64_t BindingHash(const rig::Binding& binding);

// The settings that belong to a performer's id rather than to its sender.
struct Profile {
  std::string id;  // SOURCE.NAME; "*": for future performers
  // Complete. It names styles instead of numbering them, so that it outlives weights and restarts.
  v1::Look look = InitialLook();
  std::optional<KeptRest> rest;
  // Learned earlier. While the performer is present, its stylist has a newer one.
  std::optional<KeptNeutral> neutral;
  bool pinned = false;
  bool configured = false;          // set explicitly: kept when the performer is forgotten
  bool seen = false;                // it has sent data since the daemon started
  std::uint64_t next_sequence = 1;  // number of the next frame; starts at 1
  // The next two also survive a restart. A profile without has_come was only named by a control
  // request; it may be prepared, misspelt or invented.
  bool has_come = false;  // frames of the performer were accepted, in this run or before
  // Hours of running daemons since the performer was last present or last named.
  int absent_hours = 0;
  std::uint64_t named_last = 0;  // counter: orders names within the same hour of this run
};

// Resolves a look into a network's style numbers. Unknown styles are left out and listed in
// `unknown`. In a look that asks for variations, a style without any is replaced by the style of
// that name of a network that has them, where there is one. `performer`: an id, which decides its
// own variation (v1::Look.vary_each). Allocates; not for the hot path.
stylist::Settings Resolve(const v1::Look& look, const net::Styles& styles,
                          std::vector<std::string>& unknown, std::string_view performer = {});

// The first style of the mix that is shown as it is, although the look asks for variations, because
// no network has any of it; "": none.
std::string NotVaried(const v1::Look& look, const net::Styles& styles);

// For each style of the mix, in its order, the network that shows it (StyleInfo.model); "": unknown
// style, or only one network.
std::vector<std::string> NetworksOf(const v1::Look& look, const net::Styles& styles);

// The preset of that name, or null.
const config::Preset* FindPreset(std::string_view name, const std::vector<config::Preset>& presets);

// Writes the mix of the preset `name` or, failing that, of the style `name` at weight 1, into
// `look`. An error if it is neither, or the mix does not pass stylist::Validate.
Status LookUp(const std::string& name, const std::vector<config::Preset>& presets,
              const net::Styles& styles, v1::Look& look);

// Replaces the style names in a change (mix, input_style; neutral becomes "" there) by their proper
// spelling. An error if the network has no such style.
Status ProperNames(const net::Styles& styles, v1::Look& change);

// Replaces a style by its name in a look's mix and input_style. `to` "": removes the style; a look
// without another style goes to bypass. A look that is changed no longer belongs to a preset.
// Returns whether the look named the style.
bool ReplaceStyle(const std::string& name, const std::string& to, v1::Look& look);

// The control requests that restore these settings: a set, and a pin for a pinned performer. A
// preset's name and a calibration are left out, because requests cannot restore them.
std::vector<v1::Request> AsRequests(const Profile& profile);

// A text for users, e.g. "weights sum to more than 1.5".
std::string Explain(stylist::SettingsError error);

}  // namespace styled::pipeline
