#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "model/net/styles.h"
#include "model/rig/skeleton.h"
#include "model/stylist/stylist.h"
#include "proto/styled/look.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A rest pose that was found by calibrating (rig::Calibrate), for skeletons of these joints.
struct KeptRest {
  std::uint64_t skeleton = 0;  // SkeletonHash
  bool left_handed = false;    // of the skeleton mirrored
  rig::Quat canonical_from_source = rig::Quat::Identity();
  std::vector<rig::Quat> rotations;
};
// FNV-1a over names and parents: other bone lengths are the same rig on another performer.
std::uint64_t SkeletonHash(const rig::Skeleton& skeleton);

// What belongs to a performer's id and not to its sender.
struct Profile {
  std::string id;                 // SOURCE.NAME; "*": of performers to come
  v1::Look look = InitialLook();  // whole; names styles, so that it outlives weights and restarts
  std::optional<KeptRest> rest;
  bool pinned = false;
  bool configured = false;          // somebody set it: kept when the performer is forgotten
  bool seen = false;                // it has sent since the daemon started
  std::uint64_t next_sequence = 1;  // of the next frame; 1 is the first
  // Survive a restart, too. A profile whose performer never came is one that was only named: by a
  // control request, prepared or misspelt or made up.
  bool has_come = false;         // frames of the performer were accepted, in this run or before
  int absent_hours = 0;          // of running daemons, since it was last here or was last named
  std::uint64_t named_last = 0;  // counts up: the younger of two of the same hour; this run's
};

// The look in terms of a network's style numbers. Styles that it does not know are left out and
// named in `unknown`. Allocates; not for the hot path.
stylist::Settings Resolve(const v1::Look& look, const net::Styles& styles,
                          std::vector<std::string>& unknown);

// The preset of that name, or null.
const config::Preset* FindPreset(std::string_view name, const std::vector<config::Preset>& presets);

// The mix of the preset `name` or, failing that, of the style `name` at weight 1, into `look`.
// False when it is neither, or the mix does not pass stylist::Validate: `why` says so.
bool LookUp(const std::string& name, const std::vector<config::Preset>& presets,
            const net::Styles& styles, v1::Look& look, std::string& why);

// Replaces the names of styles in a change (mix, input_style; neutral becomes "" there) by their
// proper ones. False where the network has no such style: `why` names it.
bool ProperNames(const net::Styles& styles, v1::Look& change, std::string& why);

// The control requests that give a performer these settings: a set, and a pin for a pinned one. A
// preset's name and a calibration are left out: requests cannot restore them.
std::vector<v1::Request> AsRequests(const Profile& profile);

// "weights sum to more than 1.5", ...
std::string Explain(stylist::SettingsError error);

}  // namespace styled::pipeline
