#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/styled/look.h"

// A look on the command line, as JSON and in words: by kLookFields, so that a new field is an
// option and a part of status without a change here.
namespace styled::stylectl {

// Adds an option for each field to a command; parsing writes what is given into `change`, which
// outlives the command. `preset` is a command of its own.
void AddLookOptions(CLI::App& command, v1::Look& change);
// The names of those options: "--style, --mix, ...".
std::string LookOptionNames();

nlohmann::json MixJson(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix);
// "old 0.60 + proud 0.40"; "bypass".
std::string MixText(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix);
// Every field by its name.
nlohmann::json LookJson(const v1::Look& look);
// What a change says: "old 0.60, strength 0.8, parts head,left-arm"; "" for nothing.
std::string ChangeText(const v1::Look& change);
// How a whole look differs from the initial one, but for mix, strength and transition: "input
// style elderly, parts head"; "" for in nothing.
std::string NotesText(const v1::Look& look);

}  // namespace styled::stylectl
