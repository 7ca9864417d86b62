#pragma once

#include <string>
#include <vector>

#include "clients/cpp/doctor/address.h"
#include "clients/cpp/doctor/format.h"
#include "model/base/status.h"

namespace styled::doctor {

// A source that frames should come in by.
struct Wanted {
  enum class Origin {
    kDaemon,   // a running daemon told of it
    kConfig,   // the configuration file
    kAssumed,  // neither: what a daemon without configuration listens to
    kOption    // --listen
  };
  Origin origin = Origin::kConfig;
  std::string name, type;
  Format format = Format::kUnknown;  // of `type`
  bool stream = false;
  bool network = true;  // false: comes by USB, or `listen` cannot be read
  Endpoint listen;
  // OptiTrack.
  std::string server, group = "239.255.42.99", interface;
  bool multicast = true;
};

struct Settings {
  std::vector<Wanted> sources;
  std::string control;  // "": not said
};

// The keys of a styled.toml that say where frames come in. What else is in it, and whether it is
// right, is for `styled --check-config` to say. Errors: no file, no TOML, a source without address.
Result<Settings> ReadSettings(const std::string& file);

// "TYPE=HOST:PORT", as --listen has it.
Result<Wanted> ParseListen(const std::string& text);

// The sources of a daemon that was given no configuration.
std::vector<Wanted> AssumedSources();

// Of what a daemon or a file says; `listen` "" is the type's usual address.
Wanted MakeWanted(Wanted::Origin origin, const std::string& name, const std::string& type,
                  const std::string& listen);

}  // namespace styled::doctor
