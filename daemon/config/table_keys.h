#pragma once

#include "daemon/config/keys.h"

// The keys whose values are tables or lists. Errors say what was expected and what was found; the
// struct is then unspecified. Start-up and reload only; allocates; any thread.
namespace styled::config {

Status ReadTrackers(const toml::node& node, Source& source);
Status ReadJoints(const toml::node& node, rig::JointNames& out);
Status ReadProps(const toml::node& node, Source& source);
Status ReadParts(const toml::node& node, Source& source);
Status ReadPerformers(const toml::node& node, Output& output);

}  // namespace styled::config
