#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/styled/look.h"

// Converts a look from command-line options, and to JSON and text. Driven by the table kLookFields,
// so that a new field becomes an option and a part of `status` without a change here.
namespace styled::stylectl {

// Adds an option for each field to a command. Parsing writes the given values to `change`, which
// must outlive the command. `preset` is a separate command.
void AddLookOptions(CLI::App& command, v1::Look& change);
// The names of those options: "--style, --mix, ...".
std::string LookOptionNames();

nlohmann::json MixJson(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix);
// "old 0.60 + proud 0.40"; "bypass".
// `networks`: the network that shows each style, "" or fewer than styles: unknown.
std::string MixText(const google::protobuf::RepeatedPtrField<v1::StyleWeight>& mix,
                    const google::protobuf::RepeatedPtrField<std::string>& networks = {});
// Every field by its name.
nlohmann::json LookJson(const v1::Look& look);
// The fields of a change: "old 0.60, strength 0.8, parts head,left-arm"; "" for an empty one.
std::string ChangeText(const v1::Look& change);
// The differences of a complete look from the initial one, except mix, strength and transition:
// "input style elderly, parts head"; "" if there are none.
std::string NotesText(const v1::Look& look);

}  // namespace styled::stylectl
