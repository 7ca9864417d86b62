#pragma once

#include <toml++/toml.h>

#include "model/base/status.h"
#include "proto/styled/look.h"

// A look in TOML: the one reader and writer for [style], [[cue]], [presets] and the state file.
// Start-up, reload and the state file only; allocates.
namespace styled::config {

// Reads the value of one field into `look`. On an error it returns what was expected and changes
// nothing. A mix is { style = weight, ... } or, if its order matters, [{ style = "old", weight =
// 0.5 }].
Status ReadLookField(const LookField& field, const toml::node& node, v1::Look& look);
// Every field of a whole look by its name; ReadLookField reads them all back.
toml::table LookTable(const v1::Look& look);

}  // namespace styled::config
